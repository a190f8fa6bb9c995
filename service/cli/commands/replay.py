"""`drumtrue record` and `drumtrue replay`: readings into a file, and out of it again."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from itertools import islice
from pathlib import Path

from drivers.bridge.http import HttpOut, Outlet
from drivers.can.bus import parse_bus
from drivers.can.driver import CanDriver
from drivers.can.mapping import CanMapping
from drivers.can.sender import CanOut
from drivers.clock import SystemClock
from drivers.errors import LogError, UnreadableFile
from drivers.files.readings import Recorder
from drivers.files.replay import ReplayDriver, open_log
from drivers.protocol import Driver
from drivers.reading import Reading
from service.cli.commands.bridge import BusChoice, first_sequence
from service.cli.support.can_options import mapping_of
from service.cli.support.signals import on_stop
from service.cli.support.sources import StandIn, Waveform, require_read, stand_in, tell_of, why_refused

BATCH = 500


def record_until_stopped(file: Path, read: BusChoice | StandIn, source: str, count: int | None) -> None:
    """Record a bus or a simulated drum until SIGINT or SIGTERM, or this many readings, a waveform file to its end.

    Raises `UnreadableFile` for a waveform file that gives no reading, and leaves no recording of it.
    """
    driver: Driver
    if isinstance(read, BusChoice):
        driver = CanDriver(
            read.address, read.mapping, clock=SystemClock(), source=source, sequence_start=first_sequence()
        )
    else:
        driver = stand_in(read, source, 1, -1)
    with Recorder(file) as recorder, driver:
        on_stop(driver.close)
        for reading in islice(driver, count):
            recorder.write([reading])
    health = driver.health()
    print(
        f"{recorder.written} readings in {file}, missed {health.missed}, refused {health.refused}" + why_refused(driver)
    )
    tell_of(driver)
    try:
        require_read(driver)
    except UnreadableFile:
        file.unlink()
        raise


def replay_file(
    file: Path | Waveform,
    *,
    to: str,
    url: str,
    token: str | None,
    bus: str,
    mapping: Path | None,
    sensors: str,
    j1939: bool,
    source: str | None,
    speed: float | None,
    as_now: bool,
    keep_going: bool,
    started_at: datetime | None = None,
) -> int:
    """Replay one file to a service or onto a bus; returns how many errors were passed over.

    Raises `LogError` at the first unless keep_going, `LogError` or `UnreadableFile` for a file that gives no reading,
    and what the way out raises.
    """
    errors: list[LogError] = []

    def on_error(error: LogError) -> None:
        errors.append(error)
        print(f"passed over: {error}", flush=True)

    messages = mapping_of(mapping, sensors, "", j1939=j1939)
    replay: Driver
    if isinstance(file, Waveform):
        replay, path = file.driver(source or file.file.stem), file.file
    else:
        path = file
        replay = ReplayDriver(
            path,
            clock=SystemClock(),
            source=source,
            mapping=messages,
            speed=speed,
            shift=_to_now(path, messages, started_at) if as_now else timedelta(),
            on_error=on_error if keep_going else None,
            started_at=started_at,
        )
    out: Outlet = HttpOut(url, batch_size=BATCH, token=token) if to == "http" else CanOut(parse_bus(bus), messages)
    sent = 0
    try:
        with replay:
            on_stop(replay.close)
            for batch in _batches(iter(replay), BATCH if speed is None else 1):
                sent += out.post(batch)
    finally:
        out.close()
        refused = replay.health().refused
        print(
            f"{sent} readings of {replay.source!r} replayed from {path}, {len(errors)} errors passed over"
            + (f", {refused} refused" if refused else "")
            + why_refused(replay)
        )
        tell_of(replay)
    require_read(replay)
    return len(errors)


def _to_now(file: Path, mapping: CanMapping, started_at: datetime | None) -> timedelta:
    """From the time of the file's first reading to the present."""
    first = next(open_log(file, mapping, lambda _: None, started_at), None)
    return timedelta() if first is None else datetime.now(UTC) - first.taken_at


def _batches(readings: Iterator[Reading], size: int) -> Iterator[list[Reading]]:
    while batch := list(islice(readings, size)):
        yield batch
