"""Recordings: JSON Lines of Reading, written as they come and read back strictly."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path

from drivers.can.logs.can_log import OnError
from drivers.closeable import Closeable
from drivers.errors import READABLE, WRITABLE, LogError
from drivers.reading import Reading
from drivers.reading_json import reading_to_json
from drivers.reading_rules import reading_from_dict

MAX_LINE = 100_000


class Recorder(Closeable):
    """Writes a recording; each reading is in the file when `write` returns. An existing file is never overwritten."""

    def __init__(self, path: Path) -> None:
        try:
            self._file = path.open("x", encoding="utf-8")
        except FileExistsError as there:
            raise LogError(
                path, None, "it is there already", "name a new file: a recording never replaces one"
            ) from there
        except OSError as error:
            raise LogError(path, None, f"it cannot be written ({error.strerror})", WRITABLE) from error
        self._path = path
        self.written = 0

    def write(self, readings: Iterable[Reading]) -> None:
        """Append readings. Raises `LogError` where the disk does not take them."""
        lines = [reading_to_json(one) + "\n" for one in readings]
        try:
            self._file.writelines(lines)
            self._file.flush()
        except OSError as error:
            reason = f"it cannot be written ({error.strerror})"
            raise LogError(self._path, self.written + 1, reason, WRITABLE) from error
        self.written += len(lines)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def read_recording(path: Path, on_error: OnError | None = None) -> Iterator[Reading]:
    """Readings of a recording.

    Raises `LogError` at the first line that is none; with on_error calls that instead and goes on with the next.
    """
    try:
        with path.open("rb") as file:
            number = 0
            while line := file.readline(MAX_LINE):
                number += 1
                if not line.strip():
                    continue
                try:
                    yield _reading(line)
                except (ValueError, RecursionError) as error:
                    wrong = LogError(path, number, str(error))
                    if on_error is None:
                        raise wrong from error
                    on_error(wrong)
    except OSError as error:
        raise LogError(path, None, f"it cannot be read ({error.strerror})", READABLE) from error


def _reading(line: bytes) -> Reading:
    if not line.endswith(b"\n") and len(line) >= MAX_LINE:
        raise ValueError(f"the line is longer than {MAX_LINE} bytes")
    try:
        values = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"it is no JSON ({error})") from error
    return reading_from_dict(values)
