"""What is wrong with a design document, or worth knowing: a message with its severity."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from service.errors import InvalidInput
from service.messages import Message, Parameter, render, render_advice

Severity = Literal["refusal", "warning"]


@dataclass(frozen=True)
class Finding:
    """One problem of a document. The message's parameter `field` is a dotted path of the document, if it has one."""

    data: Message
    severity: Severity = "refusal"

    @property
    def code(self) -> str:
        """The stable code."""
        return self.data.code

    @property
    def message(self) -> str:
        """What is wrong, in English."""
        return render(self.data)

    @property
    def advice(self) -> str:
        """What to do, in English."""
        return render_advice(self.data) or ""

    @property
    def field(self) -> str | None:
        """Path of the field, or None."""
        field = self.data.parameters.get("field")
        return field if isinstance(field, str) else None

    @property
    def value(self) -> Parameter:
        """The value that breaks a rule."""
        return self.data.parameters.get("value")


def warning(message: Message) -> Finding:
    """Something worth knowing that hinders nothing."""
    return Finding(message, "warning")


def of_error(error: InvalidInput, prefix: str = "") -> Finding:
    """A refusal of the numerics as a finding; prefix: path of the table that the numerics call theirs."""
    parameters = dict(error.data.parameters)
    field = ".".join(part for part in (prefix, error.field) if part)
    return Finding(Message(error.data.key, **{**parameters, "field": field}))


class RefusedDesign(InvalidInput):
    """A design document that breaks a rule; findings: all that were found."""

    def __init__(self, findings: Iterable[Finding]) -> None:
        self.findings = tuple(findings)
        first = self.findings[0]
        super().__init__(first.data, field=first.field, value=first.value)


def refusal(message: Message) -> RefusedDesign:
    """The refusal of one message."""
    return RefusedDesign([Finding(message)])
