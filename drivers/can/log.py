"""CAN logs that python-can reads, with what it does not tell: which line is wrong, and that a file was cut short."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import can
from can.io.blf import BLFReader

from drivers.errors import CORRECT, READABLE, LogError

SUFFIXES = (".log", ".asc", ".csv", ".trc", ".blf")
MOST_ERRORS = 1000
LATEST_S = 253_402_300_799.0
"""End of the year 9999."""

NO_CAN_LOG = (
    "a line of a CAN log has 7: timestamp, arbitration_id, extended, remote, error, dlc, data; a waveform is read with "
    "its layout (--layout)"
)
_IN_WORDS = (
    (r"not enough values to unpack|list index out of range", "it has too few parts"),
    (r"too many values to unpack", "it has too many parts"),
    (r"invalid literal for int\(\) with base 16: (.*)", r"\1 is no hexadecimal number"),
    (r"invalid literal for int\(\) with base \d+: (.*)", r"\1 is no whole number"),
    (r"could not convert string to float: (.*)", r"\1 is no number"),
    (r"non-hexadecimal number found", "its data are no hexadecimal digits"),
    (r"Incorrect padding|Invalid base64|Only base64", "its data are no base64"),
)
"""What Python says of a wrong line, and the same in words."""

OnError = Callable[[LogError], None]

_ASC_FRAME = re.compile(
    r"^\s*\d+\.\d+\s+(CANFD\s+)?\d+\s+(?!Statistic|Status|J1939TP|OverloadFrame|SV:)\S", re.IGNORECASE
)
_TRC_OTHER = re.compile(r"\s(ST|ER|EC|EV|Warng|Error|FFFFFFFF)\s", re.IGNORECASE)


def read_can_log(path: Path, on_error: OnError | None = None) -> Iterator[can.Message]:
    """Frames of a log, by its suffix (.log .asc .csv .trc .blf).

    Raises `LogError` at the first line or block that is wrong; with on_error calls that instead and goes on with the
    rest, up to 1,000 wrong lines. Of a .blf only what lies before the damage can be read.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise LogError(
            path, None, f"{suffix!r} is no suffix of a log that can be read", f"give one of {', '.join(SUFFIXES)}"
        )
    reader = _read_blf(path) if suffix == ".blf" else _read_text(path, suffix, on_error)
    try:
        yield from reader
    except LogError as error:
        if on_error is None or error.line is not None:
            raise
        on_error(error)


def _read_blf(path: Path) -> Iterator[can.Message]:
    objects = 0
    try:
        # Opened here: the library leaves a file open whose head it cannot read.
        with path.open("rb") as file:
            reader = BLFReader(file)
            for message in reader:
                _check_time(message)
                objects += 1
                yield message
            whole = reader.file_size <= path.stat().st_size
    except OSError as error:
        raise LogError(path, None, f"it cannot be opened ({error.strerror})", READABLE) from error
    except Exception as error:
        # Whatever a damaged file makes the library stumble over.
        raise LogError(path, None, f"it is damaged after {objects} frames ({_words(error)})") from error
    if not whole:
        raise LogError(path, None, f"it is cut short after {objects} frames")


def _read_text(path: Path, suffix: str, on_error: OnError | None) -> Iterator[can.Message]:
    """Read again from the start after each error, without the wrong lines, and pass over what was given before."""
    bad: set[int] = set()
    given = 0
    while True:
        try:
            for index, message in enumerate(_one_reading(path, suffix, bad)):
                if index >= given:
                    given += 1
                    yield message
            return
        except LogError as error:
            if on_error is None or error.line is None or error.line in bad or len(bad) >= MOST_ERRORS:
                raise
            bad.add(error.line)
            on_error(error)


def _one_reading(path: Path, suffix: str, bad: set[int]) -> Iterator[can.Message]:
    lines = _Lines(path, suffix, bad)
    try:
        reader = can.io.player.MESSAGE_READERS[suffix](cast(Any, lines), relative_timestamp=False)
        for message in reader:
            lines.unread = None
            _check_time(message)
            yield message
        lines.check_read()
    except LogError:
        raise
    except Exception as error:
        advice = NO_CAN_LOG if suffix == ".csv" and "unpack" in str(error) else CORRECT
        raise LogError(path, lines.number or None, f"{_words(error)}: {lines.text[:80]!r}", advice) from error
    finally:
        lines.close()


class _Lines:
    """A text file that knows where it is, leaves out lines, and notices frames that the reader passed over."""

    def __init__(self, path: Path, suffix: str, bad: set[int]) -> None:
        try:
            self._file = path.open(encoding="utf-8", errors="replace", newline=None)
        except OSError as error:
            raise LogError(path, None, f"it cannot be opened ({error.strerror})", READABLE) from error
        self._path, self._suffix, self._bad = path, suffix, bad
        self.number = 0
        self.text = ""
        self.unread: int | None = None

    def __next__(self) -> str:
        self.check_read()
        while True:
            self.text = next(self._file)
            self.number += 1
            if self.number not in self._bad:
                break
        if self._like_a_frame(self.text):
            self.unread = self.number
        return self.text

    def __iter__(self) -> _Lines:
        return self

    def read(self) -> str:
        """All of the rest: what a file has, and no reader of logs uses."""
        return "".join(self)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def check_read(self) -> None:
        """Raise `LogError` where the last line looked like a frame and gave none."""
        if self.unread is not None:
            raise LogError(self._path, self.unread, f"no frame can be read: {self.text.strip()[:80]!r}")

    def _like_a_frame(self, text: str) -> bool:
        if self._suffix == ".asc":
            return _ASC_FRAME.match(text) is not None
        if self._suffix == ".trc":
            return bool(text.strip()) and not text.lstrip().startswith(";") and not _TRC_OTHER.search(text)
        return False


def _check_time(message: can.Message) -> None:
    if not (math.isfinite(message.timestamp) and 0.0 <= message.timestamp <= LATEST_S):
        raise ValueError(f"time {message.timestamp} is none")


def _words(error: Exception) -> str:
    said = str(error) or type(error).__name__
    for pattern, words in _IN_WORDS:
        if found := re.match(pattern, said):
            return found.expand(words)
    return said
