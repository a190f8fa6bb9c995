"""All arrangements better than a level, by meeting in the middle.

The places are split in two halves. For every choice of the parts of one half and of the other, all orders of both are
listed, and joined where their residuals add up to something better than the best so far (`near_pairs`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from service.balancing.arrangement.exact.near_pairs import Table, near_pairs
from service.balancing.arrangement.exact.region import Axes
from service.balancing.arrangement.exact.slots import Slots
from service.balancing.rotor.phasors import ComplexArray, IntArray

FIRST_BLOCK, MAX_BLOCK = 20_000, 120_000
"""Orders of one half in a step: the first ones are few, since what they find narrows the search of the others."""
MAX_CHOICES = 2_000_000
"""Choices of parts for both halves that are listed."""


def order_count(slots: Slots) -> float:
    """Orders of both halves over all choices of their parts, which the time of the search is in proportion to."""
    first, second = _half_sizes(slots)
    choices = math.comb(slots.size, first) * math.comb(slots.size - first, second)
    return float(choices) * (math.factorial(first) + math.factorial(second))


def choice_count(slots: Slots) -> float:
    """Choices of parts for both halves."""
    first, second = _half_sizes(slots)
    return float(math.comb(slots.size, first)) * math.comb(slots.size - first, second)


def better_arrangements(slots: Slots, axes: Axes, level: list[float]) -> Iterator[IntArray]:
    """Yield parts (n, open places) that may be better than `level[0]`, which the caller lowers between the steps.

    Everything better than the level at the end has been yielded then. Steps take some ten milliseconds. Needs
    `choice_count` <= MAX_CHOICES.
    """
    first, second = _half_sizes(slots)
    places = _split(slots, first)
    one, two = _choices(slots.size, first, second)
    begin, block = 0, FIRST_BLOCK
    per_choice = math.factorial(first) + math.factorial(second)
    while begin < len(one):
        end = begin + max(1, block // per_choice)
        low, high = axes.box(level[0])
        a = _orders(slots, one[begin:end], places[:first])
        b = _orders(slots, two[begin:end], places[first:])
        left = Table(a.group, axes.coordinates(a.sum + slots.offset))
        right = Table(b.group, axes.coordinates(b.sum))
        for i, j in near_pairs(left, right, low, high):
            found = np.empty((len(i), slots.open_places), dtype=np.int64)
            found[:, places[:first]] = one[begin + a.group[i]][np.arange(len(i))[:, None], a.order[i]]
            found[:, places[first:]] = two[begin + b.group[j]][np.arange(len(j))[:, None], b.order[j]]
            yield found
        yield np.empty((0, slots.open_places), dtype=np.int64)
        begin, block = end, min(2 * block, MAX_BLOCK)


@dataclass(frozen=True)
class _Orders:
    """Orders of chosen parts: which choice (n,), which of its parts in each place (n, h), and their sum (n, S)."""

    group: IntArray
    order: IntArray
    sum: ComplexArray


def _half_sizes(slots: Slots) -> tuple[int, int]:
    first = slots.open_places // 2
    return first, slots.open_places - first


def _split(slots: Slots, first: int) -> IntArray:
    """Slots of both halves: every other place, so that each half can point anywhere."""
    order = np.concatenate([np.arange(0, slots.open_places, 2), np.arange(1, slots.open_places, 2)])
    return order[::-1] if len(range(0, slots.open_places, 2)) != first else order


def _choices(size: int, first: int, second: int) -> tuple[IntArray, IntArray]:
    """Parts (n, first) and (n, second) of both halves, all choices."""
    ones = np.array(list(combinations(range(size), first)), dtype=np.int64).reshape(math.comb(size, first), first)
    inside = np.zeros((len(ones), size), dtype=np.bool_)
    np.put_along_axis(inside, ones, True, axis=1)
    left = np.nonzero(~inside)[1].reshape(len(ones), size - first)
    ways = math.comb(size - first, second)
    picks = np.array(list(combinations(range(size - first), second)), dtype=np.int64).reshape(ways, second)
    return np.repeat(ones, len(picks), axis=0), left[:, picks].reshape(len(ones) * len(picks), second)


def _orders(slots: Slots, chosen: IntArray, places: IntArray) -> _Orders:
    """Every allowed order of the parts (n, h) in the slots (h,)."""
    h = chosen.shape[1]
    group = np.arange(len(chosen), dtype=np.int64)
    order = np.empty((len(chosen), 0), dtype=np.int8)
    total = np.zeros((len(chosen), slots.offset.shape[0]), dtype=np.complex128)
    used = np.zeros(len(chosen), dtype=np.int64)
    for place in places:
        free = (used[:, None] >> np.arange(h)) & 1 == 0
        fits = slots.allowed[chosen[:, :], place] if len(chosen) else np.zeros((0, h), dtype=np.bool_)
        row, local = np.nonzero(free & fits[group])
        part = chosen[group[row], local]
        total = total[row] + slots.effects[part, place]
        order = np.concatenate([order[row], local[:, None].astype(np.int8)], axis=1)
        used = used[row] | (1 << local)
        group = group[row]
    return _Orders(group, order.astype(np.int64), total)
