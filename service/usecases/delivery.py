"""What a bridge delivers, into the database of this very process."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy.exc import OperationalError

from db.documents.run import BalancerAnswer, MassOnRotor
from drivers.errors import DeliveryFailed, DeliveryRefused
from drivers.reading import Answer, Reading
from drivers.spool import Spooled
from service.errors import DrumtrueError
from service.usecases import answers, readings
from service.usecases.work import Work


class IntoDatabase:
    """The way into the database of this very process."""

    def __init__(self, work: Work) -> None:
        self._work = work

    def send(self, items: Sequence[Spooled]) -> None:
        """Store items; raises a `DeliveryError` as the way over HTTP does."""
        entries = [item.entry() for item in items]
        values = [entry for entry in entries if isinstance(entry, Reading)]
        try:
            if values:
                readings.ingest(self._work, values)
            for entry in entries:
                if isinstance(entry, Answer):
                    answers.ingest(self._work, _answer(entry))
        except DrumtrueError as error:
            if error.status >= 500:
                raise DeliveryFailed(error.message) from error
            said = f"{error.message}; what to do: {error.advice}" if error.advice else error.message
            raise DeliveryRefused(said, status=error.status, detail=error.advice or "") from error
        except OperationalError as error:
            raise DeliveryFailed(f"the database does not take them now ({error.orig})") from error

    def close(self) -> None:
        """Nothing to let go of: the database is the service's."""


def _answer(answer: Answer) -> BalancerAnswer:
    masses = tuple(MassOnRotor(plane=plane, mass_g=mass, angle_deg=angle) for plane, mass, angle in answer.masses)
    return BalancerAnswer(source=answer.source, sequence=answer.sequence, taken_at=answer.taken_at, masses=masses)
