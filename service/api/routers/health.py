"""Whether the service is well."""

from __future__ import annotations

from fastapi import APIRouter, Response

from db.documents.base import document
from service.api.dependencies import WorkDep
from service.version import __version__

router = APIRouter()


@document
class Health:
    """State of the service."""

    status: str
    """ok, or broken when the database does not answer."""
    version: str
    """Version of Drumtrue."""
    database: str
    """ok, or what the database said."""


@router.get("/health", tags=["health"], responses={503: {"model": Health, "description": "The database is gone."}})
def get_health(work: WorkDep, response: Response) -> Health:
    """Ask the service and its database for a sign of life. There is no quantity with a unit."""
    try:
        with work.read() as store:
            store.ping()
    except Exception as broken:
        response.status_code = 503
        return Health(status="broken", version=__version__, database=type(broken).__name__)
    return Health(status="ok", version=__version__, database="ok")
