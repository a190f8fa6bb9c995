"""Runs of a rotor that is linear by construction, for the tests of the numerics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from service.balancing.influence.fit import InfluenceFit, RunSet, fit_influence
from service.balancing.rotor.phasors import ComplexArray, FloatArray


def normal(rng: np.random.Generator, *shape: int) -> ComplexArray:
    """Circular complex normal numbers, standard deviation 1 per real component."""
    return rng.normal(size=shape) + 1j * rng.normal(size=shape)


def measured(
    influence: ComplexArray,
    initial: ComplexArray,
    masses: ComplexArray,
    rng: np.random.Generator | None = None,
    scatter: float = 0.0,
    stated: bool = True,
) -> RunSet:
    """The runs with `masses` (K, P) on v = initial + influence u, each reading with `scatter` per real component."""
    vibration = initial + masses @ influence.T
    if rng is not None:
        vibration = vibration + scatter * normal(rng, *vibration.shape)
    known = np.full(vibration.shape, scatter if stated and scatter > 0.0 else np.nan)
    return RunSet(masses, vibration, known)


def fits_of_repeated(
    influence: ComplexArray,
    initial: ComplexArray,
    masses: ComplexArray,
    rng: np.random.Generator,
    scatter: float,
    times: int,
    stated: bool = True,
) -> Iterator[InfluenceFit]:
    """A fit of each of so many repetitions of the same runs, scattered anew.

    Every sensor is fitted by itself, so the repetitions are fitted in one call, as sensors of one rotor.
    """
    sensors = len(initial)
    runs = measured(np.tile(influence, (times, 1)), np.tile(initial, times), masses, rng, scatter, stated)
    whole = fit_influence(runs)
    for start in range(0, times * sensors, sensors):
        mine = slice(start, start + sensors)
        by_sensor = ("influence", "initial", "covariance", "dof", "scatter_dof", "chi_square")
        yield replace(
            whole,
            **{name: getattr(whole, name)[mine] for name in by_sensor},
            **{name: getattr(whole, name)[:, mine] for name in ("residuals", "leverage")},
        )


def trial_plan(masses: ComplexArray | FloatArray) -> ComplexArray:
    """One run as found, then one per plane with its trial mass alone: (P,) -> (P + 1, P)."""
    return np.vstack([np.zeros((1, len(masses))), np.diag(masses)]).astype(np.complex128)


def turned(degrees: float) -> complex:
    return complex(np.exp(1j * np.radians(degrees)))
