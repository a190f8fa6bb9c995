"""Parameters of messages in JSON: numbers, texts and lists as they are, the other kinds as objects that say which.

A quantity is {"value": 12.5, "unit": "g"}, a word {"word": "trial"}, a part {"part": "run", "number": 3, "name": null,
"note": ...}, a message {"key": "...", "parameters": {...}}.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, cast

from service.messages.message import Message, Parameter, Part, Quantity, Word


def parameters_json(message: Message) -> dict[str, Any]:
    """The parameters of a message as JSON holds them; a number that is not finite as its text."""
    return {name: _plain(value) for name, value in message.parameters.items()}


def from_json(key: str, parameters: Mapping[str, Any]) -> Message:
    """A stored message. An object of no known kind is kept as its text."""
    return Message(key, **{name: _read(value) for name, value in parameters.items()})


def _plain(value: Parameter) -> Any:
    if isinstance(value, Message):
        return {"key": value.key, "parameters": parameters_json(value)}
    if isinstance(value, Quantity):
        return {"value": _plain(value.value), "unit": value.unit}
    if isinstance(value, Word):
        return {"word": value.name}
    if isinstance(value, Part):
        return {"part": value.kind, "number": value.number, "name": value.name, "note": _plain(value.note)}
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def _read(value: Any) -> Parameter:
    if isinstance(value, list | tuple):
        return tuple(_read(one) for one in value)
    if not isinstance(value, Mapping):
        return cast("Parameter", value)
    if "unit" in value and "value" in value:
        return Quantity(float(value["value"]), str(value["unit"]))
    if "word" in value:
        return Word(str(value["word"]))
    if "part" in value:
        note = _read(value.get("note"))
        return Part(value["part"], value["number"], value["name"], note if isinstance(note, Word | Quantity) else None)
    if "key" in value:
        return from_json(str(value["key"]), value.get("parameters", {}))
    return str(value)
