"""Every selection of a tiny box on a tiny drum, rated by arithmetic of its own: the judge of plans made over HTTP."""

from __future__ import annotations

import cmath
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.api.workshop import DRUM, LinearDrum, machine_body

Hole = tuple[str, float, float]
"""Plane, angle in degrees, mass in g."""
ANGLES = (0.0, 50.0, 130.0, 180.0, 250.0, 300.0)
"""Uneven on purpose."""
BOX: Mapping[float, int] = {50.0: 2, 120.0: 1, 200.0: 2}
LIMIT = 0.2
RADIUS_MM = 330.0
BEARINGS_MM = (-480.0, 440.0)
PLANES_MM = (-330.0, 330.0)


def tiny_machine(**changes: Any) -> dict[str, Any]:
    """What differs from the published drum: six uneven positions, two masses a plane."""
    planes = [
        {**plane, "positions_deg": list(ANGLES), "max_masses": 2, **changes} for plane in machine_body()["planes"]
    ]
    return {"planes": planes}


@dataclass(frozen=True)
class EverySelection:
    """All that may be bolted on: one piece a hole, `most` a plane, no more of a mass than the box holds.

    taken: holes that take nothing. fixed: masses that are on (or, negative, off) whatever is chosen.
    """

    box: Mapping[float, int] = field(default_factory=lambda: BOX)
    most: tuple[int, int] = (2, 2)
    taken: frozenset[tuple[str, float]] = frozenset()
    fixed: tuple[Hole, ...] = ()
    drum: LinearDrum = DRUM

    def but(self, **changes: Any) -> EverySelection:
        """The same with changes."""
        return replace(self, **changes)

    @cached_property
    def all(self) -> tuple[tuple[Hole, ...], ...]:
        """Every selection that the box can supply."""
        firsts, seconds = (list(self._of_plane(plane, most)) for plane, most in zip("12", self.most, strict=True))
        return tuple(one + other for one in firsts for other in seconds if self._in_the_box(one + other))

    @cached_property
    def pieces(self) -> NDArray[np.int64]:
        """Pieces of each selection."""
        return np.array([len(chosen) for chosen in self.all])

    @cached_property
    def grams(self) -> NDArray[np.float64]:
        """Total mass of each selection, g."""
        return np.array([sum(grams for _, _, grams in chosen) for chosen in self.all])

    def values(self, objective: str, norm: str | None = None) -> NDArray[np.float64]:
        """Objective of each selection."""
        u = np.array([[self._vector(chosen, plane) for plane in "12"] for chosen in self.all])
        return rated(self.drum, u, objective, norm)

    def best(self, objective: str = "residual_vibration", norm: str | None = None) -> float:
        """The least objective there is."""
        return float(self.values(objective, norm).min())

    def value_of(self, placements: Sequence[Mapping[str, Any]], objective: str, norm: str | None = None) -> float:
        """Objective of the placements that the service states."""
        chosen = tuple((p["plane"], p["position_deg"], p["mass_g"] + p["fastener_g"]) for p in placements)
        u = np.array([[self._vector(chosen, plane) for plane in "12"]])
        return float(rated(self.drum, u, objective, norm)[0])

    def _of_plane(self, plane: str, most: int) -> Iterator[tuple[Hole, ...]]:
        free = [angle for angle in ANGLES if (plane, angle) not in self.taken]
        for many in range(most + 1):
            for holes in combinations(free, many):
                for masses in product(self.box, repeat=many):
                    yield tuple((plane, hole, grams) for hole, grams in zip(holes, masses, strict=True))

    def _in_the_box(self, chosen: Sequence[Hole]) -> bool:
        return all(self.box[grams] >= many for grams, many in Counter(grams for _, _, grams in chosen).items())

    def _vector(self, chosen: Sequence[Hole], plane: str) -> complex:
        everything = (*chosen, *self.fixed)
        return sum((cmath.rect(m, math.radians(a)) for p, a, m in everything if p == plane), 0j)


def rated(drum: LinearDrum, u: NDArray[np.complex128], objective: str, norm: str | None = None) -> NDArray[np.float64]:
    """Objective of masses u (N, 2), complex g: the definitions written out once more."""
    matrix = np.array([[drum.influence[sensor, plane] for plane in "12"] for sensor in "PQ"])
    initial = np.array([drum.initial[sensor] for sensor in "PQ"])
    if objective == "residual_vibration":
        over = np.abs(initial + u @ matrix.T) / LIMIT
        joined = {"max": over.max(axis=1), "rms": np.sqrt((over**2).mean(axis=1))}
        return np.asarray(joined.get(norm or "sum", over.sum(axis=1)))
    unbalance = RADIUS_MM * (u + np.linalg.solve(matrix, initial))
    if objective == "components":
        return np.asarray(0.5 * (np.abs(unbalance.real) + np.abs(unbalance.imag)).sum(axis=1))
    as_found = RADIUS_MM * np.linalg.solve(matrix, initial)[None, :].astype(np.complex128)
    return np.asarray(0.5 * (_reactions(unbalance) / _reactions(as_found)).sum(axis=1))


def _reactions(unbalance: NDArray[np.complex128]) -> NDArray[np.float64]:
    """|F_P|, |F_Q| (N, 2), up to the speed squared: force and moment of a rigid rotor on two bearings."""
    p, q = BEARINGS_MM
    force, moment = unbalance.sum(axis=1), unbalance @ np.array(PLANES_MM)
    at_q = (moment - p * force) / (q - p)
    return np.asarray(np.abs(np.stack([force - at_q, at_q], axis=1)))
