"""Files that commands write, and words for how many of what is in them."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from service.errors import Conflict, InvalidInput
from service.messages import Message


@contextmanager
def writing(path: Path, noun: str) -> Iterator[None]:
    """A block that writes a new file; noun: what it is, such as `backup`.

    Raises Conflict where it is there already, InvalidInput where it cannot be written.
    """
    try:
        if path.exists():
            raise FileExistsError(path)
        yield
    except FileExistsError as there:
        raise Conflict(Message("file_exists", path=path, noun=noun), field="FILE", value=str(path)) from there
    except (OSError, sqlite3.Error) as wrong:
        raise InvalidInput(
            Message("invalid_input.file_not_written", path=path, reason=wrong), field="FILE", value=str(path)
        ) from wrong


def counted(number: int, noun: str) -> str:
    """A number of things as text: `1 session`, `2 sessions`."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
