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
from service.messages import Message, parameters_json, render, render_advice
from service.model.base import document, to_plain
from service.model.faults import message_of
from service.runtime.context import unreadable

MEDIA_TYPE = "application/problem+json"
_MAX_VALUE = 200
_MAX_ERRORS = 20


@document
class Problem:
    """An error, as RFC 9457 has it."""

    type: str
    """Address of the kind of problem: about:blank, `code` tells them apart."""
    title: str
    """The HTTP status as text."""
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
    message: Message,
    *,
    code: str | None = None,
    field: str | None = None,
    value: object = None,
    errors: Sequence[dict[str, Any]] = (),
    headers: Mapping[str, str] | None = None,
    current: object = None,
) -> JSONResponse:
    """A problem as a response; code: that of the message where none is given."""
    body = {
        "type": "about:blank",
        "title": HTTPStatus(status).phrase,
        "status": status,
        "code": code or message.code,
        "detail": render(message),
        "field": field,
        "value": safe(value),
        "advice": render_advice(message),
        "errors": list(errors),
        "key": message.key,
        "parameters": parameters_json(message),
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
    return problem(500, Message("internal_error"))


def _deliberate(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, DrumtrueError)  # noqa: S101
    later = {} if error.retry_after_s is None else {"retry-after": str(error.retry_after_s)}
    return problem(
        error.status,
        error.data,
        code=error.code,
        field=error.field,
        value=error.value,
        headers=later,
        current=error.current if isinstance(error, Stale) else None,
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
    found = [(message_of(e), _entry(e)) for e in listed[:_MAX_ERRORS]]
    message, first = found[0]
    return problem(
        422,
        message,
        field=first["field"],
        value=first["value"],
        errors=[entry for _, entry in found] if len(found) > 1 else (),
    )


def _http(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)  # noqa: S101
    phrase = HTTPStatus(error.status_code).phrase
    code = phrase.lower().replace(" ", "_").replace("-", "_")
    unknown = error.status_code in (404, 405)
    message = Message("http_error.address" if unknown else "http_error", detail=str(error.detail))
    return problem(error.status_code, message, code=code, headers=error.headers)


def _entry(error: Mapping[str, Any]) -> dict[str, Any]:
    rule, message = str(error["type"]), message_of(error)
    return {
        "field": _path(error.get("loc", ())),
        "detail": render(message),
        "value": None if rule in ("missing", "json_invalid") else safe(error.get("input")),
        "rule": rule,
        "advice": render_advice(message),
    }


def _path(location: Sequence[str | int]) -> str | None:
    """body, readings, 0, amplitude -> readings[0].amplitude."""
    path = ""
    for part in location:
        if isinstance(part, int):
            path += f"[{part}]"
        elif part not in ("body", "query", "path", "header"):
            path += f".{part}" if path else part
    return path or None
