"""Design studies: linkages, flywheels, gear pairs and shaft sets."""

from __future__ import annotations

from fastapi import APIRouter

from service.api.dependencies import Key, WorkDep, errors
from service.api.strict_json import StrictRoute
from service.model.design import (
    DesignCheck,
    DesignEvaluation,
    DesignFront,
    DesignFrontRequest,
    DesignOptimiseRequest,
    DesignOutcome,
    DesignPreset,
    DesignRequest,
    DesignSummary,
    DesignVerdict,
)
from service.usecases.designs import answers

router = APIRouter(route_class=StrictRoute)


@router.get("/designs", tags=["designs"], responses=errors())
def list_designs() -> tuple[DesignSummary, ...]:
    """Published systems that the product brings as design documents; no quantity with a unit."""
    return answers.list_presets()


@router.get("/designs/{name}", tags=["designs"], responses=errors(404))
def get_design(name: Key) -> DesignPreset:
    """The document of a published system, in the units of its own table `units`."""
    return answers.get_preset(name)


@router.get("/designs/{name}/verdict", tags=["designs"], responses=errors(404, 503))
def get_design_verdict(work: WorkDep, name: Key) -> DesignVerdict:
    """Published designs of a system evaluated again: what they do and break, and the optimum. Units of its document."""
    return answers.judge(work, name)


@router.post("/design-checks", tags=["designs"], responses=errors())
def check_design(work: WorkDep, request: DesignRequest) -> DesignCheck:  # noqa: ARG001  every POST has its key
    """Everything that is wrong with a design document, and warnings; nothing is stored. Units of the document."""
    return answers.check(request)


@router.post("/design-evaluations", tags=["designs"], responses=errors(503))
def evaluate_design(work: WorkDep, request: DesignRequest) -> DesignEvaluation:
    """What a design does and which limits it breaks, in the units of its document; nothing is stored."""
    return answers.evaluate(work, request)


@router.post("/design-optima", tags=["designs"], responses=errors(503))
def optimise_design(work: WorkDep, request: DesignOptimiseRequest) -> DesignOutcome:
    """The best design within the limits of a document, in its units, with what speaks for it; nothing is stored."""
    return answers.optimise(work, request)


@router.post("/design-fronts", tags=["designs"], responses=errors(503))
def trade_design_off(work: WorkDep, request: DesignFrontRequest) -> DesignFront:
    """Designs that no other beats in the two responses of `aim.front`, in SI units or ratios; nothing is stored."""
    return answers.front(work, request)
