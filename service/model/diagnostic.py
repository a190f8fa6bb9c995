"""What the technician should know."""

from __future__ import annotations

from dataclasses import field
from typing import Literal

from service.model.base import document

Severity = Literal["info", "warning", "error"]
Parameter = str | float | int | None


@document
class Diagnostic:
    """Something the technician should know."""

    code: str
    """Stable code."""
    severity: Severity
    """info, warning or error."""
    message: str
    """What was seen, with its value."""
    advice: str
    """What to do."""
    runs: tuple[int, ...] = ()
    """Numbers of the runs it is about; empty: all."""
    planes: tuple[str, ...] = ()
    """Planes it is about; empty: all."""
    sensors: tuple[str, ...] = ()
    """Sensors it is about; empty: all."""
    parameters: dict[str, Parameter] = field(default_factory=dict)
    """The values in `message` and `advice`, by name; empty for codes that state none."""
