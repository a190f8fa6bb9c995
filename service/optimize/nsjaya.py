"""NSJAYA: Jaya for fronts, by ranks and crowding distance (thesis, chapter 3 and appendix A).

x' = x + r1 (best - |x|) - r2 (worst - |x|), best a random end of the first rank, worst the last member; old and new are
merged and cut; then the quasi-opposite of the whole population likewise (2 evaluations a member and iteration).
`improved` drops the modulus and the quasi-opposition, which pull to the centre of the box.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from service.optimize.evolving_front import FrontGeneration, FrontSearchProblem, Members

Rules = Literal["improved", "published"]


class Nsjaya(Iterator[FrontGeneration]):
    """Iterator over generations; the first one is the initial population."""

    def __init__(
        self, problem: FrontSearchProblem, members: int, rng: np.random.Generator, rules: Rules = "improved"
    ) -> None:
        self._problem, self._size, self._rng = problem, members, rng
        self._published = rules == "published"
        self.members: Members | None = None

    def __next__(self) -> FrontGeneration:
        """Advance by one generation."""
        if self.members is None:
            self.members = Members(self._problem, self._size, self._rng)
            return self.members.generation()
        members, rng = self.members, self._rng
        x = members.x
        ends = np.flatnonzero((members.ranks == 0) & np.isinf(members.distance))
        best = x[rng.choice(ends)]
        size = np.abs(x) if self._published else x
        moved = x + rng.random(x.shape) * (best - size) - rng.random(x.shape) * (x[-1] - size)
        members.join(np.clip(moved, self._problem.lower, self._problem.upper))
        if self._published:
            centre = (self._problem.lower + self._problem.upper) / 2.0
            opposite = self._problem.lower + self._problem.upper - members.x
            members.join(centre + rng.random(x.shape) * (opposite - centre))
        members.number += 1
        return members.generation()
