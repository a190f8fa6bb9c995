"""What pydantic finds wrong with a document, as messages of the catalogue."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from service.messages import Message, render


class BrokenRule(ValueError):
    """A rule of our own that a value breaks, raised inside a validator. data: the rule as a message."""

    def __init__(self, data: Message) -> None:
        super().__init__(render(data))
        self.data = data


_RULES: dict[str, Callable[..., Message]] = {
    "json_invalid": partial(Message, "invalid_json"),
    "finite_number": partial(Message, "invalid_input.finite_number"),
    "missing": partial(Message, "invalid_input.missing"),
    "unexpected_keyword_argument": partial(Message, "invalid_input.unexpected_keyword_argument"),
    "string_pattern_mismatch": partial(Message, "invalid_input.string_pattern_mismatch"),
    "string_too_short": partial(Message, "invalid_input.string_too_short"),
    "string_too_long": partial(Message, "invalid_input.string_too_long"),
    "too_short": partial(Message, "invalid_input.too_short"),
    "too_long": partial(Message, "invalid_input.too_long"),
    "greater_than": partial(Message, "invalid_input.greater_than"),
    "greater_than_equal": partial(Message, "invalid_input.greater_than_equal"),
    "less_than": partial(Message, "invalid_input.less_than"),
    "less_than_equal": partial(Message, "invalid_input.less_than_equal"),
    "literal_error": partial(Message, "invalid_input.literal_error"),
    "float_type": partial(Message, "invalid_input.float_type"),
    "int_type": partial(Message, "invalid_input.int_type"),
    "int_from_float": partial(Message, "invalid_input.int_from_float"),
    "string_type": partial(Message, "invalid_input.string_type"),
    "bool_type": partial(Message, "invalid_input.bool_type"),
    "tuple_type": partial(Message, "invalid_input.tuple_type"),
    "list_type": partial(Message, "invalid_input.list_type"),
    "dataclass_type": partial(Message, "invalid_input.dataclass_type"),
}
"""What a rule of pydantic asks for, by its type; its limits are the parameters."""


def message_of(fault: Mapping[str, Any]) -> Message:
    """What is wrong and what to do, of an entry of `ValidationError.errors()`."""
    context = fault.get("ctx") or {}
    if isinstance(broken := context.get("error"), BrokenRule):
        return broken.data
    rule = str(fault["msg"]).removeprefix("Value error, ")
    limits = {name: _limit(limit) for name, limit in context.items()}
    return _RULES.get(str(fault["type"]), partial(Message, "invalid_input"))(**{**limits, "rule": rule})


def _limit(limit: object) -> str:
    """A limit as it is read: 1000000000, not 1000000000.0."""
    return f"{limit:.15g}" if isinstance(limit, float) else str(limit)
