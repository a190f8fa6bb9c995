"""Reachable set: an outer polygon of the vector sums that a plane's stock masses can make."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.placements import effective_g, slots
from service.balancing.selection.problem import SelectionPlane, SelectionProblem, Stock

DIRECTIONS = 24
MAX_SORTED = 4096
"""Pieces a plane beyond which positions are taken to hold any number of them."""


@dataclass(frozen=True)
class SharedReach:
    """How far all planes together reach with one box: slots per plane, and the heaviest pieces that fill them.

    fixed: (P,) g. turns, room: per plane, unit vectors of the open positions and pieces each takes. most: (P,) pieces.
    heaviest: (K,) g, descending.
    """

    fixed: ComplexArray
    turns: tuple[ComplexArray, ...]
    room: tuple[IntArray, ...]
    most: tuple[int, ...]
    heaviest: FloatArray

    def least(self, g: ComplexArray) -> float:
        """Bound sum_p Re(conj(g_p) u_p) from below: heaviest pieces where they count most, limits in grams aside."""
        worth = []
        for weight, turn, room, most in zip(g, self.turns, self.room, self.most, strict=True):
            along = np.maximum(-(np.conj(weight) * turn).real, 0.0)
            order = np.argsort(-along, kind="stable")
            worth.append(np.repeat(along[order], room[order])[:most])
        slots_by_worth = np.sort(np.concatenate(worth))[::-1]
        used = min(len(slots_by_worth), len(self.heaviest))
        return float((np.conj(g) * self.fixed).real.sum() - slots_by_worth[:used] @ self.heaviest[:used])


@dataclass(frozen=True)
class Reach:
    """Outer bounds of the vector sums of P planes.

    normals: (K,) unit vectors. support: (P, K), Re(conj(normal) u_p) <= support for every selection. centre: (P,) and
    radius: (P,), a disc around each polygon, g. corners: (P, K) of the polygons. shared: where one box is too small to
    fill every plane as if it were alone.
    """

    normals: ComplexArray
    support: FloatArray
    centre: ComplexArray
    radius: FloatArray
    corners: ComplexArray
    shared: SharedReach | None

    def contains(self, u: ComplexArray) -> bool:
        """Whether every u_p of u (P,) lies within its polygon, and all of them within the box as far as u tells."""
        along = (np.conj(self.normals)[None, :] * u[:, None]).real
        if not (along <= self.support).all():
            return False
        if self.shared is None:
            return True
        g = self.shared.fixed - u
        return bool((np.conj(g) * u).real.sum() >= self.shared.least(g))

    def least(self, g: ComplexArray) -> FloatArray:
        """Least value (P,) of Re(conj(g_p) u_p) over the polygons, for g (P,)."""
        return np.asarray((np.conj(g)[:, None] * self.corners).real.min(axis=1), dtype=np.float64)

    def least_together(self, g: ComplexArray) -> float:
        """Bound sum_p Re(conj(g_p) u_p) from below."""
        apart = float(self.least(g).sum())
        return apart if self.shared is None else max(apart, self.shared.least(g))


def reach_of(problem: SelectionProblem) -> Reach:
    """Outer polygons of all planes, each limit taken by itself."""
    normals = np.exp(2j * math.pi * np.arange(DIRECTIONS) / DIRECTIONS)
    fixed = np.array([plane.fixed for plane in problem.planes])
    own = np.array([_support(plane, problem.stock, normals) for plane in problem.planes])
    support = own + (np.conj(normals)[None, :] * fixed[:, None]).real
    corners = _corners(normals, support)
    centre = corners.mean(axis=1)
    return Reach(normals, support, centre, np.abs(corners - centre[:, None]).max(axis=1), corners, _shared(problem))


def _shared(problem: SelectionProblem) -> SharedReach | None:
    """What the box limits in all planes together; None where it could fill each plane as if it were alone."""
    most = [slots(plane, problem.stock) for plane in problem.planes]
    alone = sum(_heaviest(problem.stock, many)[1] for many in most)
    heaviest, together = _heaviest(problem.stock, sum(most))
    if together >= alone * (1.0 - 1e-12) or sum(most) > MAX_SORTED:
        return None
    opens = [np.flatnonzero((plane.capacity > 0) & (plane.capacity_g > 0.0)) for plane in problem.planes]
    return SharedReach(
        fixed=np.array([plane.fixed for plane in problem.planes]),
        turns=tuple(np.exp(1j * p.angles[at]) for p, at in zip(problem.planes, opens, strict=True)),
        room=tuple(np.minimum(p.capacity[at], many) for p, at, many in zip(problem.planes, opens, most, strict=True)),
        most=tuple(most),
        heaviest=heaviest,
    )


def _support(plane: SelectionPlane, stock: Stock, normals: ComplexArray) -> FloatArray:
    """Farthest that the pieces can reach along each normal, (K,): heaviest pieces in the best positions."""
    most = slots(plane, stock)
    cosines = np.maximum((np.conj(normals)[:, None] * np.exp(1j * plane.angles)[None, :]).real, 0.0)
    cosines[:, np.minimum(plane.capacity, plane.capacity_g) <= 0] = 0.0
    best = cosines.max(axis=1)
    heaviest, total = _heaviest(stock, most)
    support = best * min(total, plane.max_mass_g)
    room = np.minimum(plane.capacity, most)
    if most > MAX_SORTED or (room >= most).all():
        return np.asarray(support, dtype=np.float64)
    for k, order in enumerate(np.argsort(-cosines, axis=1, kind="stable")):
        along = np.repeat(cosines[k, order], room[order])[:most]
        support[k] = min(support[k], float(along @ heaviest[: len(along)]))
    return np.asarray(support, dtype=np.float64)


def _heaviest(stock: Stock, most: int) -> tuple[FloatArray, float]:
    """List the `most` heaviest pieces in the box, g, as far as they are listed, and their total mass."""
    mass = effective_g(stock)
    order = np.argsort(-mass, kind="stable")
    counts = np.minimum(stock.counts[order], most)
    taken = np.minimum(counts, np.maximum(most - (np.cumsum(counts, dtype=np.float64) - counts), 0.0))
    listed = np.repeat(mass[order], np.minimum(taken, MAX_SORTED).astype(np.int64))
    return listed, float(taken @ mass[order])


def _corners(normals: ComplexArray, support: FloatArray) -> ComplexArray:
    """Corners (P, K) where neighbouring edges meet; an edge that the others cut off leaves a harmless outer corner."""
    following = np.roll(support, -1, axis=1)
    step = 2.0 * math.pi / len(normals)
    along = (following - support * math.cos(step)) / math.sin(step)
    return np.asarray(normals[None, :] * (support + 1j * along), dtype=np.complex128)
