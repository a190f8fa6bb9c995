"""Each finding fires where its fault is, on the simulated drum, and hardly ever where there is none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.drum import DrumSpec, Scatter
from drivers.faults import NO_FAULTS, Faults, LooseMass
from service.balancing.analysis import analyse
from service.balancing.corrections import Wishes, least_squares
from service.balancing.diagnosis.findings import Circumstances
from service.balancing.diagnosis.planes import significance
from service.balancing.phasors import ComplexArray
from service.errors import NumericsError
from tests.balancing.diagnosis.sessions import Session, sound
from tests.balancing.runs import measured, normal, trial_plan

SESSIONS = 40
NONE = np.zeros(2, dtype=complex)


def trials(session: Session, faults: Faults = NO_FAULTS) -> ComplexArray:
    masses = session.trial()
    for state in (NONE, masses * [1, 0], masses * [0, 1]):
        session.run(state, faults=faults)
    return masses


def small_trial(seed: int) -> Session:
    session = Session(seed)
    masses = session.trial() * [1.0, 0.004]
    session.run(NONE)
    session.run(masses * [1, 0])
    session.run(masses * [0, 1])
    return session


def small_trial_without_scatter(seed: int) -> Session:
    session = Session(seed, stated=False)
    masses = session.trial() * [0.08, 1.0]
    session.run(NONE)
    session.run(masses * [1, 0])
    session.run(masses * [0, 1])
    return session


def drifting(seed: int) -> Session:
    session = Session(seed)
    masses = session.trial()
    session.run(NONE)
    session.run(masses * [1, 0], speed=1.06 if seed % 2 else 0.94)
    session.run(masses * [0, 1])
    return session


def mistyped(seed: int) -> Session:
    """One run of six whose phase, amplitude or masses were typed wrong."""
    session = Session(seed)
    a, b = session.trial()
    states = [NONE, [a, 0], [0, b], [a, b], [-a, 0.5j * b], [0.5j * a, -b]]
    wrong = 1 + seed % 5
    for k, masses in enumerate(np.array(state, dtype=complex) for state in states):
        if k != wrong:
            session.run(masses)
        elif seed % 3 == 0:
            session.run(masses, typed=lambda v: v * np.exp(1j * np.radians(70.0)))
        elif seed % 3 == 1:
            session.run(masses, typed=lambda v: v * 2.0)
        else:
            session.run(masses, really=masses * np.exp(1j * np.radians(120.0)))
    session.wrong = wrong
    return session


def wrong_phase_sense(seed: int) -> Session:
    session = Session(seed)
    faults = Faults(wrong_phase_sense=True)
    trials(session, faults)
    session.run(session.correction(), faults=faults, check=True)
    return session


def wrong_angle_sense(seed: int) -> Session:
    session = Session(seed)
    faults = Faults(wrong_angle_sense=True)
    masses = trials(session, faults)
    session.run(masses * [1j, -1], faults=faults)
    return session


def lost_mass(seed: int) -> Session:
    session = Session(seed)
    trials(session)
    plane = session.spec.planes[seed % 2].name
    loose = LooseMass(plane, lost=True) if seed % 3 else LooseMass(plane, slip_deg=60.0)
    session.run(session.correction(), faults=Faults(loose_trial_mass=loose), check=True)
    return session


def bent(seed: int) -> Session:
    """A support that stiffens: the reading grows with the root of what it should be."""
    session = Session(seed)
    a, b = session.trial(350.0)
    for state in (NONE, [a, 0], [0, b], [a, b], [-a, 0.5j * b], [0.5j * a, -b], [-a, -b]):
        session.run(np.array(state, dtype=complex), typed=lambda v: v / np.sqrt(np.abs(v) / 3.0))
    return session


def rattling(seed: int) -> Session:
    def altered(spec: DrumSpec) -> DrumSpec:
        return replace(spec, sensors=tuple(replace(sensor, broadband_rms=15.0) for sensor in spec.sensors))

    session = Session(seed, altered=altered)
    trials(session)
    return session


def beating(seed: int) -> Session:
    session = Session(
        seed, rounds=4, altered=lambda spec: replace(spec, scatter=Scatter(phase_deg=50.0, amplitude=0.1))
    )
    trials(session)
    return session


def contradicting(seed: int) -> Session:
    session = Session(seed)
    trials(session)
    session.run(NONE, typed=lambda v: v * 1.35)
    return session


def stuck(seed: int) -> Session:
    session = Session(seed)
    trials(session, Faults(stuck=(session.spec.sensors[seed % 2].name,)))
    return session


def silent(seed: int) -> Session:
    session = Session(seed)
    masses = session.trial()
    for state in (NONE, masses * [1, 0], masses * [0, 1]):
        session.run(state, typed=lambda v: v * [1, 0])
    return session


def planes_side_by_side(seed: int) -> Session:
    def altered(spec: DrumSpec) -> DrumSpec:
        left, right = spec.planes
        return replace(spec, planes=(replace(left, axial_mm=290.0), right))

    session = Session(seed, altered=altered)
    trials(session)
    return session


def balanced_already(seed: int) -> Session:
    session = Session(seed, altered=lambda spec: replace(spec, unbalances=()))
    trials(session)
    return session


FAULTS: list[tuple[str, Callable[[int], Session]]] = [
    ("trial_response_small", small_trial),
    ("trial_response_small", small_trial_without_scatter),
    ("speed_drift", drifting),
    ("bad_run", mistyped),
    ("sense_mirrored", wrong_phase_sense),
    ("sense_mirrored", wrong_angle_sense),
    ("prediction_missed", lost_mass),
    ("not_linear", bent),
    ("not_unbalance_1x_share", rattling),
    ("phase_unsteady", beating),
    ("runs_contradict", contradicting),
    ("sensor_stuck", stuck),
    ("sensor_silent", silent),
    ("planes_dependent", planes_side_by_side),
    ("correction_in_noise", balanced_already),
]


def codes(session: Session) -> set[str]:
    try:
        analysis = analyse(session.recorded(), circumstances=session.circumstances())
    except NumericsError as error:
        return {error.code}
    return {finding.code for finding in analysis.findings}


@pytest.mark.parametrize(("code", "faulty"), FAULTS, ids=[faulty.__name__ for _, faulty in FAULTS])
def test_fires_where_the_fault_is(code: str, faulty: Callable[[int], Session]) -> None:
    fired = sum(code in codes(faulty(seed)) for seed in range(SESSIONS))
    assert fired >= 0.95 * SESSIONS


@pytest.mark.parametrize(("stated", "rounds"), [(True, 8), (False, 1)])
def test_hardly_ever_fires_without_a_fault(stated: bool, rounds: int) -> None:
    counted = Counter(code for seed in range(200) for code in codes(sound(seed, stated, rounds)))
    assert max(counted.values(), default=0) <= 3


def test_the_bad_run_is_the_one_named() -> None:
    for seed in range(30):
        session = mistyped(seed)
        findings = analyse(session.recorded(), circumstances=session.circumstances()).findings
        assert [(finding.code, finding.runs) for finding in findings] == [("bad_run", (session.wrong,))]


def test_planes_that_buck_are_offered_damping() -> None:
    """Two planes nearly alike, asked for the little in which they differ: much mass for nothing."""
    A = np.array([[1.0, 0.9], [1.0, 0.95], [1.0, 1.0]], dtype=complex)
    v0 = A @ [0.6, 0.6] + [0.06, 0.0, -0.06]
    analysis = analyse(measured(A, v0, trial_plan(np.ones(2)), scatter=1e-4))
    (finding,) = [finding for finding in analysis.findings if finding.code == "planes_buck"]
    assert "damping 0.0" in finding.advice
    damping = float(finding.advice.split("damping ")[1].split()[0])
    damped = least_squares(analysis.fit, None, Wishes(damping=damping))
    assert np.linalg.norm(damped.masses) <= 0.5 * np.linalg.norm(analysis.correction.masses)
    assert damped.objective - analysis.correction.objective <= 0.051 * np.linalg.norm(v0)


def test_directions_that_unbalance_does_not_make() -> None:
    A = np.array([[1.0], [1.0], [1.0]], dtype=complex)

    def found(*v0: complex) -> set[str]:
        circumstances = Circumstances(
            direction=("horizontal", "vertical", "axial"), bearing=("P", "P", "P"), speed_rpm=np.full((2, 3), 460.0)
        )
        runs = measured(A, np.array(v0, dtype=complex), trial_plan(np.array([5.0])), scatter=0.01)
        return {finding.code for finding in analyse(runs, circumstances=circumstances).findings}

    assert found(2.0, 1.8j, 0.3) == set()
    assert found(2.0, 0.5j, 0.3) == {"not_unbalance_direction"}
    assert found(2.0, 1.8, 0.3) == {"not_unbalance_phase"}
    assert found(2.0, 1.8j, 1.9) == {"not_unbalance_axial"}


@pytest.mark.parametrize("columns", [2, 3, 4])
def test_significance_is_what_is_new_in_a_plane(columns: int) -> None:
    rng = np.random.default_rng(columns)
    A = normal(rng, 6, columns)
    np.testing.assert_allclose(significance(np.linalg.qr(A)[0]), 1.0)
    A[:, -1] = A[:, 0] * (0.3 - 0.1j) + 1e-9
    assert significance(A).min() < 1e-8
    A[:, -1] = 0.0
    assert significance(A)[-1] == 0.0
