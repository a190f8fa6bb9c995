"""A recording as read from a file, and how its columns are to be understood."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from drivers.checks import require, require_distinct, require_finite
from drivers.errors import UnreadableFile
from drivers.signal.block import Block, Channel, Floats
from drivers.signal.edges import Slope, find_edges
from drivers.signal.revolutions import one_a_turn

SAME_RATE = 1e-4
"""Share by which rates may differ that are one: universal files write them with 6 digits."""
MAX_BYTES = 512 * 1024 * 1024
"""Largest file that is read: an hour of 8 channels at 2.5 kHz and 4 bytes is 288 MB."""


Stated = dict[str, tuple[str | None, str | None]]
"""Quantity and unit of columns, as far as a file says."""


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """Columns of samples (n,) by name, all taken together at sample_rate_hz; NaN: the sample was lost.

    stated: (quantity, unit) of a column as far as the file says, each None where it says nothing. unitless: the columns
    hold shares of the input's full scale. rates_hz: of columns that have another rate. starts_s: when a column begins,
    where that is not the first moment. began: when the first moment was, as far as the file says. notes: what the user
    should know of how it was read.
    """

    path: str
    sample_rate_hz: float
    columns: dict[str, Floats]
    stated: Stated = field(default_factory=dict)
    unitless: bool = False
    rates_hz: dict[str, float] = field(default_factory=dict)
    starts_s: dict[str, float] = field(default_factory=dict)
    began: datetime | None = None
    notes: tuple[str, ...] = ()

    def rate_of(self, name: str) -> float:
        """Sample rate of a column, Hz."""
        return self.rates_hz.get(name, self.sample_rate_hz)

    def column(self, name: str) -> Floats:
        """Column of this name; raises `UnreadableFile` naming the ones there are."""
        if name not in self.columns:
            known = ", ".join(sorted(self.columns)) or "none"
            raise UnreadableFile(f"has no column {name!r}: its columns are {known}", path=self.path)
        return self.columns[name]


@dataclass(frozen=True, slots=True)
class Layout:
    """Which column is what.

    channels: (column, channel) of each sensor. key_phasor: column of the tachometer signal; slope, threshold and
    hysteresis as in `find_edges`, in the column's own unit. started_at: time of the first sample, aware. Text only:
    time is the column of times, else sample_rate_hz must be stated; not both; time_unit (s, ms, us, ns) and encoding
    where the file does not tell them. Where the file states its rate, none but that may be stated.

    In a WAV file a sample of 1 is the channel's full_scale, which must be stated; columns are named 1, 2 ... . In a
    universal file a column is named by node and direction, as 12+Z, by its first line of text, or by number, as #3.
    pulses_per_turn: of the key-phasor; None: one, unless the vibration says otherwise, which refuses the block.
    """

    channels: tuple[tuple[str, Channel], ...]
    key_phasor: str
    started_at: datetime
    slope: Slope = "rising"
    threshold: float | None = None
    hysteresis: float | None = None
    time: str | None = None
    sample_rate_hz: float | None = None
    time_unit: str | None = None
    encoding: str | None = None
    pulses_per_turn: int | None = None

    def wanted(self) -> list[str]:
        """The columns that are read, each once, the key-phasor's first."""
        return list(dict.fromkeys([self.key_phasor, *(column for column, _ in self.channels)]))

    def __post_init__(self) -> None:
        require_finite(self)
        require(bool(self.channels), "number of channels 0", "be one or more")
        require_distinct((channel.sensor for _, channel in self.channels), "sensor")
        offset = self.started_at.utcoffset()
        require(offset == timedelta(0), f"started_at {self.started_at.isoformat()}", "be in UTC")
        units = ("s", "ms", "us", "ns")
        require(self.time_unit in (None, *units), f"time_unit {self.time_unit!r}", f"be one of {', '.join(units)}")
        pulses = self.pulses_per_turn
        require(pulses is None or 1 <= pulses <= 1000, f"pulses_per_turn {pulses}", "be within 1 and 1000")
        rate = self.sample_rate_hz
        require(rate is None or rate > 0.0, f"sample_rate_hz {rate}", "be > 0")
        stated = f"sample_rate_hz {rate} beside the column of time {self.time!r}"
        require(rate is None or self.time is None, stated, "not be stated: the times say the rate")


