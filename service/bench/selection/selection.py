"""`drumtrue bench selection`: time to proof, quality and success rate, ours and named peers' in one run."""

from __future__ import annotations

import statistics
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field

from rich.console import Console

from service.bench.selection.limits import longest_overrun, longest_step, peak_mb
from service.bench.selection.ours import Answer, Runs, answer_of, budget_of, jaya_runs, proved
from service.bench.selection.peer import Found, Peer
from service.bench.selection.peers import peers, rated
from service.bench.selection.problems import Case, cases
from service.bench.selection.startup import first_plan
from service.bench.timing import show

STOP_AIM_MS, MEMORY_AIM_MB, FIRST_PLAN_AIM_S = 100.0, 500.0, 0.5
REFERENCE_S = 20.0
"""Time of the exact search for the value that all others are compared with."""


@dataclass
class Bench:
    """How the measurement is run. budget_s: of each peer and problem; runs: of the published budgets."""

    markdown: bool = False
    quick: bool = False
    budget_s: float = 5.0
    seeds: int = 5
    runs: int = 20
    console: Console = field(default_factory=lambda: Console(width=None if sys.stdout.isatty() else 240))
    missed: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        if self.quick:
            self.budget_s, self.seeds, self.runs = min(self.budget_s, 0.6), min(self.seeds, 2), min(self.runs, 2)

    @property
    def cases(self) -> list[Case]:
        """The problems of this run."""
        return [case for case in cases() if case.small or not self.quick]

    def show(self, title: str, header: tuple[str, ...], lines: Sequence[tuple[str, ...]]) -> None:
        """Print one table."""
        show(self.console, title, header, lines, markdown=self.markdown)

    def say(self, what: str) -> None:
        """Tell how far it is, apart from the tables."""
        print(what, file=sys.stderr, flush=True)

    def judge(self, what: str, value: float, aim: float) -> str:
        """Compare with an aim, and keep what misses it."""
        if value < aim:
            return "met"
        self.missed.append(what)
        return "missed"


def bench_selection(bench: Bench, *, as_published: bool = False) -> bool:
    """Print all tables; True where every aim is met."""
    if as_published:
        published(bench)
        return not bench.missed
    ours(bench)
    if not bench.quick:
        limits(bench)
    beside_peers(bench)
    abilities(bench)
    return not bench.missed


def ours(bench: Bench) -> None:
    """Time to an answer with its proof or bound, as a plan gets it."""
    lines = []
    for case in bench.cases:
        bench.say(f"ours: {case.name}")
        exact, certified = (answer_of(case, method, 10.0) for method in ("exact", "certified"))
        lines.append(
            (
                case.name,
                f"{1e3 * case.aim_s:g}",
                f"{1e3 * exact.seconds:.1f}",
                bench.judge(f"exact, {case.name}", _needed(exact), case.aim_s),
                f"{1e3 * certified.seconds:.1f}",
                bench.judge(f"certified, {case.name}", _needed(certified), case.aim_s),
                certified.result.status,
                *_proof(certified, case),
            )
        )
    header = ("problem", "aim ms", "exact ms", "", "certified ms", "", "status", "value", "lower bound", "uncertainty")
    bench.show("bench selection: time to the answer of a plan", header, lines)


def _needed(answer: Answer) -> float:
    """Time of an answer that is as good as proved."""
    return answer.seconds if answer.result.status in ("optimal", "within_uncertainty") else float("inf")


def _proof(answer: Answer, case: Case) -> tuple[str, str, str]:
    bound = answer.result.lower_bound
    return f"{answer.result.value:.4g}", f"{bound:.4g}", f"{case.uncertainty:.3g}" if case.uncertainty else "-"


def limits(bench: Bench) -> None:
    """Memory, stops, and the first plan after start-up."""
    lines = []
    for case in [case for case in bench.cases if case.hard]:
        bench.say(f"memory and stops: {case.name}")
        peak = peak_mb(case.name)
        judged = bench.judge(f"peak memory, {case.name}", peak, MEMORY_AIM_MB)
        lines.append((f"peak memory, {case.name}", f"{peak:.0f} MB", f"{MEMORY_AIM_MB:g} MB", judged))
        step = longest_step(case)
        judged = bench.judge(f"longest step, {case.name}", 1e3 * step.seconds, STOP_AIM_MS)
        seen = f"{1e3 * step.seconds:.0f} ms, {1e3 * step.processor_s:.0f} ms of it computing"
        lines.append((f"longest step (number {step.number}), {case.name}", seen, f"{STOP_AIM_MS:g} ms", judged))
        late = 1e3 * longest_overrun(case)
        judged = bench.judge(f"past its time limit, {case.name}", late, STOP_AIM_MS)
        lines.append((f"longest past its time limit, {case.name}", f"{late:.0f} ms", f"{STOP_AIM_MS:g} ms", judged))
    bench.say("first plan")
    taken = [first_plan() for _ in range(3)]
    first, second = (statistics.median(times) for times in zip(*taken, strict=True))
    judged = bench.judge("first plan", first, FIRST_PLAN_AIM_S)
    lines.append(("first plan after start-up", f"{first:.3f} s", f"{FIRST_PLAN_AIM_S:g} s", judged))
    lines.append(("second plan", f"{second:.3f} s", "-", ""))
    bench.show("bench selection: limits", ("what", "seen", "aim", ""), lines)


