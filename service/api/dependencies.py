"""Dependencies of the endpoints."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any

from fastapi import Depends, Header, Path, Query, Request

from service.api.problems import Problem
from service.model.base import Moment
from service.runtime.context import AppContext
from service.runtime.presence import Presence
from service.usecases.access.tokens import Principal
from service.usecases.readings.clocks import Arrival


# Neither waits for anything: as coroutines they are spared a turn of a thread each.
async def _work(request: Request) -> AppContext:
    """What the use cases need, acting for who asks."""
    work: AppContext = request.app.state.work
    principal: Principal | None = getattr(request.state, "principal", None)
    return replace(work, gone=Presence(request), actor=work.actor if principal is None else principal.name)


async def _having_seen(
    work: Annotated[AppContext, Depends(_work)],
    if_match: Annotated[
        str | None,
        Header(
            alias="If-Match",
            pattern=r'^(\*|"[1-9][0-9]{0,9}")$',
            description="ETag of the session or plan that the change was decided on; refused with 412 if it is older.",
        ),
    ] = None,
) -> AppContext:
    """What the use cases need, and the version that the request was made on."""
    return work.having_seen(None if if_match in (None, "*") else int(if_match.strip('"')))


async def _arriving(
    work: Annotated[AppContext, Depends(_work)],
    sent_at: Annotated[
        Moment | None,
        Header(
            alias="sent-at",
            description="The sender's time as it sends this, RFC 3339: how far its clock is off is known by that. Left "
            "out, the least time from taken to received of the last minutes tells.",
        ),
    ] = None,
) -> Arrival:
    """When a request of a source came, and was sent."""
    return Arrival(work.now(), sent_at)


ArrivalDep = Annotated[Arrival, Depends(_arriving)]
SeenDep = Annotated[AppContext, Depends(_having_seen)]
WorkDep = Annotated[AppContext, Depends(_work)]
Key = Annotated[str, Path(min_length=1, max_length=32, pattern="^[0-9A-Za-z_-]+$", description="Identifier.")]
Limit = Annotated[int, Query(ge=1, le=200, description="How many at most.")]
Offset = Annotated[int, Query(ge=0, le=1_000_000_000, description="How many to pass over.")]


def errors(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The problems an operation may answer with, for its API document."""
    words = {
        404: "Nothing is stored under an identifier.",
        409: "The step is out of order, or contradicts what is stored; `advice` says what to do instead.",
        412: "The session or plan was changed since: `current` is what it is now.",
        413: "The body or a list in it is too long.",
        415: "The body is not declared as JSON.",
        503: "Too many selections are being computed: `Retry-After` says how many seconds to wait.",
        422: "A value breaks a rule: `field`, `value` and `detail` say which.",
    }
    return {status: {"model": Problem, "description": words[status]} for status in (*statuses, 413, 415, 422)}
