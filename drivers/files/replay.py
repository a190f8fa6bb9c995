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
from drivers.can.logs.can_log import SUFFIXES, CanLog, OnError, suffix_of
from drivers.can.mapping import CanMapping
from drivers.can.refusals import counted, table
from drivers.checks import require
from drivers.clock import Clock
from drivers.errors import READABLE, BrokenSource, InvalidSetting, LogError
from drivers.files.readings import read_recording
from drivers.reading import Reading
from drivers.reading_rules import reading_from_dict

RECORDING_SUFFIXES = (".jsonl", ".ndjson")
SESSION_FORMAT = "drumtrue-session"
CHECK_MAPPING = "check the mapping (--mapping, --sensors, --j1939)"


class ReplayDriver(BaseDriver):
    """Readings of a file in its order, each waited for as its time says, divided by `speed`; speed None: at once.

    source: names all readings anew; without it they keep the file's, of which there may be one only. Numbers are the
    file's where it is a recording, those of a CAN log count from its first moment, others from 1; `after` passes over
    those up to it. Times that go back are held. It ends with the file; opened again it goes on where it was closed.
    on_error: see `CanLog`. started_at: of a CAN log, before what it says itself. Raises `LogError` for a file without a
    reading.
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
        started_at: datetime | None = None,
    ) -> None:
        require(speed is None or speed > 0.0, f"speed {speed} of the replay", "be above 0")
        self.frames = LogReadings(path, mapping, on_error, started_at) if is_can_log(path) else None
        readings = open_log(path, mapping, on_error) if self.frames is None else iter(self.frames)
        self._readings = _shifted(readings, shift, numbers=self.frames is not None)
        self._first = next(self._readings, None)
        if self._first is None:
            raise _nothing_read(path, self.frames)
        super().__init__(source or self._first.source or "replay", sequence_start=0)
        self._path, self._clock, self._speed, self._after = path, clock, speed, after
        self._renamed = source is not None
        self._last_time: datetime | None = None

    def told(self) -> list[str]:
        """What to tell of a CAN log once it was read: how its start is known, and why frames gave no reading."""
        return [] if self.frames is None else self.frames.told()

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


def is_can_log(path: Path) -> bool:
    """Whether a file is a CAN log, by its suffix."""
    return suffix_of(path) in SUFFIXES


def open_log(
    path: Path,
    mapping: CanMapping | None = None,
    on_error: OnError | None = None,
    started_at: datetime | None = None,
) -> Iterator[Reading]:
    """Readings of a file by its suffix: .jsonl a recording, .json a session log, else a CAN log, read by `mapping`.

    Raises `LogError` while it is read, `InvalidSetting` for a CAN log without a mapping.
    """
    suffix = path.suffix.lower()
    if suffix in RECORDING_SUFFIXES:
        return read_recording(path, on_error)
    if suffix == ".json":
        return read_session_log(path, on_error)
    if not is_can_log(path):
        known = ", ".join((*RECORDING_SUFFIXES, ".json", *SUFFIXES))
        raise LogError(path, None, f"{suffix!r} is no suffix of a log that can be read", f"give one of {known}")
    return iter(LogReadings(path, mapping, on_error, started_at))


class LogReadings:
    """Readings in a CAN log, once, taken at the times of its frames; numbers leave gaps where its counters do.

    Numbers count from the first reading's microsecond: a log that is read again gives the same ones, and another log
    of the same source gives others. Raises `InvalidSetting` where there is no mapping.
    """

    def __init__(
        self, path: Path, mapping: CanMapping | None, on_error: OnError | None, started_at: datetime | None
    ) -> None:
        if mapping is None:
            raise InvalidSetting(f"{path} is a CAN log: name the mapping of its balancer (--mapping, or --sensors)")
        self.log = CanLog(path, on_error, started_at=started_at, names=mapping.identifiers())
        self.decoder = FrameDecoder(mapping)

    def __iter__(self) -> Iterator[Reading]:
        decoder, sequence, latest = self.decoder, 0, 0.0
        for frame in self.log:
            latest = max(latest, frame.timestamp)
            for found in decoder.feed(
                frame.arbitration_id, frame.is_extended_id, frame.data, latest, is_data=frame.is_data
            ):
                if isinstance(found, Vector):
                    sequence = sequence + found.lost + 1 if sequence else round(latest * 1e6)
                    yield reading_of(found, self.log.path.stem, sequence, datetime.fromtimestamp(latest, UTC))

    def told(self) -> list[str]:
        """What the user should know: notes on the log, and the table of reasons."""
        lines = [f"{self.log.path}: {note}" for note in self.log.notes]
        if counted(self.decoder.counts):
            lines += [f"frames without a reading, of {self.decoder.frames}:", *table(self.decoder.counts)]
        return lines


def _nothing_read(path: Path, readings: LogReadings | None) -> LogError:
    """Why a file gives no reading, as far as its frames tell."""
    if readings is None:
        return LogError(path, None, "it holds no reading", "give another file", code="nothing_read")
    decoder = readings.decoder
    reasons, frames = counted(decoder.counts), decoder.frames
    if not frames:
        what, advice = "and no frame of a bus", "give another file"
    elif not reasons:
        what, advice = f"; its {frames} frames have no sensor's amplitude and phase both", CHECK_MAPPING
    elif reasons.keys() == {"foreign"}:
        seen = ", ".join(f"{number:X}{'x' if extended else ''}" for number, extended in decoder.foreign)
        what, advice = (
            f": none of its {frames} frames is of a mapped message; their identifiers are {seen}",
            CHECK_MAPPING,
        )
    else:
        lines = "\n".join(table(decoder.counts))
        what, advice = f"; why, of {frames} frames:\n{lines}\n ", "see the reasons above"
    space = "" if what[0] in ":;" else " "
    return LogError(path, None, f"it holds no reading{space}{what}", advice, code="nothing_read")


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


def _shifted(readings: Iterator[Reading], shift: timedelta, *, numbers: bool) -> Iterator[Reading]:
    """Readings moved in time; numbers: theirs count from the time, and are moved with it."""
    step = round(shift / timedelta(microseconds=1)) if numbers else 0
    for reading in readings:
        moved = replace(reading, taken_at=reading.taken_at + shift, sequence=reading.sequence + step)
        yield moved if shift else reading