def beside_peers(bench: Bench) -> None:
    """Each method's value over the proved optimum, in the same run on the same problems."""
    there = peers()
    header = ("problem", "optimum", "ours: exact", "ours: modified Jaya", *(peer.label for peer in there))
    lines = []
    for case in bench.cases:
        bench.say(f"beside peers: {case.name}")
        state, seconds = proved(case, REFERENCE_S)
        best = state.value
        jaya = jaya_runs(case, bench.seeds, as_published=False, limit_s=bench.budget_s)
        took = f"proved, {_time(seconds)}" if state.proved else f"best known, {_time(seconds)}"
        row = [case.name, f"{best:.5g}", took, _searched(jaya, best)]
        lines.append((*row, *(compared(bench, peer, case, best) for peer in there)))
    bench.show(
        f"bench selection: value over the optimum, {bench.budget_s:g} s for each peer and problem, "
        f"searchers {bench.seeds} seeds sharing it",
        header,
        lines,
    )


def compared(bench: Bench, peer: Peer, case: Case, best: float) -> str:
    """One peer on one problem, as text; a peer that cannot is told with its reason, never left out."""
    if not peer.installed:
        return "not installed"
    if why := peer.cannot(case.problem):
        return f"cannot: {why}"
    if peer.proves:
        found = peer.solve(case.problem, 1, bench.budget_s)
        return _proving(case, found, best)
    return _searched(searched(peer, case, bench.seeds, bench.budget_s / bench.seeds), best)


def searched(peer: Peer, case: Case, seeds: int, budget_s: float) -> Runs:
    """Runs of a searcher, one a seed."""
    found = [peer.solve(case.problem, seed, budget_s) for seed in range(1, seeds + 1)]
    values = [rated(case.problem, run) for run in found]
    allowed = tuple(float("inf") if broken else value for value, broken in values)
    return Runs(allowed, statistics.median(run.seconds for run in found), sum(b is not None for _, b in values))


def _proving(case: Case, found: Found, best: float) -> str:
    value, broken = rated(case.problem, found)
    if found.selection is None:
        return f"nothing, {_time(found.seconds)}" + (f": {found.trouble}" if found.trouble else "")
    if broken:
        return f"{_over(value, best)} but not allowed: {broken}"
    if found.ended and found.lower_bound >= value * (1.0 - 1e-5):
        return f"{_over(value, best)}, proved, {_time(found.seconds)}"
    return f"{_over(value, best)}, bound {found.lower_bound / best:.0%}, {_time(found.seconds)}"


def _searched(runs: Runs, best: float) -> str:
    median = "none allowed" if runs.median == float("inf") else f"median {_over(runs.median, best)}"
    return f"{runs.reached(best)}/{len(runs.values)}, {median}, {_time(runs.seconds)}"


def _over(value: float, best: float) -> str:
    return f"x {value / best:.3f}" if value < 10.0 * best else f"x {value / best:.3g}"


def _time(seconds: float) -> str:
    return f"{1e3 * seconds:.0f} ms" if seconds < 0.9995 else f"{seconds:.1f} s"


def abilities(bench: Bench) -> None:
    """What each method can and cannot express."""
    lines = [
        ("ours: exact", "yes", "yes", "pieces and grams", "all", "yes, and a bound at any time"),
        ("ours: modified Jaya", "yes", "yes", "pieces and grams", "all", "no"),
    ]
    lines += [
        (peer.name, a.joint, a.stock, a.capacity, a.norms, a.proof) for peer in peers() for a in (peer.abilities,)
    ]
    header = ("method", "joint planes", "stock counts", "capacity", "norms", "proof")
    bench.show("bench selection: what each can express", header, lines)


def published(bench: Bench) -> None:
    """Modified Jaya as published at its published budgets: how often it finds the optimum."""
    lines = []
    for case in [
        case for case in bench.cases if " a plane" in case.name and not case.hard and "match" not in case.name
    ]:
        best = proved(case, REFERENCE_S)[0].value
        bench.say(f"as published: {case.name}, {bench.runs} runs of {budget_of(case, as_published=True)}")
        runs = jaya_runs(case, bench.runs, as_published=True, limit_s=float("inf"))
        best_run = min(runs.values)
        cells = (f"{runs.reached(best)}/{len(runs.values)}", f"{best:.4g}", f"{best_run:.4g}", f"{runs.median:.4g}")
        lines.append((case.name, budget_of(case, as_published=True), *cells, _time(runs.seconds)))
        bench.say(f"  {cells[0]} at the optimum, {_time(runs.seconds)} a run")
    header = ("problem", "population x generations", "at the optimum", "optimum", "best", "median", "a run")
    bench.show("bench selection: modified Jaya as published", header, lines)
