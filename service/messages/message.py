"""A message as data, and the kinds of parameter that it may have."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

PartKind = Literal["run", "plane", "sensor"]


@dataclass(frozen=True)
class Quantity:
    """A number with the unit it is stored in (g, mm, g.mm, mm/s, r/min, deg, s, ...); the reader's unit may differ."""

    value: float
    unit: str


@dataclass(frozen=True)
class Word:
    """A word of the product's vocabulary, such as `trial` or `planned`: `word.<name>` in the catalogue."""

    name: str


@dataclass(frozen=True)
class Part:
    """A run, plane or sensor of the session, by its name or else its number, from 1.

    note: what is added to a run (its kind) or to a sensor (the speed it was read at).
    """

    kind: PartKind
    number: int
    name: str | None = None
    note: Word | Quantity | None = None


Parameter: TypeAlias = "str | float | int | bool | Quantity | Word | Part | Message | tuple[Parameter, ...] | None"
"""Text is shown as it is: names that users gave, values that they sent. A tuple is a list of the sentence."""


@dataclass(frozen=True, init=False)
class Message:
    """A text of the catalogue by its key, `code` or `code.variant`, with the values that it names.

    Parameters may be numpy scalars, lists or other iterables too; they are kept as plain numbers and tuples.
    """

    key: str
    parameters: Mapping[str, Parameter]

    def __init__(self, key: str, /, **parameters: Any) -> None:
        object.__setattr__(self, "key", key)
        object.__setattr__(self, "parameters", {name: plain(value) for name, value in parameters.items()})

    @property
    def code(self) -> str:
        """The stable code of the error or finding, without the variant."""
        return self.key.partition(".")[0]


def plain(value: Any) -> Parameter:
    """A parameter in its own type. Whatever is none of them is kept as its text."""
    if value is None or isinstance(value, str | bool | Quantity | Word | Part | Message):
        # The text of a string, not its subclass: an enumeration's member would be written by its name.
        return str(value) if type(value) is not str and isinstance(value, str) else value
    if isinstance(value, int | float):
        return float(value) if isinstance(value, float) else int(value)
    if hasattr(value, "tolist"):  # arrays and scalars of numpy, which this room does not import
        return plain(value.tolist())
    if isinstance(value, Iterable):
        return tuple(plain(one) for one in value)
    return str(value)
