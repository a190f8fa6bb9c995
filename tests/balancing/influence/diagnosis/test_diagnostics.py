"""Each finding fires where its fault is, on the simulated drum, and hardly ever where there is none."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from service.balancing.influence.analysis import analyse
from service.balancing.influence.corrections import CorrectionOptions, least_squares
from service.balancing.influence.diagnosis.findings import Code, RunConditions
from service.balancing.influence.diagnosis.planes import significance
from tests.balancing.influence.diagnosis import campaign, faults
from tests.balancing.influence.diagnosis.campaign import FAULTY, SOUND, Faulty, Sound
from tests.support.numerics.runs import measured, normal, trial_plan

SESSIONS = 24
"""Of each fault; `python -m tests.balancing.influence.diagnosis.campaign` takes more, and others."""
SOUND_SESSIONS = 120


def test_every_code_there_is_has_its_fault_and_sessions_without_it() -> None:
    """mypy keeps every finding to a `Code`, so a new diagnostic cannot go without."""
    codes = set(get_args(Code))
    assert {faulty.code for faulty in FAULTY} == codes
    assert {code for sound in SOUND for code in sound.codes} == codes


@pytest.mark.parametrize("faulty", FAULTY, ids=lambda faulty: faulty.name)
def test_fires_where_the_fault_is(faulty: Faulty) -> None:
    assert campaign.fired(faulty, range(SESSIONS)) >= 0.95 * SESSIONS


@pytest.mark.parametrize("sound", SOUND, ids=lambda sound: sound.name)
def test_hardly_ever_fires_without_a_fault(sound: Sound) -> None:
    alarms = campaign.false_alarms(sound, range(SOUND_SESSIONS))
    assert max(alarms.values(), default=0) <= 3 * SOUND_SESSIONS / 200


def test_the_bad_run_is_the_one_named() -> None:
    for seed in range(30):
        session = faults.mistyped(seed)
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
    damped = least_squares(analysis.fit, None, CorrectionOptions(damping=damping))
    assert np.linalg.norm(damped.masses) <= 0.5 * np.linalg.norm(analysis.correction.masses)
    assert damped.objective - analysis.correction.objective <= 0.051 * np.linalg.norm(v0)


def test_directions_that_unbalance_does_not_make() -> None:
    A = np.array([[1.0], [1.0], [1.0]], dtype=complex)

    def found(*v0: complex) -> set[str]:
        circumstances = RunConditions(
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
