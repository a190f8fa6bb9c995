"""What a unit of work changes, written in the same transaction: who, when, what. One place for all use cases.

Rows that go through the ORM are seen here by themselves; what a store writes past it is told by `note`. Entries form a
hash chain (`db.audit_chain`) in the order of their commits, except those of telemetry, which would make bridges wait
for each other. A session's version counts what changes in it, a plan's what changes of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from typing import Any

from sqlalchemy import event, func, insert, select
from sqlalchemy.orm import Session
from sqlalchemy.orm.attributes import get_history

from db.audit_chain import BEGIN, ENTRY, FORMAT, link, record_digest
from db.row_digests import COLUMNS, ROWS, digests
from db.rows import AuditRow, Base, CorrectionRow, PlanRow, RunRow, SessionRow, StockBalanceRow, StopRow
from db.types import Document
from service.model.base import to_plain

_LOCK = 7_325_118
"""Advisory lock of PostgreSQL under which the chain grows; SQLite has one writer at a time anyhow."""
_PARTS = (RunRow, CorrectionRow, PlanRow, StopRow)
_UNTOLD = frozenset(
    {"audit", "login", "idempotency", "source_mark", "reading_range", "source_clock", "design_progress"}
)
"""Tables without history: itself, browsers that come and go, keys of requests, counters that never stand still."""
KINDS = frozenset(Base.metadata.tables) - _UNTOLD - {StockBalanceRow.__tablename__}
"""What an entry may be about: the names of the tables with history."""
_KEPT_OUT = frozenset({"token.digest", "session.version", "plan.version"})
"""What is secret, or counted from the history itself."""


class ClosedForGood(Exception):
    """A closed session, or a line of the history or of the stock's ledger, was about to be changed."""


