"""Waveforms of LabVIEW: text files of measurements (.lvm), and TDMS files, read by npTDMS, which is an extra."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from drivers.errors import UnreadableFile
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
    head, _, body = text.rpartition(END_OF_HEADER)
    if not head:
        raise UnreadableFile(f"has no line {END_OF_HEADER}: it is cut short", path=name)
    separator = SEPARATORS.get(_setting(head, "Separator").casefold(), "\t")
    line = body.split("\n", 1)[1] if "\n" in body else ""
    columns = _setting(head, "X_Columns").casefold()
    step = _setting(head, "Delta_X").split(separator)[0].replace(",", ".")
    has_time = columns in ("one", "multi") and time is None
    used = "X_Value" if has_time else time
    rate = None if used is not None else _rate(step, name)
    # A decimal comma is told from the cells; the names stand in the line below the header.
    asked = list(dict.fromkeys([*([used] if used else []), *wanted])) if wanted else []
    table = find_table(line, asked, name, separator)
    return read_table(table, name, time=used, sample_rate_hz=rate, time_unit="s", whole=False)


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


def read_tdms(path: Path, wanted: Sequence[str] = ()) -> Recording:
    """Read a .tdms; columns by the name of their channel, or GROUP/CHANNEL. Raises `UnreadableFile`."""
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
    columns, rates = {}, {}
    stated: Stated = {}
    for title, one in chosen.items():
        step = one.properties.get("wf_increment")
        data = np.asarray(one[:])
        if not isinstance(step, float | int) or not 1e-9 < float(step) < 1e3 or data.dtype.kind not in "iuf":
            if wanted:
                raise UnreadableFile(f"has no even time axis or no numbers in {title!r}: export it as CSV", path=name)
            continue
        columns[title], rates[title] = data.astype(float), 1.0 / float(step)
        stated[title] = (None, level_of(str(one.properties.get("unit_string", "")))[0])
    if not columns:
        raise UnreadableFile("has no channel of a waveform with a rate: export it as CSV", path=name)
    rate = next(iter(rates.values()))
    return Recording(name, rate, columns, stated, rates_hz={t: r for t, r in rates.items() if r != rate})


def _title(channel: Any) -> str:
    return f"{channel.group_name}/{channel.name}"


def _channel(channels: list[Any], name: str, path: str) -> Any:
    found = [one for one in channels if _title(one) == name] or [one for one in channels if one.name == name]
    if len(found) == 1:
        return found[0]
    known = ", ".join(_title(one) for one in channels[:20]) or "none"
    what = f"has {len(found)} columns {name!r}" if found else f"has no column {name!r}"
    raise UnreadableFile(f"{what}: its columns are {known}", path=path)
