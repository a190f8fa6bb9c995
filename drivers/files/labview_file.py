"""Waveforms of LabVIEW: text files of measurements (.lvm), and TDMS files, read by npTDMS, which is an extra."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from drivers.errors import UnreadableFile
from drivers.files.began import moment_in, moment_of_seconds
from drivers.files.csv_file import read_table
from drivers.files.recording import Recording, Stated, read_bytes
from drivers.files.text_table import decoded, find_table
from drivers.units import level_of

END_OF_HEADER = "***End_of_Header***"
SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}
INSTALL_TDMS = "pip install 'drumtrue[tdms]', or export it as CSV"


def read_lvm(path: Path, wanted: Sequence[str] = (), *, time: str | None = None) -> Recording:
    """Read a .lvm at the rate of its column of times, X_Value, or of Delta_X in its header. Raises `UnreadableFile`."""
    name = str(path)
    text = decoded(read_bytes(path), None, name)
    if not text.startswith("LabVIEW Measurement"):
        raise UnreadableFile("is no LabVIEW measurement: it does not begin so", path=name)
    head, body, segments = _parts(text)
    if not head:
        raise UnreadableFile(f"has no line {END_OF_HEADER}: it is cut short", path=name)
    separator = SEPARATORS.get(_setting(head, "Separator").casefold(), "\t")
    columns = _setting(head, "X_Columns").casefold()
    step = _setting(head, "Delta_X").split(separator)[0].replace(",", ".")
    has_time = columns in ("one", "multi") and time is None
    used = ("#1" if columns == "multi" else "X_Value") if has_time else time
    rate = None if used is not None else _rate(step, name)
    # A decimal comma is told from the cells; the names stand in the line below the header.
    asked = list(dict.fromkeys([*([used] if used else []), *wanted])) if wanted else []
    table = find_table(body, asked, name, separator)
    found = read_table(table, name, time=used, sample_rate_hz=rate, time_unit="s", whole=False)
    more = () if segments == 1 else (f"it holds {segments} recordings one behind the other: the first is read",)
    return replace(found, began=moment_in(head.splitlines()) or found.began, notes=(*found.notes, *more))


def _parts(text: str) -> tuple[str, str, int]:
    """Both headers of the first recording, its lines, and how many recordings there are, each with a header."""
    first, *rest = re.split(rf"^{re.escape(END_OF_HEADER)}.*$\r?\n?", text, flags=re.MULTILINE)
    if not rest:
        return "", "", 0
    if len(rest) == 1:
        return first, rest[0], 1
    body = re.split(r"^Channels[\t,;]", rest[1], maxsplit=1, flags=re.MULTILINE)[0]
    return first + rest[0], body, len(rest) - 1


def _setting(head: str, key: str) -> str:
    """The last value of a key in the header; empty if there is none."""
    found = re.findall(rf"^{key}[\t,;](.*?)\s*$", head, re.MULTILINE)
    return str(found[-1]).strip() if found else ""


def _rate(step: str, path: str) -> float:
    try:
        size = float(step)
    except ValueError:
        size = 0.0
    if not 1e-9 < size < 1e3:
        raise UnreadableFile(f"has neither a column of times nor a step between samples (Delta_X {step!r})", path=path)
    return 1.0 / size


def read_tdms(path: Path, wanted: Sequence[str] = (), *, sample_rate_hz: float | None = None) -> Recording:
    """Read a .tdms; columns by the name of their channel, or GROUP/CHANNEL.

    sample_rate_hz: of channels that state none. Raises `UnreadableFile`.
    """
    name = str(path)
    read_bytes(path)  # says what is wrong with the file itself
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise UnreadableFile(f"needs a package that is not installed ({error}): {INSTALL_TDMS}", path=name) from error
    try:
        channels = [one for group in TdmsFile.read(str(path)).groups() for one in group.channels()]
    except Exception as error:  # whatever a damaged file makes the library stumble over
        raise UnreadableFile(f"is damaged ({error}): export it again", path=name) from error
    chosen = (
        {title: _channel(channels, title, name) for title in wanted} if wanted else {_title(c): c for c in channels}
    )
    columns, rates, begun = {}, {}, {}
    stated: Stated = {}
    for title, one in chosen.items():
        rate, data = _rate_of(one) or sample_rate_hz, np.asarray(one[:])
        if rate is None or data.dtype.kind not in "iuf":
            if wanted:
                what = "no numbers" if data.dtype.kind not in "iuf" else "no even time axis"
                raise UnreadableFile(f"has {what} in {title!r}: state sample_rate_hz, or export it as CSV", path=name)
            continue
        columns[title], rates[title] = data.astype(float), rate
        begun[title] = _began(one)
        stated[title] = (None, level_of(str(one.properties.get("unit_string", "")))[0])
    if not columns:
        raise UnreadableFile("has no channel of a waveform with a rate: export it as CSV", path=name)
    first = next(iter(columns))
    starts = {
        title: (moment - zero).total_seconds()
        for title, moment in begun.items()
        if (zero := begun[first]) is not None and moment is not None and moment != zero
    }
    other = {title: rate for title, rate in rates.items() if rate != rates[first]}
    return Recording(name, rates[first], columns, stated, rates_hz=other, starts_s=starts, began=begun[first])


def _rate_of(channel: Any) -> float | None:
    step = channel.properties.get("wf_increment")
    return 1.0 / float(step) if isinstance(step, float | int) and 1e-9 < float(step) < 1e3 else None


def _began(channel: Any) -> datetime | None:
    """When the channel's first sample was taken: its start and the offset behind it."""
    start, offset = channel.properties.get("wf_start_time"), channel.properties.get("wf_start_offset", 0.0)
    if not isinstance(start, np.datetime64):
        return None
    seconds = float((start - np.datetime64(0, "us")) / np.timedelta64(1, "us")) / 1e6
    return moment_of_seconds(seconds + (float(offset) if isinstance(offset, float | int) else 0.0))


def _title(channel: Any) -> str:
    return f"{channel.group_name}/{channel.name}"


def _channel(channels: list[Any], name: str, path: str) -> Any:
    found = [one for one in channels if _title(one) == name] or [one for one in channels if one.name == name]
    if len(found) == 1:
        return found[0]
    known = ", ".join(_title(one) for one in channels[:20]) or "none"
    what = f"has {len(found)} columns {name!r}" if found else f"has no column {name!r}"
    raise UnreadableFile(f"{what}: its columns are {known}", path=path)
