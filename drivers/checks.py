"""Checks of values: errors name the value, the rule and what to do."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import fields

from drivers.errors import InvalidSetting


def require(holds: bool, value: str, rule: str) -> None:
    """Raise `InvalidSetting` "`value` must `rule`: correct it" unless `holds`."""
    if not holds:
        raise InvalidSetting(f"{value} must {rule}: correct it")


def require_finite(record: object) -> None:
    """Raise `InvalidSetting` for a float field of a dataclass that is NaN or infinite."""
    for field in fields(record):  # type: ignore[arg-type]
        value = getattr(record, field.name)
        if isinstance(value, float):
            require(math.isfinite(value), f"{field.name} {value} of {type(record).__name__}", "be a finite number")


def require_distinct(names: Iterable[str], what: str) -> None:
    """Raise `InvalidSetting` for an empty name or one used twice."""
    seen: set[str] = set()
    for name in names:
        require(bool(name), f"name {name!r} of a {what}", "not be empty")
        require(name not in seen, f"name {name!r} of two {what}s", "be used once")
        seen.add(name)


def require_known(name: str, known: Iterable[str], what: str) -> None:
    """Raise `InvalidSetting` naming the known ones unless `name` is among them."""
    choices = sorted(known)
    if name not in choices:
        raise InvalidSetting(f"{what} {name!r} is not on this drum: use one of {', '.join(choices)}")
