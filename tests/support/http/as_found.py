"""A rotor that was found with pieces on it, every way of dealing with them, and what a plan for it has to be."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from tests.support.http.every_selection import BOX, EverySelection, tiny_machine
from tests.support.http.workshop import DRUM, Workshop, mass, vectors

SAME = 1e-9


def piece(plane: str, angle: float, grams: float, may: str) -> dict[str, Any]:
    """A piece on the as-found rotor."""
    return {"plane": plane, "position_deg": angle, "mass_g": grams, "may": may}


def opened(shop: Workshop, pieces: Sequence[dict[str, Any]], **plane: Any) -> tuple[str, str]:
    """A session whose rotor was found with these pieces, its runs done, and its box."""
    items = [{"mass_g": grams, "count": count} for grams, count in BOX.items()]
    box = str(shop.post("/catalogues", {"name": f"tiny {shop.count('catalogue')}", "items": items})["id"])
    session = shop.session(shop.machine(**tiny_machine(**plane)), box, on_rotor=list(pieces))
    shop.learn(session)
    return session, box


def planned(shop: Workshop, session: str, **request: Any) -> Any:
    """A plan of the session by the exact search, as the workshop makes them."""
    usual = {"max_masses_per_plane": None}
    return shop.plan(session, shop.correct(session), **{**usual, **request})


def possible(pieces: Sequence[dict[str, Any]], every: EverySelection | None = None) -> list[EverySelection]:
    """Every way of dealing with the pieces, by hand: each with all that may be bolted on then."""
    ways = [every or EverySelection()]
    for one in pieces:
        plane, angle, grams = one["plane"], one["position_deg"], one["mass_g"]
        off = (plane, angle, -grams)
        after = []
        for way in ways:
            most = tuple(n - 1 if name == plane else n for name, n in zip("12", way.most, strict=True))
            if one["may"] != "move":
                after.append(way.but(taken=way.taken | {(plane, angle)}, most=most))
            if one["may"] == "remove":
                after.append(way.but(fixed=(*way.fixed, off)))
            if one["may"] == "move":
                box = {**way.box, grams: way.box.get(grams, 0) + 1}
                after.append(way.but(fixed=(*way.fixed, off), box=box))
        ways = after
    return ways


def best(pieces: Sequence[dict[str, Any]], objective: str = "residual_vibration", **changes: Any) -> float:
    """The least objective there is with these pieces."""
    return min(way.best(objective) for way in possible(pieces, EverySelection().but(**changes)))


def net(plan: Any, key: str = "placements") -> list[dict[str, Any]]:
    """Masses relative to the as-found rotor."""
    on = [mass(p["plane"], p["mass_g"] + p["fastener_g"], p["position_deg"]) for p in plan[key]]
    return on + [mass(p["plane"], -p["mass_g"], p["position_deg"]) for p in plan["taken_off"]]


def actions(plan: Any) -> set[tuple[str, str, float, float]]:
    """What is to be done at each position."""
    return {
        (c["action"], c["placement"]["plane"], c["placement"]["position_deg"], c["placement"]["mass_g"])
        for c in plan["changes"]
    }


def holds(plan: Any, pieces: Sequence[dict[str, Any]], objective: str = "residual_vibration", **changes: Any) -> None:
    """The plan is the best of all, its prediction that of the drum with its masses."""
    assert plan["status"] == "optimal"
    assert plan["objective_value"] == pytest.approx(best(pieces, objective, **changes), rel=SAME)
    assert vectors(plan["predicted"]) == pytest.approx(DRUM.vibration(net(plan)), abs=1e-9)


def assert_done(pieces: Sequence[dict[str, Any]], plan: Any) -> None:
    """Whoever does what `changes` says has the placements on the rotor, and what stays as found."""
    rotor = [(one["plane"], one["position_deg"], one["mass_g"]) for one in pieces]
    rotor += [(one["plane"], one["angle_deg"], one["mass_g"]) for one in plan["inputs"]["on_rotor"]]
    for action, *where in sorted(actions(plan), reverse=True):
        if action == "remove":
            rotor.remove((where[0], where[1], where[2]))
    for action, plane, angle, grams in actions(plan):
        if action == "keep":
            assert (plane, angle, grams) in rotor
        if action == "add":
            rotor.append((plane, angle, grams))
    left = [(one["plane"], one["position_deg"], one["mass_g"]) for one in pieces]
    for off in plan["taken_off"]:
        left.remove((off["plane"], off["position_deg"], off["mass_g"]))
    on = [(p["plane"], p["position_deg"], p["mass_g"]) for p in plan["placements"]]
    assert sorted(rotor) == sorted([*left, *on])
