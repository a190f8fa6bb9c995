"""The history: read, and checked against what is stored."""

from __future__ import annotations

from collections.abc import Iterator

from db.audit_chain import BEGIN, FORMAT, link
from db.history import KINDS
from db.rows import AuditRow, CatalogueRow, SessionRow
from db.store import Store
from service.errors import InvalidInput
from service.model.history import Finding, HistoryEntry, Verdict
from service.runtime.context import Work, require

_CHUNK = 1000


def of_session(work: Work, session_id: str, limit: int, offset: int) -> tuple[HistoryEntry, ...]:
    """Changes of a session, newest first. Raises NotFound."""
    with work.read() as store:
        require(store, SessionRow, session_id)
        return tuple(_entry(row) for row in store.history(limit, offset, session_id=session_id))


def find(
    work: Work, limit: int, offset: int, *, kind: str | None = None, key: str | None = None, actor: str | None = None
) -> tuple[HistoryEntry, ...]:
    """Changes, newest first: all, of one kind of thing, of one thing, by one actor. Raises InvalidInput."""
    if kind is not None and kind not in KINDS:
        raise InvalidInput(
            f"there is no history of {kind!r}",
            field="kind",
            value=kind,
            advice=f"use one of {', '.join(sorted(KINDS))}",
        )
    with work.read() as store:
        return tuple(_entry(row) for row in store.history(limit, offset, kind=kind, key=key, actor=actor))


def verify(work: Work, head: str | None = None) -> Verdict:
    """Walk the hash chain and compare every closed session with what was sealed; the ledger's balances too.

    head: NUMBER:HASH as an earlier walk gave it, which must be on the chain. Raises InvalidInput where it is none.
    """
    wanted = None if head is None else _parsed(head)
    with work.read() as store:
        walk = _Walk(store)
        findings = [*walk.entries(), *walk.sessions(), *_balances(store)]
    if wanted is not None and walk.hashes_wanted(wanted) is False:
        findings.append(_finding("head_missing", f"entry {head} is not on the chain: its end was cut off or rewritten"))
    return Verdict(
        entries=walk.count, sessions=len(walk.sealed), head=f"{walk.number}:{walk.hash}", findings=tuple(findings)
    )


class _Walk:
    """Along the chain, entry by entry. sealed: digest of each closed session's record, in the order of closing."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self.count = 0
        self.number, self.hash = 0, BEGIN
        self.sealed: dict[str, str] = {}

    def hashes_wanted(self, wanted: tuple[int, str]) -> bool:
        """Whether the chain has this entry."""
        found = [self.number, self.hash] if wanted[0] == self.number else None
        if found is None:
            row = next(iter(self.store.chained(wanted[0] - 1, 1)), None)
            found = [row.number, row.hash] if row is not None else None
        return found == list(wanted)

    def entries(self) -> Iterator[Finding]:
        while rows := self.store.chained(self.number, _CHUNK):
            for row in rows:
                yield from self._step(row)

    def _step(self, row: AuditRow) -> Iterator[Finding]:
        number = row.number or 0
        if number != self.number + 1:
            yield _finding("entry_missing", f"entries {self.number + 1} to {number - 1} of the history were removed")
        elif link(self.hash, vars(row)) != row.hash:
            said = f"entry {number} of the history ({row.kind} {row.key} {row.action}) was altered"
            yield _finding("entry_altered", said, row.session_id)
        yield from self._seal(row)
        self.count += 1
        self.number, self.hash = number, row.hash or BEGIN

    def _seal(self, row: AuditRow) -> Iterator[Finding]:
        """Note what a session was sealed with. A repair of a closed session seals it anew, and tells from what."""
        if row.kind != "session" or row.action not in ("closed", "repaired") or row.changes.get("format") != FORMAT:
            return
        seal = row.changes["record_sha256"]
        before, after = seal if row.action == "repaired" else (None, seal)
        if self.sealed.get(row.key) != before:
            again = "closed a second time" if row.action == "closed" else "altered before it was repaired"
            yield _finding("session_altered", f"session {row.key} was {again}", row.key)
        self.sealed[row.key] = str(after)

    def sessions(self) -> Iterator[Finding]:
        """Closed sessions that are not as they were sealed, are gone, or were never sealed."""
        for session_id, sealed in self.sealed.items():
            found = self.store.record_digest(session_id)
            if found is None:
                yield _finding("session_missing", f"session {session_id} was removed after it was closed", session_id)
            elif found != sealed:
                yield _finding("session_altered", f"session {session_id} was altered after it was closed", session_id)
        for session_id in self.store.closed_sessions():
            if session_id not in self.sealed:
                said = f"session {session_id} was inserted as closed: the history does not tell of its closing"
                yield _finding("session_inserted", said, session_id)


def _balances(store: Store) -> Iterator[Finding]:
    for catalogue_id, item, balance, summed in store.wrong_balances():
        box = require(store, CatalogueRow, catalogue_id)
        mass_g = box.items[item].mass_g
        yield _finding("balance", f"the box {box.name!r} has {balance} of {mass_g:g} g, its movements come to {summed}")


def _parsed(head: str) -> tuple[int, str]:
    number, _, digest = head.partition(":")
    if not number.isdecimal() or len(digest) != len(BEGIN):
        raise InvalidInput(
            f"{head!r} is no entry of the chain",
            field="head",
            value=head,
            advice="give NUMBER:HASH as an earlier `drumtrue verify` printed it",
        )
    return int(number), digest


def _finding(code: str, detail: str, session_id: str | None = None) -> Finding:
    return Finding(code=code, detail=detail, session_id=session_id)


def _entry(row: AuditRow) -> HistoryEntry:
    return HistoryEntry(**{name: getattr(row, name) for name in HistoryEntry.__dataclass_fields__})
