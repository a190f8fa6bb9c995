"""The service under the bench of the bus: a process of its own, its source bound to a machine."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import httpx2

from service.bench.can.frames import SENSORS

MACHINE = {
    "name": "bench",
    "service_speed_rpm": 460.0,
    "planes": [{"name": "1", "radius_mm": 330.0, "positions_deg": [0.0, 90.0, 180.0, 270.0], "max_masses": 3}],
    "sensors": [{"name": name} for name in SENSORS],
}


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
