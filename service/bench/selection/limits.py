"""What the selection may use: memory, and the time from a stop to the answer."""

from __future__ import annotations

import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from service.balancing.selection.certified import search_certified
from service.balancing.selection.exact.search import search_exact
from service.bench.selection.ours import request_of
from service.bench.selection.problems import Case, cases
from service.engine.plan_methods import run_method

DEADLINES_S = (0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6)
PLAN_S = 10.0
"""Default time limit of a plan."""


def peak_mb(name: str, limit_s: float = PLAN_S) -> float:
    """Peak resident memory, MB, of a process of its own that searches for a proof until the limit."""
    done = subprocess.run(  # noqa: S603 - this interpreter, this module
        [sys.executable, "-m", "service.bench.selection.limits", name, str(limit_s)],
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout)


@dataclass(frozen=True)
class Step:
    """One step of a search: its number, and how long it took, s, by the wall and of the processor."""

    number: int
    seconds: float
    processor_s: float


def longest_step(case: Case, limit_s: float = PLAN_S) -> Step:
    """Longest step between two moments at which a search can be stopped.

    The exact search alone, then modified Jaya with the exact search after it; no stop can take longer to be honoured.
    """
    worst = Step(0, 0.0, 0.0)
    for search in (search_exact(case.problem), search_certified(case.problem, 1)):
        begun = before = time.perf_counter()
        used = time.thread_time()
        for number, _ in enumerate(search):
            now, now_used = time.perf_counter(), time.thread_time()
            if now - before > worst.seconds:
                worst = Step(number, now - before, now_used - used)
            if now - begun > limit_s:
                break
            before, used = now, now_used
    return worst


def longest_overrun(case: Case) -> float:
    """Longest time, s, that a plan takes beyond its time limit."""
    worst = 0.0
    for limit_s in DEADLINES_S:
        solved = run_method(case.problem, request_of("exact", limit_s), 0.0, time.perf_counter)
        worst = max(worst, solved.seconds - limit_s)
    return worst


def _own_peak_mb() -> float:
    """Peak of this process: by the kernel's own mark, for ru_maxrss may be that of the process that started it."""
    status = Path("/proc/self/status")
    if status.exists():
        lines = status.read_text(encoding="ascii", errors="replace").splitlines()
        marks = [line.split()[1] for line in lines if line.startswith("VmHWM:")]
        if marks:
            return int(marks[0]) / 1024.0
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / (2**20 if sys.platform == "darwin" else 1024.0)


def _main(name: str, limit_s: str) -> None:
    case = next(case for case in cases() if case.name == name)
    run_method(case.problem, request_of("certified", float(limit_s)), 0.0, time.perf_counter)
    print(_own_peak_mb())


if __name__ == "__main__":
    _main(*sys.argv[1:])
