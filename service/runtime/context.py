"""Context of every use case: unit-of-work factory, clock and identifiers."""

from __future__ import annotations

import functools
import logging
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from typing import Any, TypeVar

from sqlalchemy.exc import DBAPIError, OperationalError, StatementError
from sqlalchemy.exc import TimeoutError as PoolTimeout

from db.database import Database, FileGone, is_away, is_deadlock, is_read_only, lacks_room
from db.rows import Base
from db.set_apart import require_readable
from db.store import Store
from db.unreadable import DocumentRefused, UnreadableRow
from service.errors import Abandoned, Conflict, InvalidInput, NotFound, StorageFull, Unavailable
from service.messages import Message, Word
from service.runtime.background import Background
from service.runtime.group_commit import GroupCommit
from service.runtime.listeners import Listeners
from service.runtime.metrics import Metrics
from service.runtime.solver_slots import SolverSlots

Row = TypeVar("Row", bound=Base)
Argument = TypeVar("Argument")
Outcome = TypeVar("Outcome")
MAX_DEADLOCKS = 4
AWAY_S = 3
"""When to ask again where the database does not answer, s."""
_log = logging.getLogger("drumtrue.storage")


def utc_now() -> datetime:
    """The time of the machine's clock."""
    return datetime.now(UTC)


def new_id() -> str:
    """An identifier that no one can guess."""
    return uuid.uuid4().hex


def _is_away(error: Exception) -> bool:
    return isinstance(error, Unavailable) and error.code == Unavailable.code


def never() -> bool:
    """Who asks for something within the process does not hang up."""
    return False


@dataclass(frozen=True)
class AppContext:
    """Storage, clocks and identifiers; tests hand in their own. `actor` is who acts: a token's name, or local.

    max_ahead_s: readings that are dated further ahead of the moment at which they come are set apart.

    together: small batches of readings that come at the same time share a unit of work. turns: to compute a selection.
    background: computations that outlast the request that began them.
    long_list: held while a long list of readings is stored; several at once would be done no sooner, and all that is
    asked meanwhile would wait for all of them.
    """

    database: Database
    now: Callable[[], datetime] = utc_now
    new_id: Callable[[], str] = new_id
    monotonic: Callable[[], float] = time.monotonic
    max_readings: int = 10_000
    max_ahead_s: float = 60.0
    actor: str = "local"
    meters: Metrics = field(default_factory=Metrics)
    together: GroupCommit[Any, Any] = field(default_factory=lambda: GroupCommit(_is_away))
    turns: SolverSlots = field(default_factory=SolverSlots)
    long_list: threading.Lock = field(default_factory=threading.Lock)
    listeners: Listeners = field(default_factory=Listeners)
    background: Background = field(default_factory=Background)
    joined: Callable[[], AbstractContextManager[Store]] | None = None
    """A unit of work under way that `write` joins; its beginner ends it."""
    gone: Callable[[], bool] = never
    """Whether who asked has hung up."""
    looking: Callable[[], Store] | None = None
    """A unit of work under way that `read` joins, so that several looks see one moment."""
    seen: int | None = None
    """Version of the session or plan on which the request was made; None: it does not say."""

    def acting(self, actor: str) -> AppContext:
        """The same, for another actor."""
        return replace(self, actor=actor)

    def having_seen(self, version: int | None) -> AppContext:
        """The same, for a request that was made on this version of its session or plan."""
        return replace(self, seen=version)

    def attended(self) -> float:
        """The stop-watch of a long computation, s. Raises Abandoned once who asked has hung up."""
        if self.gone():
            raise Abandoned(Message("request_abandoned"))
        return self.monotonic()

    def write(self) -> AbstractContextManager[Store]:
        """A unit of work that commits at its end. Raises Unavailable; StorageFull for a full disk."""
        return _stored(self.database.write(self.actor, self.now) if self.joined is None else self.joined())

    def read(self) -> AbstractContextManager[Store]:
        """A unit of work that only looks. Raises Unavailable."""
        return _stored(self.database.read() if self.looking is None else nullcontext(self.looking()))

    @contextmanager
    def one_moment(self) -> Iterator[AppContext]:
        """The same, whose looks within the block all see one moment; begun by the first of them."""
        with ExitStack() as ending:
            yield self if self.looking is not None else self.looking_within(ending)

    def looking_within(self, ending: ExitStack) -> AppContext:
        """The same, whose looks all see one moment until `ending` ends; begun by the first of them."""
        begun: list[Store] = []

        def look() -> Store:
            if not begun:
                begun.append(ending.enter_context(self.read()))
            return begun[0]

        return replace(self, looking=look)


