"""What all documents share: strictness, named field rules, reading and writing JSON."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from functools import cache
from typing import Annotated, Any, TypeVar, cast, dataclass_transform

from annotated_types import Ge, Le, Len
from pydantic import (
    AfterValidator,
    AwareDatetime,
    ConfigDict,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    StringConstraints,
    TypeAdapter,
)
from pydantic_core import CoreSchema

from service.messages import Message
from service.model.faults import BrokenRule

T = TypeVar("T")

STRICT = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)


@dataclass_transform(frozen_default=True, kw_only_default=True)
def document(cls: type[T]) -> type[T]:
    """Make `cls` a frozen keyword-only dataclass that pydantic validates strictly."""
    cls.__pydantic_config__ = STRICT  # type: ignore[attr-defined]
    cls.__get_pydantic_core_schema__ = classmethod(_schema_made_once)  # type: ignore[attr-defined]
    cls.__get_pydantic_json_schema__ = classmethod(_described)  # type: ignore[attr-defined]
    return dataclass(frozen=True, kw_only=True)(cls)


def _schema_made_once(cls: Any, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
    """Pydantic's own schema of a document, made at its first use.

    A document is part of many others and of many routes. pydantic would read the class for each of them, and every
    start of the service would take seconds longer.
    """
    if "_schema" not in cls.__dict__:
        cls._schema = None  # being made: the call from within asks pydantic
        cls._schema = TypeAdapter(cls).core_schema
    return cls._schema or handler(source)


def _described(cls: Any, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
    """Describe the fields in the API document."""
    from service.model.descriptions import describe  # reads source text, which validation never needs

    return describe(cls, schema, handler)


Name = Annotated[
    str, StringConstraints(min_length=1, max_length=100, strip_whitespace=True, pattern=r"^[^\x00-\x1f\x7f]*$")
]
Key = Annotated[str, StringConstraints(pattern=r"^[0-9A-Za-z_.-]{1,32}$")]
Text = Annotated[str, StringConstraints(max_length=2000, pattern=r"^[^\x00]*$")]
Reason = Annotated[str, StringConstraints(min_length=1, max_length=2000, strip_whitespace=True, pattern=r"^[^\x00]*$")]
"""A text that says something."""
Positive = Annotated[float, Ge(1e-9), Le(1e9)]
Scatter = Annotated[float, Ge(1e-15), Le(1e9)]
"""Of a displacement in m it is far below any other positive number."""
NotNegative = Annotated[float, Ge(0), Le(1e9)]
Finite = Annotated[float, Ge(-1e9), Le(1e9)]
AngleDeg = Annotated[float, Ge(-360), Le(360)]
Count = Annotated[int, Ge(1), Le(1_000_000)]
Small = Annotated[int, Ge(1), Le(20)]
Sequence = Annotated[int, Ge(0), Le(2**53 - 1)]
Seed = Annotated[int, Ge(0), Le(2**53 - 1)]
YEARS = range(1900, 9999)
"""Times that can be written in any zone."""


def _writable(moment: datetime) -> datetime:
    if moment.year not in YEARS:
        raise BrokenRule(Message("invalid_input.moment", first=str(YEARS.start), last=str(YEARS.stop - 1)))
    return moment


Moment = Annotated[AwareDatetime, AfterValidator(_writable)]
"""A time with its zone, RFC 3339."""

MAX_LIST = Len(0, 1000)
"""Longest list inside a document; bulk readings have their own limit."""


@cache
def adapter(kind: Any) -> TypeAdapter[Any]:
    """The validator of a document type, built once."""
    return TypeAdapter(kind)


def read_json(kind: type[T], text: str | bytes) -> T:
    """A document from JSON text. Raises pydantic.ValidationError where a rule is broken."""
    value: T = adapter(cast(Any, kind)).validate_json(text)
    return value


def write_json(value: object, kind: Any = None) -> str:
    """JSON text of a document."""
    return adapter(kind or cast(Any, type(value))).dump_json(value, by_alias=True).decode()


def to_plain(value: object, kind: Any = None) -> Any:
    """A document as dictionaries, lists and numbers that the json module takes."""
    return adapter(kind or cast(Any, type(value))).dump_python(value, mode="json", by_alias=True)
