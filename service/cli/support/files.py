"""Files that commands write, and words for how many of what is in them."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from service.errors import Conflict, InvalidInput


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
        raise Conflict(
            f"{path} is there already",
            code="file_exists",
            field="FILE",
            value=str(path),
            advice=f"name another file: this command replaces no {noun}",
        ) from there
    except (OSError, sqlite3.Error) as wrong:
        raise InvalidInput(
            f"cannot write {path}: {wrong}",
            field="FILE",
            value=str(path),
            advice="name a file in a folder that can be written and has room",
        ) from wrong


def counted(number: int, noun: str) -> str:
    """So many of them, in words: `1 session`, `2 sessions`."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
