"""What the technician should know."""

from __future__ import annotations

from dataclasses import field
from typing import Any, Literal

from service.messages import Message, from_json, parameters_json, render, render_advice
from service.model.base import document

Severity = Literal["info", "warning", "error"]


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
    key: str | None = None
    """Key of `message` and `advice` in the catalogue, `code` or `code.variant`; null in what older versions stored."""
    parameters: dict[str, Any] = field(default_factory=dict)
    """The values in `message` and `advice`, by name, as MessageData has them; empty for codes that state none."""

    @property
    def data(self) -> Message | None:
        """The message as the renderer takes it; None where only its English text was stored."""
        return None if self.key is None else from_json(self.key, self.parameters)


def diagnostic(
    message: Message,
    severity: Severity,
    *,
    runs: tuple[int, ...] = (),
    planes: tuple[str, ...] = (),
    sensors: tuple[str, ...] = (),
) -> Diagnostic:
    """The document of a message: with its English text, its key and its values."""
    return Diagnostic(
        code=message.code,
        severity=severity,
        message=render(message),
        advice=render_advice(message) or "",
        runs=runs,
        planes=planes,
        sensors=sensors,
        key=message.key,
        parameters=parameters_json(message),
    )
