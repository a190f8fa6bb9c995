"""What runs err by, and what they share of it."""

from __future__ import annotations

import numpy as np
import pytest

from service.balancing.influence.corrections import least_squares
from service.balancing.influence.fit import KNOWN_SCATTER, RunSet, fit_influence
from service.balancing.influence.run_errors import (
    CONTRADICT,
    MIN_DOF,
    REPEATABILITY,
    Errors,
    Pieces,
    Repeats,
    fit_with_errors,
    learned,
    repeats_of,
    with_repeatability,
)
from service.balancing.influence.uncertainty import blur, drawn_errors
from service.balancing.rotor.phasors import ComplexArray

A = np.array([[0.03 + 0.01j, 0.008 - 0.004j], [0.006 + 0.002j, 0.025 + 0.015j]])
V0 = np.array([3.0 + 1.0j, -2.0 + 2.0j])
MASSES = np.array([[0, 0], [100, 0], [0, 100], [-40, 30j]], dtype=complex)
SCATTER = 0.01


def noisy(rng: np.random.Generator, errors: Errors, pieces: Pieces) -> RunSet:
    """Runs with the errors that are stated, drawn by this test's own arithmetic."""
    off = errors.placement * np.abs(pieces.mass) * circular(rng, len(pieces.mass))
    true = MASSES.copy()
    for run in range(len(MASSES)):
        for piece in np.flatnonzero(pieces.on[run]):
            true[run, pieces.plane[piece]] += off[piece]
    clean = V0 + true @ A.T
    clean = clean * (1.0 + errors.per_component * circular(rng, clean.size).reshape(clean.shape))
    clean = clean * (1.0 + errors.drift / np.sqrt(2.0) * circular(rng, 1)[0] * np.arange(len(MASSES))[:, None])
    return RunSet(
        MASSES, clean + SCATTER * circular(rng, clean.size).reshape(clean.shape), np.full(clean.shape, SCATTER)
    )


def circular(rng: np.random.Generator, count: int) -> ComplexArray:
    return np.asarray(rng.standard_normal(count) + 1j * rng.standard_normal(count))


PIECES = Pieces(
    plane=np.array([0, 1, 0, 1]),
    mass=np.array([100.0 + 0j, 100.0 + 0j, -40.0 + 0j, 30j]),
    on=np.array([[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1]], dtype=bool),
)


@pytest.mark.parametrize(
    "errors",
    [
        Errors(repeatability=0.02, mass_sd=0.0, angle_sd=0.0),
        Errors(repeatability=0.0, mass_sd=0.02, angle_sd=0.02),
        Errors(repeatability=0.005, drift=0.02, mass_sd=0.01, angle_sd=0.01),
    ],
)
def test_the_covariance_is_that_of_many_sessions(errors: Errors) -> None:
    rng = np.random.default_rng(1)
    fits = [fit_with_errors(with_repeatability(noisy(rng, errors, PIECES), errors), errors, PIECES) for _ in range(600)]
    off = np.array([np.column_stack([fit.initial - V0, fit.influence - A]) for fit in fits])
    measured = np.einsum("nsi,nsj->sij", off, off.conj()) / (2.0 * len(off))
    stated = np.mean([fit.covariance for fit in fits], axis=0)
    ratio = measured.diagonal(axis1=1, axis2=2).real / stated.diagonal(axis1=1, axis2=2).real
    assert ((ratio > 0.75) & (ratio < 1.35)).all(), ratio
    # What sensors have together makes corrections err together: the answer's covariance knows of it.
    answers = np.array([least_squares(fit).masses for fit in fits]) - np.linalg.solve(A, -V0)
    spread = np.mean([least_squares(fit).covariance.diagonal() for fit in fits], axis=0).reshape(-1, 2).sum(axis=1)
    assert (np.abs(answers) ** 2).mean(axis=0) == pytest.approx(spread, rel=0.25)


def test_without_errors_of_runs_the_fit_is_the_plain_one() -> None:
    errors = Errors(repeatability=0.0, mass_sd=0.0, angle_sd=0.0)
    runs = noisy(np.random.default_rng(2), errors, PIECES)
    plain, fit = fit_influence(runs), fit_with_errors(runs, errors, PIECES)
    assert np.array_equal(plain.covariance, fit.covariance)
    assert not len(fit.shared)


def test_a_scatter_that_is_not_stated_stays_unknown() -> None:
    runs = noisy(np.random.default_rng(3), Errors(), PIECES)
    unknown = RunSet(runs.masses[:3], runs.vibration[:3], np.full((3, 2), np.nan))
    fit = fit_with_errors(with_repeatability(unknown, Errors()), Errors(), None)
    assert np.isnan(fit.covariance).all()


def test_errors_drawn_have_the_covariance_of_the_fit() -> None:
    errors = Errors(drift=0.02)
    fit = fit_with_errors(noisy(np.random.default_rng(4), errors, PIECES), errors, PIECES)
    drawn = drawn_errors(fit, np.random.default_rng(5), 4000)
    measured = np.einsum("nsi,nsj->sij", drawn, drawn.conj()) / (2.0 * len(drawn))
    assert measured == pytest.approx(fit.covariance, abs=0.1 * float(np.abs(fit.covariance).max()))
    assert 0.0 < blur(fit) < 1.0


def test_repeated_runs_teach_the_repeatability() -> None:
    rng = np.random.default_rng(6)
    runs = 400
    clean = np.broadcast_to(V0, (runs, 2))
    share = 0.03
    vibration = clean * (1.0 + share / np.sqrt(2.0) * circular(rng, 2 * runs).reshape(runs, 2))
    vibration = vibration + SCATTER * circular(rng, 2 * runs).reshape(runs, 2)
    groups = np.repeat(np.arange(runs // 2), 2)[:, None] * np.array([[1.0 + 0j, 0.0]])
    found = repeats_of(RunSet(groups, vibration, np.full((runs, 2), SCATTER)))
    assert found.share == pytest.approx(share, rel=0.1)
    assert found.dof > 0.8 * 2 * runs
    assert learned((found,)) == found


def test_lucky_runs_do_not_make_a_machine_exact_and_wrong_ones_teach_nothing() -> None:
    runs = RunSet(np.zeros((2, 1), complex), np.array([[1.0 + 0j], [1.0 + 0j]]), np.full((2, 1), np.nan))
    found = repeats_of(runs)
    assert found == Repeats(0.0, 2)
    assert learned((found,)).share == pytest.approx(REPEATABILITY * np.sqrt(MIN_DOF / (MIN_DOF + 2)))
    wrong = RunSet(runs.masses, np.array([[1.0 + 0j], [1.0 + 1.5 * CONTRADICT]]), runs.scatter)
    assert repeats_of(wrong).dof == 0
    assert learned(()) == Repeats(REPEATABILITY, 0)
    assert Errors().dof == KNOWN_SCATTER
