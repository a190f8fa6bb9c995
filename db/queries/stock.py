"""The ledger of boxes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

from sqlalchemy import and_, bindparam, func, insert, select, update

from db.queries.base import Queries
from db.rows import StockBalanceRow, StockEntryRow


class Stock(Queries):
    """Movements of stock, their balances, and what plans were promised."""

    def open_stock(self, catalogue_id: str, items: Sequence[int]) -> None:
        """Begin the ledger of counted items, at none."""
        rows = [{"catalogue_id": catalogue_id, "item": item, "on_hand": 0} for item in items]
        if rows:
            self._session.execute(insert(StockBalanceRow), rows)

    def move_stock(self, entries: Sequence[Mapping[str, Any]]) -> None:
        """Write movements of stock. The engine refuses those that would leave less than nothing: IntegrityError."""
        if not entries:
            return
        written = insert(StockEntryRow).returning(StockEntryRow.id, sort_by_parameter_order=True)
        keys = self._session.scalars(written, [dict(entry) for entry in entries]).all()
        moved = [
            {"in_box": entry["catalogue_id"], "of_item": entry["item"], "change": entry["pieces"]}
            for entry in entries
            if entry["pieces"] != 0
        ]
        if moved:
            table = StockBalanceRow.__table__
            here = and_(table.c.catalogue_id == bindparam("in_box"), table.c.item == bindparam("of_item"))
            change = {"on_hand": table.c.on_hand + bindparam("change")}
            self._session.connection().execute(update(StockBalanceRow).where(here).values(change), moved)
        self._note_stock(entries, keys)

    def balances(self, catalogue_id: str) -> dict[int, int]:
        """Pieces on hand of each item that is counted."""
        table = StockBalanceRow.__table__
        query = select(table.c.item, table.c.on_hand).where(table.c.catalogue_id == catalogue_id)
        return {item: int(pieces) for item, pieces in self._session.execute(query)}

    def reservations(self, catalogue_id: str, since: datetime) -> Sequence[StockEntryRow]:
        """All movements of the plans that were promised pieces of this box until later than `since`, oldest first."""
        promised = select(StockEntryRow.plan_id).where(
            StockEntryRow.catalogue_id == catalogue_id, StockEntryRow.until > since
        )
        return self._session.scalars(
            select(StockEntryRow)
            .where(StockEntryRow.catalogue_id == catalogue_id, StockEntryRow.plan_id.in_(promised))
            .order_by(StockEntryRow.id)
        ).all()

    def session_movements(self, session_id: str) -> Sequence[StockEntryRow]:
        """All movements of stock for a session, oldest first."""
        return self._session.scalars(
            select(StockEntryRow).where(StockEntryRow.session_id == session_id).order_by(StockEntryRow.id)
        ).all()

    def last_fitted(self, catalogue_id: str, item: int) -> StockEntryRow | None:
        """The latest movement by which pieces of an item went onto a drum."""
        return self._session.scalars(
            select(StockEntryRow)
            .where(
                StockEntryRow.catalogue_id == catalogue_id, StockEntryRow.item == item, StockEntryRow.kind == "fitted"
            )
            .order_by(StockEntryRow.id.desc())
            .limit(1)
        ).one_or_none()

    def stock_entries(self, catalogue_id: str, limit: int, offset: int) -> Sequence[StockEntryRow]:
        """Movements of a catalogue's stock, newest first."""
        query = select(StockEntryRow).where(StockEntryRow.catalogue_id == catalogue_id)
        return self._page(query.order_by(StockEntryRow.id.desc()), limit, offset)

    def wrong_balances(self) -> Sequence[tuple[str, int, int, int]]:
        """Box, item, balance and sum of the movements wherever the two differ."""
        table, entry = StockBalanceRow, StockEntryRow
        summed = (
            select(entry.catalogue_id, entry.item, func.sum(entry.pieces).label("pieces"))
            .group_by(entry.catalogue_id, entry.item)
            .subquery()
        )
        found = func.coalesce(summed.c.pieces, 0)
        same = and_(summed.c.catalogue_id == table.catalogue_id, summed.c.item == table.item)
        query = select(table.catalogue_id, table.item, table.on_hand, found).outerjoin(summed, same)
        return [tuple(row) for row in self._session.execute(query.where(table.on_hand != found))]

    def _note_stock(self, entries: Sequence[Mapping[str, Any]], keys: Sequence[int]) -> None:
        """Tell the history what moved, a line for each kind of movement, box and session."""
        lines: dict[tuple[str, str, str | None], list[dict[str, Any]]] = {}
        rows: dict[tuple[str, str, str | None], list[tuple[str, int]]] = {}
        for entry, key in zip(entries, keys, strict=True):
            told = {
                name: entry[name] for name in ("item", "pieces", "held", "plan_id", "note") if entry[name] is not None
            }
            line = entry["kind"], entry["catalogue_id"], entry["session_id"]
            lines.setdefault(line, []).append(told)
            rows.setdefault(line, []).append((StockEntryRow.__tablename__, key))
        for line, moves in lines.items():
            kind, catalogue_id, session_id = line
            self._note(kind, "catalogue", catalogue_id, {"movements": moves}, session_id=session_id, rows=rows[line])
