"""The campaign against brute force: its short form, and that it notices what does not hold."""

from __future__ import annotations

import pytest

from service.balancing.selection.problem import SelectionProblem
from tests.balancing.campaign import FAMILIES, campaign
from tests.support.numerics import against_brute_force
from tests.support.numerics.random_problems import KINDS


@pytest.mark.parametrize("kind", KINDS)
def test_everything_holds_for_one_of_each(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert campaign(1, (kind,), tuple(FAMILIES), first=40) == []
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines] == [f"{kind}, {family}" for family in FAMILIES]


def test_a_wrong_answer_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A judge that knows a better selection than there is finds every answer wrong."""
    of = against_brute_force.Every.of

    def better(problem: SelectionProblem) -> against_brute_force.Every:
        every = of(problem)
        every.values[-1] = 0.5 * every.values.min() - 1.0
        return every

    monkeypatch.setattr(against_brute_force.Every, "of", better)
    assert len(campaign(3, ("components",), ("plain",))) == 3
