"""Names that must be unique: machines, boxes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy.exc import IntegrityError

from service.errors import Conflict
from service.messages import Message, Word


@contextmanager
def named_once(noun: str, name: str) -> Iterator[None]:
    """Raise Conflict where the engine finds, as it stores, that another request took the name meanwhile."""
    try:
        yield
    except IntegrityError as broken:
        # The engines name the column or the constraint.
        if any(f"{noun}{sign}name" in str(broken.orig) for sign in "._"):
            raise name_taken(noun, name) from broken
        raise


def name_taken(noun: str, name: str) -> Conflict:
    """The error for a name that is used already."""
    return Conflict(Message("name_taken", noun=Word(noun), name=name), field="name", value=name)
