"""Boxes of stock masses, and what their ledger says."""

from __future__ import annotations

from collections.abc import Sequence

from db.rows import CatalogueRow, SessionRow
from db.store import Store
from service.engine.validation import check_catalogue, item_of
from service.errors import InvalidInput
from service.messages import Message, Quantity
from service.model.machine import Catalogue, CatalogueItem, CataloguePatch, Pieces, StockItem, StoredCatalogue
from service.model.stock import Balance, Hold, Movement, Stock, StockBooking
from service.runtime.context import AppContext, require
from service.usecases.names import name_taken, named_once
from service.usecases.stock import ledger

FIRST_PAGE = 50
"""Movements shown with the answer to a booking."""


def create(work: AppContext, catalogue: Catalogue) -> StoredCatalogue:
    """Store a box; its counts are booked as received. Raises InvalidInput, or Conflict where the name is taken."""
    check_catalogue(catalogue)
    with named_once("catalogue", catalogue.name), work.write() as store:
        if store.catalogue_named(catalogue.name) is not None:
            raise name_taken("catalogue", catalogue.name)
        now = work.now()
        row = CatalogueRow(id=work.new_id(), name=catalogue.name, items=catalogue.items, created_at=now)
        store.add(row)
        counted = {i: item.count for i, item in enumerate(catalogue.items) if item.count is not None}
        store.open_stock(row.id, list(counted))
        ledger.book(store, row, counted, kind="received", at=now)
        return _view(work, store, row)


def get(work: AppContext, catalogue_id: str) -> StoredCatalogue:
    """One box with what is left in it. Raises NotFound."""
    with work.read() as store:
        return _view(work, store, require(store, CatalogueRow, catalogue_id))


def find(work: AppContext, limit: int, offset: int) -> tuple[StoredCatalogue, ...]:
    """Boxes, newest first."""
    with work.read() as store:
        return tuple(_view(work, store, row) for row in store.catalogues(limit, offset))


def change(work: AppContext, catalogue_id: str, patch: CataloguePatch) -> StoredCatalogue:
    """Rename, receive, count. Raises InvalidInput for a mass that is not in the box or has no count."""
    with named_once("catalogue", patch.name or ""), work.write() as store:
        row = require(store, CatalogueRow, catalogue_id, lock=True)
        if patch.name is not None and patch.name != row.name:
            if store.catalogue_named(patch.name) is not None:
                raise name_taken("catalogue", patch.name)
            row.name = patch.name
        for kind, pieces in (("received", patch.received), ("counted", patch.counted)):
            ledger.book(
                store,
                row,
                _counted_items(row.items, pieces, kind, may_be_none=kind == "counted"),
                kind=kind,
                at=work.now(),
            )
        return _view(work, store, row)


def stock_of(work: AppContext, catalogue_id: str, limit: int, offset: int) -> Stock:
    """Balances, what is held for whom, and a page of movements, newest first. Raises NotFound."""
    with work.read() as store:
        return _stock(work, store, require(store, CatalogueRow, catalogue_id), limit, offset)


def book(work: AppContext, catalogue_id: str, booking: StockBooking) -> Stock:
    """Book pieces that came, went or were counted.

    Raises NotFound, InvalidInput for a mass that is not in the box or has no count, Conflict where more are withdrawn
    than are free.
    """
    with work.write() as store:
        row = require(store, CatalogueRow, catalogue_id, lock=True)
        pieces = _counted_items(row.items, booking.pieces, "pieces", may_be_none=booking.kind == "counted")
        ledger.book(store, row, pieces, kind=booking.kind, at=work.now(), note=booking.note)
        return _stock(work, store, row, FIRST_PAGE, 0)


def _counted_items(
    items: Sequence[CatalogueItem], pieces: Sequence[Pieces], field: str, *, may_be_none: bool
) -> dict[int, int]:
    out: dict[int, int] = {}
    for index, entry in enumerate(pieces):
        item = item_of(items, entry.mass_g, f"{field}[{index}].mass_g")
        if items[item].count is None or item in out:
            raise InvalidInput(
                Message("invalid_input.count_missing", mass=Quantity(entry.mass_g, "g"), field=field),
                field=f"{field}[{index}].mass_g",
                value=entry.mass_g,
            )
        if entry.pieces == 0 and not may_be_none:
            raise InvalidInput(
                Message("invalid_input.no_movement", mass=Quantity(entry.mass_g, "g")),
                field=f"{field}[{index}].pieces",
                value=0,
            )
        out[item] = entry.pieces
    return out


def _view(work: AppContext, store: Store, row: CatalogueRow) -> StoredCatalogue:
    items = tuple(
        StockItem(**vars(item), on_hand=balance.on_hand, reserved=balance.reserved, available=balance.available)
        for item, balance in zip(row.items, _balances(store, row, ledger.holds(store, row.id, work.now())), strict=True)
    )
    return StoredCatalogue(id=row.id, name=row.name, items=items, created_at=row.created_at)


def _balances(store: Store, row: CatalogueRow, holds: Sequence[ledger.Held]) -> tuple[Balance, ...]:
    reserved = ledger.pieces_held(holds)
    return tuple(
        Balance(
            mass_g=item.mass_g,
            name=item.name,
            on_hand=n,
            reserved=reserved[i],
            available=None if n is None else max(n - reserved[i], 0),
        )
        for i, (item, n) in enumerate(zip(row.items, ledger.on_hand(store, row), strict=True))
    )


def _stock(work: AppContext, store: Store, row: CatalogueRow, limit: int, offset: int) -> Stock:
    holds = ledger.holds(store, row.id, work.now())
    return Stock(
        catalogue_id=row.id,
        items=_balances(store, row, holds),
        holds=tuple(_hold(store, row, held) for held in holds),
        movements=tuple(
            Movement(
                mass_g=row.items[entry.item].mass_g,
                **{name: getattr(entry, name) for name in Movement.__dataclass_fields__ if name != "mass_g"},
            )
            for entry in store.stock_entries(row.id, limit, offset)
        ),
    )


def _hold(store: Store, row: CatalogueRow, held: ledger.Held) -> Hold:
    session = require(store, SessionRow, held.session_id)
    return Hold(
        mass_g=row.items[held.item].mass_g,
        pieces=held.pieces,
        plan_id=held.plan_id,
        session_id=held.session_id,
        machine_name=session.machine_name,
        technician=session.technician,
        until=held.until,
    )
