"""What all selections of a batch share: everything that each plane can carry, listed once."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar, cast

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.exact.plane_table import Table, table_of
from service.balancing.selection.exact.subsets import Placements, gathered, levels_of, many_of, placements_of
from service.balancing.selection.placements import Selection
from service.balancing.selection.problem import SelectionPlane, Stock

Made = TypeVar("Made")

MAX_ROWS = 3_000_000
"""Selections of one plane that are listed."""


@dataclass(frozen=True)
class PlaneRows:
    """All selections of one plane: the table, and of each row (n,) what tells equals apart.

    items: (n, k) in stock, one past the last for none. rank: (n,) order of the rows' pieces.
    """

    table: Table
    placements: Placements
    items: IntArray
    pieces: IntArray
    mass_g: FloatArray
    scarcity: FloatArray
    rank: IntArray
    fixed: complex

    @cached_property
    def sums(self) -> ComplexArray:
        """Vector sums (n,) with what is fixed, g."""
        return self.table.vector + self.fixed

    @cached_property
    def order(self) -> FloatArray:
        """Pieces, mass, scarcity and rank (n, 4), in the order in which they tell equals apart."""
        return np.stack([self.pieces, self.mass_g, self.scarcity, self.rank], axis=1).astype(np.float64)


@dataclass(frozen=True)
class Shared:
    """Rows of every plane, and the box they share. stock_binds: whether some pairs of rows may break its counts."""

    planes: tuple[PlaneRows, ...]
    stock: Stock
    stock_binds: bool

    def selection(self, rows: Sequence[int] | IntArray) -> Selection:
        """Pieces of one row of each plane."""
        return tuple(
            plane.placements.pieces(plane.table.index[int(row)]) for plane, row in zip(self.planes, rows, strict=True)
        )


def shared_rows(planes: Sequence[SelectionPlane], stock: Stock) -> Shared | None:
    """List everything that each plane can carry; None where that is too much, or some plane takes nothing."""
    placements = [placements_of(plane, stock) for plane in planes]
    if any(
        not placed.none or not placed.most or many_of(placed, None, placed.most) > MAX_ROWS for placed in placements
    ):
        return None
    found: list[PlaneRows] = []
    for plane, placed in zip(planes, placements, strict=True):
        same = next((rows for rows in found if _alike(rows.placements, placed)), None)
        found.append(_rows(placed, plane.fixed) if same is None else _moved(same, plane.fixed))
    together = sum(placed.most for placed in placements)
    return Shared(tuple(found), stock, bool((stock.counts < together).any()))


def finished(steps: Generator[None, None, Made]) -> Made:
    """Result of steps that need no stop."""
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return cast(Made, done.value)


def _alike(one: Placements, other: Placements) -> bool:
    """Whether two planes may carry the same selections at the same angles."""
    names = ("position", "item", "mass", "vector", "capacity", "capacity_g", "counts")
    same = all(np.array_equal(getattr(one, name), getattr(other, name)) for name in names)
    return same and one.most == other.most and one.max_mass_g == other.max_mass_g


def _moved(rows: PlaneRows, fixed: complex) -> PlaneRows:
    parts = {name: getattr(rows, name) for name in rows.__dataclass_fields__}
    return PlaneRows(**{**parts, "fixed": fixed})


def _rows(placed: Placements, fixed: complex) -> PlaneRows:
    levels = finished(levels_of(placed, np.arange(placed.none), placed.most))
    everything = finished(gathered(placed, levels, placed.most))
    table = finished(table_of(everything.index, everything.vector))
    items = placed.item[table.index]
    bare = np.where(table.index == placed.none, -1, table.index)
    rank = np.empty(len(bare), dtype=np.int64)
    rank[np.lexsort(bare.T[::-1])] = np.arange(len(bare))
    return PlaneRows(
        table=table,
        placements=placed,
        items=items,
        pieces=(table.index != placed.none).sum(axis=1),
        mass_g=placed.mass[table.index].sum(axis=1),
        scarcity=(1.0 / placed.counts[items]).sum(axis=1),
        rank=rank,
        fixed=fixed,
    )
