"""Request bodies read strictly: the JSON text goes straight to the documents' validator."""

from __future__ import annotations

import asyncio
import functools
import hashlib
import inspect
import json
from collections.abc import Callable, Coroutine, Iterator, Sequence
from types import NoneType
from typing import Annotated, Any, cast, get_args, get_type_hints

from fastapi import Header, Request, Response
from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute
from pydantic import ValidationError
from pydantic_core import to_jsonable_python
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException

from service.errors import InvalidInput, PreconditionFailed, UnsupportedMediaType
from service.messages import Message, Word
from service.model.base import adapter, write_json
from service.model.design_run import DesignStudy
from service.model.plan import Plan
from service.model.session import Session
from service.runtime import idempotency
from service.usecases.readings.clocks import Arrival

Validator = Callable[[bytes], Any]


class InvalidBody(HTTPException):
    """A body that breaks a rule of its document; raised while it is read, hence of the framework's family."""

    def __init__(self, errors: Sequence[Any]) -> None:
        super().__init__(422)
        self.errors = errors


class StrictRoute(APIRoute):
    """A route whose body is validated as JSON text, and whose query parameters are all known.

    FastAPI reads the text into dictionaries first, for which strict documents are too strict (a list is no tuple, a
    text no time); validated as JSON the same documents read well, and faster. A query parameter that the operation does
    not have is refused. A POST takes an `Idempotency-Key`; a session, plan or design study is answered with its version
    as `ETag`.
    """

    def __init__(self, path: str, endpoint: Callable[..., Any], **given: Any) -> None:
        hints = get_type_hints(endpoint, include_extras=True)
        returned, by_itself = hints.pop("return", None), Response in hints.values()
        status = given.get("status_code") or 200
        if "POST" in (given.get("methods") or ()):
            endpoint = _done_once(endpoint, status, returned)
        if not by_itself and returned is not NoneType:
            endpoint = _written(endpoint, status, returned)
        super().__init__(path, endpoint, **given)

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """The handler, with a request whose `json()` is the validated body."""
        handler = super().get_route_handler()
        known = frozenset(_queries(self.dependant))
        has_version = "If-Match" in set(_headers(self.dependant))
        body = self.body_field
        validate = None if body is None else _validator(body.field_info.annotation)

        async def handle(request: Request) -> Response:
            _require_known(request, known)
            if not has_version:
                _require_no_version(request)
            if validate is None:
                return await handler(request)
            _require_json(request)
            return await handler(_ValidatedRequest(request, validate))

        return handle


IDEMPOTENCY_KEY = Header(
    alias="Idempotency-Key",
    min_length=1,
    max_length=200,
    pattern=r"^[\x21-\x7e]+$",
    description="Sent again with the same key within a day, the request is done once and answered as the first time.",
)


def _done_once(endpoint: Callable[..., Any], status: int, returned: Any) -> Callable[..., Any]:
    """The endpoint, done once for all requests with the same key; without a key as it is."""

    def keyed(key: str, given: dict[str, Any]) -> Response:
        work = given.pop("work")
        # When it came is no part of what is asked: sent again it comes later.
        said = {name: value for name, value in given.items() if not isinstance(value, Arrival)}
        asked = json.dumps([endpoint.__name__, to_jsonable_python(said)], sort_keys=True)
        answer = idempotency.answer(
            work,
            key,
            hashlib.sha256(asked.encode()).hexdigest(),
            lambda acting: idempotency.Answer(
                status, write_json(_to_its_end(endpoint(work=acting, **given)), returned)
            ),
        )
        headers = {"idempotent-replayed": "true"} if answer.replayed else {}
        return Response(answer.body, answer.status, headers, "application/json")

    @functools.wraps(endpoint)
    def answered(*, idempotency_key: str | None = None, **given: Any) -> Any:
        return endpoint(**given) if idempotency_key is None else keyed(idempotency_key, given)

    @functools.wraps(endpoint)
    async def awaited(*, idempotency_key: str | None = None, **given: Any) -> Any:
        if idempotency_key is None:
            return await endpoint(**given)
        return await run_in_threadpool(keyed, idempotency_key, given)

    signature = inspect.signature(endpoint)
    key = inspect.Parameter(
        "idempotency_key",
        inspect.Parameter.KEYWORD_ONLY,
        default=None,
        annotation=Annotated[str | None, IDEMPOTENCY_KEY],
    )
    chosen: Callable[..., Any] = awaited if inspect.iscoroutinefunction(endpoint) else answered
    chosen.__signature__ = signature.replace(parameters=[*signature.parameters.values(), key])  # type: ignore[attr-defined]
    return chosen


