"""Boxes of stock masses, and their ledger: pieces are received, fitted, returned and counted, never overwritten."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

from db.documents.machine import (
    Catalogue,
    CatalogueItem,
    CataloguePatch,
    Pieces,
    StockItem,
    StoredCatalogue,
)
from db.documents.plan import Placement
from db.rows import CatalogueRow
from db.store import Store
from service.errors import Conflict, InvalidInput
from service.usecases.machines import name_taken
from service.usecases.rules import check_catalogue
from service.usecases.work import Work, require


def create(work: Work, catalogue: Catalogue) -> StoredCatalogue:
    """Store a box; its counts are booked as received. Raises InvalidInput, or Conflict where the name is taken."""
    check_catalogue(catalogue)
    with work.write() as store:
        if store.catalogue_named(catalogue.name) is not None:
            raise name_taken("catalogue", catalogue.name)
        now = work.now()
        row = CatalogueRow(id=work.new_id(), name=catalogue.name, items=catalogue.items, created_at=now)
        store.add(row)
        counted = {i: item.count for i, item in enumerate(catalogue.items) if item.count is not None}
        _book(work, store, row, "received", counted)
        return _view(store, row)


def get(work: Work, catalogue_id: str) -> StoredCatalogue:
    """One box with what is left in it. Raises NotFound."""
    with work.read() as store:
        return _view(store, require(store, CatalogueRow, catalogue_id))


def find(work: Work, limit: int, offset: int) -> tuple[StoredCatalogue, ...]:
    """Boxes, newest first."""
    with work.read() as store:
        return tuple(_view(store, row) for row in store.catalogues(limit, offset))


def change(work: Work, catalogue_id: str, patch: CataloguePatch) -> StoredCatalogue:
    """Rename, receive, count. Raises InvalidInput for a mass that is not in the box or has no count."""
    with work.write() as store:
        row = require(store, CatalogueRow, catalogue_id, lock=True)
        if patch.name is not None and patch.name != row.name:
            if store.catalogue_named(patch.name) is not None:
                raise name_taken("catalogue", patch.name)
            row.name = patch.name
        _book(work, store, row, "received", _counted_items(row.items, patch.received, "received"))
        found = _counted_items(row.items, patch.counted, "counted")
        balances = store.balances(row.id)
        _book(work, store, row, "counted", {i: pieces - balances.get(i, 0) for i, pieces in found.items()})
        return _view(store, row)


def on_hand(store: Store, row: CatalogueRow) -> tuple[int | None, ...]:
    """Pieces left of each item; None: unlimited."""
    balances = store.balances(row.id)
    return tuple(None if item.count is None else balances.get(i, 0) for i, item in enumerate(row.items))


def exchange(
    work: Work,
    store: Store,
    row: CatalogueRow,
    *,
    back: Sequence[Placement],
    out: Sequence[Placement],
    session_id: str,
    plan_id: str,
) -> None:
    """Return the pieces `back` and take the pieces `out`, all or none; `row` is locked by the caller.

    Raises Conflict where the box holds too few.
    """
    wanted, returned = pieces_of(row.items, out), pieces_of(row.items, back)
    net = {i: returned[i] - wanted[i] for i in wanted.keys() | returned.keys() if row.items[i].count is not None}
    balances = store.balances(row.id)
    short = [i for i, pieces in sorted(net.items()) if balances.get(i, 0) + pieces < 0]
    if short:
        lines = ", ".join(f"{-net[i]} of {row.items[i].mass_g:g} g (in the box: {balances.get(i, 0)})" for i in short)
        raise Conflict(
            f"the box {row.name!r} holds too few pieces: {lines} needed",
            code="out_of_stock",
            field="placements",
            value=[row.items[i].mass_g for i in short],
            advice="make a new plan from what is left, or book the pieces that were put into the box",
        )
    entry = {"session_id": session_id, "plan_id": plan_id}
    _book(work, store, row, "returned", {i: pieces for i, pieces in net.items() if pieces > 0}, **entry)
    _book(work, store, row, "fitted", {i: pieces for i, pieces in net.items() if pieces < 0}, **entry)


def item_of(items: Sequence[CatalogueItem], mass_g: float, field: str) -> int:
    """Index of the item of this mass. Raises InvalidInput."""
    for index, item in enumerate(items):
        if item.mass_g == mass_g:
            return index
    raise InvalidInput(
        f"the box has no mass of {mass_g:g} g",
        field=field,
        value=mass_g,
        advice=f"it has {', '.join(f'{item.mass_g:g}' for item in items[:20])} g; a weighed value goes into weighed_g",
    )


def pieces_of(items: Sequence[CatalogueItem], placements: Iterable[Placement]) -> Counter[int]:
    """Pieces of each item that placements take out of the box."""
    return Counter(item_of(items, p.mass_g, "placements") for p in placements if p.from_box)


def _counted_items(items: Sequence[CatalogueItem], pieces: Sequence[Pieces], field: str) -> dict[int, int]:
    out: dict[int, int] = {}
    for index, entry in enumerate(pieces):
        item = item_of(items, entry.mass_g, f"{field}[{index}].mass_g")
        if items[item].count is None or item in out:
            raise InvalidInput(
                f"the {entry.mass_g:g} g mass has no count, or appears twice in {field}",
                field=f"{field}[{index}].mass_g",
                value=entry.mass_g,
                advice="book each counted mass once",
            )
        out[item] = entry.pieces
    return out


def _book(work: Work, store: Store, row: CatalogueRow, kind: str, pieces: dict[int, int], **entry: Any) -> None:
    blank = {"session_id": None, "plan_id": None}
    store.move_stock(
        {"catalogue_id": row.id, "item": i, "kind": kind, "pieces": n, "at": work.now(), **blank, **entry}
        for i, n in sorted(pieces.items())
        if n != 0
    )


def _view(store: Store, row: CatalogueRow) -> StoredCatalogue:
    left = on_hand(store, row)
    items = tuple(StockItem(**vars(item), on_hand=n) for item, n in zip(row.items, left, strict=True))
    return StoredCatalogue(id=row.id, name=row.name, items=items, created_at=row.created_at)
