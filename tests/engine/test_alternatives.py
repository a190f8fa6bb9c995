"""Other answers: the best for each number of masses, and what missing or bought pieces would change."""

from __future__ import annotations

import itertools
import time
from dataclasses import replace

import pytest

from service.engine import correct, plan
from service.engine.alternatives import front_of, what_if
from service.engine.logs.replay import last_problem
from service.errors import InvalidInput
from service.model.plan import StockChange, WhatIf, WhatIfRequest
from tests.support.numerics.drum_log import session

LOG = session()
MADE = plan(LOG, correct(LOG))
POSED = last_problem(LOG)[1]
assert POSED is not None
GROUND = POSED.ground


def asked(**changes: object) -> WhatIf:
    return what_if(GROUND, MADE, WhatIfRequest(**changes), None, time.monotonic)  # type: ignore[arg-type]


def test_more_masses_make_it_better_or_are_not_listed() -> None:
    points = front_of(GROUND, MADE.request, None, time.monotonic)
    assert points[0].pieces == 0
    values = [point.offer.objective_value for point in points]
    assert all(after < before for before, after in itertools.pairwise(values))  # type: ignore[operator]
    assert values[-1] == pytest.approx(MADE.objective_value)


def test_nothing_changed_is_the_plan_itself() -> None:
    same = asked()
    assert same.offer.placements == MADE.placements
    assert same.worse_by == pytest.approx(0.0, abs=1e-12)


def test_without_its_pieces_the_plan_is_no_better() -> None:
    gone = tuple(StockChange(mass_g=mass, pieces=10) for mass in {piece.mass_g for piece in MADE.placements})
    found = asked(missing=gone)
    assert found.worse_by is not None
    assert found.worse_by > 0.0
    assert not {one.mass_g for one in found.offer.placements} & {one.mass_g for one in gone}


def test_more_missing_than_there_are_is_refused() -> None:
    with pytest.raises(InvalidInput) as refused:
        asked(missing=(StockChange(mass_g=10.0, pieces=11),))
    assert refused.value.field == "missing[0].pieces"
    with pytest.raises(InvalidInput):
        asked(bought=(StockChange(mass_g=11.0, pieces=1),))


def test_an_unlimited_mass_stays_unlimited() -> None:
    counts = tuple(None for _ in GROUND.inputs.counts)
    free = replace(GROUND, inputs=replace(GROUND.inputs, counts=counts))
    found = what_if(
        free, MADE, WhatIfRequest(missing=(StockChange(mass_g=10.0, pieces=1000),)), "other", time.monotonic
    )
    assert found.other_box == "other"
    assert found.offer.status in ("optimal", "within_uncertainty")