class History:
    """Writes down the changes of one unit of work. actor: who acts; now: the clock."""

    def __init__(self, session: Session, actor: str, now: Callable[[], datetime]) -> None:
        self._session = session
        self._actor = actor
        self._now = now
        self._entries: list[dict[str, Any]] = []
        self._changed: dict[tuple[str, str], dict[str, Any]] = {}
        self._closed: list[str] = []
        event.listen(session, "before_flush", self._before_flush)

    def note(
        self,
        action: str,
        kind: str,
        key: str,
        changes: Mapping[str, Any],
        *,
        session_id: str | None = None,
        chained: bool = True,
        rows: Iterable[tuple[str, Any]] = (),
    ) -> None:
        """Tell a change that does not go through the ORM. rows: table and key of each row that it writes."""
        known = self._changed.get((kind, key)) if action == "changed" else None
        if known is not None:
            # What changes twice in a unit changed once: from what it was first to what it is last.
            for name, (before, after) in changes.items():
                known["changes"][name] = [known["changes"].get(name, [before])[0], after]
            return
        entry = {"action": action, "kind": kind, "key": key, "session_id": session_id, "changes": dict(changes)}
        self._entries.append({**entry, "actor": self._actor, "chained": chained, "rows": tuple(rows)})
        if action == "changed":
            self._changed[kind, key] = self._entries[-1]

    @contextmanager
    def part(self, actor: str | None = None) -> Iterator[None]:
        """A part of the unit, for another actor; where its block raises, what it told was not done."""
        told, changed, own = len(self._entries), dict(self._changed), self._actor
        self._actor = actor or own
        try:
            yield
        except BaseException:
            del self._entries[told:]
            self._changed = changed
            raise
        finally:
            self._actor = own

    def seal(self, session_id: str) -> None:
        """Close the record of a session: its digest enters the chain."""
        seal = {"record_sha256": record_digest(self._session, session_id), "format": FORMAT}
        self.note("closed", "session", session_id, seal, session_id=session_id)

    def finish(self) -> None:
        """Write the entries; the last thing a unit of work does before it commits."""
        self._session.flush()
        for session_id in self._closed:
            self.seal(session_id)
        if not self._entries:
            return
        stamp = {"at": self._now()}
        chained = [{**entry, **stamp} for entry in self._with_digests() if entry["chained"]]
        loose = [{**entry, **stamp, "number": None, "hash": None} for entry in self._entries if not entry["chained"]]
        rows = [{name: row[name] for name in (*ENTRY, "hash")} for row in (*loose, *self._linked(chained))]
        # Past the ORM, which would look at each row again.
        self._session.connection().execute(insert(AuditRow), rows)

    def _with_digests(self) -> list[dict[str, Any]]:
        """The entries, each with the digests of the rows it is about, as they are stored now."""
        wanted: dict[str, dict[str, Any]] = {}
        for entry in self._entries:
            for table, key in entry["rows"]:
                wanted.setdefault(table, {})[str(key)] = key
        connection = self._session.connection()
        found = {table: digests(connection, table, list(keys.values())) for table, keys in wanted.items()}
        return [
            {**entry, "changes": {**entry["changes"], ROWS: _digests_of(entry["rows"], found)}}
            if entry["rows"]
            else entry
            for entry in self._entries
        ]

    def _linked(self, rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
        if not rows:
            return []
        if self._session.get_bind().dialect.name == "postgresql":
            self._session.execute(select(func.pg_advisory_xact_lock(_LOCK)))
        last = select(AuditRow.number, AuditRow.hash).where(AuditRow.number.is_not(None))
        found = self._session.execute(last.order_by(AuditRow.number.desc()).limit(1)).one_or_none()
        number, before = (0, BEGIN) if found is None else (int(found[0] or 0), str(found[1]))
        out = []
        for row in rows:
            number += 1
            before = link(before, {**row, "number": number})
            out.append({**row, "number": number, "hash": before})
        return out

    # ------------------------------------------------------------ what the ORM is about to write
    def _before_flush(self, session: Session, _context: object, _instances: object) -> None:
        with session.no_autoflush:
            self._see_all(session)

    def _see_all(self, session: Session) -> None:
        touched = set()
        for row in session.new:
            touched.add(self._seen(row, "added", _scalars(row)))
        for row in session.deleted:
            touched.add(self._seen(row, "removed", _scalars(row)))
        for row in session.dirty:
            if session.is_modified(row):
                touched.add(self._seen(row, "changed", _differences(row)))
        for session_id in touched - {None}:
            owner = session.get(SessionRow, session_id)
            if owner is not None and owner not in session.new:
                owner.version += 1

    def _seen(self, row: Any, action: str, changes: Mapping[str, Any]) -> str | None:
        """Tell a row's change; returns the session whose version it counts for."""
        kind = row.__tablename__
        if kind in _UNTOLD or isinstance(row, StockBalanceRow):
            return None
        owner = row.id if isinstance(row, SessionRow) else getattr(row, "session_id", None)
        self._guard(row, kind, action, owner)
        rows = [(kind, _key(row))] if kind in COLUMNS else []
        self.note(action, kind, str(_key(row)), changes, session_id=owner, rows=rows)
        if action == "changed" and isinstance(row, PlanRow):
            row.plan = replace(row.plan, version=row.plan.version + 1)
        return owner if isinstance(row, (*_PARTS, SessionRow)) else None

    def _guard(self, row: Any, kind: str, action: str, owner: str | None) -> None:
        if kind == "session" and row.state == "closed" and "closed" not in get_history(row, "state").unchanged:
            self._closed.append(row.id)
        if kind == "stock_entry" and action != "added":
            raise ClosedForGood("the stock's ledger is only added to")
        if isinstance(row, (*_PARTS, SessionRow)) and owner is not None and owner not in self._closed:
            session = row if isinstance(row, SessionRow) else self._session.get(SessionRow, owner)
            was = () if session is None else get_history(session, "state")
            if "closed" in (*was.deleted, *was.unchanged) if was else False:
                raise ClosedForGood(f"session {owner} is closed: a correction of it is a new session")


def _digests_of(rows: Iterable[tuple[str, Any]], found: Mapping[str, Mapping[str, str]]) -> dict[str, str | None]:
    return {f"{table} {key}": found[table].get(str(key)) for table, key in rows}


def _key(row: Base) -> object:
    return getattr(row, row.__mapper__.primary_key[0].key or "")


def _columns(row: Base) -> list[Any]:
    table = row.__tablename__
    return [column for column in row.__mapper__.columns if f"{table}.{column.key}" not in _KEPT_OUT]


def _scalars(row: Base) -> dict[str, Any]:
    """What a row says outside its documents, which the row itself holds."""
    found = {c.key: getattr(row, c.key) for c in _columns(row) if not isinstance(c.type, Document)}
    return {name: _plain(value) for name, value in found.items() if value is not None and name != "id"}


def _differences(row: Base) -> dict[str, Any]:
    """[before, after] of each column that changes; of a document, of each of its fields that changes."""
    out: dict[str, Any] = {}
    for column in _columns(row):
        history = get_history(row, column.key)
        if not history.has_changes():
            continue
        before, after = (values[0] if values else None for values in (history.deleted, history.added))
        if isinstance(column.type, Document):
            kind = column.type.kind
            old, new = (None if value is None else to_plain(value, kind) for value in (before, after))
            if isinstance(old, dict) and isinstance(new, dict):
                fields = [name for name in new if old.get(name) != new[name]]
                out |= {f"{column.key}.{name}": [old.get(name), new[name]] for name in fields}
            elif old != new:
                out[column.key] = [old, new]
        else:
            out[column.key] = [_plain(before), _plain(after)]
    return out


def _plain(value: Any) -> Any:
    return value.isoformat() if isinstance(value, datetime) else value
