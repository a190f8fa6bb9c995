"""What a plan has to keep and to join: fasteners, grams a position takes, rare pieces, several speeds."""

from __future__ import annotations

import cmath
import math
from collections import Counter
from typing import Any

import numpy as np
import pytest

from tests.support.http.every_selection import LIMIT, RADIUS_MM, EverySelection, tiny_machine
from tests.support.http.tiny_bench import SAME, Bench, bench_on
from tests.support.http.workshop import DRUM, LinearDrum, Workshop, mass

HEAVIER = {50.0: 4.5, 120.0: 6.0, 200.0: 9.5}
"""Fastener, g, of each mass of the tiny box."""


def bench_with(shop: Workshop, items: list[dict[str, Any]], **changes: Any) -> Bench:
    """A session on the tiny drum with a box of these items."""
    box = str(shop.post("/catalogues", {"name": f"box {shop.count('catalogue')}", "items": items})["id"])
    session = shop.session(shop.machine(**tiny_machine(**changes)), box)
    shop.learn(session)
    return Bench(shop, session, box, shop.correct(session))


@pytest.mark.parametrize("objective", ["components", "bearing_force", "residual_vibration"])
def test_fasteners_are_mass_like_any_other(shared_shop: Workshop, objective: str) -> None:
    """The best of all selections in which each piece weighs as much as it and its fastener."""
    counts = {50.0: 2, 120.0: 1, 200.0: 2}
    items = [{"mass_g": g, "count": n, "fastener_g": HEAVIER[g]} for g, n in counts.items()]
    every = EverySelection(box={g + HEAVIER[g]: n for g, n in counts.items()})
    plan = bench_with(shared_shop, items).plan(objective=objective)
    assert plan["objective_value"] == pytest.approx(every.best(objective), rel=1e-7)
    assert plan["objective_value"] == pytest.approx(every.value_of(plan["placements"], objective), rel=1e-7)
    assert {p["mass_g"]: p["fastener_g"] for p in plan["placements"]}.items() <= HEAVIER.items()


def test_a_position_takes_so_many_grams(shared_shop: Workshop) -> None:
    """A greatest force on a position is a greatest mass in it, two pieces and their fasteners together."""
    omega = 460.0 * math.pi / 30.0
    force = 0.170 * RADIUS_MM * 1e-3 * omega**2  # 170 g
    items = [{"mass_g": g, "count": 4, "fastener_g": 5.0} for g in (50.0, 120.0, 200.0)]
    bench = bench_with(shared_shop, items, masses_per_position=2, max_masses=4, max_force_n=force)
    plan = bench.plan()
    grams: Counter[tuple[str, float]] = Counter()
    for p in plan["placements"]:
        grams[p["plane"], p["position_deg"]] += p["mass_g"] + p["fastener_g"]
    assert plan["status"] == "optimal"
    assert 125.0 <= max(grams.values()) <= 170.0
    assert 200.0 not in {p["mass_g"] for p in plan["placements"]}
    free = bench_with(shared_shop, items, masses_per_position=2, max_masses=4).plan()
    assert free["objective_value"] < plan["objective_value"] * (1.0 - SAME)


@pytest.mark.parametrize("common", [0, 1])
def test_of_pieces_alike_the_commonest_is_taken(shared_shop: Workshop, common: int) -> None:
    """110 g by themselves, or 100 g with a fastener of 10 g: the drum cannot tell them apart, the box can."""
    counts = [2, 9] if common else [9, 2]
    items = [{"mass_g": 110.0, "count": counts[0]}, {"mass_g": 100.0, "count": counts[1], "fastener_g": 10.0}]
    plan = bench_with(shared_shop, items).plan(max_masses_per_plane=1)
    assert plan["placements"]
    assert {p["mass_g"] for p in plan["placements"]} == {[110.0, 100.0][common]}


@pytest.mark.parametrize("norm", ["sum", "max", "rms"])
def test_several_speeds_are_joined(shared_shop: Workshop, norm: str) -> None:
    """Runs at two speeds: each sensor counts once at each, and the plan is the best for all of them together."""
    fast = LinearDrum(
        initial={s: v * cmath.rect(1.7, 0.9) for s, v in DRUM.initial.items()},
        influence={k: v * cmath.rect(2.1, 0.4 * (k[0] == "Q")) for k, v in DRUM.influence.items()},
    )
    one = bench_on(shared_shop)
    session = one.session
    for masses in ([], [mass("1", 200.0, 0.0)], [mass("2", 200.0, 0.0)]):
        shared_shop.run(session, "trial" if masses else "initial", masses, fast, nominal_speed_rpm=700.0)
    both = Bench(shared_shop, session, one.box, shared_shop.correct(session))
    plan = both.plan(norm=norm)
    assert plan["status"] == "optimal"
    assert [(v["sensor"], v["speed_rpm"]) for v in plan["predicted"]] == [
        ("P", 460.0), ("Q", 460.0), ("P", 700.0), ("Q", 700.0),
    ]  # fmt: skip
    over = np.array([v["amplitude"] / LIMIT for v in plan["predicted"]])
    joined = {"sum": over.sum(), "max": over.max(), "rms": math.sqrt((over**2).mean())}[norm]
    assert plan["objective_value"] == pytest.approx(joined, rel=1e-7)
    each = [EverySelection(drum=drum).values("residual_vibration", norm) for drum in (DRUM, fast)]
    together = {"sum": sum(each), "max": np.maximum(*each), "rms": np.sqrt((each[0] ** 2 + each[1] ** 2) / 2.0)}[norm]
    assert plan["objective_value"] == pytest.approx(float(np.min(together)), rel=1e-7)
