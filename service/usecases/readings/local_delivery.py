"""Store what a bridge delivers in the database of this process."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace

from sqlalchemy.exc import OperationalError

from db.rows import SourceMarkRow
from drivers.bridge.spool import Spooled
from drivers.errors import DeliveryFailed, DeliveryRefused
from drivers.reading import Answer, Counter, Entry, Mark, Reading
from service.errors import DrumtrueError
from service.model.counters import FrameCounter
from service.model.run import BalancerAnswer, MassOnRotor
from service.runtime.context import AppContext
from service.usecases.readings import balancer_answers, ingest


class IntoDatabase:
    """The way into the database of this very process, out of a spool or past it."""

    def __init__(self, work: AppContext) -> None:
        self._work = work

    def send(self, items: Sequence[Spooled]) -> None:
        """Store items; raises a `DeliveryError` as the way over HTTP does."""
        with _told():
            _ingest(self._work, [item.entry() for item in items])

    def store(self, entries: Sequence[Entry], mark: Mark | None) -> None:
        """Store entries and the mark behind them in one unit of work; raises a `DeliveryError`."""
        # Whoever sends a long list has its turn before it begins its unit of work, as everywhere.
        with _told(), self._work.long_list, self._work.write() as store:
            _ingest(replace(self._work, joined=lambda: nullcontext(store)), entries)
            if mark is not None:
                counters = (
                    FrameCounter(name=one.name, count=one.count, at=one.at, period_s=one.period_s)
                    for one in mark.counters
                )
                store.put_mark(mark.source, mark.number, tuple(counters))

    def close(self) -> None:
        """Nothing to let go of: the database is the service's."""


def last_mark(work: AppContext, source: str) -> Mark | None:
    """How far the counters of a source were with what was last stored past a spool; None where nothing was."""
    with work.read() as store:
        row = store.get(SourceMarkRow, source)
        if row is None:
            return None
        counters = tuple(Counter(one.name, one.count, one.at, one.period_s) for one in row.counters)
        return Mark(source, row.number, counters)


def _ingest(work: AppContext, entries: Sequence[Entry]) -> None:
    values = [entry for entry in entries if isinstance(entry, Reading)]
    if values:
        ingest.ingest(work, values)
    for entry in entries:
        if isinstance(entry, Answer):
            balancer_answers.ingest(work, _answer(entry))


@contextmanager
def _told() -> Iterator[None]:
    """Tell what the service says as a bridge is told it."""
    try:
        yield
    except DrumtrueError as error:
        if error.status >= 500:
            raise DeliveryFailed(error.message) from error
        said = f"{error.message}; what to do: {error.advice}" if error.advice else error.message
        raise DeliveryRefused(said, status=error.status, detail=error.advice or "") from error
    except OperationalError as error:
        raise DeliveryFailed(f"the database does not take them now ({error.orig})") from error


def _answer(answer: Answer) -> BalancerAnswer:
    masses = tuple(MassOnRotor(plane=plane, mass_g=mass, angle_deg=angle) for plane, mass, angle in answer.masses)
    return BalancerAnswer(source=answer.source, sequence=answer.sequence, taken_at=answer.taken_at, masses=masses)
