"""Faults done to real processes, with counts before and after.

`python -m tests.e2e.faults --kills 100` is a campaign.
"""

from __future__ import annotations

import argparse
import json
import random
import socket
import sqlite3
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path

import httpx2

from drivers.files.readings import Recorder
from drivers.reading import Reading
from drivers.simulator.example import threshing_drum_example
from service.cli.commands.serve import serving
from service.cli.support.demo_machine import machine_of
from service.settings import Settings
from tests.support.drivers.frames import readings
from tests.support.processes.namespaces import no_namespace, run_inside
from tests.support.processes.processes import Process, serve

A_KILL = 4_000
"""Readings that are delivered between two kills, at most."""


@dataclass
class Place:
    """A folder with a recording of so many readings, a service's database and a bridge's spool."""

    folder: Path
    count: int

    def __post_init__(self) -> None:
        with closing(socket.create_server(("127.0.0.1", 0))) as free:
            self.port = free.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"
        self.sent = readings(self.count)
        with Recorder(self.folder / "shed.jsonl") as recorder:
            recorder.write(self.sent)

    def serve(self) -> Process:
        return serve(self.folder / "service.db", self.port)

    @contextmanager
    def served(self) -> Iterator[None]:
        """A service in this process, which no fault is done to."""
        with serving(Settings(database_url=f"sqlite:///{self.folder / 'service.db'}")) as self.url:
            self.bind()
            yield

    def bind(self) -> None:
        """The source bound to a machine, if it is not yet."""
        with httpx2.Client(base_url=f"{self.url}/api/v1", trust_env=False, timeout=60.0) as api:
            machine = api.post("/machines", json=machine_of(threshing_drum_example(1), "drum")).json()
            api.put("/sources/can", json={"machine_id": machine["id"]}).raise_for_status()

    def bridge(self, *options: str, file_size_limit: int | None = None) -> Process:
        spool, recording = str(self.folder / "spool.db"), str(self.folder / "shed.jsonl")
        process = Process(
            *("bridge", "--replay", recording, "--url", self.url, "--spool", spool, "--status", "0.1", *options),
            file_size_limit=file_size_limit,
        )
        process.wait_for("bridge: ")
        return process

    def count_stored(self) -> int:
        """How many readings the service has."""
        with closing(sqlite3.connect(f"file:{self.folder / 'service.db'}?mode=ro", uri=True)) as database:
            (count,) = database.execute("SELECT count(*) FROM reading").fetchone()
        return int(count)

    def stored(self) -> list[Reading]:
        """What the service has, in order of sequence, as it was sent."""
        query = "SELECT sequence, sensor, amplitude, phase_deg, speed_rpm, overall_rms FROM reading ORDER BY sequence"
        start = self.sent[0].taken_at
        with closing(sqlite3.connect(f"file:{self.folder / 'service.db'}?mode=ro", uri=True)) as database:
            rows = database.execute(query).fetchall()
        return [
            Reading(
                source="can",
                sequence=sequence,
                taken_at=start + timedelta(milliseconds=sequence - 1),
                sensor=sensor,
                amplitude=amplitude,
                phase_deg=phase,
                speed_rpm=speed,
                overall_rms=overall,
            )
            for sequence, sensor, amplitude, phase, speed, overall in rows
        ]

    def wait_for_progress(self, bridge: Process) -> None:
        """Until more is stored than now, or the bridge is at its end."""
        before, end = self.count_stored(), time.monotonic() + 60.0
        while self.count_stored() == before and bridge.popen.poll() is None:
            assert time.monotonic() < end, bridge.lines[-5:]
            time.sleep(0.01)

    def check(self) -> None:
        """Nothing lost, nothing doubled, nothing changed; spool and database whole."""
        stored = self.stored()
        assert len(stored) == self.count, f"sent {self.count}, stored {len(stored)}"
        assert stored == self.sent
        for name in ("service.db", "spool.db"):
            with closing(sqlite3.connect(self.folder / name)) as database:
                assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        with closing(sqlite3.connect(self.folder / "spool.db")) as database:
            assert database.execute("SELECT count(*) FROM kept").fetchone() == (0,)
            assert database.execute("SELECT count(*) FROM aside").fetchone() == (0,)


