"""`drumtrue check`: decode a bus or a log by a mapping and show values and reasons; nothing is stored or sent."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from drivers.can.bus import BusAddress, bus_errors
from drivers.can.decoder import Masses, Vector
from drivers.can.explained import Explained, Explainer, Shown
from drivers.can.frames import Frames, open_frames
from drivers.can.logs.can_log import CanLog
from drivers.can.mapping import CanMapping
from drivers.can.refusals import FOREIGN, REASONS, table
from drivers.errors import LogError

SHOWN_A_REASON = 3
"""Frames of each reason that are shown beyond the first ones."""
SHOWN_ERRORS = 5
ANY_START = datetime(2001, 1, 1, tzinfo=UTC)
"""Start of a log that states none: here only differences of times count."""
POLL_S = 0.1

Frame = tuple[float, int, bool, bytes, bool]
"""Seconds, identifier, extended, data, whether it is a data frame."""


@dataclass(slots=True)
class Checked:
    """What was seen so far: frames of each mapped message, readings of each sensor."""

    messages: dict[str, int]
    readings: dict[str, list[Vector]] = field(default_factory=dict)
    by_reason: dict[str, int] = field(default_factory=dict)
    shown: int = 0
    answers: int = 0


def check_frames(frames: Iterable[Frame], mapping: CanMapping, most: int) -> Iterator[str]:
    """Lines that tell of frames as they come, and a summary behind. most: frames that are shown one by one.

    Returns by its last line whether there was a reading: see `check_log` and `check_bus`.
    """
    explainer = Explainer(mapping)
    seen = Checked({message.name: 0 for message in mapping.messages()})
    first: float | None = None
    for at, identifier, extended, data, is_data in frames:
        first = at if first is None else first
        one = explainer.take(identifier, extended, data, at, is_data=is_data)
        _count(one, seen)
        if _worth(one, seen, most):
            yield from lines_of(one, at - first, mapping)
    yield from _summary(explainer, seen, mapping)


def lines_of(one: Explained, passed_s: float, mapping: CanMapping) -> list[str]:
    """A frame in a line: its values, and what it completed or was refused for."""
    identifier = f"{one.identifier:08X}" if one.extended else f"{one.identifier:03X}"
    what = one.message or "not mapped"
    values = ", ".join(_value(shown) for shown in one.signals) or one.data.hex(" ")
    lines = [f"{passed_s:10.3f} s  {identifier}  {what}: {values}"]
    lines += [f"{'':14}-> {_reading(found, mapping)}" for found in one.found]
    lines += [f"{'':14}!! {reason}: {REASONS[reason]}" for reason in one.reasons]
    return lines


def check_log(path: Path, mapping: CanMapping, most: int, started_at: datetime | None) -> int:
    """Check a log and print. Returns 1 where it gives no reading. Raises `LogError`."""
    errors: list[LogError] = []
    log = CanLog(path, errors.append, started_at=started_at, names=mapping.identifiers())
    unknown = False
    try:
        next(iter(CanLog(path, lambda _: None, started_at=started_at, names=mapping.identifiers())), None)
    except LogError as error:
        if error.code != "start_unknown":
            raise
        unknown = True
        log = CanLog(path, errors.append, started_at=ANY_START, names=mapping.identifiers())
    frames = ((one.timestamp, one.arbitration_id, one.is_extended_id, one.data, one.is_data) for one in log)
    found = _printed(check_frames(frames, mapping, most))
    for wrong in errors[:SHOWN_ERRORS]:
        print(f"wrong: {wrong}")
    if len(errors) > SHOWN_ERRORS:
        print(f"and {len(errors) - SHOWN_ERRORS} more lines that are wrong")
    if unknown:
        print(f"{path} does not say when it was recorded: state --started-at to replay it")
    for note in () if unknown else log.notes:
        print(f"{path}: {note}")
    return found


def check_bus(address: BusAddress, mapping: CanMapping, most: int, seconds: float, stop: threading.Event) -> int:
    """Check a bus for some seconds, or until stopped, and print. Returns 1 where it gives no reading.

    Raises `BusUnavailable`.
    """
    source = open_frames(address)
    try:
        with bus_errors(address):
            return _printed(check_frames(live(source, seconds, stop, time.monotonic), mapping, most))
    finally:
        source.close()


def live(source: Frames, seconds: float, stop: threading.Event, monotonic: Callable[[], float]) -> Iterator[Frame]:
    """The frames that come within some seconds, until stopped."""
    end = monotonic() + seconds
    while not stop.is_set() and (left := end - monotonic()) > 0.0:
        for stamp, identifier, extended, data, is_data in source.take(min(POLL_S, left)):
            yield (monotonic() if stamp is None else stamp, identifier, extended, bytes(data), is_data)


def _printed(lines: Iterator[str]) -> int:
    last = ""
    for last in lines:
        print(last, flush=True)
    return int(last.startswith("no reading"))


def _count(one: Explained, seen: Checked) -> None:
    if one.message is not None and not set(one.reasons) & FOREIGN:
        seen.messages[one.message] += 1
    for found in one.found:
        if isinstance(found, Vector):
            seen.readings.setdefault(found.sensor, []).append(found)
            del seen.readings[found.sensor][1:-1]  # the first and the last are told
        else:
            seen.answers += 1


def _worth(one: Explained, seen: Checked, most: int) -> bool:
    """Whether a frame is shown: the first ones of mapped messages, and some of each reason."""
    again = False
    for reason in set(one.reasons) - {"foreign"}:
        seen.by_reason[reason] = seen.by_reason.get(reason, 0) + 1
        again = again or seen.by_reason[reason] <= SHOWN_A_REASON
    if one.message is None and not one.found and not again:
        return False
    seen.shown += 1
    return again or seen.shown <= most


def _value(shown: Shown) -> str:
    raw = f"{shown.raw:g}" if isinstance(shown.raw, float) else str(shown.raw)
    why = f", {shown.why}" if shown.why else ""
    return f"{shown.target} {shown.value:.6g} {shown.unit}".rstrip() + f" ({shown.name} {raw}{why})"


def _reading(found: Vector | Masses, mapping: CanMapping) -> str:
    if isinstance(found, Masses):
        return "correction " + ", ".join(
            f"{plane} {mass:.4g} g at {angle:.4g} deg" for plane, mass, angle in found.masses
        )
    unit = next((sensor.unit for sensor in mapping.sensors if sensor.name == found.sensor), "")
    words = [f"{found.sensor} {found.amplitude:.4g} {unit}"]
    words.append("without phase" if found.phase_deg is None else f"at {found.phase_deg:.1f} deg")
    words.append("without speed" if found.speed_rpm is None else f"{found.speed_rpm:.5g} r/min")
    if found.overall_rms is not None:
        words.append(f"overall {found.overall_rms:.4g} {unit} rms")
    return ", ".join(words)


def _summary(explainer: Explainer, seen: Checked, mapping: CanMapping) -> Iterator[str]:
    decoder = explainer.decoder
    yield f"{decoder.frames} frames; of mapped messages: " + ", ".join(f"{n} {c}" for n, c in seen.messages.items())
    for name in [name for name, count in seen.messages.items() if not count]:
        yield f"{name} never came: check its identifier in the DBC, the node, and that the balancer sends it"
    if any(decoder.counts.values()):
        yield f"frames without a reading, of {decoder.frames}:"
        yield from table(decoder.counts)
    if decoder.foreign:
        yield "not mapped: " + ", ".join(
            f"{number:X}{'x' if extended else ''} ({count})" for (number, extended), count in decoder.foreign.items()
        )
    for name in [sensor.name for sensor in mapping.sensors if sensor.name not in seen.readings]:
        yield f"{name}: no reading"
    for last in (found[-1] for found in seen.readings.values()):
        yield f"last: {_reading(last, mapping)}"
    yield (
        "nothing was stored or sent"
        if seen.readings
        else "no reading: see the reasons above; nothing was stored or sent"
    )
