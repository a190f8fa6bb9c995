"""`drumtrue record` and `drumtrue replay`: readings into a file, and out of it again."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from itertools import islice
from pathlib import Path

from drivers.can_bus import parse_bus
from drivers.can_driver import CanDriver
from drivers.can_mapping import CanMapping
from drivers.can_sender import CanOut
from drivers.clock import SystemClock
from drivers.errors import LogError
from drivers.http_out import HttpOut, Outlet
from drivers.protocol import Driver
from drivers.reading import Reading
from drivers.recording import Recorder
from drivers.replay import ReplayDriver, open_log
from drivers.simulated import SimulatedDrum, threshing_drum_example
from service.cli.bridging import BusChoice, first_sequence
from service.cli.canbus import mapping_of
from service.cli.signals import on_stop

BATCH = 500


def record_until_stopped(
    file: Path, bus: BusChoice | None, source: str, seed: int, interval_s: float, count: int | None
) -> None:
    """Record a bus, else a simulated drum, until SIGINT or SIGTERM, or so many readings."""
    clock = SystemClock()
    driver: Driver
    if bus is None:
        spec = threshing_drum_example(seed)
        driver = SimulatedDrum(spec, seed=seed, clock=clock, source=source, interval_s=interval_s)
    else:
        driver = CanDriver(bus.address, bus.mapping, clock=clock, source=source, sequence_start=first_sequence())
    with Recorder(file) as recorder, driver:
        on_stop(driver.close)
        for reading in islice(driver, count):
            recorder.write([reading])
    health = driver.health()
    print(f"{recorder.written} readings in {file}, missed {health.missed}, refused {health.refused}")


def replay_file(
    file: Path,
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
) -> int:
    """Replay one file to a service or onto a bus; returns how many errors were passed over.

    Raises `LogError` at the first unless keep_going, and what the way out raises.
    """
    errors: list[LogError] = []

    def on_error(error: LogError) -> None:
        errors.append(error)
        print(f"passed over: {error}", flush=True)

    messages = mapping_of(mapping, sensors, "", j1939=j1939)
    replay = ReplayDriver(
        file,
        clock=SystemClock(),
        source=source,
        mapping=messages,
        speed=speed,
        shift=_to_now(file, messages) if as_now else timedelta(),
        on_error=on_error if keep_going else None,
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
        print(f"{sent} readings of {replay.source!r} replayed from {file}, {len(errors)} errors passed over")
    return len(errors)


def _to_now(file: Path, mapping: CanMapping) -> timedelta:
    """From the time of the file's first reading to the present."""
    first = next(open_log(file, mapping, lambda _: None), None)
    return timedelta() if first is None else datetime.now(UTC) - first.taken_at


def _batches(readings: Iterator[Reading], size: int) -> Iterator[list[Reading]]:
    while batch := list(islice(readings, size)):
        yield batch
