"""Every error as problem JSON (RFC 9457): a stable code, the field, the value, the rule, and what to do."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import ValidationError
from starlette.exceptions import HTTPException

from db.unreadable import UnreadableRow
from service.api.strict_json import InvalidBody
from service.errors import DrumtrueError, Stale
from service.messages import Message, parameters_json
from service.model.base import document, to_plain
from service.runtime.context import unreadable

MEDIA_TYPE = "application/problem+json"
_ADVICE = {
    "json_invalid": "send the body as JSON text in UTF-8",
    "finite_number": "send a finite number; leave out what was not measured",
    "unexpected_keyword_argument": "leave the field out; the API document lists the fields that are known",
}
_NUMBER, _LIST = "send a number within the limits", "send as many entries as are allowed"
_RULES: dict[str, tuple[str, str]] = {
    "missing": ("this field is required", "state the field"),
    "unexpected_keyword_argument": ("there is no such field here", _ADVICE["unexpected_keyword_argument"]),
    "string_pattern_mismatch": ("the text has characters that {pattern} does not allow", "leave these characters out"),
    "string_too_short": ("the text must have at least {min_length} characters", "write something here"),
    "string_too_long": ("the text must have at most {max_length} characters", "shorten the text"),
    "too_short": ("the list must have at least {min_length} entries", _LIST),
    "too_long": ("the list must have at most {max_length} entries", _LIST),
    "greater_than": ("the number must be greater than {gt}", _NUMBER),
    "greater_than_equal": ("the number must be at least {ge}", _NUMBER),
    "less_than": ("the number must be less than {lt}", _NUMBER),
    "less_than_equal": ("the number must be at most {le}", _NUMBER),
    "literal_error": ("the value must be {expected}", "send {expected}"),
    "float_type": ("a number is needed here", "send a number, without quotation marks"),
    "int_type": ("a whole number is needed here", "send a whole number, without quotation marks"),
    "int_from_float": ("a whole number is needed here", "send a whole number"),
    "string_type": ("a text is needed here", "send a text in quotation marks"),
    "bool_type": ("true or false is needed here", "send true or false, without quotation marks"),
    "tuple_type": ("a list is needed here", "send a list: [...]"),
    "list_type": ("a list is needed here", "send a list: [...]"),
    "dataclass_type": ("an object with named fields is needed here", "send an object: {{...}}"),
}
"""What a rule of pydantic asks for, and what to do, in the words of a reader; its limits stand in braces."""
_MAX_VALUE = 200
_MAX_ERRORS = 20


@document
class Problem:
    """An error, as RFC 9457 has it."""

    type: str
    """Address of the kind of problem: about:blank, `code` tells them apart."""
    title: str
    """The HTTP status in words."""
    status: int
    """The HTTP status."""
    code: str
    """Stable code of the problem."""
    detail: str
    """What is wrong: the value and the rule it breaks."""
    field: str | None
    """The offending field, such as readings[0].amplitude."""
    value: Any
    """The offending value; a number that JSON cannot hold as text."""
    advice: str | None
    """What to do about it."""
    errors: tuple[dict[str, Any], ...] = ()
    """Where several fields are wrong: each with field, detail, value."""
    key: str | None = None
    """Key of `detail` and `advice` in the catalogue of messages, `code` or `code.variant`; null where there is none."""
    parameters: dict[str, Any] | None = None
    """The values in `detail` and `advice`, by name, as MessageData has them."""
    current: Any = None
    """With `version_stale`: the session or plan as it is now; other problems have none."""


def problem(
    status: int,
    code: str,
    detail: str,
    *,
    field: str | None = None,
    value: object = None,
    advice: str | None = None,
    errors: Sequence[dict[str, Any]] = (),
    headers: Mapping[str, str] | None = None,
    current: object = None,
    data: Message | None = None,
) -> JSONResponse:
    """A problem as a response."""
    body = {
        "type": "about:blank",
        "title": HTTPStatus(status).phrase,
        "status": status,
        "code": code,
        "detail": detail,
        "field": field,
        "value": safe(value),
        "advice": advice,
        "errors": list(errors),
        "key": None if data is None else data.key,
        "parameters": None if data is None else parameters_json(data),
    }
    if current is not None:
        body["current"] = to_plain(current)
    return JSONResponse(body, status_code=status, media_type=MEDIA_TYPE, headers=dict(headers or {}))


def safe(value: object) -> object:
    """The value, or its text where JSON cannot hold it or it is long."""
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, list | tuple) and len(value) <= 32 and all(isinstance(v, str | int | float) for v in value):
        return [safe(v) for v in value]
    text = value if isinstance(value, str) else repr(value)
    text = text.encode("utf-8", "replace").decode()
    return text if len(text) <= _MAX_VALUE else text[:_MAX_VALUE] + " ..."


def install(app: FastAPI) -> None:
    """Answer every error of the application with a problem."""
    app.add_exception_handler(DrumtrueError, _deliberate)
    app.add_exception_handler(UnreadableRow, _set_apart)
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(ValidationError, _invalid)
    app.add_exception_handler(InvalidBody, _invalid)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(Exception, _unexpected)


def _unexpected(_request: Request, _error: Exception) -> JSONResponse:
    return problem(
        500,
        "internal_error",
        "the service met something it did not expect; what was asked for is not done",
        advice="try again; if it stays so, send the service's log and the request to who looks after it",
    )


def _deliberate(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, DrumtrueError)  # noqa: S101
    later = {} if error.retry_after_s is None else {"retry-after": str(error.retry_after_s)}
    return problem(
        error.status,
        error.code,
        error.message,
        field=error.field,
        value=error.value,
        advice=error.advice,
        headers=later,
        current=error.current if isinstance(error, Stale) else None,
        data=error.data,
    )


def _set_apart(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, UnreadableRow)  # noqa: S101
    return _deliberate(request, unreadable(error))


def _invalid(_request: Request, error: Exception) -> JSONResponse:
    if isinstance(error, InvalidBody):
        listed = error.errors
    else:
        assert isinstance(error, RequestValidationError | ValidationError)  # noqa: S101
        listed = error.errors()
    found = [_entry(e) for e in listed[:_MAX_ERRORS]]
    first = found[0]
    code = "invalid_json" if first["rule"] == "json_invalid" else "invalid_input"
    return problem(
        422,
        code,
        first["detail"],
        field=first["field"],
        value=first["value"],
        advice=first["advice"],
        errors=found if len(found) > 1 else (),
    )


def _http(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)  # noqa: S101
    phrase = HTTPStatus(error.status_code).phrase
    code = phrase.lower().replace(" ", "_").replace("-", "_")
    advice = "see /docs for the addresses and methods there are" if error.status_code in (404, 405) else None
    return problem(error.status_code, code, str(error.detail), advice=advice, headers=error.headers)


def _entry(error: Mapping[str, Any]) -> dict[str, Any]:
    rule = str(error["type"])
    value = None if rule in ("missing", "json_invalid") else safe(error.get("input"))
    limits = {name: _limit(limit) for name, limit in (error.get("ctx") or {}).items()}
    detail, advice = _RULES.get(rule, ("", ""))
    return {
        "field": _path(error.get("loc", ())),
        "detail": detail.format(**limits) or str(error["msg"]).removeprefix("Value error, "),
        "value": value,
        "rule": rule,
        "advice": advice.format(**limits) or _ADVICE.get(rule) or "look up in the API document what the field may hold",
    }


def _limit(limit: object) -> str:
    """A limit as it is read: 1000000000, not 1000000000.0."""
    return f"{limit:.15g}" if isinstance(limit, float) else str(limit)


def _path(location: Sequence[str | int]) -> str | None:
    """body, readings, 0, amplitude -> readings[0].amplitude."""
    path = ""
    for part in location:
        if isinstance(part, int):
            path += f"[{part}]"
        elif part not in ("body", "query", "path", "header"):
            path += f".{part}" if path else part
    return path or None
