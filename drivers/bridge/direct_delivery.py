"""Deliver past the spool, into the database of this process.

The spool stays the way for all else: while it holds anything, while the database refuses, and for a batch that is not
stored within a bounded time. Such a batch may be stored in the end as well as spooled: delivery is at least once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Protocol

from drivers.errors import DeliveryError
from drivers.reading import Entry, Mark

MAX_S = 1.0
"""How long a batch is held in memory for, at most, before it is spooled."""


class DirectDelivery(Protocol):
    """A way on which nothing that was taken can be lost."""

    def store(self, entries: Sequence[Entry], mark: Mark | None) -> None:
        """Store entries, and with them how far the counters are: all or nothing. Raises a `DeliveryError`."""
        ...


class _Parcel:
    """A batch on its way; stored: None until that is known. left: its sender no longer waits."""

    def __init__(self, batch: Sequence[Entry | Mark]) -> None:
        self.entries = [one for one in batch if not isinstance(one, Mark)]
        self.mark = next((one for one in reversed(batch) if isinstance(one, Mark)), None)
        self.stored: bool | None = None
        self.left = False


class Express:
    """Hands batches from the thread that keeps to the one that delivers, one at a time. wake: called for each."""

    def __init__(self, way: DirectDelivery, wake: Callable[[], None]) -> None:
        self._way, self._wake = way, wake
        self._changed = threading.Condition()
        self._next: _Parcel | None = None

    def carry(self, batch: Sequence[Entry | Mark], patience_s: float = MAX_S) -> bool:
        """Have a batch stored by the thread that calls `deliver`; False where it was not, or not in time."""
        parcel = _Parcel(batch)
        with self._changed:
            self._next = parcel
            self._wake()
            self._changed.wait_for(lambda: parcel.stored is not None, patience_s)
            parcel.left = True
            self._next = None
            return parcel.stored is True

    def deliver(self) -> int | None:
        """Store the batch that was handed over; returns how many entries that was for, None where nothing was done.

        A batch that is not waited for any longer counts nothing: it is in the spool too.
        """
        with self._changed:
            parcel, self._next = self._next, None
        if parcel is None:
            return None
        stored = False
        try:
            self._way.store(parcel.entries, parcel.mark)
            stored = True
        except DeliveryError:
            return None  # it is spooled, and the spool's own delivery meets the same and tells it
        finally:
            with self._changed:
                parcel.stored = stored
                self._changed.notify_all()
        return 0 if parcel.left else len(parcel.entries)
