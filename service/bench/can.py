"""`drumtrue bench can`: from the bus to the database, beside cantools' bare decode rate as the limit.

The frames are prepared before, and handed over as the process that drains a bus hands them over: this costs next to
nothing and loses nothing. Every frame is a whole reading, the most work a frame can be. The last part has a real bus.
"""

from __future__ import annotations

import json
import os
import random
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import can
import httpx2
from rich.console import Console

from db.documents.base import read_json
from db.documents.machine import Machine
from drivers.bridge import Bridge
from drivers.can_bus import BusAddress
from drivers.can_driver import CanDriver
from drivers.can_frames import AT_ONCE, Frame
from drivers.can_reader import FLUSH_S
from drivers.can_sender import FrameEncoder
from drivers.can_toml import standard_mapping
from drivers.clock import SystemClock
from drivers.delivery import HttpSender, Sender
from drivers.express import Direct
from drivers.http_out import HttpOut
from drivers.reading import Reading
from drivers.spool import Spool
from service import bootstrap
from service.bench.timing import show
from service.settings import Settings
from service.usecases import machines, sources
from service.usecases.delivery import IntoDatabase

FULL_BUS = 8_000
"""Frames of 8 bytes that a classic bus of 1 Mbit/s carries in a second."""
AIMS = {"listen": 3 * FULL_BUS, "bridge": FULL_BUS}
COUNTER_TURNS = 100
SENSORS = ("P", "Q")
MAPPING = standard_mapping(SENSORS)
MACHINE = {
    "name": "bench",
    "service_speed_rpm": 460.0,
    "planes": [{"name": "1", "radius_mm": 330.0, "positions_deg": [0.0, 90.0, 180.0, 270.0], "max_masses": 3}],
    "sensors": [{"name": name} for name in SENSORS],
}


@dataclass(frozen=True)
class Measured:
    """frames that were sent, stored readings, seconds until all were stored, CPU seconds of the reading process."""

    frames: int
    stored: int
    seconds: float
    cpu_s: float

    @property
    def rate(self) -> float:
        """Frames per second, from the first on the bus to the last in the database."""
        return self.frames / self.seconds


def bench_can(*, markdown: bool = False, frames: int = 200_000, paced_s: float = 5.0) -> bool:
    """Print the table; True where every aim is met and nothing was lost."""
    prepared = prepared_frames()
    bare = _bare_decode(prepared)
    cpu = time.process_time()
    _bare_decode(prepared)
    a_second = f"{len(prepared) / (time.process_time() - cpu):,.0f}"
    lines = [("cantools decode alone", f"{bare:,.0f}", "", "", a_second, "", "")]
    good = True
    for name, what, measure in (
        ("listen", "serve --can: bus to database", into_database),
        ("bridge", "bridge: bus, spool, HTTP, database", over_http),
    ):
        full = measure(prepared, frames, None)
        paced = measure(prepared, int(FULL_BUS * paced_s), FULL_BUS)
        line, met = _line(what, AIMS[name], full, paced)
        lines.append(line)
        good &= met
    from service.bench.can_wire import over_wire

    what = "serve --can: udp_multicast between processes, paced"
    # A little faster than the aim: what is stored after the last frame came is time too.
    full_wire, paced_wire = over_wire(round(1.05 * AIMS["listen"]), 2.0 * paced_s), over_wire(FULL_BUS, paced_s)
    if isinstance(full_wire, str) or isinstance(paced_wire, str):
        lines.append((what, str(full_wire), "", "", "", "", ""))
    else:
        line, met = _line(what, AIMS["listen"], full_wire, paced_wire)
        lines.append(line)
        good &= met
    header = ("what", "frames/s", "aim", "lost", "frames a CPU second", f"CPU of one core at {FULL_BUS:,}/s", "")
    show(Console(), "bench can", header, lines, markdown=markdown)
    return good


Line = tuple[str, str, str, str, str, str, str]


def _line(what: str, aim: int, full: Measured, paced: Measured) -> tuple[Line, bool]:
    """A line of the table, and whether the aim was met."""
    lost = full.frames - full.stored + paced.frames - paced.stored
    met = full.rate >= aim and lost == 0
    share = f"{100 * paced.cpu_s / paced.seconds:.0f} %"
    a_second = f"{full.frames / full.cpu_s:,.0f}" if full.cpu_s else "-"
    words = "met" if met else "MISSED"
    return (what, f"{full.rate:,.0f}", f"{aim:,}", str(lost), a_second, share, words), met


def prepared_frames() -> list[can.Message]:
    """Frames of two sensors whose counters go on where the list begins again."""
    encoder = FrameEncoder(MAPPING)
    found: list[can.Message] = []
    for index in range(256 * COUNTER_TURNS):
        reading = Reading(
            "x", 1, datetime.now(UTC), SENSORS[index % 2], 3.0 + 0.001 * (index % 500), 0.1 * (index % 3600)
        )
        found.append(encoder.reading(reading)[-1])
    return found


