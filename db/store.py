"""All queries, over the session of one unit of work."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import datetime
from typing import Any, TypeVar

from sqlalchemy import Select, and_, bindparam, delete, func, insert, or_, select, update
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from db.bulk import NewReading, insert_new
from db.chain import record_digest
from db.history import History
from db.notices import stream
from db.rows import (
    NOT_CLOSED,
    AuditRow,
    BalancerAnswerRow,
    Base,
    CatalogueRow,
    CorrectionRow,
    IdempotencyRow,
    InfluenceRow,
    LoginRow,
    MachineRow,
    PlanRow,
    ReadingMinuteRow,
    ReadingRow,
    RunRow,
    SessionRow,
    SourceRow,
    StockBalanceRow,
    StockEntryRow,
    StopRow,
    TokenRow,
)

Row = TypeVar("Row", bound=Base)

_LOOKUP_CHUNK = 400
"""Numbers in one IN list: SQLite takes 32,766 variables, and short statements are cached."""


class Store:
    """What is stored, seen from inside one unit of work; `history` is that of a unit that writes."""

    def __init__(self, session: Session, history: History | None = None) -> None:
        self._session = session
        self._history = history

    # ------------------------------------------------------------ rows by key
    def add(self, row: Base) -> None:
        """Store a new row; constraints are checked at once."""
        self._session.add(row)
        self._session.flush()

    def get(self, kind: type[Row], key: str) -> Row | None:
        """The row with this key, or None."""
        return self._session.get(kind, key)

    def lock(self, kind: type[Row], key: str) -> Row | None:
        """The row with this key, locked until the unit of work ends (SQLite holds its one write lock already)."""
        return self._session.get(kind, key, with_for_update=True, populate_existing=True)

    @contextmanager
    def part(self, actor: str | None = None) -> Iterator[None]:
        """A part of a unit that writes, maybe for another actor, which is undone by itself where its block raises."""
        assert self._history is not None, "a unit that only looks has no parts"  # noqa: S101
        with self._history.part(actor), self._session.begin_nested():
            yield

    def flush(self) -> None:
        """Send pending changes to the engine."""
        self._session.flush()

    # ------------------------------------------------------------ lists
    def machines(self, limit: int, offset: int) -> Sequence[MachineRow]:
        """Machines, newest first."""
        return self._page(select(MachineRow).order_by(MachineRow.created_at.desc(), MachineRow.id), limit, offset)

    def machine_named(self, name: str) -> MachineRow | None:
        """The machine of this name."""
        return self._session.scalars(select(MachineRow).where(MachineRow.name == name)).one_or_none()

    def catalogues(self, limit: int, offset: int) -> Sequence[CatalogueRow]:
        """Catalogues, newest first."""
        return self._page(select(CatalogueRow).order_by(CatalogueRow.created_at.desc(), CatalogueRow.id), limit, offset)

    def catalogue_named(self, name: str) -> CatalogueRow | None:
        """The catalogue of this name."""
        return self._session.scalars(select(CatalogueRow).where(CatalogueRow.name == name)).one_or_none()

    def sessions(
        self,
        limit: int,
        offset: int,
        *,
        machine_id: str | None = None,
        state: str | None = None,
        words: str | None = None,
    ) -> Sequence[SessionRow]:
        """Sessions, newest first; words: those whose machine, technician or note has them, in any case."""
        query = select(SessionRow).order_by(SessionRow.created_at.desc(), SessionRow.id)
        if machine_id is not None:
            query = query.where(SessionRow.machine_id == machine_id)
        if state is not None:
            query = query.where(SessionRow.state == state)
        if words is not None:
            searched = (SessionRow.machine_name, SessionRow.technician, SessionRow.note)
            query = query.where(or_(*(column.icontains(words, autoescape=True) for column in searched)))
        return self._page(query, limit, offset)

    def open_sessions(self, machine_id: str) -> Sequence[SessionRow]:
        """Sessions on a machine that are not closed, newest first."""
        return self._session.scalars(
            select(SessionRow)
            .where(SessionRow.machine_id == machine_id, NOT_CLOSED)
            .order_by(SessionRow.created_at.desc())
        ).all()

    def sources(self) -> Sequence[SourceRow]:
        """Bound sources, by name."""
        return self._session.scalars(select(SourceRow).order_by(SourceRow.name)).all()

    # ------------------------------------------------------------ of a session
    def runs(self, session_id: str) -> Sequence[RunRow]:
        """Runs of a session, in order."""
        return self._numbered(RunRow, session_id)

    def corrections(self, session_id: str) -> Sequence[CorrectionRow]:
        """Corrections of a session, in order."""
        return self._numbered(CorrectionRow, session_id)

    def plans(self, session_id: str) -> Sequence[PlanRow]:
        """Plans of a session, in order."""
        return self._numbered(PlanRow, session_id)

    def stops(self, session_id: str) -> Sequence[StopRow]:
        """Stops of a session to change masses, in order."""
        return self._numbered(StopRow, session_id)

    def import_session(
        self, session: Mapping[str, Any], parts: Mapping[type[Base], Sequence[Mapping[str, Any]]], told: dict[str, Any]
    ) -> None:
        """Store a session of another service with its parts, as they are; a closed one is sealed.

        Past the ORM: its version and its history are not those of this service. told: what the one entry tells.
        """
        session_id = str(session["id"])
        self._session.execute(insert(SessionRow), [dict(session)])
        for kind, rows in parts.items():
            if rows:
                self._session.execute(insert(kind), [{**row, "session_id": session_id} for row in rows])
        stream(self._session, (session_id, session["machine_id"]))
        if self._history is not None:
            self._history.note("imported", SessionRow.__tablename__, session_id, told, session_id=session_id)
            if session["state"] == "closed":
                self._history.seal(session_id)

    # ------------------------------------------------------------ influence
    def influences(self, machine_id: str) -> Sequence[InfluenceRow]:
        """What a machine's coefficients were, latest first."""
        return self._session.scalars(
            select(InfluenceRow)
            .where(InfluenceRow.machine_id == machine_id)
            .order_by(InfluenceRow.learned_at.desc(), InfluenceRow.id)
        ).all()

    def influences_of_type(self, machine_type: str) -> Sequence[InfluenceRow]:
        """All coefficients of machines of a type, latest first."""
        return self._session.scalars(
            select(InfluenceRow)
            .where(InfluenceRow.machine_type == machine_type)
            .order_by(InfluenceRow.learned_at.desc(), InfluenceRow.id)
        ).all()

    # ------------------------------------------------------------ readings
    def add_readings(self, rows: Sequence[NewReading]) -> int:
        """Insert readings whose (source, sequence) is not stored yet; returns how many were."""
        stream(self._session, {row.machine_id for row in rows})
        added = insert_new(self._session.connection(), rows)
        if added:
            for source, last in {row.source: row.sequence for row in rows}.items():
                told = {"new": added, "last_sequence": last}
                self._note("sent", ReadingRow.__tablename__, source, told, chained=False)
        return added

    def known(
        self, kind: type[ReadingRow | BalancerAnswerRow], keys: Sequence[tuple[str, int]]
    ) -> dict[tuple[str, int], ReadingRow | BalancerAnswerRow]:
        """The rows stored under these (source, sequence)."""
        found: dict[tuple[str, int], ReadingRow | BalancerAnswerRow] = {}
        of_source: dict[str, list[int]] = {}
        for source, sequence in keys:
            of_source.setdefault(source, []).append(sequence)
        for source, sequences in of_source.items():
            for start in range(0, len(sequences), _LOOKUP_CHUNK):
                # One source at a time: for pairs in a list SQLite takes no index, and reads the table to its end.
                chunk = sequences[start : start + _LOOKUP_CHUNK]
                query: Select[Any] = select(kind).where(kind.source == source, kind.sequence.in_(chunk))
                found.update({(row.source, row.sequence): row for row in self._session.scalars(query)})
        return found

    def newest_readings(
        self, machine_id: str, session_id: str, sources: Sequence[str], since: datetime, most: int
    ) -> Sequence[ReadingRow]:
        """The newest readings on a machine: of its bound sources, or sent for the session; newest first."""
        return self._session.scalars(
            select(ReadingRow)
            .where(
                ReadingRow.machine_id == machine_id,
                or_(
                    and_(ReadingRow.source.in_(sources), ReadingRow.session_id.is_(None)),
                    ReadingRow.session_id == session_id,
                ),
                ReadingRow.taken_at >= since,
            )
            .order_by(ReadingRow.taken_at.desc())
            .limit(most)
        ).all()

    def latest_of(self, source: str, most: int) -> list[tuple[int, datetime]]:
        """Number and time of the latest readings and answers of a source, the highest number first."""
        found: list[tuple[int, datetime]] = []
        # One look at the end of each index: there are few sources, and many readings.
        for kind in (ReadingRow, BalancerAnswerRow):
            query = select(kind.sequence, kind.taken_at).where(kind.source == source).order_by(kind.sequence.desc())
            found += [(number, at) for number, at in self._session.execute(query.limit(most))]
        return sorted(found, reverse=True)[:most]

    def highest_sequence(self, kind: type[ReadingRow | BalancerAnswerRow], source: str) -> int:
        """The highest number stored of a source; -1 for none."""
        highest = [self._session.scalar(select(func.max(kind.sequence)).where(kind.source == source))]
        if kind is ReadingRow:
            rolled = select(func.max(ReadingMinuteRow.last_sequence)).where(ReadingMinuteRow.source == source)
            highest.append(self._session.scalar(rolled))
        return max((int(found) for found in highest if found is not None), default=-1)

    def answers(self, machine_id: str, session_id: str, limit: int, offset: int) -> Sequence[BalancerAnswerRow]:
        """Balancers' answers on a machine for a session, or for none; newest first."""
        query = (
            select(BalancerAnswerRow)
            .where(
                BalancerAnswerRow.machine_id == machine_id,
                or_(BalancerAnswerRow.session_id == session_id, BalancerAnswerRow.session_id.is_(None)),
            )
            .order_by(BalancerAnswerRow.taken_at.desc(), BalancerAnswerRow.id)
        )
        return self._page(query, limit, offset)

    def readings_between(self, source: str, machine_id: str, since: datetime, until: datetime) -> Sequence[ReadingRow]:
        """Readings of a source on a machine between two times, in order of sequence."""
        return self._session.scalars(
            select(ReadingRow)
            .where(
                ReadingRow.source == source,
                ReadingRow.machine_id == machine_id,
                ReadingRow.taken_at >= since,
                ReadingRow.taken_at <= until,
            )
            .order_by(ReadingRow.sequence)
        ).all()

    # ------------------------------------------------------------ raw readings that grow old
    def sources_of_readings(self) -> Sequence[str]:
        """Names of all sources that raw readings are stored of."""
        return self._session.scalars(select(ReadingRow.source).distinct()).all()

    def oldest_reading(self, source: str) -> datetime | None:
        """When the oldest raw reading of a source was taken."""
        query = select(ReadingRow.taken_at).where(ReadingRow.source == source)
        return self._session.scalar(query.order_by(ReadingRow.taken_at).limit(1))

    def readings_before(self, source: str, until: datetime) -> Sequence[ReadingRow]:
        """Raw readings of a source from before a moment."""
        query = select(ReadingRow).where(ReadingRow.source == source, ReadingRow.taken_at < until)
        return self._session.scalars(query).all()

    def roll_up(self, source: str, until: datetime, readings: int, minutes: list[dict[str, Any]]) -> None:
        """Remove raw readings of a source from before a moment, and store what is left of them."""
        self._session.execute(insert(ReadingMinuteRow), minutes)
        self._session.execute(delete(ReadingRow).where(ReadingRow.source == source, ReadingRow.taken_at < until))
        if self._history is not None:
            changes = {"rolled_up_before": [None, until.isoformat()], "readings": [readings, 0]}
            self._history.note("changed", "source", source, changes)

    def rolled_up_between(self, source: str, since: datetime, until: datetime) -> datetime | None:
        """The first minute between two times of which a source's raw readings were removed."""
        query = select(ReadingMinuteRow.minute).where(
            ReadingMinuteRow.source == source,
            ReadingMinuteRow.minute >= since.replace(second=0, microsecond=0),
            ReadingMinuteRow.minute <= until,
        )
        return self._session.scalar(query.order_by(ReadingMinuteRow.minute).limit(1))

    # ------------------------------------------------------------ stock
    def open_stock(self, catalogue_id: str, items: Sequence[int]) -> None:
        """Begin the ledger of counted items, at none."""
        rows = [{"catalogue_id": catalogue_id, "item": item, "on_hand": 0} for item in items]
        if rows:
            self._session.execute(insert(StockBalanceRow), rows)

    def move_stock(self, entries: Sequence[Mapping[str, Any]]) -> None:
        """Write movements of stock. The engine refuses those that would leave less than nothing: IntegrityError."""
        if not entries:
            return
        self._session.execute(insert(StockEntryRow), [dict(entry) for entry in entries])
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
        self._note_stock(entries)

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

    def newest_by_source(self) -> dict[str, datetime]:
        """When the newest reading of each bound source was taken; sources without one are left out."""
        newest = select(func.max(ReadingRow.taken_at)).where(ReadingRow.source == SourceRow.name).scalar_subquery()
        found = self._session.execute(select(SourceRow.name, newest))
        return {name: at for name, at in found if at is not None}

    # ------------------------------------------------------------ access
    def tokens(self) -> Sequence[TokenRow]:
        """All tokens, oldest first."""
        return self._session.scalars(select(TokenRow).order_by(TokenRow.created_at, TokenRow.id)).all()

    def token_named(self, name: str) -> TokenRow | None:
        """The token of this name."""
        return self._session.scalars(select(TokenRow).where(TokenRow.name == name)).one_or_none()

    def any_token(self) -> bool:
        """Whether a token was ever created."""
        return self._session.scalar(select(TokenRow.id).limit(1)) is not None

    def end_logins(
        self, *, login_id: str | None = None, token_id: str | None = None, before: datetime | None = None
    ) -> None:
        """Forget logins: one, those of a token, or those that ended by themselves before a moment."""
        for column, value in ((LoginRow.id, login_id), (LoginRow.token_id, token_id)):
            if value is not None:
                self._session.execute(delete(LoginRow).where(column == value))
        if before is not None:
            self._session.execute(delete(LoginRow).where(LoginRow.expires_at < before))

    # ------------------------------------------------------------ history
    def history(
        self,
        limit: int,
        offset: int,
        *,
        session_id: str | None = None,
        kind: str | None = None,
        key: str | None = None,
        actor: str | None = None,
    ) -> Sequence[AuditRow]:
        """Changes, newest first: of a session, of one thing, by one actor."""
        query = select(AuditRow).order_by(AuditRow.id.desc())
        wanted = {"session_id": session_id, "kind": kind, "key": key, "actor": actor}
        for name, value in wanted.items():
            if value is not None:
                query = query.where(getattr(AuditRow, name) == value)
        return self._page(query, limit, offset)

    def chained(self, after: int, most: int) -> Sequence[AuditRow]:
        """Entries of the chain above a number, in order."""
        query = select(AuditRow).where(AuditRow.number > after).order_by(AuditRow.number).limit(most)
        rows = self._session.scalars(query).all()
        self._session.expunge_all()
        return rows

    def closed_sessions(self) -> Sequence[str]:
        """Identifiers of all closed sessions."""
        return self._session.scalars(select(SessionRow.id).where(SessionRow.state == "closed")).all()

    def record_digest(self, session_id: str) -> str | None:
        """Digest of all that is stored of a session, as `db.chain` says; None where it is not stored."""
        return record_digest(self._session, session_id)

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

    # ------------------------------------------------------------ keys of requests
    def claim(self, row: IdempotencyRow, now: datetime) -> bool:
        """Store a key that nobody has; another unit of work that is about to store it is waited for.

        False where it is taken. Some keys whose time is over are forgotten first.
        """
        over = select(IdempotencyRow.id).where(IdempotencyRow.expires_at <= now).order_by(IdempotencyRow.id)
        old = over.limit(100).with_for_update(skip_locked=True)
        self._session.execute(delete(IdempotencyRow).where(IdempotencyRow.id.in_(old)))
        own = and_(IdempotencyRow.id == row.id, IdempotencyRow.expires_at <= now)
        self._session.execute(delete(IdempotencyRow).where(own))
        if self._session.get(IdempotencyRow, row.id) is not None:
            return False
        self._session.add(row)
        try:
            self._session.flush()
        except IntegrityError:
            return False
        return True

    # ------------------------------------------------------------ health
    def ping(self) -> None:
        """Ask the engine for a sign of life."""
        self._session.execute(select(1))

    def _note_stock(self, entries: Sequence[Mapping[str, Any]]) -> None:
        """Tell the history what moved, a line for each kind of movement, box and session."""
        lines: dict[tuple[str, str, str | None], list[dict[str, Any]]] = {}
        for entry in entries:
            told = {
                name: entry[name] for name in ("item", "pieces", "held", "plan_id", "note") if entry[name] is not None
            }
            lines.setdefault((entry["kind"], entry["catalogue_id"], entry["session_id"]), []).append(told)
        for (kind, catalogue_id, session_id), moves in lines.items():
            self._note(kind, "catalogue", catalogue_id, {"movements": moves}, session_id=session_id)

    def _note(self, *told: Any, **more: Any) -> None:
        if self._history is not None:
            self._history.note(*told, **more)

    def _page(self, query: Select[Any], limit: int, offset: int) -> Sequence[Any]:
        return self._session.scalars(query.limit(limit).offset(offset)).all()

    def _numbered(self, kind: Any, session_id: str) -> Sequence[Any]:
        return self._session.scalars(select(kind).where(kind.session_id == session_id).order_by(kind.number)).all()
