"""Documents that break a rule: refused when they are written, set apart when they are read.

A document is validated in one place, the column type of `db.types`, by the same rules in both directions and whatever
code computed it. What is stored and cannot be read (an older version wrote it, a disk damaged it) does not end the
query that meets it: an `Unreadable` takes its place, and only code that uses the document gets `UnreadableRow`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NoReturn

from pydantic import ValidationError

MAX_SHOWN = 80
"""Characters of a value that a fault shows."""


@dataclass(frozen=True)
class Fault:
    """Why a document is refused or set apart. table, key, column: where it is stored, as far as is known."""

    field: str
    """Path of the field that breaks a rule, such as readings[0].scatter; empty for a text that is no JSON."""
    rule: str
    """The rule, as the validator states it."""
    value: str | None
    """The value, shortened; None where the field is missing."""
    table: str = ""
    key: str = ""
    column: str = ""

    def __str__(self) -> str:
        """One line: row, field, rule, value."""
        place = ".".join(part for part in (self.column, self.field) if part) or "document"
        row = f"{self.table} {self.key}: " if self.table else ""
        got = "" if self.value is None else f", got {self.value}"
        return f"{row}{place}: {self.rule}{got}"

    def at(self, table: str, key: str, column: str) -> Fault:
        """The same fault, of this row and column."""
        return replace(self, table=table, key=key, column=column)


class DocumentRefused(ValueError):
    """A document that was about to be stored breaks a rule by which it would be read."""

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault


class UnreadableRow(Exception):
    """A stored document was used that cannot be read."""

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault


def fault_in(error: ValueError) -> Fault:
    """The first rule that a text breaks; error: what the validator raised."""
    if not isinstance(error, ValidationError):
        return Fault(field="", rule=str(error), value=None)
    first = error.errors(include_url=False, include_context=False)[0]
    path = ""
    for part in first["loc"]:
        path += f"[{part}]" if isinstance(part, int) else f".{part}" if path else str(part)
    is_named = first["type"] not in ("missing", "json_invalid")
    return Fault(field=path, rule=first["msg"], value=_short(first["input"]) if is_named else None)


def require_finite(value: object, path: str = "") -> None:
    """Raise DocumentRefused for a number that JSON cannot hold, anywhere in lists and dictionaries."""
    if isinstance(value, float) and not math.isfinite(value):
        raise DocumentRefused(Fault(field=path, rule="Input should be a finite number", value=str(value)))
    if isinstance(value, dict):
        for name, part in value.items():
            require_finite(part, f"{path}.{name}" if path else str(name))
    if isinstance(value, list | tuple):
        for index, part in enumerate(value):
            require_finite(part, f"{path}[{index}]")


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= MAX_SHOWN else f"{text[:MAX_SHOWN]} ..."


class Unreadable:
    """Takes the place of a document that cannot be read. Any use of it raises `UnreadableRow`; ask `fault_of` first."""

    __slots__ = ("_fault",)
    __dataclass_fields__: ClassVar[dict[str, Any]] = {}
    """So that `dataclasses.replace` asks for its fields, and gets `UnreadableRow` too."""

    def __init__(self, fault: Fault) -> None:
        object.__setattr__(self, "_fault", fault)

    def __getattribute__(self, name: str) -> Any:
        if name != "__class__":
            _refuse(self)
        return object.__getattribute__(self, name)

    def __repr__(self) -> str:
        return f"<unreadable {fault_of(self)}>"

    def __iter__(self) -> Iterator[Any]:
        _refuse(self)

    def __len__(self) -> int:
        _refuse(self)

    def __getitem__(self, _key: object) -> Any:
        _refuse(self)


def _refuse(value: Unreadable) -> NoReturn:
    raise UnreadableRow(object.__getattribute__(value, "_fault"))


def fault_of(value: object) -> Fault | None:
    """Why a value that was read from a document column cannot be used; None for a document."""
    return object.__getattribute__(value, "_fault") if type(value) is Unreadable else None


def name_fault(value: object, table: str, key: str, column: str) -> Fault | None:
    """Tell an unreadable document which row it is of; its fault, None for a document."""
    fault = fault_of(value)
    if fault is not None and not fault.table:
        fault = fault.at(table, key, column)
        object.__setattr__(value, "_fault", fault)
    return fault