def _to_its_end(value: Any) -> Any:
    """What an endpoint returns; a coroutine is run in this thread, whose unit of work it joins."""
    return asyncio.run(value) if inspect.iscoroutine(value) else value


def _written(endpoint: Callable[..., Any], status: int, returned: Any) -> Callable[..., Any]:
    """The endpoint, what it returns written as JSON at once; what has versions, with its own in the header ETag.

    FastAPI would check it once more and write it in another turn of its threads, which costs more than the work of a
    short request.
    """

    def response(value: Any) -> Response:
        made = value if isinstance(value, Response) else None
        if made is None:
            made = Response(write_json(value, returned), status, media_type="application/json")
        if returned in (Session, Plan, DesignStudy):
            version = json.loads(bytes(made.body))["version"] if made is value else value.version
            made.headers["etag"] = f'"{version}"'
        return made

    @functools.wraps(endpoint)
    def answered(**given: Any) -> Response:
        return response(endpoint(**given))

    @functools.wraps(endpoint)
    async def awaited(**given: Any) -> Response:
        return response(await endpoint(**given))

    return awaited if inspect.iscoroutinefunction(endpoint) else answered


def _queries(dependant: Dependant) -> Iterator[str]:
    """Names of the query parameters of an operation and of what it depends on."""
    yield from (one.alias for one in dependant.query_params)
    for further in dependant.dependencies:
        yield from _queries(further)


def _headers(dependant: Dependant) -> Iterator[str]:
    """Names of the headers that an operation and what it depends on ask for."""
    yield from (one.alias for one in dependant.header_params)
    for further in dependant.dependencies:
        yield from _headers(further)


def _require_no_version(request: Request) -> None:
    """Refuse a version where none is kept: passed over, a change would be made on whatever is stored by now."""
    stated = request.headers.get("if-match", "*")
    if stated != "*":
        raise PreconditionFailed(Message("version_unknown"), field="If-Match", value=stated)


def _require_known(request: Request, known: frozenset[str]) -> None:
    """Refuse a query parameter that the operation does not have: left out silently, it would seem to have worked."""
    # The text is looked at first: most requests have none, and to take nothing apart costs as much as to validate.
    unknown = sorted(set(request.query_params) - known) if request.scope["query_string"] else []
    if unknown:
        raise InvalidInput(
            Message("unknown_parameter", unknown=unknown, known=sorted(known)),
            field=unknown[0],
            value=request.query_params[unknown[0]],
        )


def _require_json(request: Request) -> None:
    """Refuse a body that is not declared as JSON: a browser sends it to us for any page without asking first."""
    stated = request.headers.get("content-type", "")
    kind = stated.partition(";")[0].strip().lower()
    if kind != "application/json":
        raise UnsupportedMediaType(
            Message("unsupported_media_type", kind=kind or Word("missing")), field="content-type", value=stated or None
        )


class _ValidatedRequest(Request):
    def __init__(self, request: Request, validate: Validator) -> None:
        super().__init__(request.scope, request.receive)
        self._validate = validate

    async def json(self) -> Any:
        try:
            return self._validate(await self.body())
        except ValidationError as wrong:
            raise InvalidBody(wrong.errors(include_url=False)) from None


def _validator(annotation: Any) -> Validator:
    """The validator of a body; for `list | single` the text's first sign tells which, so that errors name one."""
    options = get_args(annotation)
    many = next((o for o in options if "list[" in str(o)), None)
    if many is None:
        return adapter(cast(Any, annotation)).validate_json
    single = next(o for o in options if o is not many)

    def validate(text: bytes) -> Any:
        return adapter(many if text.lstrip()[:1] == b"[" else single).validate_json(text)

    return validate
