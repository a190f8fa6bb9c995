"""A spool that fills a small disk of its own, which a mount namespace gives it: run inside as a module."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections import deque
from contextlib import suppress
from functools import cache
from itertools import islice
from pathlib import Path

from drivers.bridge.spool import Spool
from drivers.errors import SpoolFull
from drivers.reading import Counter, Mark, Reading
from tests.support.drivers.frames import START, readings

MARK = Mark("can", 7, (Counter("Sensor1", 9, START, 0.01),))
MOUNT = 'mount -t tmpfs -o size=700k none "$0"'


@cache
def no_small_disk() -> str | None:
    """Why no disk of 700 kB can be made here; None where it can."""
    if shutil.which("unshare") is None:
        return "no disk of its own: the program unshare is needed"
    tried = subprocess.run(["unshare", "-rm", "sh", "-c", MOUNT, "/mnt"], capture_output=True, text=True, check=False)
    return None if tried.returncode == 0 else f"no disk of its own can be mounted here: {tried.stderr.strip()}"


def run_on_small_disk(folder: Path) -> str:
    """What the module prints when the folder is a disk of 700 kB."""
    inside = [str(folder), sys.executable, "-m", "tests.support.drivers.full_disk", str(folder)]
    done = subprocess.run(
        ["unshare", "-rm", "sh", "-c", f'{MOUNT} && exec "$@"', *inside],
        capture_output=True,
        text=True,
        timeout=60.0,
        check=True,
    )
    return done.stdout


def main(folder: Path) -> None:
    """Fill it, open it again while it is full, then take all out and fill it again and again; print what came of it."""
    path, some, delivered = folder / "spool.db", deque(readings(50_000)), list[int]()
    with Spool(path) as spool:
        spool.put([MARK])
        kept = [fill(spool, some)]
    with Spool(path) as spool:
        kept.append(spool.waiting())
        for most in (100, 7, 1000, 300, 50, 2_000):
            for at_once in (most, most, 10_000):  # some, and more put meanwhile; then all
                batch = spool.first(at_once)
                delivered += [one.sequence for one in batch]
                spool.done(batch)
                kept.append(fill(spool, some))
        highest, mark = spool.highest("can"), spool.mark("can") == MARK
    sys.stdout.write(json.dumps({"kept": kept, "delivered": delivered, "highest": highest, "mark": mark}))


def fill(spool: Spool, some: deque[Reading]) -> int:
    """Put readings, in ever smaller batches, until not one finds a place; how many did."""
    count = 0
    for size in (400, 20, 1):
        with suppress(SpoolFull):
            while True:
                count += spool.put(list(islice(some, size)))
                for _ in range(size):
                    some.popleft()
    return count


if __name__ == "__main__":
    main(Path(sys.argv[1]))
