"""The protocol of a design study: a document, and what is computed from it.

A study offers four functions on a document: check (findings), simulate (responses), problem (what may vary, objective
and limits for the solvers of `service.optimize`) and verdict (published designs evaluated again). Everything is in SI.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from service.design.findings import Finding
from service.design.reading import Asked
from service.design.units import PURE
from service.mechanics.bodies import FloatArray
from service.optimize.epsilon import TwoObjectives
from service.optimize.problem import MixedProblem
from service.optimize.smooth import SmoothProblem

Document = Mapping[str, Any]
Sense = Literal["at_most", "at_least"]

VIOLATED = 1e-6
"""A limit that is passed by more than this part of itself is broken."""
ACTIVE = 1e-6
"""A limit within this part of itself binds the design."""


@dataclass(frozen=True)
class Scalar:
    """A response: one number in SI."""

    name: str
    value: float
    quantity: str = PURE


@dataclass(frozen=True)
class Curve:
    """A response over something: arrays x and y of one length, in SI."""

    name: str
    x: FloatArray
    y: FloatArray
    x_quantity: str
    y_quantity: str


@dataclass(frozen=True)
class LimitCheck:
    """A limit and what the design has. excess: how far it is passed, as part of the limit; below 0 within it.

    where: the place that the limit speaks of, such as a link's name, or None.
    """

    code: str
    value: float
    limit: float
    sense: Sense
    excess: float
    quantity: str = PURE
    where: str | None = None

    @property
    def violated(self) -> bool:
        """Whether the design breaks the limit."""
        return self.excess > VIOLATED

    @property
    def active(self) -> bool:
        """Whether the limit holds the design back."""
        return abs(self.excess) <= ACTIVE


def limit_check(
    code: str, value: float, limit: float, sense: Sense, quantity: str = PURE, where: str | None = None
) -> LimitCheck:
    """A limit check with its excess, as part of the limit (of 1 where the limit is 0)."""
    scale = abs(limit) or 1.0
    excess = (value - limit) / scale if sense == "at_most" else (limit - value) / scale
    return LimitCheck(code, value, limit, sense, excess, quantity, where)


@dataclass(frozen=True)
class Simulation:
    """What a design does. drawing: plain data for pictures, kinds depend on the study."""

    scalars: tuple[Scalar, ...]
    curves: tuple[Curve, ...] = ()
    limits: tuple[LimitCheck, ...] = ()
    warnings: tuple[Finding, ...] = ()
    drawing: Mapping[str, Any] = field(default_factory=dict)

    def value(self, name: str) -> float:
        """A scalar by its name."""
        return next(one.value for one in self.scalars if one.name == name)

    @property
    def feasible(self) -> bool:
        """Whether no limit is broken."""
        return not any(one.violated for one in self.limits)


@dataclass(frozen=True)
class Variable:
    """What may vary. Values in SI; present: of the document's own design."""

    name: str
    lower: float
    upper: float
    present: float
    quantity: str = PURE


@dataclass(frozen=True)
class DesignProblem:
    """A study's document as an optimisation problem.

    maximise: the objective is shown with its sign turned. alternatives: the feasible set is the union of the regions
    of these problems (most often one). front: two responses to trade off. exact: the proved optimum by other means,
    where there is one (x, objective), None where nothing is feasible; proved: whether it is more than the best
    found. apply: a design x as a document.
    """

    variables: tuple[Variable, ...]
    objective_name: str
    maximise: bool
    alternatives: tuple[SmoothProblem, ...]
    apply: Callable[[FloatArray], Document]
    objective_quantity: str = PURE
    mixed: MixedProblem | None = None
    exact: Callable[[], tuple[FloatArray, float] | None] | None = None
    proved: bool = False
    front_names: tuple[str, str] | None = None
    front: TwoObjectives | None = None


class Study(Protocol):
    """One kind of study."""

    name: str

    def check(self, document: Document) -> tuple[Finding, ...]:
        """Everything that is wrong with a document, and warnings; never raises for bad values."""

    def asked(self, document: Document) -> Mapping[str, Asked]:
        """The fields of a document by path, with their quantities and choices."""

    def simulate(self, document: Document) -> Simulation:
        """Responses of the document's own design; raises RefusedDesign as `check` says."""

    def problem(self, document: Document) -> DesignProblem:
        """The document as an optimisation problem; raises RefusedDesign as `check` says."""
