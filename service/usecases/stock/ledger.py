"""Stock: the ledger of a box. Pieces are received, held for a plan, fitted, returned and counted, never overwritten.

What is on hand is the sum of the movements; what is held for a plan ends when it is fitted, released, or the time is
over. Every function is called with the box locked where it books: two tablets cannot have the last piece.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from db.rows import CatalogueRow, SessionRow, StockEntryRow
from db.store import Store
from service.engine.validation import item_of
from service.errors import Conflict
from service.messages import Message, Quantity, Word
from service.model.machine import CatalogueItem
from service.model.plan import Placement


@dataclass(frozen=True)
class Held:
    """Pieces of one item that are held for a plan. session_id, plan_id: for whom; until: how long."""

    item: int
    pieces: int
    session_id: str
    plan_id: str
    until: datetime


def holds(store: Store, catalogue_id: str, now: datetime) -> tuple[Held, ...]:
    """What is held of a box now."""
    return tuple(held for held in _open_holds(store.reservations(catalogue_id, now)) if held.until > now)


def on_hand(store: Store, row: CatalogueRow) -> tuple[int | None, ...]:
    """Pieces in the box of each item, held ones included; None: unlimited."""
    balances = store.balances(row.id)
    return tuple(None if item.count is None else balances.get(i, 0) for i, item in enumerate(row.items))


def pieces_held(held: Iterable[Held]) -> Counter[int]:
    """Pieces of each item that are held, for whomever."""
    sums: Counter[int] = Counter()
    for one in held:
        sums[one.item] += one.pieces
    return sums


def available(store: Store, row: CatalogueRow, now: datetime, session_id: str | None) -> tuple[int | None, ...]:
    """Pieces of each item that a session may have: on hand and not held for another one; None: unlimited."""
    others = pieces_held(held for held in holds(store, row.id, now) if held.session_id != session_id)
    # A count may have found fewer pieces than are promised.
    return tuple(None if n is None else max(n - others[i], 0) for i, n in enumerate(on_hand(store, row)))


def reserve(
    store: Store, row: CatalogueRow, pieces: Mapping[int, int], *, at: datetime, until: datetime, **plan: str
) -> None:
    """Hold pieces for a plan (`session_id`, `plan_id`), all or none. Raises Conflict as `exchange`."""
    wanted = {i: n for i, n in sorted(pieces.items()) if n > 0}
    _require_available(store, row, wanted, plan["session_id"], at)
    store.move_stock([_entry(row.id, i, "reserved", at, held=n, until=until, **plan) for i, n in wanted.items()])


def release(store: Store, session_id: str, now: datetime) -> None:
    """Hold nothing for a session any more."""
    movements = store.session_movements(session_id)
    box_of = {entry.plan_id: entry.catalogue_id for entry in movements if entry.until is not None}
    freed = []
    for held in _open_holds(movements):
        kind = "released" if held.until > now else "expired"
        plan = {"session_id": session_id, "plan_id": held.plan_id}
        freed.append(_entry(box_of[held.plan_id], held.item, kind, now, held=-held.pieces, **plan))
    store.move_stock(freed)


def exchange(store: Store, row: CatalogueRow, net: Mapping[int, int], *, at: datetime, **plan: str) -> None:
    """Book what `net_of` says for a plan (`session_id`, `plan_id`), all or none.

    Raises Conflict where the box holds too few (`out_of_stock`), or enough but for others (`stock_reserved`).
    """
    _require_available(store, row, {i: -n for i, n in sorted(net.items()) if n < 0}, plan["session_id"], at)
    back = [_entry(row.id, i, "returned", at, pieces=n, **plan) for i, n in sorted(net.items()) if n > 0]
    out = [_entry(row.id, i, "fitted", at, pieces=n, **plan) for i, n in sorted(net.items()) if n < 0]
    store.move_stock(back + out)


def book(
    store: Store, row: CatalogueRow, pieces: Mapping[int, int], *, kind: str, at: datetime, note: str | None = None
) -> None:
    """Book pieces by hand: this many into the box, withdrawn out of it, or counted in it.

    A count is what was found, whatever is held. Raises Conflict as `exchange` where more are withdrawn than are free.
    """
    moved = dict(sorted(pieces.items()))
    if kind == "withdrawn":
        _require_available(store, row, moved, None, at, field="pieces")
        moved = {i: -n for i, n in moved.items()}
    if kind == "counted":
        balances = store.balances(row.id)
        moved = {i: n - balances.get(i, 0) for i, n in moved.items()}
    store.move_stock([_entry(row.id, i, kind, at, pieces=n, note=note) for i, n in moved.items() if n != 0])


def net_of(items: Sequence[CatalogueItem], *, back: Sequence[Placement], out: Sequence[Placement]) -> dict[int, int]:
    """Pieces of each counted item that go into the box, negative: out of it."""
    wanted, returned = pieces_of(items, out), pieces_of(items, back)
    return {i: returned[i] - wanted[i] for i in wanted.keys() | returned.keys() if items[i].count is not None}


def pieces_of(items: Sequence[CatalogueItem], placements: Iterable[Placement]) -> Counter[int]:
    """Pieces of each item that placements take out of the box."""
    return Counter(item_of(items, p.mass_g, "placements") for p in placements if p.from_box)


def _open_holds(movements: Sequence[StockEntryRow]) -> list[Held]:
    """What these movements, oldest first, leave held, whether or not the time is over."""
    left: Counter[tuple[str, int]] = Counter()
    last: dict[tuple[str, int], Held] = {}
    for entry in movements:
        if entry.plan_id is None or entry.session_id is None:
            continue
        key = (entry.plan_id, entry.item)
        left[key] += entry.held
        if entry.until is not None:
            last[key] = Held(entry.item, 0, entry.session_id, entry.plan_id, entry.until)
    return [
        Held(held.item, left[key], held.session_id, held.plan_id, held.until)
        for key, held in last.items()
        if left[key] > 0
    ]


def _require_available(
    store: Store,
    row: CatalogueRow,
    wanted: Mapping[int, int],
    session_id: str | None,
    now: datetime,
    field: str = "placements",
) -> None:
    free = available(store, row, now, session_id)
    short = {i: n for i, n in wanted.items() if n > (free[i] or 0)}
    if not short:
        return
    have = on_hand(store, row)
    in_box = all(n <= (have[i] or 0) for i, n in short.items())
    raise Conflict(
        Message(
            "stock_reserved" if in_box else "out_of_stock",
            box=row.name,
            short=[_shortage(store, row, i, n, session_id, now) for i, n in short.items()],
        ),
        field=field,
        value=[row.items[i].mass_g for i in short],
    )


def _shortage(
    store: Store, row: CatalogueRow, item: int, wanted: int, session_id: str | None, now: datetime
) -> tuple[Message, ...]:
    """Which piece is short, who has it, and until when."""
    have = store.balances(row.id).get(item, 0)
    short = Message("out_of_stock.needed", wanted=wanted, mass=Quantity(row.items[item].mass_g, "g"), have=have)
    holders = [
        Message("out_of_stock.held", pieces=held.pieces, holder=_whose(store, held.session_id), until=_moment(held))
        for held in holds(store, row.id, now)
        if held.item == item and held.session_id != session_id
    ]
    last = store.last_fitted(row.id, item)
    if have < wanted and last is not None and last.session_id is not None:
        holders.append(Message("out_of_stock.mounted", holder=_whose(store, last.session_id)))
    return (short, *holders)


def _moment(held: Held) -> str:
    return f"{held.until:%Y-%m-%dT%H:%M:%SZ}"


def _whose(store: Store, session_id: str) -> Message:
    session = store.get(SessionRow, session_id)
    if session is None:
        return Message("out_of_stock.holder_session", session=session_id)
    who = session.technician or Word("somebody")
    return Message("out_of_stock.holder", who=who, machine=session.machine_name, session=session_id)


def _entry(row_id: str, item: int, kind: str, at: datetime, **given: Any) -> dict[str, Any]:
    blank = {"pieces": 0, "held": 0, "session_id": None, "plan_id": None, "until": None, "note": None}
    return {"catalogue_id": row_id, "item": item, "kind": kind, "at": at, **blank, **given}
