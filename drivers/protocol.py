"""The narrow contract of every source of readings: simulated, CAN, replay, file.

tests/support/drivers/driver_contract.py states it as tests. A driver

* is opened and closed, or used as a context manager; closing twice is harmless, a closed driver may be opened again;
* is iterated while open; asking a closed one raises `DriverClosed`; closing it, from any thread, ends a running
  iteration without an error; a source with an end (a file) ends its iteration by itself;
* yields readings of one source, with sequence numbers that strictly increase, over re-opening too (a gap is a
  reading that was lost on the way), and aware UTC times that never go back;
* counts what it did not deliver and never raises for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from types import TracebackType
from typing import Literal, Protocol, Self

from drivers.reading import Reading


@dataclass(frozen=True, slots=True)
class Health:
    """What a driver knows of itself.

    delivered: readings handed over. refused: what arrived but was no valid reading. missed: readings that were due and
    never arrived. last_taken_at: time of the last delivered reading. All count from construction.
    """

    state: Literal["open", "closed"]
    delivered: int = 0
    refused: int = 0
    missed: int = 0
    last_taken_at: datetime | None = None


class Driver(Protocol):
    """A source of readings; see the module for what its methods promise."""

    @property
    def source(self) -> str:
        """Name of the source, the same in each of its readings."""
        ...

    def open(self) -> None:
        """Connect; raises `DriverClosed` if open already, another `DriverError` if the source cannot be reached."""
        ...

    def close(self) -> None:
        """Disconnect and end any iteration; harmless when closed."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    def __iter__(self) -> Iterator[Reading]: ...

    def health(self) -> Health:
        """State and counters, at any time."""
        ...
