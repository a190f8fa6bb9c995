"""Compares what is stored with what the history told: the chain, closed sessions, every row, the ledger, readings.

No alteration ends the walk: what cannot be read is a finding like any other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Text, select, type_coerce
from sqlalchemy.orm import Session

from db.audit_chain import BEGIN, FORMAT, link, parsed, record_digest
from db.reading_verification import reading_findings
from db.row_digests import COLUMNS, PARTS, ROWS, all_digests
from db.rows import AuditRow, SessionRow
from service.model.history import Finding

_CHUNK = 1000
ALTERED_RECORD = "altered"
"""Instead of the digest of a session whose record the engine cannot read."""


@dataclass(frozen=True)
class Line:
    """A line of the history as it is stored, whatever stands in its columns."""

    number: Any
    hash: Any
    fields: dict[str, Any]

    @property
    def changes(self) -> dict[str, Any]:
        """What the line tells; empty where it is no object."""
        return self.fields["changes"] if isinstance(self.fields["changes"], dict) else {}


class Walk:
    """Along the chain, line by line, then through the tables. One use; the unit of work must see one moment."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.count = 0
        self.number, self.hash = 0, BEGIN
        self.sealed: dict[str, str] = {}
        """Digest of each closed session's record, in the order of closing."""
        self._told: dict[tuple[str, str], tuple[str | None, str | None]] = {}
        """Digest and session of each row that the history tells of, as of its last line."""
        self._whole = True
        self._wrong: set[str] = set()

    def findings(self) -> Iterator[Finding]:
        """Everything that is not as it was written."""
        yield from self._chain()
        yield from self._unchained()
        yield from self._sessions()
        for table in COLUMNS:
            yield from self._rows(table)
        yield from self._missing()
        yield from reading_findings(self._session)

    # ------------------------------------------------------------ the chain
    def _chain(self) -> Iterator[Finding]:
        while lines := chained(self._session, self.number, _CHUNK):
            for line in lines:
                if not isinstance(line.number, int):
                    yield finding("entry_altered", f"entry {line.number!r} of the history has no number")
                    return
                yield from self._step(line)

    def _step(self, line: Line) -> Iterator[Finding]:
        told = line.fields
        if line.number != self.number + 1:
            self._whole = False
            yield finding(
                "entry_missing", f"entries {self.number + 1} to {line.number - 1} of the history were removed"
            )
        elif _linked(self.hash, told) != line.hash:
            said = f"entry {line.number} of the history ({told['kind']} {told['key']} {told['action']}) was altered"
            yield finding("entry_altered", said, told["session_id"])
        yield from self._seal(line)
        self._note_rows(line)
        self.count += 1
        self.number, self.hash = line.number, line.hash if isinstance(line.hash, str) else BEGIN

    def _seal(self, line: Line) -> Iterator[Finding]:
        """Note what a session was sealed with. A repair of a closed session seals it anew, and tells from what."""
        kind, key, action = (line.fields[name] for name in ("kind", "key", "action"))
        if kind != "session" or action not in ("closed", "repaired") or line.changes.get("format") != FORMAT:
            return
        seal = line.changes.get("record_sha256")
        before, after = seal if isinstance(seal, list) and len(seal) == 2 else (None, seal)
        if self.sealed.get(key) != before:
            again = "closed a second time" if action == "closed" else "altered before it was repaired"
            yield finding("session_altered", f"session {key} was {again}", key)
        self.sealed[key] = str(after)

    def _note_rows(self, line: Line) -> None:
        rows = line.changes.get(ROWS)
        for name, found in rows.items() if isinstance(rows, dict) else ():
            table, _, key = name.partition(" ")
            self._told[table, key] = found, line.fields["session_id"]

    def _unchained(self) -> Iterator[Finding]:
        """Lines outside the chain that tell of anything but readings."""
        query = select(AuditRow.id, AuditRow.kind, AuditRow.key).where(
            AuditRow.number.is_(None), AuditRow.kind != "reading"
        )
        for key, kind, of in self._session.execute(query):
            yield finding("entry_forged", f"line {key} of the history ({kind} {of}) is not in the chain")

    # ------------------------------------------------------------ the tables
    def _sessions(self) -> Iterator[Finding]:
        """Closed sessions that are not as they were sealed, are gone, or were never sealed."""
        for session_id, sealed in self.sealed.items():
            found = self._record(session_id)
            if found is None:
                self._wrong.add(session_id)
                yield finding("session_missing", f"session {session_id} was removed after it was closed", session_id)
            elif found != sealed:
                self._wrong.add(session_id)
                yield finding("session_altered", f"session {session_id} was altered after it was closed", session_id)
        for session_id in self._session.scalars(select(SessionRow.id).where(SessionRow.state == "closed")):
            if session_id not in self.sealed:
                self._wrong.add(session_id)
                said = f"session {session_id} was inserted as closed: the history does not tell of its closing"
                yield finding("session_inserted", said, session_id)

    def _record(self, session_id: str) -> str | None:
        try:
            return record_digest(self._session, session_id)
        except (ValueError, TypeError):
            return ALTERED_RECORD

    def _rows(self, table: str) -> Iterator[Finding]:
        for key, owner, now in all_digests(self._session.connection(), table):
            told, _ = self._told.pop((table, key), (None, None))
            if self._is_covered(table, owner) or now == told:
                continue
            if told is not None:
                yield finding("row_altered", f"{table} {key} was altered behind the service", owner)
            elif self._whole:
                yield finding("row_inserted", f"{table} {key} is stored, and the history does not tell of it", owner)

    def _missing(self) -> Iterator[Finding]:
        for (table, key), (told, owner) in self._told.items():
            if told is not None and table in COLUMNS and not self._is_covered(table, owner):
                yield finding("row_missing", f"{table} {key} was removed behind the service", owner)

    def _is_covered(self, table: str, owner: str | None) -> bool:
        """Whether the seal of a closed session speaks for a row: of its parts always, of the ledger if it is broken."""
        return owner in self._wrong or (table in PARTS and owner in self.sealed)


def chained(session: Session, after: int, most: int) -> list[Line]:
    """Lines of the chain above a number, in order, with times and documents as far as they can be read."""
    names = ("number", "at", "actor", "action", "kind", "key", "session_id", "changes", "hash")
    texts = {"changes", "at"} if session.get_bind().dialect.name == "sqlite" else {"changes"}
    columns = AuditRow.__table__.c
    chosen = [type_coerce(columns[name], Text).label(name) if name in texts else columns[name] for name in names]
    query = select(*chosen).where(AuditRow.number > after).order_by(AuditRow.number).limit(most)
    out = []
    for row in session.execute(query).mappings():
        told = {**row, "at": _moment(row["at"]), "changes": parsed(row["changes"] or "")}
        out.append(Line(number=told["number"], hash=told.pop("hash"), fields=told))
    return out


def finding(code: str, detail: str, session_id: str | None = None) -> Finding:
    """Something that is not as the history says."""
    return Finding(code=code, detail=detail, session_id=session_id)


def _moment(value: Any) -> Any:
    """A time as the chain has it; as it is where it is none."""
    if isinstance(value, str):
        try:
            value = datetime.fromisoformat(value)
        except ValueError:
            return value
    return value.replace(tzinfo=UTC) if isinstance(value, datetime) and value.tzinfo is None else value


def _linked(before: str, told: dict[str, Any]) -> str | None:
    try:
        return link(before, told)
    except (ValueError, TypeError):
        return None
