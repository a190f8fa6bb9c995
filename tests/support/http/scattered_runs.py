"""Runs whose readings state a scatter, and what a correction leaves of the vibration."""

from __future__ import annotations

from typing import Any

from tests.support.http.workshop import DRUM, LinearDrum, Workshop, mass, reading


def scattered(shop: Workshop, session: str, kind: str, masses: list[dict[str, Any]], drum: LinearDrum = DRUM) -> Any:
    """A run whose readings state a scatter of 1 %."""
    readings = [reading(s, v, scatter=0.01 * abs(v)) for s, v in drum.vibration(masses).items()]
    return shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "readings": readings})


def learned(shop: Workshop, session: str, drum: LinearDrum = DRUM) -> None:
    scattered(shop, session, "initial", [], drum)
    for plane in ("1", "2"):
        scattered(shop, session, "trial", [mass(plane, 200.0, 0.0)], drum)


def silenced(correction: Any, drum: LinearDrum = DRUM) -> float:
    """Greatest amplitude the drum has with the corrections fitted."""
    pieces = [mass(c["plane"], c["mass_g"], c["angle_deg"]) for c in correction["corrections"]]
    return max(abs(v) for v in drum.vibration(pieces).values())
