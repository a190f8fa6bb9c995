"""A first layout for a waveform file: what can be seen in it, filled in; the rest to be corrected by hand."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from drivers.files.survey import Column, Survey
from drivers.files.toml_lines import quoted
from drivers.quantities import PER_UNIT

MAX_SHOWN = 40
"""Columns that the heading tells of."""


def described(found: Survey, path: Path) -> list[str]:
    """What the file holds, line by line."""
    kind = {"text": "text", "lvm": "LabVIEW measurement", "tdms": "TDMS", "wav": "WAV", "uff": "universal file"}
    samples = max(len(one) for one in found.recording.columns.values())
    unknown = found.rate_stated == 0.0
    length = "its sample rate is stated nowhere" if unknown else f"{found.seconds:.6g} s at {_rate(found):.6g} Hz"
    lines = [f"{path.name}: {kind[found.kind]}, {len(found.columns)} columns of {samples} samples, {length}"]
    lines += [f"  {_told(one, found)}" for one in found.columns[:MAX_SHOWN]]
    if len(found.columns) > MAX_SHOWN:
        lines.append(f"  and {len(found.columns) - MAX_SHOWN} more")
    if found.passed_over:
        lines.append(f"  without numbers: {', '.join(found.passed_over[:MAX_SHOWN])}")
    return [*lines, *(f"  {note}" for note in found.recording.notes)]


def draft(found: Survey, path: Path, started_at: datetime | None = None) -> str:
    """The layout as TOML, which `read_layout` reads once what it marks is put right.

    started_at: before what the file says.
    """
    lines = [f"# {line}" for line in described(found, path)]
    lines += ["# Correct what is marked, and the names of the sensors: as the machine calls them.", ""]
    if found.key_phasor is None:
        lines.append('key_phasor = ""    # no column looks like pulses, one a turn: state which is the key-phasor')
    else:
        column = next(one for one in found.columns if one.name == found.key_phasor)
        lines.append(f"key_phasor = {quoted(found.key_phasor)}    # {column.rpm:.5g} r/min, if it is one pulse a turn")
    lines += _times(found)
    began = started_at or found.recording.began
    if began is None:
        lines.append("# started_at = 2026-05-04T08:30:00Z    # the file does not say: state it, or use --started-at")
    else:
        source = "" if started_at else "    # as the file says; without a zone it was taken as UTC"
        lines.append(f"started_at = {began.astimezone(UTC).isoformat().replace('+00:00', 'Z')}{source}")
    for column in found.columns:
        lines += _channel(column, found)
    return "\n".join(lines) + "\n"


def _rate(found: Survey) -> float:
    measured = [one for one in found.columns if one.name != found.key_phasor] or list(found.columns)
    return measured[0].rate_hz


def _told(column: Column, found: Survey) -> str:
    words = [f"{column.low:.4g} to {column.high:.4g}" if not column.still else f"always {column.low:.4g}"]
    if column.unit:
        words[0] += f" {column.unit}"
    if column.rate_hz != _rate(found):
        words.append(f"at {column.rate_hz:.6g} Hz")
    if column.lost:
        words.append(f"{column.lost} samples lost")
    if column.pulses:
        words.append(f"crosses its middle {column.pulses} times, evenly: {column.rpm:.5g} in a minute")
    return f"{column.name}: {', '.join(words)}"


def _times(found: Survey) -> list[str]:
    if found.time is not None:
        return [f"time = {quoted(found.time)}"]
    if found.rate_stated is None:
        return []
    if found.rate_stated:
        return [f"sample_rate_hz = {found.rate_stated:.9g}    # as its header says"]
    return ["sample_rate_hz = 0.0    # the file does not say: state it"]


def _channel(column: Column, found: Survey) -> list[str]:
    """The table of a channel; of a column that cannot be one, as a comment."""
    if column.name == found.key_phasor:
        return []
    name = " ".join(column.name.split())[:100] or column.name
    lines = ["[[channel]]", f"column = {quoted(column.name)}", f"sensor = {quoted(name)}"]
    unit = column.unit or "m/s2"
    quantity = next(one for one, units in PER_UNIT.items() if unit in units)
    mark = "" if column.unit else "    # the file does not say: correct it"
    lines += [f'raw_quantity = "{quantity}"', f'raw_unit = "{unit}"{mark}']
    if found.recording.unitless:
        lines.append("full_scale = 0.0    # state the raw value of a sample at full scale: a WAV file has no unit")
    if column.still:
        return ["", *(f"# {line}" for line in ["it never moves:", *lines])]
    return ["", *lines]
