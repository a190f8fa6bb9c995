"""`drumtrue bench trust`: the share of stated intervals that hold the truth, by rotor and by kind of error."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console

from service.bench.timing import show
from service.bench.trust.cases import CASES
from service.bench.trust.coverage import ERROR_SETS, WHAT, coverage

ALLOWED = {"stated": (0.93, 0.97), "default": (0.93, 1.0), "severe": (0.90, 0.98)}
"""Least and greatest share that holds: with the errors stated, with the usual ones alone, in the severe mixture."""
DOUBT = 2.0
"""Standard deviations by which chance may carry a share beyond these."""


def bench_trust(sessions: int, rotors: Iterable[str], *, markdown: bool = False) -> bool:
    """Print the table; True where every share is within what is allowed, but for chance."""
    lines, met = [], True
    for rotor in rotors:
        for name in ERROR_SETS:
            found = coverage(CASES[rotor], name, sessions)
            low, high = allowed(name)
            cells = []
            for share, count in found.values():
                doubt = DOUBT * (0.05 * 0.95 / max(count, 1)) ** 0.5
                good = low - doubt <= share <= high + doubt
                met &= good
                cells.append(f"{100.0 * share:.1f}" + ("" if good else " !"))
            lines.append((f"{rotor}: {CASES[rotor].what}", name, *cells, f"{100 * low:.0f}-{100 * high:.0f}"))
    header = ("rotor", "errors", *(f"{what}, %" for what in WHAT), "allowed")
    show(Console(), "bench trust", header, lines, markdown=markdown)
    return met


def allowed(name: str) -> tuple[float, float]:
    """What share may hold, for a set of errors."""
    if name.startswith("severe"):
        return ALLOWED["severe"]
    return ALLOWED["default" if name.endswith("default") else "stated"]
