"""Times of short calls, and the machine they were taken on."""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable, Sequence

from rich.console import Console
from rich.table import Table

Timed = tuple[float, float]


def timed(call: Callable[[], object], *, repeats: int = 200, warm_up: int = 5) -> Timed:
    """Median and 95th percentile of one call, s."""
    for _ in range(warm_up):
        call()
    taken = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        taken.append(time.perf_counter() - start)
    return statistics.median(taken), sorted(taken)[int(0.95 * (repeats - 1))]


def timed_quietly(call: Callable[[], object], *, batches: int = 12) -> Timed:
    """Median and 95th percentile of one call, s, in the quietest of some batches: what else runs there is not ours."""
    return min(timed(call, repeats=60) for _ in range(batches))


def machine_line() -> str:
    """The machine and its load: figures mean nothing without them."""
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    return f"Python {platform.python_version()}, {os.cpu_count()} cores, load {load:.2f}"


def show(
    console: Console, title: str, header: Sequence[str], lines: Sequence[Sequence[str]], *, markdown: bool
) -> None:
    """A table for the terminal, or in Markdown for docs/benchmarks.md."""
    if markdown:
        print(f"{title} ({machine_line()})\n")
        print("| " + " | ".join(header) + " |\n|" + "---|" * len(header))
        for line in lines:
            print("| " + " | ".join(line) + " |")
        print()
        return
    table = Table(*header, title=f"{title} ({machine_line()})")
    for line in lines:
        table.add_row(*line)
    console.print(table)
