"""Combine lists of one plane's selections into selections of all planes, within an ellipsoid and the shared box.

Planes are taken from the shortest list to the longest. A partial selection of some planes, lying within the ellipsoid's
shadow, leaves the next plane an ellipse of its own; there the next list is searched.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.exact.bounds import SLACK, Bounds
from service.balancing.selection.exact.level_ellipsoid import Ellipsoid
from service.balancing.selection.exact.neighbours import Columns
from service.balancing.selection.exact.subsets import Placements, Sums
from service.balancing.selection.objectives import rows_times
from service.balancing.selection.problem import BoolArray, Piece

BRANCH = 20_000
"""Partial selections that are extended together."""
TINY_PART = 1e-300


@dataclass(frozen=True)
class PlaneList:
    """Selections of one plane.

    vector: (n,) sums with `fixed`, g. items: (n, k) in stock, one past the last for none. pieces, mass_g: (n,).
    scarcity: (n,), how much of the box's rare masses they take: the sum over pieces of 1 / count.
    """

    vector: ComplexArray
    items: IntArray
    pieces: IntArray
    mass_g: FloatArray
    scarcity: FloatArray
    placements: Placements
    index: IntArray

    @classmethod
    def of(cls, sums: Sums, placements: Placements, fixed: complex) -> PlaneList:
        """List `sums` of these placements."""
        items = placements.item[sums.index]
        return cls(
            vector=sums.vector + fixed,
            items=items,
            pieces=(sums.index != placements.none).sum(axis=1),
            mass_g=placements.mass[sums.index].sum(axis=1),
            scarcity=(1.0 / placements.counts[items]).sum(axis=1),
            placements=placements,
            index=sums.index,
        )

    def only(self, pieces: int) -> PlaneList:
        """Those of exactly this many pieces."""
        keep = self.pieces == pieces
        return PlaneList(
            self.vector[keep],
            self.items[keep],
            self.pieces[keep],
            self.mass_g[keep],
            self.scarcity[keep],
            self.placements,
            self.index[keep],
        )

    def selection(self, row: int) -> tuple[Piece, ...]:
        """Pieces of one entry."""
        return self.placements.pieces(self.index[row])


@dataclass(frozen=True)
class Joint:
    """n selections of all planes: rows (n, P) in the planes' lists, and vector sums (n, P) in g."""

    lists: list[PlaneList]
    rows: IntArray
    vectors: ComplexArray

    def __len__(self) -> int:
        return len(self.rows)

    def total(self, name: str, chosen: IntArray) -> FloatArray:
        """Sum over the planes of `pieces`, `mass_g` or `scarcity`, of the chosen rows."""
        parts = [getattr(where, name)[self.rows[chosen, p]] for p, where in enumerate(self.lists)]
        return np.asarray(np.sum(parts, axis=0), dtype=np.float64)

    def in_the_box(self, chosen: IntArray, counts: IntArray) -> BoolArray:
        """Which of the chosen rows the box can supply."""
        parts = [where.items[self.rows[chosen, p]] for p, where in enumerate(self.lists)]
        items = np.concatenate(parts, axis=1)
        limits = np.append(counts, np.iinfo(np.int64).max)
        fits = np.ones(len(items), dtype=bool)
        for j in range(items.shape[1]):
            fits &= (items == items[:, j : j + 1]).sum(axis=1) <= limits[items[:, j]]
        return fits

    def selection(self, row: int) -> tuple[tuple[Piece, ...], ...]:
        """Pieces of one row, per plane."""
        return tuple(where.selection(int(i)) for where, i in zip(self.lists, self.rows[row], strict=True))


@dataclass(frozen=True)
class Ceiling:
    """What a joint choice must not exceed: norm of the group lengths |rows x + offsets| <= level, as in `bounds`."""

    rows: FloatArray  # (G, k, 2 P)
    offsets: FloatArray  # (G, k)
    norm: str
    level: float

    @classmethod
    def of(cls, bounds: Bounds, level: float) -> Ceiling:
        """The objective's values up to `level`."""
        return cls(bounds.rows, bounds.offsets, bounds.norm, level / bounds.unit * (1.0 + SLACK) + SLACK * TINY_PART)