class PreparedFrames:
    """Gives prepared frames, `rate` of them a second or as fast as they are taken, so many in all."""

    def __init__(self, messages: list[can.Message], count: int, rate: int | None) -> None:
        self._frames = [(m.arbitration_id, m.is_extended_id, bytes(m.data)) for m in messages]
        self._count, self._rate = count, rate
        self._given = 0
        self.begun = 0.0

    def take(self, timeout_s: float) -> list[Frame]:
        """What came since, as many as a reader hands over at once."""
        if not self._given:
            self.begun = time.perf_counter()
        due = self._count
        if self._rate is not None:
            time.sleep(FLUSH_S)
            due = min(due, int((time.perf_counter() - self.begun) * self._rate))
        upto = min(due, self._given + AT_ONCE)
        if upto == self._given:
            time.sleep(timeout_s)
        at, size = time.monotonic(), len(self._frames)
        given: list[Frame] = [(at, *self._frames[number % size], True) for number in range(self._given, upto)]
        self._given = upto
        return given

    def close(self) -> None:
        """There is no bus to let go of."""


def into_database(prepared: list[can.Message], count: int, rate: int | None) -> Measured:
    """As `serve --can` does."""
    with tempfile.TemporaryDirectory() as folder:
        database = Path(folder) / "bench.db"
        work = bootstrap.build_work(Settings(database_url=f"sqlite:///{database}"))
        machine = machines.create(work, read_json(Machine, json.dumps(MACHINE)))
        sources.bind(work, "can", machine.id)
        try:
            with Spool(Path(folder) / "spool.db") as spool:
                way = IntoDatabase(work)
                return _run(prepared, count, rate, database, spool, way, way)
        finally:
            work.database.close()


def over_http(prepared: list[can.Message], count: int, rate: int | None) -> Measured:
    """As `drumtrue bridge` does, to a service in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        database = Path(folder) / "bench.db"
        with served(database) as service, Spool(Path(folder) / "spool.db") as spool:
            bind(service.url)
            return _run(prepared, count, rate, database, spool, HttpSender(HttpOut(service.url)))


def _run(
    prepared: list[can.Message],
    count: int,
    rate: int | None,
    database: Path,
    spool: Spool,
    sender: Sender,
    direct: Direct | None = None,
) -> Measured:
    """Bridge so many frames, and stop the clock when the last is acknowledged."""
    bus, stop, cpu = PreparedFrames(prepared, count, rate), threading.Event(), time.process_time()
    driver = CanDriver(
        BusAddress("prepared"),
        MAPPING,
        clock=SystemClock(),
        source="can",
        on_mark=lambda mark: bridge.mark(mark),
        open_with=lambda _: bus,
    )
    bridge = Bridge(
        driver,
        spool,
        sender,
        stop=stop,
        clock=SystemClock(),
        rng=random.Random(1),  # noqa: S311
        report=lambda _: None,
        # Frames without a pace wait for a place: what a bus would never carry must not be lost.
        live=rate is not None,
        direct=direct,
    )
    thread = threading.Thread(target=bridge.run)
    thread.start()
    while thread.is_alive() and bridge.totals.delivered + bridge.totals.overflowed < count:
        time.sleep(0.002)
    seconds, cpu = time.perf_counter() - bus.begun, time.process_time() - cpu
    stop.set()
    thread.join()
    with closing(sqlite3.connect(database)) as connection:
        (stored,) = connection.execute("SELECT count(DISTINCT sequence) FROM reading").fetchone()
    return Measured(count, int(stored), seconds, cpu)


class Served(NamedTuple):
    """A running service."""

    url: str
    pid: int


@contextmanager
def served(database: Path, *options: str) -> Iterator[Served]:
    """A service in a process of its own."""
    address = ("--port", "0", "--database-url", f"sqlite:///{database}")
    command = [sys.executable, "-m", "service", "serve", *address, *options]
    process = subprocess.Popen(  # noqa: S603
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        assert process.stdout is not None  # noqa: S101
        yield Served(process.stdout.readline().split()[2], process.pid)
    finally:
        process.terminate()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()


def bind(url: str) -> None:
    """The source bound to a machine with the sensors of the frames."""
    with httpx2.Client(base_url=f"{url}/api/v1", trust_env=False, timeout=60.0) as api:
        stored = api.post("/machines", json=MACHINE).raise_for_status().json()
        api.put("/sources/can", json={"machine_id": stored["id"]}).raise_for_status()


def _bare_decode(prepared: list[can.Message]) -> float:
    """Frames a second that cantools decodes, and nothing else."""
    decoders: dict[int, Callable[..., Any]] = {m.frame_id: m.decode for m in MAPPING.messages()}
    begun = time.perf_counter()
    for frame in prepared:
        decoders[frame.arbitration_id](frame.data, decode_choices=False)
    return len(prepared) / (time.perf_counter() - begun)
