"""What is stored, against what was acknowledged."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass

import httpx2
from sqlalchemy import Connection, text

from service import bootstrap
from service.chaos.crew import Crew
from service.chaos.field_bridge import FieldBridge
from service.chaos.load import Technician
from service.settings import Settings
from service.usecases import audit

DOCUMENTS = ("", "/log", "/report.json", "/history")


@dataclass(frozen=True)
class Judgement:
    """Counts of what was acknowledged and found, and everything that is not as it was promised."""

    readings: int
    sessions: int
    closed: int
    fitted: int
    pieces: int
    out_of_box: int
    entries: int
    wrong: tuple[str, ...]


def judge(settings: Settings, url: str, crew: Crew) -> Judgement:
    """Count everything. url: of a service that runs again, over which every session is read."""
    wrong: list[str] = []
    with closing(bootstrap.build_work(settings).database) as database, database.engine.connect() as connection:
        for bridge in crew.bridges:
            wrong += _readings(connection, bridge.source, bridge.acknowledged)
        wrong += _readings(connection, crew.field.source, crew.field.acknowledged)
        wrong += _dated_ahead(connection, crew.field)
        out_of_box, below = _stock(connection)
        wrong += below
        stored = {row[0] for row in connection.execute(text("SELECT id FROM session"))}
    promised = {crew.watched, *(session for one in crew.technicians for session in one.sessions)}
    wrong += [f"session {key} was acknowledged and is not stored" for key in sorted(promised - stored)]
    wrong += [f"session {key} is stored and was never acknowledged" for key in sorted(stored - promised)]
    pieces = 0
    with httpx2.Client(base_url=f"{url}/api/v1", timeout=60.0, trust_env=False) as api:
        for one in crew.technicians:
            for session in one.sessions:
                wrong += _session(api, one, session)
                plan = one.fitted.get(session)
                pieces += len(api.get(f"/plans/{plan}").json()["fitted"]) if plan else 0
    if pieces != out_of_box:
        wrong.append(f"{pieces} pieces were acknowledged as fitted, {out_of_box} are out of the box")
    work = bootstrap.build_work(settings)
    with closing(work.database):
        verdict = audit.verify(work)
    wrong += [f"{finding.code}: {finding.detail}" for finding in verdict.findings]
    return Judgement(
        readings=crew.sent(),
        sessions=len(promised),
        closed=sum(len(one.closed) for one in crew.technicians),
        fitted=sum(len(one.fitted) for one in crew.technicians),
        pieces=pieces,
        out_of_box=out_of_box,
        entries=verdict.entries,
        wrong=(*crew.failures, *wrong),
    )


def _readings(connection: Connection, source: str, sent: int) -> Iterator[str]:
    """Each once, and with the values that were sent."""
    query = text(
        "SELECT count(*), count(DISTINCT sequence), coalesce(max(sequence), 0), "
        "coalesce(sum(CASE WHEN amplitude <> sequence OR phase_deg <> sequence % 360 THEN 1 ELSE 0 END), 0) "
        "FROM reading WHERE source = :source"
    )
    count, distinct, highest, altered = connection.execute(query, {"source": source}).one()
    if (count, distinct, highest) != (sent, sent, sent):
        yield f"{source}: {sent} readings acknowledged, {count} stored ({distinct} different), up to {highest}"
    if altered:
        yield f"{source}: {altered} readings are not as they were sent"


def _dated_ahead(connection: Connection, bridge: FieldBridge) -> Iterator[str]:
    """Set apart is what was dated ahead of its source's clock, and nothing else; nothing was refused."""
    query = text("SELECT sequence FROM reading WHERE source = :source AND apart IS NOT NULL ORDER BY sequence")
    apart = [row[0] for row in connection.execute(query, {"source": bridge.source})]
    odd = [number for number in bridge.odd if number <= bridge.acknowledged]
    if apart != odd:
        yield f"{bridge.source}: readings {odd[:9]} were dated ahead, {apart[:9]} are set apart"
    if bridge.set_aside:
        yield f"{bridge.source}: {bridge.set_aside} readings were set aside by the bridge"


def _stock(connection: Connection) -> tuple[int, list[str]]:
    """Pieces out of the box by its movements, and items of which there are fewer than none."""
    out = connection.execute(
        text("SELECT coalesce(sum(pieces), 0) FROM stock_entry WHERE kind IN ('fitted', 'returned')")
    )
    below = connection.execute(text("SELECT item, sum(pieces) FROM stock_entry GROUP BY item HAVING sum(pieces) < 0"))
    return -int(out.scalar_one()), [f"item {item} of the box: {pieces} pieces" for item, pieces in below]


def _session(api: httpx2.Client, one: Technician, session: str) -> Iterator[str]:
    """Readable in every form; its runs and its state as acknowledged."""
    for path in DOCUMENTS:
        answer = api.get(f"/sessions/{session}{path}")
        if answer.status_code != 200:
            yield f"session {session}{path}: {answer.status_code} {answer.text[:200]}"
            return
    found = api.get(f"/sessions/{session}").json()
    runs = [run["id"] for run in found["runs"]]
    if runs != one.sessions[session]:
        yield f"session {session}: runs {one.sessions[session]} acknowledged, {runs} stored"
    if (found["state"] == "closed") != (session in one.closed):
        yield f"session {session} is {found['state']}, closed was {session in one.closed} by what was acknowledged"
    if found["fitted_plan_id"] != one.fitted.get(session):
        yield f"session {session}: plan {found['fitted_plan_id']} is fitted, {one.fitted.get(session)} was acknowledged"
