"""A network of a test's own, in which CAN frames travel by multicast and nothing leaves the machine."""

from __future__ import annotations

import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

PREPARE = "ip link set lo up && ip route add 224.0.0.0/4 dev lo"
ROOT = Path(__file__).parents[3]


@cache
def no_namespace() -> str | None:
    """Why no network namespace can be made here; None where it can."""
    if shutil.which("unshare") is None or shutil.which("ip") is None:
        return "no network namespace: the programs unshare and ip are needed"
    tried = subprocess.run(["unshare", "-rn", "sh", "-c", PREPARE], capture_output=True, text=True, check=False)
    return None if tried.returncode == 0 else f"no network namespace can be made here: {tried.stderr.strip()}"


def run_inside(module: str, *arguments: str, timeout_s: float) -> subprocess.CompletedProcess[str]:
    """Run a module of the tests inside a new namespace; all that it started ends with it."""
    command = f'{PREPARE} && exec "$@"'
    return subprocess.run(
        # A process namespace too: when its first process ends, so do all the others.
        ["unshare", "-rnpf", "--kill-child", "sh", "-c", command, "sh", sys.executable, "-m", module, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=timeout_s,
        check=False,
    )
