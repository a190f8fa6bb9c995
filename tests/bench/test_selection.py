"""The benchmark of the selection: every method is rated on the same problem by the same judge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.brute_force import solve_exhaustive
from service.balancing.selection.exact.search import solve_exact
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import broken_limit, vectors_of
from service.balancing.selection.problem import Piece, SelectionProblem
from service.bench.selection.coding import Coded, excess
from service.bench.selection.hsbalance import HSBALANCE
from service.bench.selection.linear import POLYGON_GAP, cannot_state, linear
from service.bench.selection.ours import answer_of, jaya_runs
from service.bench.selection.peer import Found, Peer
from service.bench.selection.peers import peers, rated, solve_highs
from service.bench.selection.problems import Case, cases
from service.bench.selection.selection import Bench, abilities, beside_peers, compared, ours
from tests.support.numerics.random_problems import KINDS, random_problem

CLOSE = 1e-6
TINY = [case for case in cases() if case.name in ("match, 1 a plane", "drum, 1 a plane")]
INSTALLED = [peer for peer in peers() if peer.installed and peer is not HSBALANCE]


@pytest.mark.parametrize("kind", KINDS)
def test_the_linear_form_has_the_value_of_each_allowed_selection_and_refuses_the_others(kind: str) -> None:
    rng = np.random.default_rng(5)
    told = {True: 0, False: 0}
    for seed in range(20):
        problem = random_problem(kind, seed)
        if cannot_state(problem):
            assert kind == "rms"
            continue
        form = linear(problem)
        for _ in range(20):
            counts = (rng.random(len(form.most)) < 1.5 / len(form.most)).astype(np.int64)
            selection = form.selection(counts, len(problem.planes))
            allowed = bool((form.G @ counts <= form.h * (1.0 + 1e-9)).all() and (counts <= form.most).all())
            assert allowed == (broken_limit(problem, selection) is None)
            told[allowed] += 1
            value = float(evaluate(problem.objective, vectors_of(problem, selection)))
            gap = 0.0 if kind == "components" else POLYGON_GAP
            assert value * (1.0 - gap - 1e-9) - 1e-12 <= _cost(problem, counts) <= value * (1.0 + 1e-9) + 1e-12
    assert kind == "rms" or min(told.values()) > 0


def _cost(problem: SelectionProblem, counts: np.ndarray[tuple[int], np.dtype[np.int64]]) -> float:
    form = linear(problem)
    rows = form.C @ counts + form.d
    return float(sum(rows[form.of == t].max() for t in range(int(form.of.max()) + 1)))


@pytest.mark.parametrize("kind", ["components", "bearing_force", "sum", "max"])
def test_highs_brackets_the_optimum_of_brute_force(kind: str) -> None:
    for seed in range(3):
        problem = random_problem(kind, seed)
        optimum = solve_exhaustive(problem).value
        found = solve_highs(problem, 1, 20.0)
        assert found.ended
        value, broken = rated(problem, found)
        assert broken is None
        assert value >= optimum * (1.0 - CLOSE)
        assert found.lower_bound <= optimum * (1.0 + CLOSE) + CLOSE
        if kind == "components":
            assert value == pytest.approx(optimum, rel=CLOSE, abs=CLOSE)


@pytest.mark.parametrize("kind", KINDS)
def test_the_coded_form_counts_what_is_broken(kind: str) -> None:
    rng = np.random.default_rng(6)
    for seed in range(20):
        problem = random_problem(kind, seed)
        coded = Coded.of(problem)
        optimum = solve_exhaustive(problem).value
        for _ in range(20):
            x = rng.integers(0, coded.highest + 1).astype(float).tolist()
            selection = coded.selection(x)
            assert (excess(problem, selection) > 0.0) == (broken_limit(problem, selection) is not None)
            assert coded.penalised(x) >= optimum * (1.0 - CLOSE)


@pytest.mark.parametrize("peer", INSTALLED, ids=lambda peer: peer.package)
@pytest.mark.parametrize("case", TINY, ids=lambda case: case.name)
def test_no_method_beats_the_proved_optimum(peer: Peer, case: Case) -> None:
    optimum = solve_exact(case.problem).value
    found = peer.solve(case.problem, 1, 0.3)
    value, broken = rated(case.problem, found)
    assert value >= optimum * (1.0 - CLOSE)
    assert found.lower_bound <= optimum * (1.0 + CLOSE)
    if found.selection is not None and peer.proves:
        assert broken is None


@pytest.mark.parametrize("as_published", [False, True])
def test_modified_jaya_never_beats_the_proved_optimum(as_published: bool) -> None:
    case = TINY[0]
    optimum = solve_exact(case.problem).value
    runs = jaya_runs(case, 3, as_published=as_published, limit_s=10.0)
    assert len(runs.values) == 3
    assert min(runs.values) >= optimum * (1.0 - CLOSE)
    assert runs.reached(optimum) == sum(abs(v / optimum - 1.0) < CLOSE for v in runs.values)


def test_both_ways_of_a_plan_prove_the_same_optimum() -> None:
    for case in TINY:
        exact, certified = (answer_of(case, method, 10.0, repeats=1).result for method in ("exact", "certified"))
        assert exact.status == certified.status == "optimal"
        assert exact.value == pytest.approx(certified.value, rel=CLOSE)


def test_what_readings_cannot_tell_belongs_to_the_problems_that_come_from_readings() -> None:
    hard = [case for case in cases() if case.hard]
    assert {len(case.problem.planes) for case in hard} == {2, 3}
    assert all(0.0 < case.uncertainty < 2.0 for case in hard)
    assert all(case.uncertainty == 0.0 for case in cases() if not case.hard)


def test_a_peer_that_is_not_installed_is_printed_as_such(capsys: pytest.CaptureFixture[str]) -> None:
    bench = Bench(markdown=True, quick=True, budget_s=0.3, seeds=1)
    absent = replace(INSTALLED[0], name="Absent", package="no_such_package_at_all")
    assert (absent.label, absent.installed) == ("Absent", False)
    assert compared(bench, absent, TINY[0], 1.0) == "not installed"
    abilities(bench)
    printed = capsys.readouterr().out
    assert all(peer.name in printed for peer in peers())


def test_a_selection_that_breaks_a_limit_is_not_taken_for_an_answer() -> None:
    def crowd(problem: SelectionProblem, seed: int, budget_s: float) -> Found:
        return Found((tuple(Piece(0, 0) for _ in range(9)), ()), 0.0, True, budget_s)

    careless = replace(INSTALLED[0], solve=crowd, package="numpy")
    bench = Bench(seeds=1)
    assert "not allowed" in compared(bench, careless, TINY[0], 1.0)
    assert "none allowed" in compared(bench, replace(careless, proves=False), TINY[0], 1.0)


def test_the_tables_have_a_line_for_every_problem(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Bench, "cases", TINY)
    bench = Bench(markdown=True, quick=True, budget_s=0.3, seeds=1)
    ours(bench)
    beside_peers(bench)
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("| ")]
    for case in TINY:
        mine, beside = (line for line in lines if line.startswith(f"| {case.name} |"))
        assert "| optimal |" in mine
        assert beside.count("|") == 5 + len(peers())
        assert "proved" in beside
