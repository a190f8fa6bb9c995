"""Idempotency keys: a retried request runs once and gets the stored answer.

The key is claimed and its answer kept in the very unit of work that makes the change: there is never the one without
the other. Only what was done is kept; what was refused changed nothing and is asked anew. Keys belong to their actor.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from datetime import timedelta

from db.rows import IdempotencyRow
from db.store import Store
from service.errors import InvalidInput
from service.messages import Message
from service.runtime.context import AppContext

KEPT = timedelta(hours=24)
"""How long an answer is kept at least; once it is forgotten its key is like a new one."""


@dataclass(frozen=True)
class Answer:
    """What a request is answered. replayed: it was done before."""

    status: int
    body: str
    replayed: bool = False


def answer(work: AppContext, key: str, request: str, act: Callable[[AppContext], Answer]) -> Answer:
    """What `act` answers, done once for all requests with this key. request: digest of what is asked for.

    `act` is called with a work whose units are all one, which commits with the answer. Raises InvalidInput where the
    key was used for something else, and what `act` raises: then nothing is done and the key is free.
    """
    name = hashlib.sha256(f"{work.actor}\0{key}".encode()).hexdigest()
    known = _kept(work, name, request, key)
    if known is not None:
        return known
    try:
        with ExitStack() as ending:
            unit = _Unit(work, ending, name, request)
            given = act(replace(work, joined=unit.join))
            kept = unit.begin()
            kept.status, kept.body = given.status, given.body
        return given
    except _KeyTaken:
        # Another request with the key came first, between our look and our claim.
        known = _kept(work, name, request, key)
        if known is None:
            raise
        return known


class _KeyTaken(Exception):
    """The key was claimed meanwhile."""


class _Unit:
    """One unit of work for all that a request writes; begun, with the claim of its key, by the first who writes."""

    def __init__(self, work: AppContext, ending: ExitStack, name: str, request: str) -> None:
        self._work = work
        self._ending = ending
        self._row = IdempotencyRow(id=name, request=request, status=0, body="", expires_at=work.now() + KEPT)
        self._store: Store | None = None

    def begin(self) -> IdempotencyRow:
        """The claimed key."""
        if self._store is None:
            self._store = self._ending.enter_context(self._work.write())
            if not self._store.claim(self._row, self._work.now()):
                raise _KeyTaken
        return self._row

    @contextmanager
    def join(self) -> Iterator[Store]:
        """The unit, for a use case that would begin one; it is not ended with the block."""
        self.begin()
        assert self._store is not None  # noqa: S101
        yield self._store
        self._store.flush()


def _kept(work: AppContext, name: str, request: str, key: str) -> Answer | None:
    with work.read() as store:
        row = store.get(IdempotencyRow, name)
        if row is None:
            return None
        if row.request != request:
            raise InvalidInput(Message("key_reused"), field="Idempotency-Key", value=key)
        return Answer(status=row.status, body=row.body, replayed=True)
