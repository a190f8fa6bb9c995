"""A message as data, as documents store it next to its English text."""

from __future__ import annotations

from dataclasses import field
from typing import Any

from service.messages import Message, from_json, parameters_json
from service.model.base import document


@document
class MessageData:
    """The key of a text in the catalogue, and its values: a client renders it in its own language and units."""

    key: str
    """Key in the catalogue of messages (docs/reference/codes.md)."""
    parameters: dict[str, Any] = field(default_factory=dict)
    """The values in the text, by name: numbers and texts, lists of them, and objects for quantities ({value, unit}),
    words ({word}), runs, planes and sensors ({part, number, name, note}) and other messages ({key, parameters})."""

    @property
    def message(self) -> Message:
        """As the renderer takes it."""
        return from_json(self.key, self.parameters)


def message_data(message: Message | None) -> MessageData | None:
    """A message as documents store it."""
    return None if message is None else MessageData(key=message.key, parameters=parameters_json(message))
