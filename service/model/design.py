"""Design studies over HTTP: a document in, responses, optima, fronts and verdicts out. Nothing of them is stored."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from annotated_types import Ge, Gt, Le

from service.model.base import Seed, Text, document

DesignDocument = dict[str, Any]
"""The tables of a design file, TOML or JSON alike; docs/reference/designs.md has its fields."""


@document
class DesignSummary:
    """A published system that the product brings."""

    name: Text
    """Its name, by which it is asked for."""
    study: Text
    """Kind of study: linkage, flywheel, gear_pair or shaft_set."""
    title: Text
    """What it is."""


@document
class DesignPreset:
    """A published system with its document."""

    name: Text
    """Its name."""
    document: DesignDocument
    """Its document; quantities in the units that its table `units` states."""


@document
class DesignRequest:
    """A document to check or evaluate."""

    document: DesignDocument
    """The document; quantities in the units that its table `units` states."""


@document
class DesignFinding:
    """Something wrong with a document, or worth knowing."""

    code: Text
    """Stable code."""
    severity: Literal["refusal", "warning"]
    """Whether the document is refused for it."""
    field: Text | None
    """Path of the field, or null."""
    message: Text
    """What is wrong."""
    advice: Text
    """What to do."""


@document
class DesignCheck:
    """What was found in a document."""

    findings: tuple[DesignFinding, ...]
    """Everything that is wrong, and warnings; empty where nothing is."""
    accepted: bool
    """Whether nothing was refused."""


@document
class DesignScalar:
    """A response of a design."""

    name: Text
    """Its name."""
    value: float | None
    """Its value, in `unit`; null where it has none, such as a ratio to 0."""
    unit: Text
    """Its unit, as the document states it; empty for a number without one."""


@document
class DesignLimit:
    """A limit and what the design has."""

    code: Text
    """Which limit."""
    where: Text | None
    """Where it holds, such as a link or a radius, or null."""
    value: float
    """What the design has, in `unit`."""
    limit: float
    """The limit, in `unit`."""
    sense: Literal["at_most", "at_least"]
    """Which side of the limit is allowed."""
    unit: Text
    """The unit of both."""
    violated: bool
    """Whether the design breaks it, by more than a millionth of it."""
    active: bool
    """Whether it holds the design back."""


@document
class DesignCurve:
    """A response over something."""

    name: Text
    """Its name."""
    x: tuple[float, ...]
    """Places, in `x_unit`."""
    y: tuple[float, ...]
    """Values, in `y_unit`."""
    x_unit: Text
    """Unit of the places."""
    y_unit: Text
    """Unit of the values."""


@document
class DesignResponses:
    """What a design does."""

    scalars: tuple[DesignScalar, ...]
    """Numbers with their units."""
    limits: tuple[DesignLimit, ...]
    """Every limit with what the design has."""
    feasible: bool
    """Whether no limit is broken."""
    warnings: tuple[DesignFinding, ...]
    """What is worth knowing."""


@document
class DesignEvaluation:
    """What a design does, with what a page draws of it."""

    responses: DesignResponses
    """Numbers and limits."""
    curves: tuple[DesignCurve, ...]
    """Curves, such as the shaking force over a turn or stresses over the radius."""
    drawing: dict[str, Any]
    """Data of the drawing: joints over a turn in m, outline in m, diameters in mm or vibration; `kind` says which."""


@document
class DesignOptimiseRequest:
    """What to optimise, and how."""

    document: DesignDocument
    """The document; quantities in the units that its table `units` states."""
    method: Text | None = None
    """sqp, enumeration, de_standard, differential_search, jaya, ...; null: the best known."""
    seed: Seed = 1
    """Which starts or population."""
    steps: Annotated[int, Ge(1), Le(100_000)] | None = None
    """Starts of sqp, generations of the others; null: enough by default."""
    time_limit_s: Annotated[float, Gt(0), Le(60)] = 20.0
    """Time after which the best so far is answered, s."""


@document
class DesignEvidence:
    """What speaks for an answer."""

    kind: Literal["proved_bound", "kkt", "starts_agree", "none"]
    """A proved bound, residuals of the optimality conditions, starts that agree, or nothing."""
    bound: float | None
    """The proved bound of the objective, in its unit in SI."""
    residual: float | None
    """Greatest residual of the optimality conditions."""
    agreeing: int | None
    """Starts that ended in the same optimum."""
    starts: int | None
    """Starts in all."""


@document
class DesignOutcome:
    """An optimised design."""

    method: Text
    """The method used."""
    status: Literal["optimal", "converged", "limit_reached", "stopped", "infeasible"]
    """optimal: proved; converged: residuals vanish and starts agree; infeasible: no design keeps all limits."""
    objective: Text
    """The response that was optimised."""
    value: float | None
    """Its value, in `unit`."""
    unit: Text
    """Its unit."""
    evidence: DesignEvidence
    """What speaks for it."""
    before: DesignResponses
    """The present design."""
    after: DesignResponses
    """The design found."""
    document: DesignDocument
    """The document with the design found."""
    sensitivities: dict[str, float]
    """Limit -> change of the objective in % for 1 % more of it."""
    evaluations: int
    """How often the objective was computed."""
    seconds: float
    """How long it took, s."""
    seed: Seed
    """The seed used."""


@document
class DesignFrontRequest:
    """Which front to compute."""

    document: DesignDocument
    """The document; quantities in the units that its table `units` states."""
    points: Annotated[int, Ge(2), Le(200)] = 30
    """How many points between the ends."""
    ceiling: Annotated[float, Gt(0), Le(1e9)] | None = None
    """Greatest second response of interest, as it is answered; null: up to the end."""
    seed: Seed = 1
    """Which starts."""
    time_limit_s: Annotated[float, Gt(0), Le(60)] = 30.0
    """Time after which the points so far are answered, s."""


@document
class DesignFrontPoint:
    """A design that no other beats in both responses."""

    first: float
    """First response, in SI or as a ratio."""
    second: float
    """Second response, in SI or as a ratio."""
    design: dict[str, Any]
    """The table `design` of its document, in the document's units."""


@document
class DesignFront:
    """Designs that trade two responses off."""

    names: tuple[Text, Text]
    """Names of the two responses."""
    points: tuple[DesignFrontPoint, ...]
    """By rising first response."""
    complete: bool
    """Whether every point was reached before the time limit."""
    seed: Seed
    """The seed used."""


@document
class DesignClaim:
    """A published value and what is computed."""

    response: Text
    """Which response."""
    published: float
    """As published, in `unit`."""
    computed: float
    """As computed, in `unit`."""
    unit: Text
    """The unit of both."""


@document
class PublishedDesign:
    """A published design, evaluated again."""

    name: Text
    """Its name."""
    claims: tuple[DesignClaim, ...]
    """What is claimed of it."""
    broken: tuple[DesignLimit, ...]
    """Limits that it breaks."""
    objective: float | None
    """Its value of what is optimised, in the outcome's unit."""
    optimum: float | None
    """The best value of the same problem."""


@document
class DesignVerdict:
    """What is to be said about the published designs of a system."""

    title: Text
    """The system."""
    designs: tuple[PublishedDesign, ...]
    """Its published designs."""
    optimum: DesignOutcome
    """The honest optimum."""
