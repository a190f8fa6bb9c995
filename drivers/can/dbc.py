"""Loading a DBC: in the alphabet it was written in, and not stopped by messages that nothing is read from."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cantools
from cantools.database.can import Database, Message

MAX_BYTES = 64 * 1024 * 1024


class BrokenDatabase(ValueError):
    """The file is no DBC that can be read, or a message that is read from is broken in it."""


def load_dbc(path: Path) -> Database:
    """Read a DBC. Raises `BrokenDatabase`, and OSError where the file cannot be opened."""
    if path.stat().st_size > MAX_BYTES:
        raise BrokenDatabase(f"it has more than {MAX_BYTES // 1024**2} MB")
    contents = path.read_bytes()
    try:
        # cp1252, which Vector's editor writes, has no character for 5 bytes: they are replaced.
        text = contents.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = contents.decode("cp1252", errors="replace")
    try:
        database: Any = cantools.database.load_string(text, "dbc", strict=False)
    except RecursionError as error:
        raise BrokenDatabase("it is nested too deeply") from error
    except Exception as error:  # cantools lets through whatever its parsing stumbles over
        raise BrokenDatabase(str(error) or type(error).__name__) from error
    if not isinstance(database, Database):
        raise BrokenDatabase("it holds no messages of a CAN bus")
    return database


def check_messages(messages: Iterable[Message]) -> None:
    """Hold messages to the rules that `load_dbc` let pass: signals within the frame that do not overlap.

    Raises `BrokenDatabase`.
    """
    for message in messages:
        try:
            message.refresh(strict=True)
        except (cantools.Error, ValueError) as error:
            raise BrokenDatabase(f"message {message.name} is broken in it: {error}") from error
