"""Corrections: the masses that bring the drum's own arithmetic to nothing, and what is refused."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest

from service.engine import correction_solver
from service.engine.correction_solver import solve_correction
from service.engine.influence_fits import fit_runs
from service.errors import InvalidInput
from service.model.correction import Correction, CorrectionRequest
from service.model.run import MassOnRotor
from tests.support.numerics.drum_log import session, still

LOG = session()


def solved(**request: object) -> Correction:
    asked = CorrectionRequest(**({"source": "fit"} | request))  # type: ignore[arg-type]
    return solve_correction(LOG.machine, LOG.runs, (), asked, number=1, key="c1")


def vectors(correction: Correction) -> dict[str, complex]:
    return {one.plane: cmath.rect(one.mass_g, math.radians(one.angle_deg)) for one in correction.corrections}


def test_the_masses_bring_every_sensor_to_nothing() -> None:
    answer = solved()
    assert abs(still("P", vectors(answer))) < 1e-9
    assert abs(still("Q", vectors(answer))) < 1e-9
    assert [one.amplitude for one in answer.predicted] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert [one.amplitude for one in answer.initial] == pytest.approx([3.0, 5.0])
    assert answer.runs == (1, 2, 3)


def test_the_trim_is_the_total_less_what_is_on_now() -> None:
    """The last run had 200 g at 80 degrees in plane 2: that much less is to be added."""
    answer = solved()
    trim = {one.plane: cmath.rect(one.mass_g, math.radians(one.angle_deg)) for one in answer.trim}
    assert trim["1"] == pytest.approx(vectors(answer)["1"])
    assert trim["2"] == pytest.approx(vectors(answer)["2"] - cmath.rect(200.0, math.radians(80.0)))
    bare = solve_correction(LOG.machine, LOG.runs, (), CorrectionRequest(source="fit"), number=1, key="c", on_rotor=())
    assert [one.mass_g for one in bare.trim] == pytest.approx([one.mass_g for one in bare.corrections])


def test_one_plane_alone_leaves_the_least_squares_rest() -> None:
    answer = solved(planes=("1",))
    assert vectors(answer)["2"] == pytest.approx(cmath.rect(200.0, math.radians(80.0)))  # stays as it was last
    rest = [still(sensor, vectors(answer)) for sensor in ("P", "Q")]
    predicted = [one.amplitude for one in answer.predicted]
    assert predicted == pytest.approx([abs(v) for v in rest])
    for turn in (1.0, 1j, -1.0, -1j):
        beside = vectors(answer) | {"1": vectors(answer)["1"] + turn}
        assert math.hypot(*(abs(still(sensor, beside)) for sensor in ("P", "Q"))) > math.hypot(*predicted)


def test_a_limit_on_the_masses_is_kept() -> None:
    answer = solved(max_mass_g=100.0)
    assert all(one.mass_g <= 100.0 * (1.0 + 1e-6) for one in answer.corrections)
    free = [one.mass_g for one in solved().corrections]
    assert max(free) > 100.0


def test_minimax_is_no_worse_at_the_worst_sensor() -> None:
    one_plane = {"planes": ("2",)}
    worst = [max(v.amplitude for v in solved(method=m, **one_plane).predicted) for m in ("minimax", "least_squares")]
    assert worst[0] <= worst[1] * (1.0 + 1e-6)


def test_a_balancer_s_answer_is_taken_as_it_is() -> None:
    masses = (MassOnRotor(plane="1", mass_g=120.0, angle_deg=200.0),)
    answer = solved(source="balancer", masses=masses)
    assert vectors(answer)["1"] == pytest.approx(cmath.rect(120.0, math.radians(200.0)))
    assert answer.influence == ()


def test_fields_of_another_source_are_refused() -> None:
    for request in (
        CorrectionRequest(source="fit", masses=(MassOnRotor(plane="1", mass_g=1.0, angle_deg=0.0),)),
        CorrectionRequest(source="balancer", damping=0.1),
    ):
        with pytest.raises(InvalidInput):
            correction_solver.check_fields(request)
    correction_solver.check_fields(CorrectionRequest(source="fit", damping=0.1))


def test_an_unknown_plane_is_refused() -> None:
    with pytest.raises(InvalidInput):
        solved(planes=("9",))


def test_any_masses_can_be_predicted() -> None:
    fitted = fit_runs(LOG.machine, LOG.runs, ())
    told = correction_solver.predicted_with(LOG.machine, fitted, np.array([100.0 + 0j, 50j]))
    assert [one.amplitude for one in told] == pytest.approx([abs(still(s, {"1": 100, "2": 50j})) for s in ("P", "Q")])
    assert correction_solver.predicted_with(LOG.machine, None, np.zeros(2, complex)) == ()


def test_the_vectors_of_a_correction_are_its_masses() -> None:
    answer = solved()
    found = correction_solver.correction_vectors(LOG.machine, answer)
    np.testing.assert_allclose(found, [vectors(answer)["1"], vectors(answer)["2"]], rtol=1e-12)
    moved = replace(answer, corrections=answer.corrections[:1])
    assert correction_solver.correction_vectors(LOG.machine, moved)[1] == 0.0
