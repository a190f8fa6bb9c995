"""`drumtrue bench can`: from the bus to the database, beside cantools' bare decode rate as the limit.

The frames are prepared before, and handed over as the process that drains a bus hands them over: this costs next to
nothing and loses nothing. Every frame is a whole reading, the most work a frame can be. The last part has a real bus.
"""

from __future__ import annotations

import json
import random
import sqlite3
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import can
from rich.console import Console

from drivers.bridge.bridge import Bridge
from drivers.bridge.delivery import HttpSender, Sender
from drivers.bridge.direct_delivery import DirectDelivery
from drivers.bridge.http import HttpOut
from drivers.bridge.spool import Spool
from drivers.can.bus import BusAddress
from drivers.can.driver import CanDriver
from drivers.clock import SystemClock
from service import bootstrap
from service.bench.can.frames import MAPPING, Measured, PreparedFrames, prepared_frames
from service.bench.can.service import MACHINE, bind, served
from service.bench.can.wire import over_wire
from service.bench.timing import show
from service.model.base import read_json
from service.model.machine import Machine
from service.settings import Settings
from service.usecases.machines import machines
from service.usecases.readings import sources
from service.usecases.readings.local_delivery import IntoDatabase

FULL_BUS = 8_000
"""Frames of 8 bytes that a classic bus of 1 Mbit/s carries in a second."""
AIMS = {"listen": 3 * FULL_BUS, "bridge": FULL_BUS}


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
    direct: DirectDelivery | None = None,
) -> Measured:
    """Bridge this many frames, and stop the clock when the last is acknowledged."""
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


def _bare_decode(prepared: list[can.Message]) -> float:
    """Frames a second that cantools decodes, and nothing else."""
    decoders: dict[int, Callable[..., Any]] = {m.frame_id: m.decode for m in MAPPING.messages()}
    begun = time.perf_counter()
    for frame in prepared:
        decoders[frame.arbitration_id](frame.data, decode_choices=False)
    return len(prepared) / (time.perf_counter() - begun)
