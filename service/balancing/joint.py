"""Combine lists of one plane's selections into selections of all planes, within an ellipsoid and the shared box.

Planes are taken from the shortest list to the longest. A partial selection of some planes, lying within the ellipsoid's
shadow, leaves the next plane an ellipse of its own; there the next list is searched.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from service.balancing.neighbours import Columns
from service.balancing.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.region import Ellipsoid
from service.balancing.sums import Bools, Sums

BRANCH = 20_000
"""Partial selections that are extended together."""


@dataclass(frozen=True)
class PlaneList:
    """Selections of one plane.

    vector: (n,) sums with `fixed`, g. items: (n, k) in stock, one past the last for none. pieces: (n,).
    """

    vector: ComplexArray
    items: IntArray
    pieces: IntArray

    @classmethod
    def of(cls, sums: Sums, item: IntArray, fixed: complex) -> PlaneList:
        """List `sums`, whose placements carry the items `item`."""
        items = item[sums.index]
        return cls(sums.vector + fixed, items, (items < item[-1]).sum(axis=1))


@dataclass(frozen=True)
class Joint:
    """n selections of all planes: rows (n, P) in the planes' lists, and vector sums (n, P) in g."""

    rows: IntArray
    vectors: ComplexArray


@dataclass(frozen=True)
class _Step:
    """How one more plane is searched: T(u - middle(x)) within the room that the form of the planes before it leaves."""

    columns: Columns
    turn: FloatArray  # (2, 2)
    follow: FloatArray  # (2, 2 d): middle = centre - follow @ (x - centre of the planes before)
    form: FloatArray  # (2 d, 2 d) shadow on the planes before it


def combine(lists: list[PlaneList], region: Ellipsoid) -> Iterator[Joint]:
    """Yield every joint choice within `region` in chunks, box not yet asked; a chunk may be empty."""
    order = np.argsort([len(chosen.vector) for chosen in lists], kind="stable")
    steps = [_step(lists, region, order[: d + 1]) for d in range(1, len(order))]
    start = np.arange(len(lists[order[0]].vector))[:, None]
    for rows in _extend(lists, region, order, steps, start):
        back = np.empty_like(rows)
        back[:, order] = rows
        vectors = np.stack([chosen.vector[back[:, p]] for p, chosen in enumerate(lists)], axis=1)
        yield Joint(back, vectors)


def in_the_box(lists: list[PlaneList], rows: IntArray, counts: IntArray, most: int | None = None) -> Bools:
    """Which joint choices rows (n, P) the box can supply, and carry at most `most` pieces in all planes together."""
    items = np.concatenate([chosen.items[rows[:, p]] for p, chosen in enumerate(lists)], axis=1)
    limits = np.append(counts, np.iinfo(np.int64).max)
    fits = np.ones(len(rows), dtype=bool)
    for j in range(items.shape[1]):
        fits &= (items == items[:, j : j + 1]).sum(axis=1) <= limits[items[:, j]]
    if most is not None:
        fits &= sum(chosen.pieces[rows[:, p]] for p, chosen in enumerate(lists)) <= most
    return fits


def _step(lists: list[PlaneList], region: Ellipsoid, planes: IntArray) -> _Step:
    """Search of the last of `planes`, given the others."""
    coordinates = np.stack([2 * planes, 2 * planes + 1], axis=1).ravel()
    shadow = np.linalg.inv(np.linalg.inv(region.form)[np.ix_(coordinates, coordinates)])
    mine, cross = shadow[-2:, -2:], shadow[-2:, :-2]
    turn = np.linalg.cholesky(mine).T
    follow = np.linalg.solve(mine, cross)
    points = _turned(turn, lists[planes[-1]].vector)
    return _Step(Columns(points, 0.5), turn, follow, shadow[:-2, :-2] - cross.T @ follow)


def _extend(
    lists: list[PlaneList], region: Ellipsoid, order: IntArray, steps: list[_Step], rows: IntArray
) -> Iterator[IntArray]:
    """Extend partial choices (n, d), planes in `order`, by all remaining planes."""
    depth = rows.shape[1]
    if depth == len(order):
        yield rows
        return
    step = steps[depth - 1]
    for cut in range(0, len(rows), BRANCH):
        some = rows[cut : cut + BRANCH]
        known = [lists[p].vector[some[:, d]] for d, p in enumerate(order[:depth])]
        away = np.stack([part for u in known for part in (u.real, u.imag)], axis=1)
        away -= np.concatenate([region.centre[2 * p : 2 * p + 2] for p in order[:depth]])
        room = 1.0 - np.einsum("ni,ij,nj->n", away, step.form, away)
        inside = room >= 0.0
        p = order[depth]
        middle = region.centre[2 * p : 2 * p + 2] - away[inside] @ step.follow.T
        queries = _turned(step.turn, middle[:, 0] + 1j * middle[:, 1])
        kept = some[inside]
        for query, point in step.columns.pairs(queries, np.sqrt(room[inside])):
            longer = np.concatenate([kept[query], point[:, None]], axis=1)
            yield from _extend(lists, region, order, steps, longer)


def _turned(turn: FloatArray, z: ComplexArray) -> ComplexArray:
    return np.asarray(
        turn[0, 0] * z.real + turn[0, 1] * z.imag + 1j * (turn[1, 0] * z.real + turn[1, 1] * z.imag),
        dtype=np.complex128,
    )
