"""Refusals of the mechanics: input for which no answer exists."""

from __future__ import annotations

from service.errors import NumericsError
from service.messages import Message


class Refusal(NumericsError):
    """Input that the mechanics cannot take; the message's parameters `field` and `value` say what."""

    def __init__(self, message: Message) -> None:
        field = message.parameters.get("field")
        super().__init__(
            message, field=field if isinstance(field, str) else None, value=message.parameters.get("value")
        )
