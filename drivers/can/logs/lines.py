"""The lines of a text log: plain or compressed, in any usual encoding, none longer than it may be."""

from __future__ import annotations

import gzip
import io
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from drivers.errors import READABLE, LogError

MAX_LINE = 20_000
"""Characters in a line; the longest frame, of CAN XL, takes about 6,000."""
MAX_UNPACKED = 8 * 1024**3
MAX_RATIO = 300
"""Bytes unpacked for each packed one, beyond the first 16 MB; logs take 3 to 30."""
FREE_BYTES = 16 * 1024**2
COMPRESSED = ".gz"


@contextmanager
def opened(path: Path) -> Iterator[IO[bytes]]:
    """The contents of a file, unpacked if its name ends on .gz. Raises `LogError`."""
    try:
        with path.open("rb") as file:
            if path.suffix.lower() == COMPRESSED:
                yield io.BufferedReader(_Unpacked(path, file), 64 * 1024)
            else:
                yield file
    except OSError as error:
        raise LogError(path, None, f"it cannot be opened ({error.strerror or error})", READABLE) from error


class _Unpacked(io.RawIOBase):
    """The unpacked bytes of a gzip file; raises `LogError` where there are too many for its size, or it is damaged."""

    def __init__(self, path: Path, file: IO[bytes]) -> None:
        self._path, self._file, self._inner = path, file, gzip.GzipFile(fileobj=file)
        self._count = 0

    def readable(self) -> bool:
        """It is read only."""
        return True

    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override]
        """Unpack into the buffer."""
        try:
            found = self._inner.read1(len(buffer))
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            reason = f"its compressed part is damaged or cut short ({error})"
            raise LogError(self._path, None, reason, code="damaged") from error
        self._count += len(found)
        packed = max(self._file.tell(), 1)
        if self._count > MAX_UNPACKED or (self._count > FREE_BYTES and self._count > MAX_RATIO * packed):
            reason = f"it unpacks to over {self._count // 1_000_000} MB from {packed} bytes"
            raise LogError(self._path, None, reason, "unpack it yourself, if it is a log", code="too_large")
        buffer[: len(found)] = found
        return len(found)


def numbered_lines(path: Path, file: IO[bytes]) -> Iterator[tuple[int, str]]:
    """Lines with their numbers, from 1, without their ends.

    UTF-8 with or without its mark, UTF-16 with its mark, else a byte a character as in Windows' Western alphabet. Ends
    of a line: LF, CR LF or CR. Raises `LogError` for a line that is too long.
    """
    encoding = _encoding(file.peek(4)[:4])  # type: ignore[attr-defined]
    text = io.TextIOWrapper(file, encoding, errors="replace", newline=None)
    try:
        number = 0
        while line := text.readline(MAX_LINE):
            number += 1
            if len(line) >= MAX_LINE:
                raise LogError(path, number, f"the line is longer than {MAX_LINE} characters", code="no_log")
            yield number, line.rstrip("\n")
    except UnicodeError as error:  # half a character at the end of UTF-16
        raise LogError(path, None, f"it is cut short ({error})", code="damaged") from error
    finally:
        text.detach()


def _encoding(start: bytes) -> str:
    return "utf-16" if start[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
