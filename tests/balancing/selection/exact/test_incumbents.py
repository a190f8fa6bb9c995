"""Incumbents: the best so far, and who wins between equals: fewest pieces, least mass, commonest stock."""

from __future__ import annotations

import math

import numpy as np

from service.balancing.selection.exact.incumbents import TIE, Incumbents
from service.balancing.selection.exact.plane_join import Joint, PlaneList
from service.balancing.selection.exact.subsets import gathered, levels_of, placements_of
from service.balancing.selection.problem import Piece, Stock
from tests.support.numerics.problems import even_positions, plane
from tests.support.numerics.steps import finished


def selection(*positions: int) -> tuple[tuple[Piece, ...], ...]:
    return (tuple(Piece(position, 0) for position in positions),)


def values(record: Incumbents) -> list[float]:
    return [entry.value for entry in record.entries]


def test_keeps_the_best_in_order_and_tells_what_may_still_enter() -> None:
    record = Incumbents(2, 10.0)
    assert record.cap == math.inf
    record.offer(selection(1), 5.0, 1, 10.0, 1.0)
    assert record.cap == math.inf
    record.offer(selection(2), 3.0, 1, 10.0, 1.0)
    assert (values(record), record.cap) == ([3.0, 5.0], 5.0)
    record.offer(selection(3), 4.0, 1, 10.0, 1.0)
    record.offer(selection(4), 9.0, 1, 10.0, 1.0)
    assert values(record) == [3.0, 4.0]


def test_the_same_selection_enters_once() -> None:
    record = Incumbents(2, 10.0)
    record.offer(selection(1), 5.0, 1, 10.0, 1.0)
    record.offer(selection(1), 5.0, 1, 10.0, 1.0)
    assert values(record) == [5.0]


def test_equals_are_told_apart_by_pieces_then_mass_then_stock_then_themselves() -> None:
    record = Incumbents(5, 10.0)
    record.offer(selection(5, 6), 5.0, 2, 5.0, 0.1)
    record.offer(selection(4), 5.0, 1, 20.0, 0.1)
    record.offer(selection(3), 5.0, 1, 10.0, 1.0)
    record.offer(selection(2), 5.0, 1, 10.0, 0.5)
    record.offer(selection(1), 5.0, 1, 10.0, 0.5)
    order = [[piece.position for piece in entry.selection[0]] for entry in record.entries]
    assert order == [[1], [2], [3], [4], [5, 6]]


def test_what_is_better_by_more_than_the_tie_wins() -> None:
    record = Incumbents(1, 10.0)
    record.offer(selection(1), 5.0, 1, 10.0, 1.0)
    record.offer(selection(2, 3), 5.0 * (1.0 - 3.0 * TIE), 2, 99.0, 1.0)
    assert record.entries[0].selection == selection(2, 3)


def test_up_to_good_enough_all_are_equal() -> None:
    record = Incumbents(1, 10.0, good_enough=4.0)
    record.offer(selection(1, 2), 1.0, 2, 20.0, 1.0)
    record.offer(selection(3), 4.0, 1, 10.0, 1.0)
    assert (values(record), record.cap) == ([4.0], 4.0)


def test_rates_a_joint_as_it_offers_one_by_one() -> None:
    """Of all selections of a plane, those the box can supply, best first; the box holds one heavy piece."""
    box = Stock(np.array([10.0, 40.0]), np.array([2, 1]), np.zeros(2))
    placements = placements_of(plane(even_positions(3), 2, 1), box)
    levels = finished(levels_of(placements, np.arange(placements.none), 2))
    listed = PlaneList.of(finished(gathered(placements, levels, 2)), placements, 0j)
    joint = Joint([listed], np.arange(len(listed.vector))[:, None], listed.vector[:, None])
    worth = np.asarray(np.round(np.abs(listed.vector - 15.0), 3), np.float64)
    by_block, one_by_one = Incumbents(4, 15.0), Incumbents(4, 15.0)
    by_block.rate(joint, worth, box.counts)
    for row in range(len(worth)):
        if joint.in_the_box(np.array([row]), box.counts)[0]:
            one_by_one.offer(
                joint.selection(row),
                float(worth[row]),
                int(listed.pieces[row]),
                float(listed.mass_g[row]),
                float(listed.scarcity[row]),
            )
    assert by_block.entries == one_by_one.entries
