"""A named peer of the selection: how it is run, what it found, what it can express."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version

from service.balancing.selection.placements import Selection
from service.balancing.selection.problem import SelectionProblem


@dataclass(frozen=True)
class Found:
    """A peer's answer. lower_bound: 0 where it proves none. ended: it stopped by itself, its search complete.

    trouble: why there is no selection, in the peer's own words.
    """

    selection: Selection | None
    lower_bound: float
    ended: bool
    seconds: float
    trouble: str | None = None


Solve = Callable[[SelectionProblem, int, float], Found]


@dataclass(frozen=True)
class Abilities:
    """What a method can express, as text."""

    joint: str
    stock: str
    capacity: str
    norms: str
    proof: str


@dataclass(frozen=True)
class Peer:
    """A method by name. solve: (problem, seed, budget in s). proves: one run with the whole budget, no seeds."""

    name: str
    package: str
    solve: Solve
    cannot: Callable[[SelectionProblem], str | None]
    proves: bool
    abilities: Abilities

    @property
    def label(self) -> str:
        """Name with the version installed."""
        return f"{self.name} {version(self.package)}" if self.installed else self.name

    @property
    def installed(self) -> bool:
        """Whether its package can be imported."""
        return importlib.util.find_spec(self.package) is not None
