"""Influence models: from runs, from saved coefficients, from amplitudes alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.influence.saved import SavedInfluence as Arrays
from service.engine import influence_fits, mapping
from service.engine.saved_influence import as_document
from service.errors import Conflict, InvalidInput, NumericsError
from tests.support.numerics.drum_log import INFLUENCE, INITIAL, RUNS, run, session

LOG = session()
TRUE = np.array([[INFLUENCE[s, p] for p in ("1", "2")] for s in ("P", "Q")])


def test_three_runs_give_the_drum_s_own_coefficients() -> None:
    fitted = influence_fits.fit_runs(LOG.machine, LOG.runs, ())
    np.testing.assert_allclose(fitted.fit.influence, TRUE, rtol=1e-9)
    np.testing.assert_allclose(fitted.fit.initial, [INITIAL["P"], INITIAL["Q"]], rtol=1e-9)
    assert [row.sensor.name for row in fitted.rows] == ["P", "Q"]


def test_two_runs_do_not_determine_two_planes() -> None:
    with pytest.raises(NumericsError):
        influence_fits.fit_runs(LOG.machine, LOG.runs[:2], ())
    with pytest.raises(InvalidInput):
        influence_fits.require_runs(())


def test_an_excluded_run_does_not_enter() -> None:
    wrong = replace(LOG.runs[1], excluded=True, reason="typed wrong")
    assert influence_fits.used((LOG.runs[0], wrong)) == (LOG.runs[0],)


def test_runs_of_another_session_have_an_as_found_vibration_of_their_own() -> None:
    """The earlier session found the drum otherwise; its trial in plane 2 stands for the one that is missing."""
    as_found = {"P": 1.5 + 0.5j, "Q": -2j}
    other = session([run("initial", found=as_found), run("trial", ("2", 150.0, 0.0), found=as_found)])
    fitted = influence_fits.fit_runs(LOG.machine, LOG.runs[:2], (), earlier=(other.runs,))
    np.testing.assert_allclose(fitted.fit.influence, TRUE, rtol=1e-6)


def test_saved_coefficients_and_one_run() -> None:
    learned = influence_fits.fit_runs(LOG.machine, LOG.runs, ())
    arrays = Arrays(learned.fit.influence, learned.fit.covariance[:, 1:, 1:], 1)
    saved = as_document(LOG.machine, learned.rows, arrays)
    fitted, number = influence_fits.fit_saved(LOG.machine, LOG.runs[:1], (), saved)
    assert number == 1
    np.testing.assert_allclose(fitted.fit.influence, TRUE, rtol=1e-9)
    np.testing.assert_allclose(fitted.fit.initial, [INITIAL["P"], INITIAL["Q"]], rtol=1e-9)
    other_speed = replace(LOG.runs[0], nominal_speed_rpm=300.0)
    with pytest.raises(Conflict):
        influence_fits.fit_saved(LOG.machine, (other_speed,), (), saved)


def test_amplitudes_alone_need_two_runs_more_a_plane() -> None:
    """2 P + 1 amplitudes of each sensor: five runs for two planes."""
    masses = ((), (("1", 200.0, 0.0),), (("1", 200.0, 120.0),), (("2", 200.0, 0.0),), (("2", 200.0, 120.0),))
    five = session([run("initial" if not on else "trial", *on) for on in masses])
    blind = tuple(replace(r, readings=tuple(replace(one, phase_deg=None) for one in r.readings)) for r in five.runs)
    fitted = influence_fits.fit_without_phase(five.machine, blind)
    np.testing.assert_allclose(np.abs(fitted.fit.influence), np.abs(TRUE), rtol=1e-3)
    with pytest.raises(NumericsError):
        influence_fits.fit_without_phase(five.machine, blind[:3])


def test_runs_are_mapped_once() -> None:
    fitted = influence_fits.fit_runs(LOG.machine, LOG.runs, ())
    np.testing.assert_allclose(fitted.runs.vibration, mapping.run_set(LOG.machine, LOG.runs, (), fitted.rows).vibration)
    assert len(RUNS) == len(fitted.runs.masses)
