"""A CAN log of any kind as frames: which reader reads it, when it began, and what is wrong with which line.

The kind is told by the contents, not by the name: `.log` and `.txt` may be anything. A line that is no frame is told
with its number; with on_error it is passed over, and reading goes on with the next.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import datetime
from itertools import chain, islice
from pathlib import Path
from typing import Protocol

from drivers.can.logs import asc, busmaster, candump, table, trc
from drivers.can.logs.binary import read_blf, read_mf4
from drivers.can.logs.frame import LogClock, LogFrame, StartUnknown, Times
from drivers.can.logs.lines import COMPRESSED, numbered_lines, opened
from drivers.errors import LogError

SUFFIXES = (".log", ".asc", ".csv", ".trc", ".blf", ".mf4", ".txt")
MAX_ERRORS = 1000
LOOKED_AT = 200
"""Lines by which the kind of a log is told."""
STATE_START = "state when the recording began: --started-at 2026-05-04T08:30:00Z"
NO_CAN_LOG = (
    "CAN logs are known from Vector, BUSMASTER (.asc, .log), candump, PEAK (.trc), and tables with columns for time, "
    "identifier and data; a waveform is read with its layout (--layout)"
)
OnError = Callable[[LogError], None]


class LineReader(Protocol):
    """Reads one line of a log after another."""

    def read(self, line: str) -> LogFrame | None:
        """The frame of a line; None for a line that holds none. Raises ValueError with what is wrong."""
        ...


class CanLog:
    """The frames of a log, once. started_at: when it began, before what it says itself. names: see `asc`.

    notes: what the user should know of how it was read, complete once it was read.
    """

    def __init__(
        self,
        path: Path,
        on_error: OnError | None = None,
        *,
        started_at: datetime | None = None,
        names: asc.Names | None = None,
    ) -> None:
        self.path = path
        self.notes: list[str] = []
        self.frames = 0
        self._on_error, self._names = on_error, names or {}
        self._clock = LogClock(started_at)
        self._errors = 0
        self._suffix = suffix_of(path)
        if self._suffix not in SUFFIXES:
            known = ", ".join(SUFFIXES)
            raise LogError(
                path, None, f"{self._suffix!r} is no suffix of a log that can be read", f"give one of {known}"
            )

    def __iter__(self) -> Iterator[LogFrame]:
        """Raises `LogError` at the first line or block that is wrong, unless there is on_error."""
        reader: LineReader | None = None
        try:
            if self._suffix in (".blf", ".mf4"):
                read = read_blf if self._suffix == ".blf" else read_mf4
                yield from read(self.path, self._clock, self._count)
            else:
                with opened(self.path) as file:
                    lines = numbered_lines(self.path, file)
                    head = list(islice(lines, LOOKED_AT))
                    reader = self._reader([line for _, line in head if line.strip()])
                    yield from self._read(reader, chain(head, lines))
        except StartUnknown as error:
            said = getattr(reader, "unknown_date", "")
            reason = f"{error}{f' ({said})' if said else ''}"
            raise LogError(self.path, None, reason, STATE_START, code="start_unknown") from error
        except LogError as error:
            if self._on_error is None or error.line is not None or not self.frames:
                raise
            self._on_error(error)
        if self._clock.says and not self._clock.from_user:
            self.notes.insert(0, f"its start is taken from {self._clock.says}")

    def _reader(self, head: list[str]) -> LineReader:
        clock = self._clock
        if not head:
            raise LogError(self.path, None, "it is empty", "give another file", code="no_log")
        if any(line.startswith(busmaster.MARK) for line in head[:5]):
            return busmaster.BusmasterReader(clock)
        if self._suffix == ".asc":
            return asc.AscReader(clock, self._names)
        if self._suffix == ".trc":
            return trc.TrcReader(clock)
        at = 1 if head[0].startswith("sep=") else 0
        columns = table.columns_of(head[at], head[at + 1 :]) if len(head) > at else None
        if columns is not None:
            return table.TableReader(clock, columns, head[at + 1 :])
        if self._suffix == ".csv":
            found = f"its first line {head[at][:80]!r} names no columns of a CAN log"
            raise LogError(self.path, at + 1, found, NO_CAN_LOG, code="no_log")
        if head[0].startswith(";$FILEVERSION"):
            return trc.TrcReader(clock)
        if any(line.lower().startswith(("date ", "base hex", "base dec")) for line in head[:3]):
            return asc.AscReader(clock, self._names)
        clock.times = candump.times_of(head)
        return candump.CandumpReader(clock)

    def _read(self, reader: LineReader, lines: Iterator[tuple[int, str]]) -> Iterator[LogFrame]:
        last: LogError | None = None
        for number, line in lines:
            if last is not None:
                self._tell(last)
                last = None
            try:
                frame = reader.read(line)
            except StartUnknown:
                raise
            except (ValueError, OverflowError) as error:
                last = LogError(self.path, number, f"{error}: {line.strip()[:80]!r}")
                continue
            if frame is not None:
                self._count()
                yield frame
        if last is not None:
            self._end(last)

    def _end(self, last: LogError) -> None:
        """A last line that is wrong was cut off with the power, if the file ends within it."""
        if self.frames and self._suffix != COMPRESSED and not _ends_with_line(self.path):
            self.notes.append(f"its last line ({last.line}) is cut off and passed over")
        else:
            self._tell(last)

    def _tell(self, error: LogError) -> None:
        if self._on_error is None or self._errors >= MAX_ERRORS:
            raise error
        self._errors += 1
        self._on_error(error)

    def _count(self) -> None:
        self.frames += 1


def read_can_log(
    path: Path,
    on_error: OnError | None = None,
    *,
    started_at: datetime | None = None,
    names: asc.Names | None = None,
) -> Iterator[LogFrame]:
    """Frames of a log; see `CanLog`."""
    return iter(CanLog(path, on_error, started_at=started_at, names=names))


def suffix_of(path: Path) -> str:
    """The suffix that tells the kind of a file: that before .gz where it is compressed."""
    suffix = path.suffix.lower()
    return Path(path.stem).suffix.lower() if suffix == COMPRESSED else suffix


def _ends_with_line(path: Path) -> bool:
    if path.suffix.lower() == COMPRESSED:
        return True
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - 2, 0))
        return file.read().rstrip(b"\0").endswith((b"\n", b"\r"))


__all__ = ["STATE_START", "SUFFIXES", "CanLog", "LogFrame", "OnError", "Times", "read_can_log", "suffix_of"]