@contextmanager
def _stored(unit: AbstractContextManager[Store]) -> Iterator[Store]:
    try:
        with unit as store:
            yield store
    except UnreadableRow as found:
        raise unreadable(found) from found
    except FileGone as error:
        _log.error("not stored: %s", error)
        raise Unavailable(Message("storage_gone", reason=str(error)), retry_after_s=AWAY_S) from error
    except PoolTimeout as error:
        _log.error("no answer: %s", error)
        raise Unavailable(Message("unavailable.connections"), retry_after_s=AWAY_S) from error
    except DBAPIError as error:
        named = _named(error)
        if named is None:
            raise
        raise named from error
    except StatementError as error:
        if isinstance(error.orig, DocumentRefused):
            raise _refused(error.orig) from error
        raise


def _named(error: DBAPIError) -> Unavailable | None:
    """The error for what an engine says of itself: its disk, its file, its server; None for any other."""
    if lacks_room(error):
        _log.error("not stored: %s", error.orig)
        return storage_full(error)
    if is_read_only(error):
        _log.error("not stored: %s", error.orig)
        return storage_read_only(error)
    if is_deadlock(error):
        return Unavailable(Message("deadlock"), retry_after_s=1)
    if isinstance(error, OperationalError) and is_away(error):
        _log.error("no answer: %s", error.orig)
        return Unavailable(Message("unavailable.silent", reason=str(error.orig)), retry_after_s=AWAY_S)
    return None


def again_after_deadlock(act: Callable[[Argument], Outcome]) -> Callable[[Argument], Outcome]:
    """`act`, done again where the database undid it because two units of work waited for each other."""

    @functools.wraps(act)
    def done(given: Argument) -> Outcome:
        for _ in range(MAX_DEADLOCKS):
            try:
                return act(given)
            except Unavailable as undone:
                if undone.code != "deadlock":
                    raise
        return act(given)

    return done


def unreadable(found: UnreadableRow) -> Conflict:
    """The error for a stored row that was needed and cannot be read."""
    fault = found.fault
    return Conflict(
        Message("row_unreadable", table=fault.table, key=fault.key, column=fault.column or "document"),
        field=f"{fault.column}.{fault.field}".strip("."),
        value=fault.value,
    )


def _refused(error: DocumentRefused) -> InvalidInput:
    """The error for a document that could not be read again, had it been stored."""
    return InvalidInput(
        Message("document_refused", rule=error.fault.rule), field=error.fault.field or None, value=error.fault.value
    )


def storage_full(error: DBAPIError) -> StorageFull:
    """The error for what the engine had no room for."""
    return StorageFull(Message("storage_full.database", reason=error.orig))


def storage_read_only(error: DBAPIError) -> Unavailable:
    """The error for a change where the engine may only be read."""
    return Unavailable(Message("storage_read_only", reason=str(error.orig)), retry_after_s=60)


def require(store: Store, kind: type[Row], key: str, *, lock: bool = False) -> Row:
    """The row with this key. Raises NotFound; UnreadableRow where a document of it cannot be read."""
    row = store.lock(kind, key) if lock else store.get(kind, key)
    if row is None:
        noun = kind.__tablename__.replace("_", " ")
        listed = noun in ("machine", "catalogue", "session", "source", "design study", "design run")
        raise NotFound(
            Message("not_found.listed" if listed else "not_found.part", noun=Word(noun), key=key),
            field=f"{kind.__tablename__}_id",
            value=key,
        )
    require_readable(row)
    return row
