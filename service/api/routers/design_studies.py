"""Design studies that are kept, with their versions."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path

from service.api.dependencies import Key, Limit, Offset, SeenDep, WorkDep, errors
from service.api.strict_json import StrictRoute
from service.model.design_run import DesignStudy, DesignStudyRequest, DesignStudyVersion
from service.usecases.designs import studies

router = APIRouter(route_class=StrictRoute)
Version = Annotated[int, Path(ge=1, le=1_000_000_000, description="Number of a version.")]


@router.post("/design-studies", status_code=201, tags=["designs"], responses=errors())
def create_design_study(work: WorkDep, study: DesignStudyRequest) -> DesignStudy:
    """Keep a design study; a document that breaks a rule is refused. Quantities in the document's own units."""
    return studies.create(work, study)


@router.get("/design-studies", tags=["designs"], responses=errors())
def list_design_studies(work: WorkDep, limit: Limit = 50, offset: Offset = 0) -> tuple[DesignStudy, ...]:
    """Studies that are kept, the one changed last first. Quantities in each document's own units."""
    return studies.find(work, limit, offset)


@router.get("/design-studies/{study_id}", tags=["designs"], responses=errors(404))
def get_design_study(work: WorkDep, study_id: Key) -> DesignStudy:
    """A study as it stands. Quantities in the document's own units."""
    return studies.get(work, study_id)


@router.put("/design-studies/{study_id}", tags=["designs"], responses=errors(404, 412))
def change_design_study(work: SeenDep, study_id: Key, study: DesignStudyRequest) -> DesignStudy:
    """Store the next version of a study; the same again changes nothing. Quantities in the document's own units."""
    return studies.change(work, study_id, study)


@router.get("/design-studies/{study_id}/versions", tags=["designs"], responses=errors(404))
def list_design_study_versions(work: WorkDep, study_id: Key) -> tuple[DesignStudyVersion, ...]:
    """Every version of a study, the newest first, as the history tells them. Each in its document's own units."""
    return studies.versions(work, study_id)


@router.get("/design-studies/{study_id}/versions/{version}", tags=["designs"], responses=errors(404))
def get_design_study_version(work: WorkDep, study_id: Key, version: Version) -> DesignStudyVersion:
    """A study as it was at a version. Quantities in the document's own units."""
    return studies.version(work, study_id, version)
