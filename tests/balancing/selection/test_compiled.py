"""The loops for the compiler, run as plain Python: the same answers as numpy's."""

from __future__ import annotations

import pytest

from service.balancing.selection import compiled
from service.balancing.selection.batch.solver import solve_batch
from service.balancing.selection.batch.tables import shared_rows
from service.balancing.selection.exact import meet_in_middle
from service.balancing.selection.exact.search import solve_exact
from service.balancing.selection.problem import Norm
from tests.balancing.selection.batch.test_solver import drawn, workshop
from tests.support.numerics.random_problems import KINDS, random_problem


@pytest.mark.parametrize("kind", KINDS)
def test_the_exact_search_finds_the_same(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    problems = [random_problem(kind, 900 + seed) for seed in range(4)]
    plain = [solve_exact(problem) for problem in problems]
    monkeypatch.setattr(compiled, "_loaded", [compiled.Loops(met=compiled._met, pairs=compiled._pairs)])
    monkeypatch.setattr(meet_in_middle, "WORTH_COMPILING", -1)
    for problem, one in zip(problems, plain, strict=True):
        other = solve_exact(problem)
        assert (other.pieces, other.value, other.status) == (one.pieces, one.value, "optimal")


@pytest.mark.parametrize(("norm", "count"), [("sum", 1), ("max", 8), ("rms", 2), ("components", 1)])
def test_a_batch_finds_the_same(norm: Norm, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = workshop(2, 2, norm, count)
    shared = shared_rows(problem.planes, problem.stock)
    assert shared is not None
    objectives = drawn(problem, 8, 3)
    plain = solve_batch(shared, problem.planes, objectives)
    monkeypatch.setattr(compiled, "_loaded", [compiled.Loops(met=compiled._met, pairs=compiled._pairs)])
    looped = solve_batch(shared, problem.planes, objectives)
    assert looped.proved.all()
    assert [looped.selection(n) for n in range(8)] == [plain.selection(n) for n in range(8)]
    assert looped.value == pytest.approx(plain.value, rel=1e-12)


def test_without_numba_nothing_is_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> object:
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(compiled, "_loaded", [])
    monkeypatch.setattr("importlib.import_module", missing)
    assert compiled.load() is False
    assert compiled.loops() is None


def test_with_numba_the_compiled_loops_give_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("numba", reason="the extra `fast` is not installed")
    problem = workshop(2, 2, "sum", 1)
    shared = shared_rows(problem.planes, problem.stock)
    assert shared is not None
    objectives = drawn(problem, 50, 4)
    plain = solve_batch(shared, problem.planes, objectives)
    monkeypatch.setattr(compiled, "_loaded", [])
    assert compiled.load()
    fast = solve_batch(shared, problem.planes, objectives)
    assert [fast.selection(n) for n in range(50)] == [plain.selection(n) for n in range(50)]