def kill_the_bridge(place: Place, kills: int, rng: random.Random, within_s: float = 0.3) -> list[int]:
    """Kill -9 the bridge at so many random moments; returns how many readings were stored at each."""
    stored = []
    with place.served():
        for _ in range(kills):
            bridge = place.bridge()
            if rng.random() < 0.7:
                place.wait_for_progress(bridge)
            time.sleep(rng.uniform(0.0, within_s))  # the moment is what is tried
            bridge.kill()
            stored.append(place.count_stored())
        last = place.bridge()
        assert last.ended() == 0, last.lines[-5:]
        place.check()
    return stored


def kill_the_service(place: Place, kills: int, rng: random.Random, within_s: float = 0.3) -> list[int]:
    """Kill -9 the service at so many random moments under a running bridge; returns how many were stored at each."""
    stored = []
    service = place.serve()
    try:
        place.bind()
        bridge = place.bridge()
        for _ in range(kills):
            place.wait_for_progress(bridge)
            time.sleep(rng.uniform(0.0, within_s))  # the moment is what is tried
            service.kill()
            stored.append(place.count_stored())
            service = place.serve()
        assert bridge.ended() == 0, bridge.lines[-5:]
        place.check()
    finally:
        service.stop()
    return stored


def fill_the_disk(place: Place, limit: int) -> tuple[int, list[str]]:
    """A bridge that may not write files above a size, no service; then both in order again.

    Returns how many readings the spool had taken when it refused, and what the bridge said.
    """
    bridge = place.bridge(file_size_limit=limit)
    bridge.wait_for("FULL: ")
    bridge.wait_for("next attempt")
    assert bridge.stop() == 0, bridge.lines[-5:]
    with closing(sqlite3.connect(place.folder / "spool.db")) as database:
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        sequences = [row[0] for row in database.execute("SELECT sequence FROM kept ORDER BY id")]
    assert sequences == list(range(1, len(sequences) + 1))
    with place.served():
        again = place.bridge()
        assert again.ended() == 0, again.lines[-5:]
        place.check()
    return len(sequences), bridge.lines


def kill_the_listener(kills: int, seed: int) -> None:
    """Kill -9 `serve --can` under a talking balancer, in a network namespace where one can be made."""
    if no_namespace() is not None:
        print(f"kill_the_listener: not done, {no_namespace()}")
        return
    with tempfile.TemporaryDirectory() as folder:
        arguments = (folder, "--kills", str(kills), "--seed", str(seed))
        done = run_inside("tests.e2e.can_faults", *arguments, timeout_s=60.0 * (kills + 2))
        assert done.returncode == 0, done.stdout + done.stderr
        seen = json.loads(done.stdout.splitlines()[-1])
    print(f"kill_the_listener: {kills} kills, in spool or database at each {seen['had_at_each_kill']}")
    words = ("sent", "stored", "lost_of_what_it_had", "doubled", "waiting")
    print("  " + ", ".join(f"{word.replace('_', ' ')} {seen[word]}" for word in words), flush=True)
    assert (seen["lost_of_what_it_had"], seen["doubled"], seen["waiting"]) == (0, 0, 0)


def main() -> None:
    """A campaign: every fault, many times."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--readings", type=int, help="default: enough to be still under way at the last kill")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    options.readings = options.readings or max(100_000, A_KILL * options.kills)
    rng = random.Random(options.seed)
    for fault in (kill_the_bridge, kill_the_service):
        with tempfile.TemporaryDirectory() as folder:
            stored = fault(Place(Path(folder), options.readings), options.kills, rng)
            print(f"{fault.__name__}: {options.kills} kills, stored at each {stored}")
            print(f"  sent {options.readings}, stored {options.readings}, lost 0, doubled 0", flush=True)
    kill_the_listener(options.kills, options.seed)
    with tempfile.TemporaryDirectory() as folder:
        kept, lines = fill_the_disk(Place(Path(folder), options.readings), 2_000_000)
        print(f"fill_the_disk: refused after {kept}, then all delivered; said: {lines[1][:160]}")


if __name__ == "__main__":
    main()
