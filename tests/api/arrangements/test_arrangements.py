"""Arrangements over HTTP: the answer, what a machine keeps of its parts, the box besides, other circumstances."""

from __future__ import annotations

import cmath
import math
from itertools import permutations
from typing import Any

import pytest

from tests.support.http.workshop import DRUM, Workshop, machine_body, reading, vector_of

BARS = (6025.0, 5978.0, 5978.0, 6012.0, 5989.0, 6013.0)
R = 310.0


def places(count: int = 6, axial: tuple[float, ...] = (0.0,), **more: Any) -> list[dict[str, Any]]:
    """Evenly spaced places at one radius."""
    step = 360.0 / count
    return [
        {"label": str(n + 1), "angle_deg": step * n, "radius_mm": R, "axial_mm": list(axial), **more}
        for n in range(count)
    ]


def parts(masses: tuple[float, ...] = BARS, **more: Any) -> list[dict[str, Any]]:
    """Weighed parts, in their places in order."""
    return [{"id": f"b{n}", "mass_g": mass, "present": str(n), **more} for n, mass in enumerate(masses, 1)]


def size_of(masses: tuple[float, ...], offset: complex = 0j) -> float:
    """Unbalance of parts in places in order."""
    return abs(offset + sum(m * R * cmath.exp(2j * math.pi * n / len(masses)) for n, m in enumerate(masses)))


def polar(z: complex) -> dict[str, Any]:
    return {"plane": "1", "unbalance_g_mm": abs(z), "angle_deg": math.degrees(cmath.phase(z))}


