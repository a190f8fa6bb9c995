"""`serve --can` killed in mid-stream, inside a network namespace: prints counts before and after as JSON."""

from __future__ import annotations

import argparse
import json
import random
import re
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from itertools import pairwise
from pathlib import Path

import httpx2

from drivers.simulator.example import threshing_drum_example
from service.cli.support.demo_machine import machine_of
from tests.support.processes.can_talker import identity
from tests.support.processes.processes import Process, serve

PORT = 8000


def main() -> None:
    """Kill the service at random moments; what had reached its spool or database must be stored at the end, once."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--kills", type=int, default=2)
    parser.add_argument("--rate", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng, folder = random.Random(options.seed), options.folder
    had: set[int] = set()
    counts = []
    with talking(options.rate) as talker:
        for number in range(options.kills + 1):
            service = listen(folder)
            if not number:
                bind()
            wait_for_more(folder)
            if number == options.kills:
                break
            time.sleep(rng.uniform(0.0, 0.5))  # the moment is what is tried
            service.kill()
            had |= set(kept(folder)) | set(stored(folder))
            counts.append(len(had))
        time.sleep(0.2)
        sent = stop(talker)
    wait_until_quiet(folder)
    status = service.stop()
    found = stored(folder)
    for file in ("service.db", spool_of(folder).name):
        with closing(sqlite3.connect(folder / file)) as database:
            assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    print(
        json.dumps(
            {
                "sent": sent,
                "had_at_each_kill": counts,
                "stored": len(found),
                "lost_of_what_it_had": len(had - set(found)),
                "doubled": len(found) - len(set(found)),
                "waiting": len(kept(folder)),
                "gaps": gaps(found),
                "told_lost": told_lost(service.lines),
                "status": status,
            }
        )
    )


@contextmanager
def talking(rate: int) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "tests.support.processes.can_talker", str(rate)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as talker:
        try:
            yield talker
        finally:
            talker.kill()


def stop(talker: subprocess.Popen[str]) -> int:
    """Let the balancer fall silent; how many readings it sent."""
    said, _ = talker.communicate("", timeout=20.0)
    return int(said)


def listen(folder: Path) -> Process:
    return serve(folder / "service.db", PORT, "--can", "udp_multicast", "--sensors", "P")


def bind() -> None:
    with httpx2.Client(base_url=f"http://127.0.0.1:{PORT}/api/v1", trust_env=False, timeout=60.0) as api:
        machine = api.post("/machines", json=machine_of(threshing_drum_example(1), "drum")).raise_for_status().json()
        api.put("/sources/can", json={"machine_id": machine["id"]}).raise_for_status()


def spool_of(folder: Path) -> Path:
    return folder / "service.can.spool.db"


def stored(folder: Path) -> list[int]:
    """Which readings the database has, in the order of their numbers."""
    query = "SELECT amplitude, phase_deg FROM reading ORDER BY sequence"
    with closing(sqlite3.connect(f"file:{folder / 'service.db'}?mode=ro", uri=True)) as database:
        return [identity(*row) for row in database.execute(query)]


def kept(folder: Path) -> list[int]:
    """Which readings wait in the spool of a service that is no more."""
    with closing(sqlite3.connect(spool_of(folder))) as database:
        bodies = [json.loads(body) for (body,) in database.execute("SELECT body FROM kept ORDER BY id")]
    return [identity(body["amplitude"], body["phase_deg"]) for body in bodies]


def wait_for_more(folder: Path) -> None:
    before, end = len(stored(folder)), time.monotonic() + 60.0
    while len(stored(folder)) <= before:
        assert time.monotonic() < end, "nothing is stored"
        time.sleep(0.02)


def wait_until_quiet(folder: Path) -> None:
    """Until nothing more has come for a second: a stopped balancer is stored to its end."""
    last, since, end = -1, time.monotonic(), time.monotonic() + 60.0
    while time.monotonic() - since < 1.0:
        assert time.monotonic() < end, "it never ends"
        if (now := len(stored(folder))) != last:
            last, since = now, time.monotonic()
        time.sleep(0.05)


def gaps(found: list[int]) -> list[int]:
    """How many readings are missing between each and the next, where any are."""
    return [after - before - 1 for before, after in pairwise(found) if after != before + 1]


def told_lost(lines: list[str]) -> list[int]:
    """Frames that the last service said were lost, and those of them while nothing read the bus."""
    told = re.findall(r"frames lost (\d+) \(about (\d+) while nothing read the bus\)", "\n".join(lines))
    return [int(one) for one in told[-1]] if told else []


if __name__ == "__main__":
    main()
