"""`drumtrue bench designs`: every published system, its designs evaluated again, our optimum and what proves it.

Speed of the linkage engine and of the six-bar's front; with `searches`, success rates of the published searches.
"""

from __future__ import annotations

import time

import numpy as np
from rich.console import Console

from service.bench.timing import show
from service.design.documents import patched, preset, presets
from service.design.linkage.case import read_case
from service.design.optimising import front, optimise
from service.design.registry import study_of
from service.design.verdict import PublishedVerdict, Verdict, verdict
from service.mechanics.gears import CUTS
from service.optimize.differential_evolution import VARIANTS, DifferentialEvolution
from service.optimize.differential_search import DifferentialSearch
from service.optimize.search import Evidence

EVALUATIONS = 200_000
EVALUATIONS_AIM = 300_000.0
FRONT_POINTS, FRONT_AIM, FRONT_LIMIT, FRONT_SECONDS = 150, 0.461, 0.466, 10.0
AGREED = 1e-6
RUNS = 20
GEAR_GENERATIONS = (50, 200)
SHAFT_GENERATIONS = 500


def bench_designs(*, markdown: bool = False, seeds: int = 3, searches: bool = False) -> bool:
    """Print the tables; True where every aim is met."""
    console = Console(width=160)
    header = ("system", "design", "published", "computed", "breaks", "objective", "optimum", "evidence")
    lines, met = [], True
    for name in presets():
        if name != "gear_pair_printed":
            lines += _rows(name, verdict(preset(name)))
    show(console, "published designs", header, lines, markdown=markdown)
    met &= _agreement(console, seeds, markdown=markdown)
    met &= _speed(console, markdown=markdown)
    if searches:
        _gear_searches(console, markdown=markdown)
        _shaft_searches(console, markdown=markdown)
    return met


def _rows(name: str, found: Verdict) -> list[tuple[str, ...]]:
    return [_row(name, one) for one in found.designs]


def _row(name: str, one: PublishedVerdict) -> tuple[str, ...]:
    claims = [f"{claim.response} {claim.claimed:.6g}" for claim in one.claims]
    computed = [f"{claim.computed:.6g} ({100.0 * claim.deviation:+.2f} %)" for claim in one.claims]
    broken = [limit.code + (f" ({limit.where})" if limit.where else "") for limit in one.broken]
    return (
        name,
        one.name,
        ", ".join(claims) or "-",
        ", ".join(computed) or "-",
        ", ".join(broken) or "nothing",
        f"{one.objective:.7g}",
        f"{one.optimum.value:.9g}",
        _evidence(one.optimum.evidence),
    )


def _evidence(evidence: Evidence) -> str:
    if evidence.kind == "proved_bound":
        return f"proved, bound {evidence.bound:.9g}"
    if evidence.kind == "kkt":
        return f"optimality to {evidence.residual:.0e}, {evidence.agreeing} of {evidence.starts} starts"
    return "exact roots" if evidence.starts is None else f"{evidence.agreeing} of {evidence.starts} starts"


def _agreement(console: Console, seeds: int, *, markdown: bool) -> bool:
    """Whether the default method ends in the same optimum from every seed."""
    lines, met = [], True
    for name in presets():
        values, seconds = [], time.process_time()
        for seed in range(1, seeds + 1):
            found = optimise(preset(name), seed=seed)
            met &= found.result.feasible
            values.append(found.value)
        seconds = (time.process_time() - seconds) / seeds
        spread = (max(values) - min(values)) / max(abs(max(values)), 1e-300)
        met &= spread <= AGREED
        lines.append((name, found.method, f"{values[0]:.9g}", f"{spread:.1e}", f"{seconds:.2f}"))
    header = ("system", "method", "optimum", f"spread over {seeds} seeds", "CPU s a run")
    show(console, "default methods", header, lines, markdown=markdown)
    return met


def _speed(console: Console, *, markdown: bool) -> bool:
    case, _ = read_case(preset("sixbar"))
    if case is None or case.design is None:
        return False
    rng = np.random.default_rng(1)
    variables = case.design.variation.variables
    x = rng.uniform([one.lower for one in variables], [one.upper for one in variables], (EVALUATIONS, len(variables)))
    began = time.process_time()
    for part in np.array_split(x, 50):
        p = case.design.variation.numbers(part)
        case.features.mean_square("force", p)
        case.features.mean_square("moment", p)
    rate = EVALUATIONS / (time.process_time() - began)
    began = time.process_time()
    found = front(preset("sixbar"), FRONT_POINTS, ceiling=1.0)
    seconds, volume = time.process_time() - began, found.volume((1.0, 1.0))
    lines = [
        ("force and moment of a six-bar, designs/s", f"{rate:,.0f}", f"{EVALUATIONS_AIM:,.0f}"),
        (f"six-bar front, {FRONT_POINTS} points: hypervolume", f"{volume:.5f}", f"{FRONT_AIM} to {FRONT_LIMIT}"),
        ("six-bar front: CPU s", f"{seconds:.2f}", f"{FRONT_SECONDS}"),
    ]
    show(console, "speed", ("what", "measured", "aim"), lines, markdown=markdown)
    return rate >= EVALUATIONS_AIM and FRONT_AIM <= volume <= FRONT_LIMIT and seconds <= FRONT_SECONDS


def _gear_searches(console: Console, *, markdown: bool) -> None:
    """Runs within 0.1 % of the best, of the printed gear model with at most 23 teeth."""
    lines = []
    for generations in GEAR_GENERATIONS:
        for variant in VARIANTS:
            counts = []
            for cut in CUTS[:6]:
                document = patched(
                    preset("gear_pair_printed"), {"gear": {"cut": cut}, "design": {"teeth_bounds": [17, 23]}}
                )
                problem = study_of(document).problem(document)
                best = problem.exact() if problem.exact else None
                if problem.mixed is None or best is None:
                    continue
                count = 0
                for seed in range(RUNS):
                    search = DifferentialEvolution(problem.mixed, 30, np.random.default_rng(seed), variant)
                    for _ in range(generations):
                        state = next(search)
                    count += state.value <= 1.001 * best[1]
                counts.append(f"{count}")
            lines.append((str(generations), variant, *counts))
    header = ("generations", "variant", *(f"type {k}" for k in range(1, 7)))
    show(
        console,
        f"differential evolution on the printed gear model, successes of {RUNS}",
        header,
        lines,
        markdown=markdown,
    )


def _shaft_searches(console: Console, *, markdown: bool) -> None:
    lines = []
    for name in ("shaft_set_utopia", "shaft_set_conflict"):
        document = preset(name)
        problem = study_of(document).problem(document)
        if problem.mixed is None:
            continue
        values = []
        for seed in range(RUNS):
            search = DifferentialSearch(problem.mixed, 60, np.random.default_rng(seed))
            for _ in range(SHAFT_GENERATIONS):
                state = next(search)
            values.append(-state.value)
        best = optimise(document).value
        lines.append((name, f"{max(values):.6f}", f"{np.median(values):.6f}", f"{best:.8f}"))
    header = ("case", "best", "median", "default method")
    title = f"Differential Search, {SHAFT_GENERATIONS} generations of 60, {RUNS} runs: H"
    show(console, title, header, lines, markdown=markdown)
