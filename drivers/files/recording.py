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

MOST_BYTES = 512 * 1024 * 1024
"""Largest file that is read: an hour of 8 channels at 2.5 kHz and 4 bytes is 288 MB."""


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """Columns of samples (n,) by name, all taken together at sample_rate_hz; NaN: the sample was lost.

    stated: (quantity, unit) of a column as far as the file says, each None where it says nothing. unitless: the columns
    hold shares of the input's full scale.
    """

    path: str
    sample_rate_hz: float
    columns: dict[str, Floats]
    stated: dict[str, tuple[str | None, str | None]] = field(default_factory=dict)
    unitless: bool = False

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
    hysteresis as in `find_edges`, in the column's own unit. started_at: time of the first sample, aware. CSV only: time
    is the column of seconds, else sample_rate_hz must be stated; not both; where the file states its rate, none but
    that. In a WAV file a sample of 1 is the channel's full_scale, which must be stated; columns are named 1, 2 ... . In
    a universal file a column is named by node and direction, as 12+Z.
    """

    channels: tuple[tuple[str, Channel], ...]
    key_phasor: str
    started_at: datetime
    slope: Slope = "rising"
    threshold: float | None = None
    hysteresis: float | None = None
    time: str | None = None
    sample_rate_hz: float | None = None

    def __post_init__(self) -> None:
        require_finite(self)
        require(bool(self.channels), "number of channels 0", "be one or more")
        require_distinct((channel.sensor for _, channel in self.channels), "sensor")
        offset = self.started_at.utcoffset()
        require(offset == timedelta(0), f"started_at {self.started_at.isoformat()}", "be in UTC")
        rate = self.sample_rate_hz
        require(rate is None or rate > 0.0, f"sample_rate_hz {rate}", "be > 0")
        stated = f"sample_rate_hz {rate} beside the column of time {self.time!r}"
        require(rate is None or self.time is None, stated, "not be stated: the times say the rate")


def read_bytes(path: Path) -> bytes:
    """Contents of the file; raises `UnreadableFile` where it cannot be opened, is empty or too large."""
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise UnreadableFile(f"has {size} bytes; {MOST_BYTES} are the most: cut it in pieces", path=str(path))
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
    rows = []
    for name, channel in layout.channels:
        samples = recording.column(name)
        _check_stated(recording, name, channel)
        if recording.unitless:
            rule = "be stated: a WAV file knows no unit"
            require(channel.full_scale is not None, f"full_scale of {channel.sensor!r}", rule)
            samples = samples * (channel.full_scale or 1.0)
        rows.append(samples)
    edges = find_edges(
        recording.column(layout.key_phasor),
        recording.sample_rate_hz,
        slope=layout.slope,
        threshold=layout.threshold,
        hysteresis=layout.hysteresis,
    )
    channels = tuple(channel for _, channel in layout.channels)
    return Block(channels, np.stack(rows), recording.sample_rate_hz, edges)


def _check_stated(recording: Recording, name: str, channel: Channel) -> None:
    quantity, unit = recording.stated.get(name, (None, None))
    for stated, expected, what in ((quantity, channel.raw_quantity, "quantity"), (unit, channel.raw_unit, "unit")):
        if stated is not None and stated != expected:
            raise UnreadableFile(
                f"states the {what} {stated!r} of column {name!r}, the layout says {expected!r}: correct the layout",
                path=recording.path,
            )