def read_bytes(path: Path) -> bytes:
    """Contents of the file; raises `UnreadableFile` where it cannot be opened, is empty or too large."""
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise UnreadableFile(f"has {size} bytes; {MAX_BYTES} are the most: cut it in pieces", path=str(path))
        contents = path.read_bytes()
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise UnreadableFile(f"cannot be read ({reason}): check the name and permissions", path=str(path)) from error
    if not contents:
        raise UnreadableFile("is empty: record again", path=str(path))
    return contents


def whole_block(recording: Recording, layout: Layout) -> Block:
    """The recording as one block, its edges found over its whole length.

    Raises `UnreadableFile` for a column that is not there or stated in another unit, `SignalRefused` for a key-phasor
    that never moves.
    """
    rate, count = _together(recording, layout)
    rows = []
    for name, channel in layout.channels:
        samples = recording.column(name)[:count]
        _check_stated(recording, name, channel)
        if recording.unitless:
            rule = "be stated: a WAV file knows no unit"
            require(channel.full_scale is not None, f"full_scale of {channel.sensor!r}", rule)
            samples = samples * (channel.full_scale or 1.0)
        rows.append(samples)
    edges = _edges(recording, layout)
    channels = tuple(channel for _, channel in layout.channels)
    inside = edges[(edges >= 0.0) & (edges <= count / rate)]
    return Block(channels, np.stack(rows), rate, inside, 1.0 / recording.rate_of(layout.key_phasor))


def _edges(recording: Recording, layout: Layout) -> Floats:
    """Edges of the key-phasor, s from the channels' first sample, one to a turn."""
    tacho, rate = recording.column(layout.key_phasor), recording.rate_of(layout.key_phasor)

    def found(signal: Floats) -> Floats:
        return find_edges(signal, rate, slope=layout.slope, threshold=layout.threshold, hysteresis=layout.hysteresis)

    edges = found(tacho)
    if layout.pulses_per_turn is not None and layout.pulses_per_turn > 1:
        level = np.nanmin(tacho) if layout.slope == "rising" else np.nanmax(tacho)
        begun = len(found(np.concatenate([[level], tacho]))) - len(edges)  # whether the file begins within a pulse
        edges = one_a_turn(edges, layout.pulses_per_turn, before=begun, step_s=1.0 / rate)
    starts = recording.starts_s
    return edges + starts.get(layout.key_phasor, 0.0) - starts.get(layout.channels[0][0], 0.0)


def _together(recording: Recording, layout: Layout) -> tuple[float, int]:
    """The rate of the channels, which must be one, and the samples that all of them have."""
    names = [name for name, _ in layout.channels]
    counts = [len(recording.column(name)) for name in names]
    rates = [recording.rate_of(name) for name in names]
    begun = [recording.starts_s.get(name, 0.0) for name in names]
    for name, rate, start in zip(names, rates, begun, strict=True):
        if abs(rate - rates[0]) > SAME_RATE * rates[0] or abs(start - begun[0]) * rates[0] > SAME_RATE * counts[0]:
            raise UnreadableFile(
                f"has {name!r} at another rate or time than {names[0]!r}: read them with a layout each",
                path=recording.path,
            )
    return rates[0], min(counts)


def _check_stated(recording: Recording, name: str, channel: Channel) -> None:
    quantity, unit = recording.stated.get(name, (None, None))
    for stated, expected, what in ((quantity, channel.raw_quantity, "quantity"), (unit, channel.raw_unit, "unit")):
        if stated is not None and stated != expected:
            raise UnreadableFile(
                f"states the {what} {stated!r} of column {name!r}, the layout says {expected!r}: correct the layout",
                path=recording.path,
            )
