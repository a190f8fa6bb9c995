"""`drumtrue bench fit`: fit, correction and all diagnostics beside numpy's bare least squares as the limit.

Times of the quietest of twelve batches of 60 calls, ours and the limit alike.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from rich.console import Console

from service.balancing.influence.analysis import Method, analyse
from service.balancing.influence.corrections import CorrectionOptions, minimax
from service.balancing.influence.diagnosis.findings import RunConditions
from service.balancing.influence.fit import RunSet, fit_influence
from service.bench.timing import show, timed_quietly

CASES = (("fit + correction + diagnostics", 2, 2, 0.5), ("fit + correction + diagnostics", 4, 8, 1.0))
"""What, planes, sensors, aim in ms."""


def bench_fit(*, markdown: bool = False) -> bool:
    """Print the table; True where every aim is met."""
    rng = np.random.default_rng(1)
    lines, met = [], True
    for what, planes, sensors, aim in CASES:
        runs = example_runs(rng, planes, sensors)
        known = RunConditions(
            speed_rpm=np.broadcast_to(460.0 * rng.normal(1.0, 0.005, (len(runs.masses), 1)), runs.vibration.shape),
            nominal_rpm=np.full(sensors, 460.0),
            overall=1.1 * np.abs(runs.vibration),
            check=np.zeros(len(runs.masses), dtype=bool),
        )
        lines.append(_line(f"{what}, {planes} x {sensors}", _analysis(runs, known), _bare(runs), aim))
        met &= lines[-1][-1] == "met"
    runs = example_runs(rng, 4, 11)
    fit = fit_influence(runs)
    lines.append(_line("minimax with certificate, 4 x 11", lambda: minimax(fit), _bare(runs), 10.0))
    met &= lines[-1][-1] == "met"
    header = ("what, planes x sensors", "median ms", "p95 ms", "bare lstsq ms", "ratio", "aim ms", "")
    show(Console(), "bench fit", header, lines, markdown=markdown)
    return met


def example_runs(rng: np.random.Generator, planes: int, sensors: int) -> RunSet:
    """As found, a trial run in each plane and a check run, 2 % scatter."""
    A = rng.normal(size=(sensors, planes)) + 1j * rng.normal(size=(sensors, planes))
    v0 = 100.0 * (rng.normal(size=sensors) + 1j * rng.normal(size=sensors))
    masses = np.concatenate([np.zeros((1, planes)), 100.0 * np.eye(planes), 30.0 * np.ones((1, planes))]).astype(
        complex
    )
    clean = v0 + masses @ A.T
    scatter = 0.02 * np.abs(clean)
    noise = rng.normal(size=clean.shape) + 1j * rng.normal(size=clean.shape)
    return RunSet(masses, clean + scatter * noise, scatter)


def _analysis(runs: RunSet, known: RunConditions, method: Method = "least_squares") -> Callable[[], object]:
    return lambda: analyse(runs, CorrectionOptions(), method, known)


def _bare(runs: RunSet) -> Callable[[], object]:
    """numpy.linalg.lstsq twice: the runs for the coefficients, the coefficients for the masses. Nothing else."""
    design = np.concatenate([np.ones((len(runs.masses), 1)), runs.masses], axis=1)

    def call() -> object:
        solved = np.linalg.lstsq(design, runs.vibration, rcond=None)[0]
        return np.linalg.lstsq(solved[1:].T, -solved[0], rcond=None)[0]

    return call


def _line(what: str, ours: Callable[[], object], bare: Callable[[], object], aim_ms: float) -> tuple[str, ...]:
    median, p95 = timed_quietly(ours)
    limit, _ = timed_quietly(bare)
    return (
        what,
        f"{1e3 * median:.3f}",
        f"{1e3 * p95:.3f}",
        f"{1e3 * limit:.3f}",
        f"{median / limit:.1f}",
        f"{aim_ms:g}",
        "met" if 1e3 * median < aim_ms else "missed",
    )
