"""`serve --can` over a real bus between processes: udp_multicast in a network namespace of its own.

Run inside the namespace as a module; `over_wire` makes one and reads what comes of it.
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from dataclasses import asdict
from pathlib import Path

from can.interfaces.udp_multicast.utils import pack_message

from drivers.can.bus import DEFAULTS
from service.bench.can.frames import Measured, prepared_frames
from service.bench.can.service import bind, served

PREPARE = "ip link set lo up && ip route add 224.0.0.0/4 dev lo"
PORT = 43113
"""Of python-can's udp_multicast."""
AT_ONCE = 8
QUIET_S = 15.0
"""Nothing more comes once nothing has for so long."""


def over_wire(rate: int, seconds: float) -> Measured | str:
    """Frames at a rate from a sender to `serve --can`, each a process; why not, where no namespace can be made."""
    if shutil.which("unshare") is None or shutil.which("ip") is None:
        return "not measured: the programs unshare and ip are needed for a network namespace"
    inside = [sys.executable, "-m", "service.bench.can.wire", str(rate), str(seconds)]
    # Where this is root already, no user namespace: in one, the reader could not go before the others.
    kind = "-n" if os.geteuid() == 0 else "-rn"
    command = ["unshare", kind, "sh", "-c", f'{PREPARE} && exec "$@"', "sh", *inside]
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or ["it failed"])[-1]
        return f"not measured: {reason}"
    return Measured(**json.loads(done.stdout.splitlines()[-1]))


def measure(rate: int, seconds: float) -> Measured:
    """Inside the namespace: what was sent and stored, and the CPU seconds of the service with its reader."""
    with tempfile.TemporaryDirectory() as folder:
        database = Path(folder) / "bench.db"
        with served(database, "--can", "udp_multicast", "--source", "can") as service:
            bind(service.url)
            before = _cpu_s(service.pid)
            sender = subprocess.Popen(  # noqa: S603
                [sys.executable, "-m", "service.bench.can.wire", "send", str(rate), str(seconds)],
                stdout=subprocess.PIPE,
                text=True,
            )
            said, _ = sender.communicate()
            sent, begun = json.loads(said)
            until, cpu_s = _quiet(database, sent), _cpu_s(service.pid) - before
        return Measured(sent, _count(database), until - begun, cpu_s)


def send(rate: int, seconds: float) -> None:
    """Send prepared frames at a rate; print how many, and when the first went (monotonic clock, s).

    They are packed before, and sent past python-can: a balancer's controller takes nothing of this machine's cores.
    """
    packed = [pack_message(frame) for frame in prepared_frames()]
    group = (str(DEFAULTS["udp_multicast"]["channel"]), PORT)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        begun, count = time.monotonic(), int(rate * seconds)
        for number in range(0, count, AT_ONCE):
            early = begun + number / rate - time.monotonic()
            if early > 0.0:
                time.sleep(early)
            for frame in range(number, min(number + AT_ONCE, count)):
                out.sendto(packed[frame % len(packed)], group)
    print(json.dumps([count, begun]))


def _quiet(database: Path, sent: int) -> float:
    """When the last was stored, once all are or no more come."""
    last, since = -1, time.monotonic()
    while last < sent and time.monotonic() - since < QUIET_S:
        if (now := _count(database)) != last:
            last, since = now, time.monotonic()
        time.sleep(0.1)
    return since


def _count(database: Path) -> int:
    with closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True)) as connection:
        (count,) = connection.execute("SELECT count(DISTINCT sequence) FROM reading").fetchone()
    return int(count)


def _cpu_s(service: int) -> float:
    """CPU seconds, so far, of the service and of the reader that it started."""
    ticks = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it has ended
        if service in (int(stat.parent.name), int(fields[1])):
            ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def main() -> None:
    """Measure inside the namespace, or send."""
    if sys.argv[1] == "send":
        send(int(sys.argv[2]), float(sys.argv[3]))
    else:
        print(json.dumps(asdict(measure(int(sys.argv[1]), float(sys.argv[2])))))


if __name__ == "__main__":
    main()
