"""Loading a DBC: in the alphabet it was written in, and not stopped by messages that nothing is read from."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cantools
from cantools.database.can import Database, Message

EXTENDED = 1 << 31
"""Set in the identifier of a message with 29 bits."""
INDEPENDENT = 3221225472
"""Identifier of the message that holds signals of none."""
_MESSAGE = re.compile(r"^\s*BO_\s+(\d+)\s")
_SIGNAL = re.compile(r"^\s*SG_\s+(\w+)")
_OF_SIGNAL = re.compile(r"^\s*(?:VAL_|SIG_VALTYPE_|CM_ SG_|BA_ \"\w+\" SG_)\s+(\d+)\s+(\w+)")
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
        database = _parsed(text)
    except BrokenDatabase:
        kept = _without_broken(text)
        if kept == text:
            raise
        database = _parsed(kept)
    if not isinstance(database, Database):
        raise BrokenDatabase("it holds no messages of a CAN bus")
    return database


def _parsed(text: str) -> Any:
    try:
        return cantools.database.load_string(text, "dbc", strict=False)
    except RecursionError as error:
        raise BrokenDatabase("it is nested too deeply") from error
    except Exception as error:  # cantools lets through whatever its parsing stumbles over
        raise BrokenDatabase(str(error) or type(error).__name__) from error


def _without_broken(text: str) -> str:
    """The text without messages whose identifier is too great, and without names of values that no signal has.

    One such line makes cantools refuse the whole file, though nothing may be read from it.
    """
    kept: list[str] = []
    signals: dict[str, set[str]] = {}
    present = ""
    for line in text.splitlines():
        if found := _MESSAGE.match(line):
            number = int(found.group(1))
            limit = 0x1FFFFFFF if number & EXTENDED else 0x7FF
            present = found.group(1) if number & ~EXTENDED <= limit or number == INDEPENDENT else ""
            signals.setdefault(present, set())
        elif found := _SIGNAL.match(line):
            signals.setdefault(present, set()).add(found.group(1))
        elif line.strip():
            found = _OF_SIGNAL.match(line)
            if found and found.group(2) not in signals.get(found.group(1), ()):
                continue
            kept.append(line)
            continue
        if present or not line.strip():
            kept.append(line)
    return "\n".join(kept) + "\n"


def check_messages(messages: Iterable[Message]) -> None:
    """Hold messages to the rules that `load_dbc` let pass: signals within the frame that do not overlap.

    Raises `BrokenDatabase`.
    """
    for message in messages:
        try:
            message.refresh(strict=True)
        except (cantools.Error, ValueError) as error:
            raise BrokenDatabase(f"message {message.name} is broken in it: {error}") from error
