"""A reading from untrusted JSON values, held to the rules that `Reading` states itself."""

from __future__ import annotations

import math
import types
from collections.abc import Mapping
from dataclasses import MISSING, fields
from datetime import UTC, datetime
from functools import cache
from typing import Any, Union, get_args, get_origin, get_type_hints

from annotated_types import Ge, Gt, Le, Len

from drivers.reading import Reading

_Rule = tuple[type, bool, tuple[Any, ...], bool]
"""Type, whether null is allowed, the rules, whether it must be stated."""


def reading_from_dict(values: object) -> Reading:
    """Make a reading of a JSON object. Raises ValueError naming field, value and rule."""
    if not isinstance(values, Mapping):
        raise ValueError(f"{_short(values)} is no JSON object")
    rules = _rules()
    for name in values:
        if name not in rules:
            raise ValueError(f"field {_short(name)} is unknown")
    found: dict[str, Any] = {}
    for name, (kind, optional, checks, needed) in rules.items():
        value = values.get(name)
        if value is None:
            if needed and not optional:
                raise ValueError(f"{name} is not stated")
            continue
        found[name] = _checked(name, value, kind, checks)
    return Reading(**found)


def _checked(name: str, value: object, kind: type, checks: tuple[Any, ...]) -> object:
    if kind is datetime:
        return _moment(name, value)
    allowed = (int, float) if kind is float else (kind,)
    if isinstance(value, bool) or not isinstance(value, allowed):
        raise ValueError(f"{name} is {_short(value)}, which is no {kind.__name__}")
    if kind is float:
        value = _number(name, value)
    for check in checks:
        holds, rule = _holds(check, value)
        if not holds:
            raise ValueError(f"{name} is {_short(value)}, it must {rule}")
    return value


def _number(name: str, value: Any) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{name} is {_short(value)}, which is not finite")
    return number


def _moment(name: str, value: object) -> datetime:
    try:
        moment = datetime.fromisoformat(value) if isinstance(value, str) else None
        if moment is not None and moment.tzinfo is not None:
            return moment.astimezone(UTC)
    except (ValueError, OverflowError):
        pass
    raise ValueError(f"{name} is {_short(value)}, which is no time with a zone (RFC 3339)")


def _holds(check: Any, value: Any) -> tuple[bool, str]:
    if isinstance(check, Ge):
        return value >= check.ge, f"be {check.ge} or more"
    if isinstance(check, Gt):
        return value > check.gt, f"be above {check.gt}"
    if isinstance(check, Le):
        return value <= check.le, f"be {check.le} or less"
    if isinstance(check, Len):
        most = math.inf if check.max_length is None else check.max_length
        return check.min_length <= len(value) <= most, f"have {check.min_length} to {most} characters"
    return True, ""


@cache
def _rules() -> dict[str, _Rule]:
    """The rules in the annotations of `Reading`."""
    hints = get_type_hints(Reading, include_extras=True)
    found: dict[str, _Rule] = {}
    for field in fields(Reading):
        options = [hints[field.name]]
        if get_origin(options[0]) in (Union, types.UnionType):
            options = [one for one in get_args(options[0]) if one is not type(None)]
        kind, *checks = get_args(options[0]) or (options[0],)
        found[field.name] = (kind, field.default is None, tuple(checks), field.default is MISSING)
    return found


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
