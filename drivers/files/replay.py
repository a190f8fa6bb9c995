"""Replay: what was logged, as a driver: session logs, recordings and CAN logs, at any speed."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from drivers.base import BaseDriver
from drivers.can.decoder import FrameDecoder, Vector
from drivers.can.driver import reading_of
from drivers.can.log import SUFFIXES, OnError, read_can_log
from drivers.can.mapping import CanMapping
from drivers.checks import require
from drivers.clock import Clock
from drivers.errors import READABLE, BrokenSource, InvalidSetting, LogError
from drivers.files.readings import read_recording
from drivers.reading import Reading
from drivers.reading_rules import reading_from_dict

RECORDING_SUFFIXES = (".jsonl", ".ndjson")
SESSION_FORMAT = "drumtrue-session"
NO_READING = "give another file; of a CAN log check the mapping too (--mapping, --sensors, --j1939)"


class ReplayDriver(BaseDriver):
    """Readings of a file in its order, each waited for as its time says, divided by `speed`; speed None: at once.

    source: names all readings anew; without it they keep the file's, of which there may be one only. Numbers are the
    file's where it is a recording, else they count from 1; `after` passes over those up to it. Times that go back are
    held. It ends with the file; opened again it goes on where it was closed. on_error: see `read_can_log`. Raises
    `LogError` for a file without a reading.
    """

    def __init__(
        self,
        path: Path,
        *,
        clock: Clock,
        source: str | None = None,
        mapping: CanMapping | None = None,
        speed: float | None = None,
        shift: timedelta = timedelta(),
        after: int = -1,
        on_error: OnError | None = None,
    ) -> None:
        require(speed is None or speed > 0.0, f"speed {speed} of the replay", "be above 0")
        self._readings = _shifted(open_log(path, mapping, on_error), shift)
        self._first = next(self._readings, None)
        if self._first is None:
            raise LogError(path, None, "it holds no reading", NO_READING)
        super().__init__(source or self._first.source or "replay", sequence_start=0)
        self._path, self._clock, self._speed, self._after = path, clock, speed, after
        self._renamed = source is not None
        self._last_time: datetime | None = None

    def _next(self) -> Reading | None:
        """Raises `LogError` for a wrong line, unless there is on_error, and for a reading of a second source."""
        while True:
            reading, self._first = self._first or next(self._readings, None), None
            if reading is None:
                return None
            if reading.source != self.source:
                if not self._renamed:
                    found = f"it holds readings of {self.source!r} and {reading.source!r}"
                    raise LogError(self._path, None, found, "state one name for all (--source)")
                reading = replace(reading, source=self.source)
            if reading.sequence > self._after:
                break
        moment = reading.taken_at
        if self._last_time is not None:
            passed = (moment - self._last_time).total_seconds()
            moment = max(moment, self._last_time)
            if self._speed is not None and passed > 0.0 and self._clock.wait(self._closed, passed / self._speed):
                self._first = reading
                return None
        self._last_time = moment
        return reading if moment == reading.taken_at else replace(reading, taken_at=moment)

    def _accept(self, reading: Reading) -> Reading:
        try:
            return super()._accept(reading)
        except BrokenSource as error:
            raise LogError(self._path, None, str(error)) from error


def open_log(path: Path, mapping: CanMapping | None = None, on_error: OnError | None = None) -> Iterator[Reading]:
    """Readings of a file by its suffix: .jsonl a recording, .json a session log, else a CAN log, read by `mapping`.

    Raises `LogError` while it is read, `InvalidSetting` for a CAN log without a mapping.
    """
    suffix = path.suffix.lower()
    if suffix in RECORDING_SUFFIXES:
        return read_recording(path, on_error)
    if suffix == ".json":
        return read_session_log(path, on_error)
    if suffix not in SUFFIXES:
        known = ", ".join((*RECORDING_SUFFIXES, ".json", *SUFFIXES))
        raise LogError(path, None, f"{suffix!r} is no suffix of a log that can be read", f"give one of {known}")
    if mapping is None:
        raise InvalidSetting(f"{path} is a CAN log: name the mapping of its balancer")
    return read_frames(path, mapping, on_error)


def read_frames(path: Path, mapping: CanMapping, on_error: OnError | None = None) -> Iterator[Reading]:
    """Readings in a CAN log, taken at the times of its frames; numbers leave gaps where its counters do."""
    decoder, sequence, latest = FrameDecoder(mapping), 0, 0.0
    for frame in read_can_log(path, on_error):
        latest = max(latest, frame.timestamp)
        is_data = not (frame.is_error_frame or frame.is_remote_frame or frame.is_fd)
        for found in decoder.feed(frame.arbitration_id, frame.is_extended_id, frame.data, latest, is_data=is_data):
            if isinstance(found, Vector):
                sequence += found.lost + 1
                yield reading_of(found, path.stem, sequence, datetime.fromtimestamp(latest, UTC))


def read_session_log(path: Path, on_error: OnError | None = None) -> Iterator[Reading]:
    """The readings of the runs in a session log, taken when their run was stored."""
    log = _json(path)
    runs = log.get("runs") if isinstance(log, Mapping) else None
    if (
        not isinstance(log, Mapping)
        or log.get("format", SESSION_FORMAT) != SESSION_FORMAT
        or not isinstance(runs, list)
    ):
        raise LogError(path, None, "it is no session log: it has no runs", "write one with GET /sessions/ID/log")
    sequence = 0
    for index, run in enumerate(runs):
        stated = run.get("readings") if isinstance(run, Mapping) else None
        for place, one in enumerate(stated if isinstance(stated, list) else [None]):
            sequence += 1
            try:
                yield _of_run(run, one, path.stem, sequence)
            except ValueError as error:
                wrong = LogError(path, None, f"runs[{index}].readings[{place}]: {error}")
                if on_error is None:
                    raise wrong from error
                on_error(wrong)


def _of_run(run: Any, stated: object, source: str, sequence: int) -> Reading:
    if not isinstance(stated, Mapping):
        raise ValueError("the run has no list of readings")
    taken_at = run.get("taken_at", "1970-01-01T00:00:00Z")
    return reading_from_dict({"source": source, "sequence": sequence, "taken_at": taken_at, **stated})


def _json(path: Path) -> object:
    try:
        found: object = json.loads(path.read_bytes())
    except OSError as error:
        raise LogError(path, None, f"it cannot be read ({error.strerror})", READABLE) from error
    except json.JSONDecodeError as error:
        raise LogError(path, error.lineno, f"it is no JSON ({error.msg})") from error
    except (ValueError, RecursionError) as error:
        raise LogError(path, None, f"it is no JSON ({error})") from error
    return found


def _shifted(readings: Iterator[Reading], shift: timedelta) -> Iterator[Reading]:
    for reading in readings:
        yield replace(reading, taken_at=reading.taken_at + shift) if shift else reading
