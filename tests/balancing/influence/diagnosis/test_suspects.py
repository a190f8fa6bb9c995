"""A single fault is named where the data can tell it, and among the candidates where they cannot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.balancing.influence.diagnosis.single_faults import Kind
from service.balancing.influence.diagnosis.suspects import AS_FOUND, Suspects, suspects_of
from service.balancing.influence.fit import RunSet, fit_influence
from tests.support.numerics.runs import normal

SLIPS: tuple[Kind, ...] = (
    "angle_mirrored",
    "angle_opposite",
    "lost",
    "mass_factor",
    "planes_swapped",
    "left_in",
    "phase_opposite",
    "phase_mirrored",
    "sensors_swapped",
    "reading",
    "run",
)


def _session(seed: int, more: int, scatter: float = 0.01) -> RunSet:
    """As found, a trial in each of two planes, `more` runs of both; readings of two sensors err by `scatter`."""
    rng = np.random.default_rng(seed)
    A = normal(rng, 2, 2) + 2.0 * np.eye(2)
    v0 = 100.0 * np.exp(2j * np.pi * rng.random(2))
    turns = 40.0 * np.exp(2j * np.pi * rng.uniform(0.1, 0.4, (2 + more, 2)))
    masses = np.concatenate([np.zeros((1, 2)), turns[:2] * np.eye(2), turns[2:] * [1.0, -0.7]])
    clean = v0 + masses @ A.T
    size = scatter * np.abs(clean)
    return RunSet(masses, clean + size * normal(rng, *clean.shape), size)


def _spoiled(runs: RunSet, kind: Kind, k: int) -> RunSet:
    """The runs as they are written down with a slip in run k."""
    masses, vibration = runs.masses.copy(), runs.vibration.copy()
    plane = int(np.flatnonzero(masses[k])[0])
    A, u, v = fit_influence(runs).influence, masses[k, plane], vibration[k].copy()
    row = {"angle_mirrored": u.conjugate(), "angle_opposite": -u, "mass_factor": 10.0 * u}
    masses[k, plane] = row.get(kind, u)
    if kind == "planes_swapped":
        masses[k] = masses[k, ::-1]
    vibration[k] = {
        "lost": v - A[:, plane] * u,
        "left_in": v + A @ runs.masses[k - 1],
        "phase_opposite": v * [-1.0, 1.0],
        "phase_mirrored": v.conj(),
        "sensors_swapped": v[::-1],
        "reading": v * [1.0, 1.6j],
        "run": v * [1.5j, -0.7],
    }.get(kind, v)
    return replace(runs, masses=masses, vibration=vibration)


def _found(runs: RunSet) -> Suspects:
    return suspects_of(runs, fit_influence(runs))


@pytest.mark.parametrize("kind", SLIPS)
@pytest.mark.parametrize("seed", range(4))
def test_with_runs_to_spare_the_wrong_one_is_named_alone(kind: Kind, seed: int) -> None:
    k = 2 + seed % 3
    found = _found(_spoiled(_session(seed, 4), kind, k))
    assert found.named
    assert found.candidates[0].fault.runs == (k,)
    if kind not in ("reading", "run"):
        assert kind in {fault.kind for fault in found.kinds}


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), kind=st.sampled_from(SLIPS), k=st.integers(1, 3))
def test_with_one_run_to_spare_the_wrong_one_is_among_the_candidates(seed: int, kind: Kind, k: int) -> None:
    if kind == "left_in" and k == 1:
        return  # there was no mass before
    found = _found(_spoiled(_session(seed, 1), kind, k))
    assert found.sound
    assert any(k in one.fault.runs for one in found.candidates)
    assert found.named or found.next_run is None or found.next_run == AS_FOUND or found.next_run > 0


def test_the_further_run_that_is_asked_for_tells_the_candidates_apart() -> None:
    told = 0
    for seed in range(12):
        sound = _session(seed, 1)
        runs = _spoiled(sound, "reading", 1)
        found = _found(runs)
        if found.named or found.next_run is None:
            told += found.named
            continue
        masses = np.zeros(2, complex) if found.next_run == AS_FOUND else sound.masses[found.next_run]
        fit = fit_influence(sound)
        more = RunSet(
            np.vstack([runs.masses, masses]),
            np.vstack([runs.vibration, fit.initial + fit.influence @ masses]),
            np.vstack([runs.scatter, runs.scatter[:1]]),
        )
        after = _found(more)
        told += after.candidates[0].share > found.candidates[0].share or after.named
        assert any(1 in one.fault.runs for one in after.candidates)
    assert told >= 10


def test_a_machine_that_is_not_linear_is_no_single_fault() -> None:
    runs = _session(3, 5, scatter=0.005)
    bent = replace(runs, vibration=runs.vibration * np.abs(runs.vibration / 100.0) ** 0.6)
    assert not _found(bent).sound
