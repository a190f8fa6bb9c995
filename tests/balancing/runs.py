"""Runs of a rotor that is linear by construction, for the tests of the numerics."""

from __future__ import annotations

import numpy as np

from service.balancing.fit import RunSet
from service.balancing.phasors import ComplexArray, FloatArray


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


def trial_plan(masses: ComplexArray | FloatArray) -> ComplexArray:
    """One run as found, then one per plane with its trial mass alone: (P,) -> (P + 1, P)."""
    return np.vstack([np.zeros((1, len(masses))), np.diag(masses)]).astype(np.complex128)


def turned(degrees: float) -> complex:
    return complex(np.exp(1j * np.radians(degrees)))
