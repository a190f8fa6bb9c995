"""What a waveform file of any kind holds: looked at without a layout, so that one can be written for it."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from drivers.errors import DriverError, UnreadableFile
from drivers.files.csv_file import read_csv
from drivers.files.driver import SUFFIXES
from drivers.files.labview_file import read_lvm, read_tdms
from drivers.files.recording import Recording, read_bytes
from drivers.files.table_shape import Shape, shape_of
from drivers.files.text_table import decoded
from drivers.files.uff_file import read_uff
from drivers.files.wav_file import read_wav
from drivers.signal.block import Floats
from drivers.signal.edges import find_edges

MIN_PULSES = 5
EVEN = 0.15
"""Share by which the time between two pulses may differ from the usual one."""
TWO_LEVELS = 0.8
"""Share of the samples near the lowest or the highest value that makes a train of pulses; 0.6 for a sine."""
_TIME_NAME = re.compile(
    r"^\W*(t|time|times|zeit|timestamp|date.?time|datum.*|x.?value|sec|secs|seconds|elapsed.*)\b", re.I
)
_PULSE_NAME = re.compile(
    r"(?<![a-z])(kp|key|keyph|tach|trig|puls|phasor|rpm|index|zero|mark|ref|opto|laser|prox)", re.I
)
_RATE = re.compile(
    r"(?:sampl\w*[\s_]*(?:rate|freq\w*)|abtast\w*|(?<![a-z])fs|scan[\s_]*rate)\D{0,25}?(\d+(?:[.,]\d+)?)\s*(k?)", re.I
)


@dataclass(frozen=True, slots=True)
class Column:
    """A column of numbers: what it is called, the unit of vibration that the file states (None: none), its range.

    pulses, rpm: pulses that come evenly, and how many in a minute; 0 where none do. share: near its two levels.
    """

    name: str
    quantity: str | None
    unit: str | None
    low: float
    high: float
    lost: int
    rate_hz: float
    pulses: int = 0
    rpm: float = 0.0
    share: float = 0.0

    @property
    def still(self) -> bool:
        """Whether it never moves."""
        return not self.high > self.low


@dataclass(frozen=True, slots=True)
class Survey:
    """kind: as in `SUFFIXES`. time: name of the column of times; None: the rate is the file's own, or stated nowhere.

    rate_stated: Hz, of a text without times, as its header says; 0: it does not. passed_over: columns without numbers.
    """

    kind: str
    recording: Recording
    columns: tuple[Column, ...]
    key_phasor: str | None
    time: str | None = None
    rate_stated: float | None = None
    passed_over: tuple[str, ...] = ()

    @property
    def seconds(self) -> float:
        """Length of the recording."""
        return max(
            (len(self.recording.columns[one.name]) / one.rate_hz for one in self.columns if one.rate_hz), default=0.0
        )


def survey(path: Path) -> Survey:
    """Look at a file. Raises `UnreadableFile` for one that cannot be read, or holds no numbers."""
    kind = SUFFIXES.get(path.suffix.lower())
    if kind is None:
        known = ", ".join(SUFFIXES)
        raise UnreadableFile(f"has the suffix {path.suffix.lower()!r}: use one of {known}", path=str(path))
    if kind == "text":
        return _text(path)
    reader = {"lvm": read_lvm, "tdms": read_tdms, "wav": read_wav, "uff": read_uff}[kind]
    return _of(kind, reader(path))  # type: ignore[operator]


def _text(path: Path) -> Survey:
    text = decoded(read_bytes(path), None, str(path))
    shape = shape_of(text, str(path))
    names = [name if name and shape.names.count(name) == 1 else f"#{i}" for i, name in enumerate(shape.names, start=1)]
    time = _time_column(shape, names)
    wanted = [names[place] for place in shape.numbers if names[place] != time]
    if not wanted:
        raise UnreadableFile(f"has no column of numbers: its columns are {', '.join(names[:12])}", path=str(path))
    passed = tuple(names[i] for i in range(len(names)) if i not in shape.numbers and names[i] != time)
    if time is not None:
        try:
            return replace(_of("text", read_csv(path, wanted, time=time)), time=time, passed_over=passed)
        except UnreadableFile:  # no even times: perhaps none at all
            wanted = [names[place] for place in shape.numbers]
    rate = _rate_in(shape.head)
    recording = read_csv(path, wanted, sample_rate_hz=rate or 1.0)
    return replace(_of("text", recording), rate_stated=rate, passed_over=passed)


def _time_column(shape: Shape, names: list[str]) -> str | None:
    """A column of dates, else one that is called so or whose numbers grow evenly from row to row."""
    if shape.dates:
        return names[shape.dates[0]]
    growing = [place for place in shape.numbers if _grows([row[place] for row in shape.rows])]
    called = [place for place in growing if _TIME_NAME.match(shape.names[place])]
    found = called or [place for place in growing if place == 0]
    return names[found[0]] if found else None


def _grows(cells: list[str]) -> bool:
    try:
        values = np.array([float(cell.replace(",", ".")) for cell in cells])
    except ValueError:
        return False
    steps = np.diff(values)
    return bool(steps.size) and bool((steps >= 0.0).all()) and float(values[-1]) > float(values[0])


def _rate_in(lines: list[str]) -> float:
    """The sample rate, Hz, that a line of the header states; 0 if none does."""
    for line in lines:
        if found := _RATE.search(line):
            rate = float(found.group(1).replace(",", ".")) * (1000.0 if found.group(2) else 1.0)
            if 1.0 <= rate <= 1e7:
                return rate
    return 0.0


def _of(kind: str, recording: Recording) -> Survey:
    columns = tuple(_column(recording, name, samples) for name, samples in recording.columns.items())
    trains = [one for one in columns if one.pulses and (one.share >= TWO_LEVELS or _PULSE_NAME.search(one.name))]
    trains.sort(key=lambda one: (not _PULSE_NAME.search(one.name), one.unit is not None, -one.share))
    return Survey(kind, recording, columns, trains[0].name if trains else None)


def _column(recording: Recording, name: str, samples: Floats) -> Column:
    quantity, unit = recording.stated.get(name, (None, None))
    seen = samples[~np.isnan(samples)]
    low, high = (float(seen.min()), float(seen.max())) if seen.size else (0.0, 0.0)
    rate = recording.rate_of(name)
    plain = Column(name, quantity, unit, low, high, len(samples) - len(seen), rate)
    try:
        edges = find_edges(samples, rate)
    except DriverError:
        return plain
    gaps = np.diff(edges)
    if len(edges) < MIN_PULSES or np.mean(np.abs(gaps / np.median(gaps) - 1.0) < EVEN) < 1.0 - EVEN:
        return plain
    near = np.abs(seen - 0.5 * (low + high)) >= 0.3 * (high - low)
    return replace(plain, pulses=len(edges), rpm=float(60.0 / np.median(gaps)), share=float(near.mean()))
