"""The layout of a waveform file as a TOML file beside it: which column is which sensor, in which unit.

    key_phasor = "kp"                       # column of the tachometer signal
    time = "t"                              # CSV: the column of seconds; or sample_rate_hz = 2560.0
    started_at = 2026-05-04T08:30:00Z       # time of the first sample, unless it is stated with the file
    block_s = 4.0                           # a reading of each sensor for this many seconds

    [[channel]]
    column = "P"                            # WAV: "1", "2" ...; universal file: "12+Z", its text, or "#3"
    sensor = "P"                            # as the machine calls it; its quantity, unit and detection follow
    raw_unit = "m/s2"                       # of the samples, and raw_quantity, full_scale

Besides: time_unit (s, ms, us, ns) and encoding of a text, where it does not tell; pulses_per_turn, slope, threshold,
hysteresis of the key-phasor; phase_sense, window, harmonics, band_hz, accept_clipped,
nominal_rpm of the measurement (see `drivers.signal.chain.Settings`).
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from drivers.errors import InvalidSetting
from drivers.files.recording import Layout
from drivers.files.toml_lines import lines_of
from drivers.signal.block import Channel
from drivers.signal.chain import Settings

_LAYOUT: dict[str, type | tuple[type, ...]] = {
    "key_phasor": str,
    "started_at": datetime,
    "time": str,
    "sample_rate_hz": (int, float),
    "slope": str,
    "threshold": (int, float),
    "hysteresis": (int, float),
    "time_unit": str,
    "encoding": str,
    "pulses_per_turn": int,
}
_SETTINGS: dict[str, type | tuple[type, ...]] = {
    "phase_sense": str,
    "window": str,
    "harmonics": int,
    "band_hz": list,
    "accept_clipped": bool,
    "nominal_rpm": (int, float),
}
_BLOCK_S: dict[str, type | tuple[type, ...]] = {"block_s": (int, float), "channel": list}
_CHANNEL: dict[str, type | tuple[type, ...]] = {
    "column": str,
    **{one.name: (int, float) if one.name == "full_scale" else str for one in fields(Channel)},
}


@dataclass(frozen=True)
class Layouts:
    """What a layout file says: columns, seconds a reading is taken from, and how it is measured."""

    layout: Layout
    block_s: float
    settings: Settings


def read_layout(path: Path, started_at: datetime | None = None) -> Layouts:
    """Read a layout file. started_at: of this recording, before what the file says.

    Raises `InvalidSetting` naming file, line, value and rule.
    """
    try:
        text = path.read_text(encoding="utf-8")
        data = tomllib.loads(text)
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidSetting(f"layout {path} cannot be read ({error}): give a TOML file in UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise InvalidSetting(f"layout {path} is no TOML ({error}): correct it there") from error
    return _Reader(path, data, lines_of(text)).read(started_at)


class _Reader:
    """One layout being read."""

    def __init__(self, path: Path, data: dict[str, Any], lines: dict[tuple[str, int, str], int]) -> None:
        self._path, self._data, self._lines = path, data, lines

    def read(self, started_at: datetime | None) -> Layouts:
        self._check(self._data, {**_LAYOUT, **_SETTINGS, **_BLOCK_S}, "", 0, needed=("key_phasor", "channel"))
        stated = {name: value for name, value in self._data.items() if name in _LAYOUT}
        started = started_at or stated.pop("started_at", None)
        if started is None:
            raise self._wrong("", 0, "", "does not say when the recording was started: state started_at")
        if started.tzinfo is None:
            raise self._wrong("", 0, "started_at", f"has started_at {started}: state its zone, such as Z for UTC")
        channels = tuple(self._channel(table, index) for index, table in enumerate(self._data["channel"]))
        settings = {name: value for name, value in self._data.items() if name in _SETTINGS}
        if "band_hz" in settings:
            settings["band_hz"] = self._band(settings["band_hz"])
        try:
            return Layouts(
                layout=Layout(**{**stated, "channels": channels, "started_at": started.astimezone(UTC)}),
                block_s=float(self._data.get("block_s", 4.0)),
                settings=Settings(**settings),
            )
        except InvalidSetting as error:
            raise InvalidSetting(f"layout {self._path}: {error}") from error

    def _channel(self, table: Any, index: int) -> tuple[str, Channel]:
        self._check(table, _CHANNEL, "channel", index, needed=("column", "sensor"))
        stated = {name: value for name, value in table.items() if name != "column"}
        try:
            return table["column"], Channel(**stated)
        except InvalidSetting as error:
            raise self._wrong("channel", index, "", str(error)) from error

    def _band(self, value: list[Any]) -> tuple[float, float]:
        if len(value) != 2 or any(isinstance(one, bool) or not isinstance(one, int | float) for one in value):
            raise self._wrong("", 0, "band_hz", f"has band_hz {value!r}: state two frequencies")
        return float(value[0]), float(value[1])

    def _check(
        self,
        table: Any,
        known: Mapping[str, type | tuple[type, ...]],
        name: str,
        index: int,
        *,
        needed: tuple[str, ...],
    ) -> None:
        """Only known keys, of the right type, and all that are needed."""
        if not isinstance(table, dict):
            raise self._wrong(name, index, "", f"holds {table!r}: write a table")
        for key, value in table.items():
            if key not in known:
                raise self._wrong(name, index, key, f"has the unknown key {key!r}: use {', '.join(sorted(known))}")
            if not isinstance(value, known[key]) or (isinstance(value, bool) and known[key] is not bool):
                raise self._wrong(name, index, key, f"has {key} {value!r}, which is of the wrong kind")
        for key in needed:
            if not table.get(key):
                raise self._wrong(name, index, "", f"has no {key}: state it")

    def _wrong(self, table: str, index: int, key: str, what: str) -> InvalidSetting:
        line = self._lines.get((table, index, key)) or self._lines.get((table, index, ""))
        where = f"layout {self._path}{f', line {line}' if line else ''}"
        return InvalidSetting(f"{where}: {f'[[{table}]] ' if table else ''}{what}")
