"""The kernel on documents, without storage: runs -> correction -> plan.

The door for other programs and notebooks: documents in, documents out (docs/reference/python.md). What it names is
loaded when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from service.engine.logs.replay import Resolved, read_log, resolve
    from service.engine.offline import correct, plan
    from service.engine.rotor_state import Drum, changes_to, mounted, on_rotor
    from service.engine.session_state import Progress, next_step
    from service.model.correction import Correction, CorrectionRequest
    from service.model.machine import Catalogue, CatalogueItem, Machine, Plane, Sensor
    from service.model.plan import Placement, Plan, PlanRequest
    from service.model.run import MassOnRotor, Run, RunReading
    from service.model.session import SessionLog

_HOMES = {
    "service.engine.logs.replay": ("Resolved", "read_log", "resolve"),
    "service.engine.offline": ("correct", "plan"),
    "service.engine.rotor_state": ("Drum", "changes_to", "mounted", "on_rotor"),
    "service.engine.session_state": ("Progress", "next_step"),
    "service.model.correction": ("Correction", "CorrectionRequest"),
    "service.model.machine": ("Catalogue", "CatalogueItem", "Machine", "Plane", "Sensor"),
    "service.model.plan": ("Placement", "Plan", "PlanRequest"),
    "service.model.run": ("MassOnRotor", "Run", "RunReading"),
    "service.model.session": ("SessionLog",),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Catalogue",
    "CatalogueItem",
    "Correction",
    "CorrectionRequest",
    "Drum",
    "Machine",
    "MassOnRotor",
    "Placement",
    "Plan",
    "PlanRequest",
    "Plane",
    "Progress",
    "Resolved",
    "Run",
    "RunReading",
    "Sensor",
    "SessionLog",
    "changes_to",
    "correct",
    "mounted",
    "next_step",
    "on_rotor",
    "plan",
    "read_log",
    "resolve",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module. Raises AttributeError for any other."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