class TestAnswer:
    def test_without_a_machine_in_one_plane(self, shared_shop: Workshop) -> None:
        offset = 900.0 - 2500.0j
        made = shared_shop.post("/arrangements", {"places": places(), "parts": parts(), "offset": [polar(offset)]})
        assert made["status"] == "optimal"
        assert made["objective_value"] == pytest.approx(min(size_of(p, offset) for p in permutations(BARS)), rel=1e-9)
        assert made["gap"] == 0.0
        assert made["residual"][0]["unbalance_g_mm"] == pytest.approx(made["objective_value"])
        by_id = {part["id"]: part["mass_g"] for part in parts()}
        ordered = tuple(by_id[one["part"]] for one in made["arrangement"])
        assert size_of(ordered, offset) == pytest.approx(made["objective_value"])
        assert shared_shop.get(f"/arrangements/{made['id']}") == made

    def test_the_moves_lead_there_with_one_free_place(self, shared_shop: Workshop) -> None:
        made = shared_shop.post("/arrangements", {"places": places(), "parts": parts()})
        held = {part["present"]: part["id"] for part in parts()}
        bench: list[str] = []
        for move in made["moves"]:
            if move["to"] in held:
                bench.append(held.pop(move["to"]))
            assert len(bench) <= 1
            if move["part"] in bench:
                bench.remove(move["part"])
            else:
                del held[move["from"]]
            held[move["to"]] = move["part"]
        assert held == {one["place"]: one["part"] for one in made["arrangement"]}
        assert made["moves_count"] == len(made["moves"])

    def test_the_makers_rule_is_told_or_why_it_is_not(self, shared_shop: Workshop) -> None:
        made = shared_shop.post("/arrangements", {"places": places(), "parts": parts()})
        assert made["makers_rule"]["objective_value"] == pytest.approx(
            size_of((6025.0, 6012.0, 5978.0, 6013.0, 5989.0, 5978.0))
        )
        odd = shared_shop.post("/arrangements", {"places": places(5), "parts": parts(BARS[:5])})
        assert odd["makers_rule"] is None
        assert "5 places" in odd["makers_rule_reason"]

    def test_the_fewest_moves_within_a_limit(self, shared_shop: Workshop) -> None:
        by_moves = [math.inf] * 7
        for order in permutations(range(6)):
            moved = sum(n != k for n, k in enumerate(order))
            by_moves[moved] = min(by_moves[moved], size_of(tuple(BARS[k] for k in order)))
        limit = 1.0001 * by_moves[3]
        request = {"places": places(), "parts": parts(), "mode": "fewest_moves", "limit": limit}
        made = shared_shop.post("/arrangements", request)
        wanted = next(moved for moved, value in enumerate(by_moves) if value <= limit)
        assert (made["status"], made["moves_count"], made["moves_bound"]) == ("optimal", wanted, wanted)
        assert made["objective_value"] == pytest.approx(by_moves[wanted])
        front = shared_shop.get(f"/arrangements/{made['id']}/front")
        best = math.inf
        for moved, value in enumerate(by_moves):
            found = next((p["offer"]["objective_value"] for p in front if p["moves"] == moved), None)
            if value < best * (1.0 - 1e-9):
                assert found == pytest.approx(value)
                best = value
            else:
                assert found is None

    def test_one_broke_and_the_drum_was_in_balance_before(self, shared_shop: Workshop) -> None:
        """The broken bar is gone; those that stay were never weighed."""
        old = parts()
        broken = {**old[0], "id": "broken", "may": "gone"}
        new = {"id": "fresh", "mass_g": 6080.0, "new": True}
        unweighed = [{"id": p["id"], "present": p["present"], "may": "stay"} for p in old[3:]]
        request = {
            "places": places(),
            "parts": [broken, new, *old[1:3], *unweighed],
            "offset": "in_balance_with_old",
        }
        made = shared_shop.post("/arrangements", request)
        before = [BARS[n] for n in range(3)]
        best = min(
            abs(
                sum((m - o) * R * cmath.exp(1j * math.pi * n / 3.0) for n, (m, o) in enumerate(zip(p, before)))  # noqa: B905
            )
            for p in permutations((6080.0, BARS[1], BARS[2]))
        )
        assert made["objective_value"] == pytest.approx(best)
        assert made["status"] == "optimal"

    def test_equal_parts_in_any_order(self, shared_shop: Workshop) -> None:
        made = shared_shop.post("/arrangements", {"places": places(), "parts": parts((600.0,) * 6)})
        assert (made["status"], made["code"], made["moves_count"]) == ("optimal", "all_equal", 0)

    def test_what_if(self, shared_shop: Workshop) -> None:
        made = shared_shop.post("/arrangements", {"places": places(), "parts": parts()})
        asked = {"missing": ["b1"], "shelf": [{"id": "s1", "mass_g": 6000.0}], "replace": "1"}
        answer = shared_shop.post(f"/arrangements/{made['id']}/what-if", asked)
        assert answer["worse_by"] == pytest.approx(answer["offer"]["objective_value"] - made["objective_value"])
        others = sum(m * R * cmath.exp(1j * math.pi * n / 3.0) for n, m in enumerate(BARS) if n)
        assert answer["replacement"]["mass_g"] == pytest.approx(-others.real / R, rel=1e-4)
        assert answer["replacement"]["best_on_shelf"] == "s1"
        assert shared_shop.refused(
            "POST", f"/arrangements/{made['id']}/what-if", {"missing": ["x"]}, 422, "unknown_part"
        )

    def test_what_cannot_be_is_an_answer(self, shared_shop: Workshop) -> None:
        made = shared_shop.post("/arrangements", {"places": places(), "parts": parts(BARS[:4])})
        assert (made["status"], made["code"], made["arrangement"]) == ("infeasible", "too_few_parts", [])
        assert "6 places" in made["reason"]
        grouped = places(group="ring")
        limits = [{"group": "ring", "max_difference_g": 5.0}]
        made = shared_shop.post("/arrangements", {"places": grouped, "parts": parts(), "group_limits": limits})
        assert (made["status"], made["code"]) == ("infeasible", "group_limits_exclude")


