"""Readings and answers that bridges send."""

from __future__ import annotations

from typing import Annotated

from annotated_types import Len
from fastapi import APIRouter, Path, Query
from starlette.concurrency import run_in_threadpool

from drivers.reading import Reading
from service.api.dependencies import ArrivalDep, Key, Limit, Offset, WorkDep, errors
from service.api.sent_reading import SentReading
from service.api.strict_json import StrictRoute
from service.model.base import Moment, Name, document
from service.model.run import BalancerAnswer
from service.usecases.readings import balancer_answers, ingest, sources
from service.usecases.readings.balancer_answers import ListedAnswer, StoredAnswer
from service.usecases.readings.ingest import Receipt, Withdrawal, Withdrawn
from service.usecases.readings.sources import Source, StoredReading

router = APIRouter(route_class=StrictRoute)
SourceName = Annotated[
    str, Path(min_length=1, max_length=100, pattern=r"^[^\x00-\x1f\x7f]*$", description="The source.")
]


@document
class Binding:
    """The machine a source is mounted on."""

    machine_id: Name
    """Machine."""


@router.post("/readings", status_code=201, tags=["readings"], responses=errors(404, 409))
async def add_readings(
    work: WorkDep, arrival: ArrivalDep, body: Annotated[list[SentReading], Len(min_length=1)] | SentReading
) -> Receipt:
    """Store one reading or a list, all or none; sent again, they are stored once.

    A sender without a clock leaves `taken_at` out: the moment of receipt takes its place. A reading dated more than a
    minute (a setting of the service) ahead of its receipt is stored and set apart: it counts for nothing.

    Amplitude and scatter in the sensor's unit and detection, phase in degrees in the machine's `phase_sense`, speed in
    r/min, times in UTC (RFC 3339).
    """
    sent = [body] if isinstance(body, Reading) else body
    if work.joined is not None:
        return ingest.ingest(work, sent, arrival)  # in the thread of the unit of work that it joins
    if len(sent) > ingest.FEW:
        return await run_in_threadpool(ingest.ingest, work, sent, arrival)
    return await ingest.ingest_few(work, sent, arrival)


@router.post("/readings/withdrawals", status_code=201, tags=["readings"], responses=errors(404))
def withdraw_readings(work: WorkDep, request: Withdrawal) -> Withdrawn:
    """Take wrong readings out, by number or by time: they stay stored, and count for nothing. Times in UTC."""
    return ingest.withdraw(work, request)


@router.post("/balancer-answers", status_code=201, tags=["readings"], responses=errors(404, 409))
def add_answer(work: WorkDep, arrival: ArrivalDep, answer: BalancerAnswer) -> StoredAnswer:
    """Store the continuous correction masses a balancer computed. Masses in g, angles in degrees."""
    return balancer_answers.ingest(work, answer, arrival)


@router.get("/sessions/{session_id}/balancer-answers", tags=["readings"], responses=errors(404))
def list_answers(work: WorkDep, session_id: Key, limit: Limit = 50, offset: Offset = 0) -> tuple[ListedAnswer, ...]:
    """Balancers' answers that the session may be corrected by, newest first. Masses in g, angles in degrees, UTC."""
    return balancer_answers.of_session(work, session_id, limit, offset)


@router.get("/sources", tags=["readings"], responses=errors())
def list_sources(work: WorkDep) -> tuple[Source, ...]:
    """Bound sources, by name. Times in UTC; there is no quantity with a unit."""
    return sources.bound(work)


@router.put("/sources/{name}", tags=["readings"], responses=errors(404))
def bind_source(work: WorkDep, name: SourceName, binding: Binding) -> Source:
    """Bind a source to the machine it is mounted on. There is no quantity with a unit."""
    return sources.bind(work, name, binding.machine_id)


@router.get("/sources/{name}/readings", tags=["readings"], responses=errors(404))
def list_readings(
    work: WorkDep,
    name: SourceName,
    since: Annotated[Moment | None, Query(alias="from", description="Taken then or later, RFC 3339.")] = None,
    until: Annotated[Moment | None, Query(alias="to", description="Taken then or earlier, RFC 3339.")] = None,
    limit: Limit = 50,
    offset: Offset = 0,
) -> tuple[StoredReading, ...]:
    """Raw readings of a bound source, newest first, with what the signal chain found beside those of blocks.

    Amplitudes in the sensor's unit and detection, phases in degrees in the machine's `phase_sense`, speed in r/min,
    times in UTC. Readings that were rolled up are not listed.
    """
    return sources.readings_of(work, name, since, until, limit, offset)
