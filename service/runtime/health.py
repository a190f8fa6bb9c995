"""Health of the service: database latency and how far each source is behind."""

from __future__ import annotations

from typing import Literal

from service.model.base import document
from service.runtime.context import AppContext

SLOW_S = 0.5
"""A sign of life from the database takes a millisecond; above this something holds it up."""

State = Literal["ready", "slow", "broken"]


@document
class Readiness:
    """Whether the service can do its work."""

    status: State
    """ready; slow: the database answers, but late; broken: it does not."""
    database: str
    """ok, or what the database said."""
    seconds: float
    """How long the database took, s."""


def readiness(work: AppContext) -> Readiness:
    """Ask the database for a sign of life and take the time."""
    begun = work.monotonic()
    try:
        with work.read() as store:
            store.ping()
    except Exception as broken:
        return Readiness(status="broken", database=type(broken).__name__, seconds=work.monotonic() - begun)
    seconds = work.monotonic() - begun
    return Readiness(status="slow" if seconds > SLOW_S else "ready", database="ok", seconds=seconds)
