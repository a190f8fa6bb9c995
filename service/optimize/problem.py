"""A mixed-variable problem: minimise f(x) under g(x) <= 0, some variables continuous, some not.

Populations are arrays (n, d) of real values; a discrete variable takes one of its listed values, a circular one lives
on a circle, where the last value and the first are neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from service.errors import NumericsError
from service.messages import Message

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Evaluate = Callable[[FloatArray], tuple[FloatArray, FloatArray]]

FEASIBILITY = 1e-9
"""A scaled constraint above this is violated. Not 0: an identity such as F/K + (Fmax - F)/K - Fmax/K leaves 2e-16."""


@dataclass(frozen=True)
class Continuous:
    """Any value from lower to upper."""

    lower: float
    upper: float

    def snap(self, x: FloatArray) -> FloatArray:
        """Clip to the bounds."""
        return np.clip(x, self.lower, self.upper)


@dataclass(frozen=True)
class Integer:
    """A whole number from lower to upper, both included."""

    lower: int
    upper: int

    def snap(self, x: FloatArray) -> FloatArray:
        """Nearest whole number; halfway goes down."""
        return np.clip(np.ceil(x - 0.5), self.lower, self.upper)


@dataclass(frozen=True)
class Discrete:
    """One of the listed values, in ascending order."""

    values: tuple[float, ...]

    @property
    def lower(self) -> float:
        """Smallest value."""
        return self.values[0]

    @property
    def upper(self) -> float:
        """Greatest value."""
        return self.values[-1]

    def snap(self, x: FloatArray) -> FloatArray:
        """Nearest listed value; halfway goes to the lower one."""
        allowed, between = self._grid
        return np.asarray(allowed[np.searchsorted(between, x, side="left")])

    @cached_property
    def _grid(self) -> tuple[FloatArray, FloatArray]:
        """The values, and the midpoints between them."""
        allowed = np.asarray(self.values, dtype=np.float64)
        return allowed, (allowed[1:] + allowed[:-1]) / 2.0


@dataclass(frozen=True)
class Circular:
    """One of the listed values on a circle of circumference `period`; ascending, 0 <= value < period."""

    values: tuple[float, ...]
    period: float = 2.0 * math.pi

    @property
    def lower(self) -> float:
        """Start of the circle."""
        return 0.0

    @property
    def upper(self) -> float:
        """End of the circle, the same point as its start."""
        return self.period

    def snap(self, x: FloatArray) -> FloatArray:
        """Nearest listed value around the circle."""
        allowed, between, seam = self._grid
        turned = np.mod(x - seam, self.period)
        return np.asarray(allowed[np.searchsorted(between, turned, side="left")])

    @cached_property
    def _grid(self) -> tuple[FloatArray, FloatArray, float]:
        """The values, the midpoints between them from the seam on, and the seam, between the last and the first."""
        allowed = np.asarray(self.values, dtype=np.float64)
        between = (np.append(allowed[1:], allowed[0] + self.period) + allowed) / 2.0
        seam = float(between[-1]) - self.period
        return allowed, between[:-1] - seam, seam


Variable = Continuous | Integer | Discrete | Circular


@dataclass(frozen=True)
class MixedProblem:
    """Variables, and `evaluate`: (n, d) values -> objective (n,) and scaled constraints (n, c), <= 0 where satisfied.

    repair: (n, d) -> (n, d), an optional last touch that turns a snapped member into a feasible one.
    """

    variables: tuple[Variable, ...]
    evaluate: Evaluate
    repair: Callable[[FloatArray], FloatArray] | None = None

    @property
    def lower(self) -> FloatArray:
        """(d,) lower bounds."""
        return np.array([v.lower for v in self.variables], dtype=np.float64)

    @property
    def upper(self) -> FloatArray:
        """(d,) upper bounds."""
        return np.array([v.upper for v in self.variables], dtype=np.float64)

    @property
    def periods(self) -> FloatArray:
        """(d,) circumference of circular variables, 0 for the others."""
        return np.array([v.period if isinstance(v, Circular) else 0.0 for v in self.variables])

    def snap(self, x: FloatArray) -> FloatArray:
        """Nearest allowed member, repaired, for each row of x (n, d)."""
        snapped = np.empty_like(x)
        for variable, columns in self._alike:
            snapped[:, columns] = variable.snap(x[:, columns])
        return self.repair(snapped) if self.repair is not None else snapped

    @cached_property
    def _alike(self) -> list[tuple[Variable, IntArray]]:
        """Each variable object once, with the columns that hold it."""
        columns: dict[int, list[int]] = {}
        for i, variable in enumerate(self.variables):
            columns.setdefault(id(variable), []).append(i)
        return [(self.variables[found[0]], np.array(found)) for found in columns.values()]


def validate(problem: MixedProblem) -> None:
    """Raise NumericsError for a problem without variables or a variable without an allowed value."""
    if not problem.variables:
        raise NumericsError(Message("numerics.no_variable"), field="variables")
    first = {id(variable): number for number, variable in reversed(list(enumerate(problem.variables)))}
    for number in sorted(first.values()):
        variable, name = problem.variables[number], f"variable {number}"
        if isinstance(variable, Discrete | Circular):
            _listed(variable, name)
        elif not (math.isfinite(variable.lower) and math.isfinite(variable.upper) and variable.lower <= variable.upper):
            raise NumericsError(
                Message("numerics.bounds_not_finite", name=name, lower=variable.lower, upper=variable.upper), field=name
            )


def _listed(variable: Discrete | Circular, name: str) -> None:
    values = np.asarray(variable.values, dtype=np.float64)
    if values.size == 0 or not np.isfinite(values).all() or (np.diff(values) <= 0.0).any():
        raise NumericsError(Message("numerics.values_not_ascending", name=name), field=name)
    if isinstance(variable, Circular) and not (values[0] >= 0.0 and values[-1] < variable.period):
        raise NumericsError(
            Message(
                "numerics.values_outside_period", name=name, first=values[0], last=values[-1], period=variable.period
            ),
            field=name,
        )
