"""`drumtrue bench frontier`: what is proved within a processor time, as a problem grows in one direction.

The case that grows is the default of the field: two planes of 18 holes, a box of six masses with eight of each, two
sensors, four masses a plane, the sum of the amplitudes over their limits.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from rich.console import Console

from service.balancing.rotor.phasors import ComplexArray
from service.balancing.selection import compiled
from service.balancing.selection.exact.search import ExactState, last_state, search_exact
from service.balancing.selection.problem import Objective, SelectionPlane, SelectionProblem, Stock
from service.bench.selection.peer import Found, Peer
from service.bench.selection.peers import peers, rated
from service.bench.timing import show

SMALL, LARGE = 5.0, 300.0
"""Least and greatest mass of a box, g."""


@dataclass(frozen=True)
class Size:
    """A problem by its numbers: planes, holes and masses a plane, kinds in the box, sensors (rows)."""

    grows: str
    pieces: int = 4
    holes: int = 18
    kinds: int = 6
    planes: int = 2
    rows: int = 2

    @property
    def name(self) -> str:
        """What grows and how far, and the rest where it is not the usual."""
        return f"{self.planes} x {self.holes} holes, {self.kinds} kinds, {self.pieces} a plane, {self.rows} sensors"


@dataclass(frozen=True)
class Reached:
    """An answer within a processor time: value, bound, whether it is proved, and the time taken, s."""

    value: float
    bound: float
    proved: bool
    seconds: float

    def __str__(self) -> str:
        if self.proved:
            return f"proved {self.value:.3g}, {self.seconds:.2f} s"
        return f"{self.value:.3g} >= {self.bound:.3g}"


def sizes(*, quick: bool) -> Iterator[Size]:
    """Masses, holes, kinds, planes and sensors, each growing alone."""
    yield from (Size("masses", pieces=n) for n in ((2, 4, 6) if quick else range(1, 11)))
    yield from (Size("masses", pieces=n, holes=24, kinds=12) for n in ((4,) if quick else range(4, 9)))
    yield from (Size("holes", holes=h) for h in ((36,) if quick else (12, 36, 72, 150, 300)))
    yield from (Size("kinds", kinds=k) for k in ((24,) if quick else (12, 24, 48, 100, 200)))
    yield from (Size("planes", planes=p, rows=p) for p in ((3,) if quick else (1, 3, 4, 5, 6)))
    yield from (Size("planes", planes=p, rows=2 * p) for p in ((2,) if quick else (1, 2, 3, 4, 5, 6)))
    yield from (Size("sensors", rows=s) for s in ((4,) if quick else (4, 8, 12, 24)))


def problem_of(size: Size, seed: int = 1) -> SelectionProblem:
    """The problem of a size: coefficients of 0.01 mm/s per g, corrections of about 200 g, limits of 0.7 mm/s."""
    rng = np.random.default_rng([seed, size.planes, size.rows])
    shape = (size.rows, size.planes)
    influence = np.asarray(0.01 * (rng.normal(size=shape) + 1j * rng.normal(size=shape)), dtype=np.complex128)
    target: ComplexArray = 200.0 * np.exp(2j * np.pi * rng.random(size.planes)) * (0.7 + 0.6 * rng.random(size.planes))
    objective = Objective(influence, -influence @ target, np.full(size.rows, 1.0 / 0.7), "sum")
    angles = 2.0 * np.pi * np.arange(1, size.holes + 1) / size.holes
    plane = SelectionPlane(angles, np.ones(size.holes, np.int64), np.full(size.holes, np.inf), size.pieces)
    masses = (10.0, 20.0, 50.0, 100.0, 200.0, 300.0) if size.kinds == 6 else np.linspace(SMALL, LARGE, size.kinds)
    each = 8 if size.kinds == 6 else 3
    box = Stock(np.array(masses), np.full(size.kinds, each, np.int64), np.zeros(size.kinds))
    return SelectionProblem(objective, (plane,) * size.planes, box)


def ours(problem: SelectionProblem, budget_s: float) -> Reached:
    """The exact search within `budget_s` of processor time."""
    begun = time.process_time()

    def over(state: ExactState) -> bool:
        return state.proved or time.process_time() - begun >= budget_s

    state = last_state(search_exact(problem), over, patient=True)
    return Reached(state.value, state.lower_bound, state.proved, time.process_time() - begun)


def bench_frontier(*, budget_s: float, quick: bool, markdown: bool, beside: bool) -> None:
    """Print a table; with `beside`, named peers that are installed too, in wall time of as many seconds."""
    compiling = time.process_time()
    fast = compiled.load()
    compiling = time.process_time() - compiling
    named = [peer for peer in peers() if peer.proves and peer.installed] if beside else []
    lines = []
    for size in sizes(quick=quick):
        problem = problem_of(size)
        answers = [_of_peer(peer, problem, budget_s) for peer in named]
        lines.append((size.grows, size.name, str(ours(problem, budget_s)), *answers))
    loops = f"compiled loops, {compiling:.1f} s to load" if fast else "numpy alone"
    title = f"Frontier: value, and proof or bound within {budget_s:g} s of processor time; {loops}"
    show(Console(), title, ("grows", "problem", "Drumtrue", *(peer.label for peer in named)), lines, markdown=markdown)


def _of_peer(peer: Peer, problem: SelectionProblem, budget_s: float) -> str:
    trouble = peer.cannot(problem)
    if trouble is not None:
        return trouble
    found: Found = peer.solve(problem, 1, budget_s)
    value, broken = rated(problem, found)
    if broken is not None:
        return f"breaks a limit: {broken}"
    if found.selection is None:
        return found.trouble or f"none >= {found.lower_bound:.3g}"
    return str(Reached(value, min(found.lower_bound, value), found.ended, found.seconds))
