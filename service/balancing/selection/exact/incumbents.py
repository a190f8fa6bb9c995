"""Incumbents: the best selections so far, and the tie-break between equal ones.

Order: objective (equal within `TIE`), then fewest pieces, then least mass, then the box's commonest masses, then the
pieces themselves, so that the answer does not depend on the order in which it was found.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from service.balancing.rotor.phasors import FloatArray, IntArray
from service.balancing.selection.exact.plane_join import Joint
from service.balancing.selection.placements import Selection

TIE = 1e-9
"""Relative difference below which two values are one."""
NOTHING = 1e-12
"""Part of the value without any piece below which a value is as good as zero."""
BLOCK = 4096
MAX_EQUALS = 4096
"""Equals that are told apart by their pieces."""

Key = tuple[float, float, float, float]


@dataclass(frozen=True, order=True)
class Entry:
    """One selection: `key` orders by objective, pieces, mass and scarcity."""

    key: Key
    selection: Selection
    value: float


class Incumbents:
    """The `keep` best selections that were offered.

    scale: the objective without any piece. good_enough: values up to it are all equal, so that fewest pieces, least
    mass and commonest stock decide among them.
    """

    def __init__(self, keep: int, scale: float, good_enough: float = 0.0) -> None:
        self.entries: list[Entry] = []
        self._keep = keep
        self._least = max(NOTHING * scale, good_enough, 1e-300)

    @property
    def cap(self) -> float:
        """Value up to which a selection may still enter; infinite while there are fewer than wanted."""
        return max(self.entries[-1].value, self._least) if len(self.entries) == self._keep else math.inf

    def offer(self, selection: Selection, value: float, pieces: int, mass_g: float, scarcity: float) -> None:
        """Take one selection if it is good enough and new."""
        grade = float(self._grade(np.array([value]))[0])
        entry = Entry((grade, pieces, round(mass_g, 9), round(scarcity, 12)), selection, value)
        if all(entry.selection != other.selection for other in self.entries):
            self.entries = sorted([*self.entries, entry])[: self._keep]

    def rate(self, joint: Joint, values: FloatArray, counts: IntArray) -> None:
        """Take the best of `joint` that the box can supply."""
        good = np.flatnonzero(values <= self.cap * (1.0 + 2.0 * TIE))
        if not good.size:
            return
        sums = [joint.total(name, good) for name in ("scarcity", "mass_g", "pieces")]
        keys = np.stack([np.round(sums[0], 12), np.round(sums[1], 9), sums[2], self._grade(values[good])])
        order = np.lexsort(keys)
        good, keys = good[order], keys[:, order]
        taken, last = 0, -1
        for cut in range(0, len(good), BLOCK):
            block = np.arange(cut, min(cut + BLOCK, len(good)))
            for at in block[joint.in_the_box(good[block], counts)].tolist():
                # Of equals beyond those that are kept, the pieces themselves decide: all of them are offered.
                if taken >= self._keep and (keys[:, at] != keys[:, last]).any():
                    return
                pieces, mass, scarcity = keys[2, at], sums[1][order[at]], sums[0][order[at]]
                self.offer(joint.selection(int(good[at])), float(values[good[at]]), int(pieces), mass, scarcity)
                taken, last = taken + 1, at
            if taken >= self._keep + MAX_EQUALS:
                return

    def _grade(self, values: FloatArray) -> FloatArray:
        """Whole numbers in the order of the values, one for all that are equal within `TIE`."""
        return np.asarray(np.round(np.log(np.maximum(values, self._least)) / TIE), dtype=np.float64)
