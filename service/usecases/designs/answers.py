"""Design studies over HTTP: presets, checks, evaluations, optima, fronts and verdicts. Nothing is stored.

Values go out in the units of the document; a search takes a turn among the selections, ends at its time limit and
when its client hangs up.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from service.design import optimising
from service.design.documents import preset, presets
from service.design.findings import Finding, RefusedDesign
from service.design.registry import check as check_document
from service.design.registry import study_of
from service.design.study import LimitCheck, Simulation
from service.design.units import shown, unit_of
from service.design.verdict import ClaimCheck, verdict
from service.errors import NotFound
from service.messages import Message
from service.model import design as told
from service.runtime.context import AppContext

VERDICT_STEPS = 12
"""Starts of the optimum in a verdict; the document can be optimised with more."""


def list_presets() -> tuple[told.DesignSummary, ...]:
    """The published systems."""
    found = ((name, preset(name)) for name in presets())
    return tuple(told.DesignSummary(name=name, study=doc["study"], title=doc["title"]) for name, doc in found)


def get_preset(name: str) -> told.DesignPreset:
    """A published system. Raises NotFound."""
    if name not in presets():
        raise NotFound(
            Message("design_preset_unknown", field="name", value=name, known=presets()), field="name", value=name
        )
    return told.DesignPreset(name=name, document=preset(name))


def check(request: told.DesignRequest) -> told.DesignCheck:
    """Everything that is wrong with a document."""
    found = check_document(request.document)
    return told.DesignCheck(
        findings=tuple(map(_finding, found)), accepted=all(one.severity != "refusal" for one in found)
    )


def evaluate(work: AppContext, request: told.DesignRequest) -> told.DesignEvaluation:
    """What the design of a document does; raises RefusedDesign."""
    with work.turns.turn():
        return evaluated(request.document)


def evaluated(document: told.DesignDocument) -> told.DesignEvaluation:
    """The same without a turn among the selections: it takes some milliseconds."""
    simulation = study_of(document).simulate(document)
    units = _units(document)
    curves = tuple(
        told.DesignCurve(
            name=one.name,
            x=tuple(shown(value, one.x_quantity, units) for value in one.x.tolist()),
            y=tuple(shown(value, one.y_quantity, units) for value in one.y.tolist()),
            x_unit=unit_of(one.x_quantity, units),
            y_unit=unit_of(one.y_quantity, units),
        )
        for one in simulation.curves
    )
    return told.DesignEvaluation(
        responses=_responses(simulation, units), curves=curves, drawing=dict(simulation.drawing)
    )


def methods(document: told.DesignDocument) -> tuple[str, ...]:
    """Methods that can optimise a document, the best known first; none where nothing of it is free."""
    try:
        return optimising.methods(document)
    except RefusedDesign:
        return ()


def has_front(document: told.DesignDocument) -> bool:
    """Whether a document has two responses to trade off."""
    try:
        optimising.require_front(document)
    except RefusedDesign:
        return False
    return True


def optimise(work: AppContext, request: told.DesignOptimiseRequest) -> told.DesignOutcome:
    """The best design that a method finds; raises RefusedDesign."""
    with work.turns.turn():
        found = optimising.optimise(
            request.document,
            request.method,
            request.seed,
            request.steps,
            stop=work.gone,
            clock=work.monotonic,
            deadline_s=request.time_limit_s,
        )
    return outcome(found, request.document)


def front(work: AppContext, request: told.DesignFrontRequest) -> told.DesignFront:
    """The front of the two responses that a document trades off; raises RefusedDesign."""
    with work.turns.turn():
        found = optimising.front(
            request.document,
            request.points,
            request.seed,
            ceiling=ceiling(request.ceiling),
            stop=work.gone,
            clock=work.monotonic,
            deadline_s=request.time_limit_s,
        )
    return front_of(found)


def front_of(found: optimising.FrontOutcome) -> told.DesignFront:
    """A front as it is answered."""
    rows = zip(found.objectives.tolist(), found.documents, strict=True)
    points = tuple(
        told.DesignFrontPoint(first=pair[0], second=pair[1], design=dict(document["design"])) for pair, document in rows
    )
    return told.DesignFront(names=found.names, points=points, complete=found.complete, seed=found.seed)


def judge(work: AppContext, name: str) -> told.DesignVerdict:
    """The published designs of a system, evaluated again, and the optimum. Raises NotFound."""
    document = get_preset(name).document
    units = _units(document)
    with work.turns.turn():
        found = verdict(document, steps=None if name.startswith("gear") else VERDICT_STEPS)
    quantity = found.optimum.quantity
    designs = tuple(
        told.PublishedDesign(
            name=one.name,
            claims=tuple(_claim(claim, units) for claim in one.claims),
            broken=tuple(_limit(limit, units) for limit in one.broken),
            objective=_number(one.objective, quantity, units),
            optimum=_number(one.optimum.value, quantity, units),
        )
        for one in found.designs
    )
    return told.DesignVerdict(title=found.title, designs=designs, optimum=outcome(found.optimum, document))


def ceiling(stated: float | None) -> float:
    """The greatest second response of interest, infinite where none is stated."""
    return math.inf if stated is None else stated


def in_unit(value: float, quantity: str, document: told.DesignDocument) -> tuple[float | None, str]:
    """A value in SI in the unit of a document, and that unit; None where it has none."""
    units = _units(document)
    return _number(value, quantity, units), unit_of(quantity, units)


def _units(document: told.DesignDocument) -> Mapping[str, str]:
    units = document.get("units", {})
    return units if isinstance(units, dict) else {}


def _finding(one: Finding) -> told.DesignFinding:
    return told.DesignFinding(
        code=one.code, severity=one.severity, field=one.field, message=one.message, advice=one.advice
    )


def _responses(simulation: Simulation, units: Mapping[str, str]) -> told.DesignResponses:
    scalars = tuple(
        told.DesignScalar(
            name=one.name, value=_number(one.value, one.quantity, units), unit=unit_of(one.quantity, units)
        )
        for one in simulation.scalars
    )
    return told.DesignResponses(
        scalars=scalars,
        limits=tuple(_limit(one, units) for one in simulation.limits),
        feasible=simulation.feasible,
        warnings=tuple(map(_finding, simulation.warnings)),
    )


def _limit(one: LimitCheck, units: Mapping[str, str]) -> told.DesignLimit:
    return told.DesignLimit(
        code=one.code,
        where=one.where,
        value=shown(one.value, one.quantity, units),
        limit=shown(one.limit, one.quantity, units),
        sense=one.sense,
        unit=unit_of(one.quantity, units),
        violated=one.violated,
        active=one.active,
    )


def _claim(one: ClaimCheck, units: Mapping[str, str]) -> told.DesignClaim:
    published, computed = (shown(value, one.quantity, units) for value in (one.claimed, one.computed))
    return told.DesignClaim(
        response=one.response, published=published, computed=computed, unit=unit_of(one.quantity, units)
    )


def outcome(found: optimising.Outcome, document: told.DesignDocument) -> told.DesignOutcome:
    """An optimum as it is answered, in the units of its document."""
    units = _units(document)
    evidence, result = found.evidence, found.result
    return told.DesignOutcome(
        method=found.method,
        status=result.status,
        objective=found.objective,
        value=_number(found.value, found.quantity, units),
        unit=unit_of(found.quantity, units),
        evidence=told.DesignEvidence(
            kind=evidence.kind,
            bound=evidence.bound,
            residual=evidence.residual,
            agreeing=evidence.agreeing,
            starts=evidence.starts,
        ),
        before=_responses(found.before, units),
        after=_responses(found.after, units),
        document=dict(found.document),
        sensitivities=found.sensitivities,
        evaluations=result.evaluations,
        seconds=result.seconds,
        seed=result.seed,
    )


def _number(value: float, quantity: str, units: Mapping[str, str]) -> float | None:
    return shown(value, quantity, units) if math.isfinite(value) else None