class TestMachine:
    def test_it_keeps_places_and_parts_with_their_history(self, shared_shop: Workshop) -> None:
        machine = shared_shop.machine()
        shared_shop.ask("PUT", f"/machines/{machine}/place-sets/bars", {"places": places()})
        assert [s["name"] for s in shared_shop.get(f"/machines/{machine}/place-sets")] == ["bars"]
        made = shared_shop.post("/arrangements", {"machine_id": machine, "set": "bars", "parts": parts()})
        assert {p["event"] for p in shared_shop.get(f"/machines/{machine}/parts")} == {"weighed"}
        swapped = [made["arrangement"][1]["part"], made["arrangement"][0]["part"]]
        actual = [{"place": "1", "part": swapped[0]}, {"place": "2", "part": swapped[1]}]
        done = shared_shop.post(f"/arrangements/{made['id']}/mounted", {"actual": actual, "note": "swapped by mistake"})
        assert done["state"] == "mounted"
        assert [one["part"] for one in done["mounted"][:2]] == swapped
        now = {p["place"]: p["part"] for p in shared_shop.get(f"/machines/{machine}/parts")}
        assert now == {one["place"]: one["part"] for one in done["mounted"]}
        lines = shared_shop.get(f"/machines/{machine}/parts/history?part={swapped[0]}")
        assert [line["event"] for line in lines] == ["mounted", "weighed"]
        shared_shop.refused("POST", f"/arrangements/{made['id']}/mounted", {}, 409, "arrangement_mounted")
        assert shared_shop.get(f"/arrangements?machine_id={machine}")[0]["id"] == made["id"]

    def test_parts_and_stock_masses_in_one_proof(self, shared_shop: Workshop) -> None:
        machine = shared_shop.machine()
        box = shared_shop.box(masses=(10.0, 25.0))
        request = {
            "machine_id": machine,
            "catalogue_id": box,
            "places": places(5, axial=(100.0,)),
            "parts": parts(BARS[:5]),
            "max_masses_per_plane": 1,
        }
        alone = shared_shop.post("/arrangements", {**request, "catalogue_id": None})
        masses = shared_shop.post("/arrangements", {**request, "use": "box"})
        both = shared_shop.post("/arrangements", {**request, "use": "both"})
        assert [one["status"] for one in (alone, masses, both)] == ["optimal"] * 3
        assert both["objective_value"] <= min(alone["objective_value"], masses["objective_value"])
        assert masses["moves_count"] == 0
        assert both["placements"]
        assert sum(r["unbalance_g_mm"] for r in both["residual"]) == pytest.approx(both["objective_value"])


class TestMeasured:
    def test_the_offset_is_what_the_correction_leaves(self, shared_shop: Workshop) -> None:
        """Two bars move; the vibration that is predicted is the drum's."""
        session = shared_shop.session()
        shared_shop.learn(session)
        correction = shared_shop.correct(session)
        planes = {plane["name"]: plane for plane in machine_body()["planes"]}
        request = {
            "session_id": session,
            "correction_id": correction["id"],
            "places": places(axial=(-200.0,)),
            "parts": [*parts()[:3], *({"id": f"b{n}", "present": str(n), "may": "stay"} for n in (4, 5, 6))],
            "offset": "measured",
            "objective": "residual_vibration",
            "norm": "max",
        }
        made = shared_shop.post("/arrangements", request)
        assert made["status"] == "optimal"
        by_id = dict(zip(("b1", "b2", "b3"), BARS[:3], strict=True))
        axial = {name: plane["axial_mm"] for name, plane in planes.items()}
        change = sum(
            (by_id[one["part"]] - BARS[n]) * R * cmath.exp(1j * math.pi * n / 3.0)
            for n, one in enumerate(made["arrangement"][:3])
        )
        share = (-200.0 - axial["1"]) / (axial["2"] - axial["1"])
        masses = {
            "1": (1.0 - share) * change / planes["1"]["radius_mm"],
            "2": share * change / planes["2"]["radius_mm"],
        }
        for sensor, initial in DRUM.initial.items():
            wanted = initial + sum(DRUM.influence[sensor, p] * u for p, u in masses.items())
            told = next(v for v in made["predicted"] if v["sensor"] == sensor)
            assert vector_of(told) == pytest.approx(wanted, abs=1e-6)

    def test_the_interval_comes_from_the_measurement_and_the_scale(self, shared_shop: Workshop) -> None:
        session = shared_shop.session()
        for masses in (
            [],
            [{"plane": "1", "mass_g": 200.0, "angle_deg": 0.0}],
            [{"plane": "2", "mass_g": 200.0, "angle_deg": 0.0}],
        ):
            readings = [reading(s, v, scatter=0.03) for s, v in DRUM.vibration(masses).items()]
            kind = "trial" if masses else "initial"
            shared_shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "readings": readings})
        correction = shared_shop.correct(session)
        request = {"correction_id": correction["id"], "places": places(), "parts": parts(), "offset": "measured"}
        fine = shared_shop.post("/arrangements", {**request, "scale_resolution_g": 0.1})
        coarse = shared_shop.post("/arrangements", {**request, "scale_resolution_g": 50.0})
        for made in (fine, coarse):
            for left in made["residual"]:
                assert left["interval"]["low"] <= left["unbalance_g_mm"] <= left["interval"]["high"]
        assert coarse["residual"][0]["interval"]["high"] > fine["residual"][0]["interval"]["high"]
        assert coarse["objective_scatter"] == pytest.approx(500.0 * fine["objective_scatter"])
