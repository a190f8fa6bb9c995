"""Without phase: closed form, least squares, ambiguity and the run that resolves it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.balancing.influence.amplitude_only import fit_amplitudes, four_run
from service.balancing.influence.corrections import least_squares
from service.balancing.rotor.phasors import ComplexArray
from service.errors import NumericsError
from tests.support.numerics.runs import normal

seeds = st.integers(0, 2**32 - 1)
THIRDS = np.array([0.0, 2.0, 4.0]) * np.pi / 3.0


def thirds(planes: int, mass: float) -> ComplexArray:
    """As found, then each plane's trial mass at three angles."""
    rows = [np.zeros(planes, complex)]
    rows += [mass * np.exp(1j * angle) * np.eye(planes)[p] for p in range(planes) for angle in THIRDS]
    return np.array(rows, dtype=complex)


@given(seeds, st.floats(0.2, 3.0))
def test_four_runs_recover_the_correction(seed: int, effect: float) -> None:
    rng = np.random.default_rng(seed)
    v0, alpha = normal(rng, 1)[0] * 3.0, effect * np.exp(2j * np.pi * rng.random())
    amplitudes = np.abs(v0 + alpha * np.exp(1j * THIRDS))
    found = four_run(abs(v0), 5.0, THIRDS, amplitudes)
    assert found.trial_effect == pytest.approx(effect)
    assert found.correction == pytest.approx(-v0 / (alpha / 5.0))


@settings(max_examples=25, deadline=None)
@given(seeds, st.integers(1, 2), st.integers(1, 3))
def test_amplitudes_alone_recover_the_correction(seed: int, planes: int, sensors: int) -> None:
    rng = np.random.default_rng(seed)
    sensors = max(sensors, planes)
    A, v0 = normal(rng, sensors, planes) / 10.0 + 0.1 * np.eye(sensors, planes), normal(rng, sensors) + 1.0
    masses = np.vstack([thirds(planes, 10.0), 10.0 * np.exp(2j * np.pi * rng.random((2, planes)))])
    fit = fit_amplitudes(masses, np.abs(v0 + masses @ A.T), np.random.default_rng(0))
    # Independent sensors, so each row is known up to its own turn.
    turned = np.exp(-1j * np.angle(v0))
    np.testing.assert_allclose(fit.models[0].influence, A * turned[:, None], atol=1e-5)
    np.testing.assert_allclose(fit.models[0].initial, np.abs(v0), atol=1e-5)
    expected = np.linalg.lstsq(A, -v0, rcond=None)[0]
    np.testing.assert_allclose(least_squares(fit.models[0]).masses, expected, atol=1e-3 * np.abs(expected).max())


def test_opposite_trials_leave_two_answers_and_a_run_tells_which() -> None:
    """A mass at 0 and at 180 degrees cannot tell left from right."""
    alpha, v0 = 0.3 * np.exp(0.8j), 2.0
    masses = np.array([[0.0], [8.0], [-8.0]], dtype=complex)
    rng = np.random.default_rng(0)
    fit = fit_amplitudes(masses, np.abs(v0 + masses * alpha), rng)
    assert fit.ambiguous
    assert sorted(np.angle(model.influence[0, 0]) for model in fit.models) == pytest.approx([-0.8, 0.8])
    assert fit.resolving_run is not None
    assert abs(fit.resolving_run[0]) == pytest.approx(8.0)
    assert fit.difference > 0.3
    more = np.vstack([masses, fit.resolving_run])
    resolved = fit_amplitudes(more, np.abs(v0 + more * alpha), rng)
    assert not resolved.ambiguous
    assert least_squares(resolved.models[0]).masses[0] == pytest.approx(-v0 / alpha)


def test_noise_moves_the_answer_by_as_much() -> None:
    rng = np.random.default_rng(5)
    A, v0 = np.array([[0.10, 0.02j], [-0.03, 0.12]]), np.array([2.0, 1.5j])
    masses = thirds(2, 15.0)
    errors = []
    for _ in range(20):
        amplitudes = np.abs(v0 + masses @ A.T) * (1.0 + 0.01 * rng.normal(size=(7, 2)))
        found = least_squares(fit_amplitudes(masses, amplitudes, rng).models[0]).masses
        errors.append(np.abs(found - np.linalg.solve(A, -v0)).max())
    assert np.median(errors) < 0.05 * np.abs(np.linalg.solve(A, -v0)).max()


@pytest.mark.parametrize(
    ("masses", "amplitudes", "code"),
    [
        ([[0], [5]], [[1.0], [2.0]], "too_few_runs"),
        ([[0], [0], [0]], [[1.0], [1.0], [1.0]], "too_few_runs"),
        ([[5], [5], [5]], [[1.0], [1.0], [1.0]], "planes_not_separated"),
        ([[0], [5], [5j]], [[0.0], [0.0], [0.0]], "all_readings_zero"),
        ([[0], [5], [5j]], [[1.0], [np.nan], [2.0]], "too_few_runs"),
        ([[0], [5], [5j]], [[1.0], [-1.0], [2.0]], "numerics"),
        ([[0], [5], [np.nan]], [[1.0], [1.0], [2.0]], "numerics"),
    ],
)
def test_insufficient_runs_are_refused(masses: list[list[complex]], amplitudes: list[list[float]], code: str) -> None:
    with pytest.raises(NumericsError) as caught:
        fit_amplitudes(np.array(masses, dtype=complex), np.array(amplitudes), np.random.default_rng(0))
    assert caught.value.code == code


@pytest.mark.parametrize(
    ("initial", "angles", "amplitudes"),
    [(0.0, THIRDS, [1, 2, 3]), (5.0, THIRDS[:2], [1, 2]), (5.0, THIRDS * 0, [1, 2, 3]), (5.0, THIRDS, [1, 1, 1])],
)
def test_four_runs_that_make_no_sense_are_refused(initial: float, angles: list[float], amplitudes: list[float]) -> None:
    with pytest.raises(NumericsError):
        four_run(initial, 5.0, np.asarray(angles), np.array(amplitudes, dtype=float))