@dataclass(frozen=True)
class _Step:
    """How one more plane is searched: T(u - middle(x)) within the room that the form of the planes before it leaves."""

    columns: Columns
    turn: FloatArray  # (2, 2)
    follow: FloatArray  # (2, 2 d): middle = centre - follow @ (x - centre of the planes before)
    form: FloatArray  # (2 d, 2 d) shadow on the planes before it
    tangent: _Tangent


@dataclass(frozen=True)
class _Tangent:
    """Objective along what is left to choose: it is convex, so nothing is below its tangent at the middle of the room.

    residual = at_centre + away @ known, gradient = direction . rest, whose least value over the room follows from
    `spread`.
    """

    norm: str
    level: float
    shape: tuple[int, int]
    at_centre: FloatArray  # (G k,)
    known: FloatArray  # (2 d, G k)
    rest: FloatArray  # (G k, 2 (P - d))
    spread: FloatArray  # (2 (P - d), 2 (P - d)) inverse form of what is left

    @classmethod
    def of(cls, ceiling: Ceiling, region: Ellipsoid, before: IntArray, after: IntArray) -> _Tangent:
        """Tangent where the coordinates `before` are known and `after` are left."""
        flat = ceiling.rows.reshape(-1, ceiling.rows.shape[2])
        mine = region.form[np.ix_(after, after)]
        follow = np.linalg.solve(mine, region.form[np.ix_(after, before)])
        return cls(
            norm=ceiling.norm,
            level=ceiling.level,
            shape=ceiling.offsets.shape,
            at_centre=flat @ region.centre + ceiling.offsets.ravel(),
            known=(flat[:, before] - flat[:, after] @ follow).T,
            rest=flat[:, after],
            spread=np.asarray(np.linalg.inv(mine), dtype=np.float64),
        )

    def at(self, away: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Value (n,) at the middle of the room of `away` (n, 2 d), and the gradient (n, 2 (P - d)) there."""
        r = (self.at_centre + rows_times(away, self.known)).reshape(-1, *self.shape)
        length = np.sqrt(np.einsum("ngk,ngk->ng", r, r))
        along = r / np.maximum(length, TINY_PART)[:, :, None]
        if self.norm == "max":
            largest = length.argmax(axis=1)
            value = length[np.arange(len(r)), largest]
            along *= (np.arange(self.shape[0]) == largest[:, None])[:, :, None]
        else:
            value = length.sum(axis=1)
        return value, rows_times(along.reshape(len(r), -1), self.rest)

    def least(self, value: FloatArray, gradient: FloatArray, room: FloatArray) -> FloatArray:
        """Least value (n,) of the tangent over the rooms."""
        fall = np.einsum("ni,ij,nj->n", gradient, self.spread, gradient)
        return np.asarray(value - np.sqrt(np.maximum(fall * room, 0.0)), dtype=np.float64)


def combine(lists: list[PlaneList], region: Ellipsoid, ceiling: Ceiling) -> Iterator[Joint]:
    """Yield every joint choice within `region` in chunks, box not yet asked; a chunk may be empty.

    Those above the ceiling are left out as far as a tangent of the objective tells.
    """
    if any(len(chosen.vector) == 0 for chosen in lists):
        return
    order = np.argsort([len(chosen.vector) for chosen in lists], kind="stable")
    nothing = Joint(lists, np.empty((0, len(lists)), np.int64), np.empty((0, len(lists)), np.complex128))
    steps = []
    for d in range(1, len(order)):
        steps.append(_step(lists, region, order, d, ceiling))
        yield nothing
    start = np.arange(len(lists[order[0]].vector))[:, None]
    for rows in _extend(lists, region, order, steps, start):
        back = np.empty_like(rows)
        back[:, order] = rows
        vectors = np.stack([chosen.vector[back[:, p]] for p, chosen in enumerate(lists)], axis=1)
        yield Joint(lists, back, vectors)


def combine_up_to(lists: list[PlaneList], region: Ellipsoid, ceiling: Ceiling, most: int) -> Iterator[Joint]:
    """As `combine`, with at most `most` pieces in all planes together: every split of them by itself."""
    nothing = Joint(lists, np.empty((0, len(lists)), np.int64), np.empty((0, len(lists)), np.complex128))
    by_pieces: list[list[PlaneList]] = []
    for chosen in lists:
        longest = int(chosen.pieces.max(initial=0))
        by_pieces.append([])
        for k in range(min(most, longest) + 1):
            by_pieces[-1].append(chosen.only(k))
            yield nothing
    for split in _splits(by_pieces, most):
        yield nothing
        yield from combine(split, region, ceiling)


def _splits(by_pieces: list[list[PlaneList]], most: int) -> Iterator[list[PlaneList]]:
    """A list of each plane, of at most `most` pieces together, where none is empty."""
    if not by_pieces:
        yield []
        return
    first, *rest = by_pieces
    for k, chosen in enumerate(first[: most + 1]):
        if len(chosen.vector):
            for others in _splits(rest, most - k):
                yield [chosen, *others]


def _step(lists: list[PlaneList], region: Ellipsoid, order: IntArray, depth: int, ceiling: Ceiling) -> _Step:
    """Search of plane number `depth` in the order, given those before it."""
    planes = order[: depth + 1]
    every = np.stack([2 * order, 2 * order + 1], axis=1).ravel()
    coordinates = every[: 2 * depth + 2]
    shadow = np.linalg.inv(np.linalg.inv(region.form)[np.ix_(coordinates, coordinates)])
    mine, cross = shadow[-2:, -2:], shadow[-2:, :-2]
    turn = np.linalg.cholesky(mine).T
    follow = np.linalg.solve(mine, cross)
    points = _turned(turn, lists[planes[-1]].vector)
    tangent = _Tangent.of(ceiling, region, every[: 2 * depth], every[2 * depth :])
    return _Step(Columns(points, 0.5), turn, follow, shadow[:-2, :-2] - cross.T @ follow, tangent)


def _extend(
    lists: list[PlaneList], region: Ellipsoid, order: IntArray, steps: list[_Step], rows: IntArray
) -> Iterator[IntArray]:
    """Extend partial choices (n, d), planes in `order`, by all remaining planes."""
    depth = rows.shape[1]
    if depth == len(order):
        yield rows
        return
    step = steps[depth - 1]
    p = order[depth]
    for cut in range(0, len(rows), BRANCH):
        some = rows[cut : cut + BRANCH]
        known = [lists[q].vector[some[:, d]] for d, q in enumerate(order[:depth])]
        away = np.stack([part for u in known for part in (u.real, u.imag)], axis=1)
        away -= np.concatenate([region.centre[2 * q : 2 * q + 2] for q in order[:depth]])
        room = 1.0 - np.einsum("ni,ij,nj->n", away, step.form, away)
        inside = np.flatnonzero(room >= 0.0)
        value, gradient = step.tangent.at(away[inside])
        low = step.tangent.least(value, gradient, room[inside]) <= step.tangent.level
        inside, value, gradient = inside[low], value[low], gradient[low]
        middle = region.centre[2 * p : 2 * p + 2] - rows_times(away[inside], step.follow.T)
        queries = _turned(step.turn, middle[:, 0] + 1j * middle[:, 1])
        kept = some[inside]
        for query, point in step.columns.pairs(queries, np.sqrt(room[inside])):
            if depth == len(order) - 1:
                u = lists[p].vector[point]
                rise = gradient[query, 0] * (u.real - middle[query, 0]) + gradient[query, 1] * (
                    u.imag - middle[query, 1]
                )
                low = value[query] + rise <= step.tangent.level
                query, point = query[low], point[low]
            yield from _extend(lists, region, order, steps, np.concatenate([kept[query], point[:, None]], axis=1))


def _turned(turn: FloatArray, z: ComplexArray) -> ComplexArray:
    return np.asarray(
        turn[0, 0] * z.real + turn[0, 1] * z.imag + 1j * (turn[1, 0] * z.real + turn[1, 1] * z.imag),
        dtype=np.complex128,
    )
