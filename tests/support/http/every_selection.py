"""Every selection of a tiny box on a tiny drum, rated by arithmetic of its own: the judge of plans made over HTTP."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.support.http.workshop import DRUM, LinearDrum, machine_body

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
        (firsts, seconds), pairs = self._planes, self._pairs
        return tuple(firsts[i] + seconds[j] for i, j in pairs.tolist())

    @cached_property
    def pieces(self) -> NDArray[np.int64]:
        """Pieces of each selection."""
        return np.asarray(self._joined(len).sum(axis=1))

    @cached_property
    def grams(self) -> NDArray[np.float64]:
        """Total mass of each selection, g."""
        return np.asarray(self._joined(lambda chosen: sum(grams for _, _, grams in chosen)).sum(axis=1))

    def values(self, objective: str, norm: str | None = None) -> NDArray[np.float64]:
        """Objective of each selection."""
        return rated(self.drum, self._joined(_vector) + self._vectors(self.fixed), objective, norm)

    def best(self, objective: str = "residual_vibration", norm: str | None = None) -> float:
        """The least objective there is."""
        return float(self.values(objective, norm).min())

    def value_of(self, placements: Sequence[Mapping[str, Any]], objective: str, norm: str | None = None) -> float:
        """Objective of the placements that the service states."""
        chosen = [(p["plane"], p["position_deg"], p["mass_g"] + p["fastener_g"]) for p in placements]
        return float(rated(self.drum, self._vectors((*chosen, *self.fixed))[None, :], objective, norm)[0])

    @cached_property
    def _planes(self) -> tuple[list[tuple[Hole, ...]], list[tuple[Hole, ...]]]:
        """What each plane may carry by itself."""
        first, second = (list(self._of_plane(plane, most)) for plane, most in zip("12", self.most, strict=True))
        return first, second

    @cached_property
    def _pairs(self) -> NDArray[np.int64]:
        """Indices (N, 2) into both planes' choices of what the box can supply together."""
        used = [
            np.array([[sum(grams == mass for _, _, mass in chosen) for grams in self.box] for chosen in choices])
            for choices in self._planes
        ]
        together = used[0][:, None, :] + used[1][None, :, :]
        return np.argwhere((together <= np.array(list(self.box.values()))).all(axis=2))

    def _joined(self, of: Callable[[tuple[Hole, ...]], complex]) -> NDArray[Any]:
        """A number of each plane's choice, (N, 2)."""
        each = [np.array([of(chosen) for chosen in choices]) for choices in self._planes]
        return np.stack([each[0][self._pairs[:, 0]], each[1][self._pairs[:, 1]]], axis=1)

    def _vectors(self, chosen: Sequence[Hole]) -> NDArray[np.complex128]:
        """Vector sum of each plane, (2,) complex g."""
        return np.array([_vector([one for one in chosen if one[0] == plane]) for plane in "12"])

    def _of_plane(self, plane: str, most: int) -> Iterator[tuple[Hole, ...]]:
        free = [angle for angle in ANGLES if (plane, angle) not in self.taken]
        for many in range(most + 1):
            for holes in combinations(free, many):
                for masses in product(self.box, repeat=many):
                    yield tuple((plane, hole, grams) for hole, grams in zip(holes, masses, strict=True))


def _vector(chosen: Sequence[Hole]) -> complex:
    """Vector sum of masses in one plane, g."""
    return sum((cmath.rect(grams, math.radians(angle)) for _, angle, grams in chosen), 0j)


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
