"""Read the audit trail, and verify what is stored against it."""

from __future__ import annotations

from collections.abc import Iterator

from db.audit_chain import BEGIN
from db.history import KINDS
from db.row_digests import ROWS
from db.rows import AuditRow, CatalogueRow, SessionRow
from db.set_apart import fault_in_row
from db.store import Store
from service.errors import InvalidInput
from service.messages import Message, Quantity, render
from service.model.history import Finding, HistoryEntry, Verdict
from service.runtime.context import AppContext, require


def of_session(work: AppContext, session_id: str, limit: int, offset: int) -> tuple[HistoryEntry, ...]:
    """Changes of a session, newest first. Raises NotFound."""
    with work.read() as store:
        require(store, SessionRow, session_id)
        return tuple(_entry(row) for row in store.history(limit, offset, session_id=session_id))


def find(
    work: AppContext,
    limit: int,
    offset: int,
    *,
    kind: str | None = None,
    key: str | None = None,
    actor: str | None = None,
) -> tuple[HistoryEntry, ...]:
    """Changes, newest first: all, of one kind of thing, of one thing, by one actor. Raises InvalidInput."""
    if kind is not None and kind not in KINDS:
        raise InvalidInput(
            Message("invalid_input.history_kind", kind=kind, kinds=sorted(KINDS)), field="kind", value=kind
        )
    with work.read() as store:
        return tuple(_entry(row) for row in store.history(limit, offset, kind=kind, key=key, actor=actor))


def verify(work: AppContext, head: str | None = None) -> Verdict:
    """Compare what is stored with the history: its chain, closed sessions, every row, the ledger, readings by batch.

    head: NUMBER:HASH as an earlier walk gave it, which must be on the chain. Raises InvalidInput where it is none.
    """
    wanted = None if head is None else _parsed(head)
    with work.read() as store:
        walk = store.walk()
        findings = [*walk.findings(), *_balances(store)]
        if wanted is not None and not store.is_on_chain(*wanted):
            said = render(Message("head_missing", head=head))
            findings.append(Finding(code="head_missing", detail=said, session_id=None))
    return Verdict(
        entries=walk.count, sessions=len(walk.sealed), head=f"{walk.number}:{walk.hash}", findings=tuple(findings)
    )


def _balances(store: Store) -> Iterator[Finding]:
    for catalogue_id, item, balance, summed in store.wrong_balances():
        box = store.get(CatalogueRow, catalogue_id)
        readable = box is not None and fault_in_row(box) is None
        known = box.items[item].mass_g if box is not None and readable and item < len(box.items) else None
        message = Message(
            "balance" if box is not None else "balance.box_missing",
            box=box.name if box is not None else catalogue_id,
            piece=f"item {item}" if known is None else Quantity(known, "g"),
            balance=balance,
            summed=summed,
        )
        yield Finding(code="balance", detail=render(message), session_id=None)


def _parsed(head: str) -> tuple[int, str]:
    number, _, digest = head.partition(":")
    if not number.isdecimal() or len(digest) != len(BEGIN):
        raise InvalidInput(Message("invalid_input.chain_head", head=head), field="head", value=head)
    return int(number), digest


def _entry(row: AuditRow) -> HistoryEntry:
    told = {name: getattr(row, name) for name in HistoryEntry.__dataclass_fields__ if name != "rows"}
    changes = {name: value for name, value in row.changes.items() if name != ROWS}
    return HistoryEntry(**{**told, "changes": changes, "rows": row.changes.get(ROWS, {})})
