"""Mend stored scatter that is rounding error: it becomes null, with a line of history.

Used by migration 0011 and by `drumtrue repair`; what it does to a document must not change. A run of a closed session
is mended only where it cannot be read: its session is sealed anew, by a line `repaired` that holds both digests.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from sqlalchemy import Column, Integer, MetaData, String, Table, Text, select, update
from sqlalchemy.orm import Session

from db.audit_chain import FORMAT, record_digest
from db.history import History

LEAST = 1e-15
"""A run that states a lower scatter cannot be read."""
RELATIVE = 1e-12
"""Below this share of the amplitude a scatter is rounding error."""

_TABLES = MetaData()
_RUN = Table("run", _TABLES, Column("id", String), Column("session_id", String), Column("run", Text))
_SESSION = Table("session", _TABLES, Column("id", String), Column("state", String), Column("version", Integer))
_CHUNK = 500


def mend(session: Session, history: History) -> list[tuple[str, str]]:
    """Mend all runs there are; kind and key of each thing that was mended. The caller finishes the history."""
    mended = []
    for key, owner, text, state in _runs(session):
        found = _without_rounding_error(text, unreadable_only=state == "closed")
        if found is None:
            continue
        before, after = found
        sealed = record_digest(session, owner) if state == "closed" else None
        session.execute(update(_RUN).where(_RUN.c.id == key).values(run=json.dumps(after, separators=(",", ":"))))
        changes = {"run.readings": [before["readings"], after["readings"]]}
        history.note("changed", "run", key, changes, session_id=owner, rows=[("run", key)])
        if sealed is None:
            count = {"version": _SESSION.c.version + 1}
            session.execute(update(_SESSION).where(_SESSION.c.id == owner).values(count))
        else:
            seal = {"record_sha256": [sealed, record_digest(session, owner)], "format": FORMAT}
            history.note("repaired", "session", owner, seal, session_id=owner)
        mended.append(("run", key))
    return mended


def _runs(session: Session) -> Iterator[tuple[str, str, str, str]]:
    """Key, session, document and state of the session of each run, in the order of the keys."""
    whole = select(_RUN.c.id, _RUN.c.session_id, _RUN.c.run, _SESSION.c.state).join(
        _SESSION, _SESSION.c.id == _RUN.c.session_id
    )
    last = ""
    while rows := session.execute(whole.where(_RUN.c.id > last).order_by(_RUN.c.id).limit(_CHUNK)).all():
        yield from (tuple(row) for row in rows)
        last = rows[-1][0]


def _without_rounding_error(text: str, *, unreadable_only: bool) -> tuple[dict[str, Any], dict[str, Any]] | None:
    """The run as it is, and as it should be; None where nothing is to be mended."""
    try:
        run = json.loads(text)
        readings = [_mended(reading, unreadable_only) for reading in run["readings"]]
    except (ValueError, TypeError, KeyError, AttributeError):
        return None  # broken otherwise: nothing that can be mended without a guess
    return None if readings == run["readings"] else (run, {**run, "readings": readings})


def _mended(reading: dict[str, Any], unreadable_only: bool) -> dict[str, Any]:
    scatter = reading.get("scatter")
    least = LEAST if unreadable_only else max(LEAST, RELATIVE * float(reading["amplitude"]))
    if isinstance(scatter, int | float) and not isinstance(scatter, bool) and 0.0 <= scatter < least:
        return {**reading, "scatter": None}
    return reading
