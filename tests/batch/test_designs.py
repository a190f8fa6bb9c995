"""Searches of a design from many seeds: the best is found whatever the order in which they end."""

from __future__ import annotations

import pickle

import pytest

from service.batch.designs import agreeing, best_of, optimise_seeds
from service.batch.executors import Here
from service.design.documents import preset
from service.design.findings import RefusedDesign
from service.design.optimising import optimise

DOCUMENT = {**preset("shaft_set_conflict"), "published": []}


def test_the_best_seed_is_told_and_an_answer_can_travel_between_processes() -> None:
    found = list(optimise_seeds(Here(), DOCUMENT, range(1, 4), "de_standard", 40))
    assert sorted(one.seed for one in found) == [1, 2, 3]
    best = best_of(found)
    assert best.outcome.value == max(one.outcome.value for one in found)
    assert 1 <= agreeing(found) <= 3
    assert best_of(list(reversed(found))) is best
    again = pickle.loads(pickle.dumps(best))
    assert again.outcome.value == optimise(DOCUMENT, "de_standard", best.seed, 40).value


def test_a_method_that_is_not_for_the_document_is_refused() -> None:
    with pytest.raises(RefusedDesign):
        list(optimise_seeds(Here(), DOCUMENT, [1], "enumeration"))
