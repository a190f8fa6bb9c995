"""Coefficients kept from earlier sessions: one run balances the drum, and each session teaches within bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.balancing.influence.fit import KNOWN_SCATTER, InfluenceFit, condition
from service.balancing.rotor.labels import Labels
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.errors import NumericsError
from service.messages import Message

LARGEST_CHANGE = 0.5
LARGEST_TURN = np.radians(45.0)
"""A coefficient is not updated where the new one differs by more than these: ACES, two published examples."""

_SPREAD = 5.0
"""Mean square difference, in variances, from which two sessions differ by more than their covariances say."""


@dataclass(frozen=True)
class SavedInfluence:
    """influence: (S, P) complex per g. covariance: (S, P, P) complex Hermitian per real component, nan where unknown.

    sessions: how many are in it.
    """

    influence: ComplexArray
    covariance: ComplexArray
    sessions: int = 1


@dataclass(frozen=True)
class Learned:
    """saved: after learning. refused: (S, P) True where the new coefficient was too far off, and the row kept.

    change: (S, P) relative change of size; turn: (S, P) radians, of the new coefficient against the saved one.
    """

    saved: SavedInfluence
    refused: NDArray[np.bool_]
    change: FloatArray
    turn: FloatArray


def from_fit(fit: InfluenceFit) -> SavedInfluence:
    """Keep the coefficients of a session."""
    return SavedInfluence(fit.influence, fit.covariance[:, 1:, 1:])


def one_run(
    saved: SavedInfluence,
    masses: ComplexArray,
    vibration: ComplexArray,
    scatter: FloatArray,
    labels: Labels | None = None,
) -> InfluenceFit:
    """Build the fit that saved coefficients and one run make: v0 = v - A u.

    masses: (P,) complex g on the rotor during the run; vibration: (S,); scatter: (S,) per real component, nan where
    unknown. A sensor that gave nothing has a row of nan.
    """
    sensors, planes = saved.influence.shape
    if masses.shape != (planes,) or vibration.shape != (sensors,) or scatter.shape != (sensors,):
        raise NumericsError(
            Message(
                "numerics.one_run_shape",
                planes=planes,
                sensors=sensors,
                masses=masses.shape,
                vibration=vibration.shape,
                scatter=scatter.shape,
            ),
            field="runs",
        )
    both = np.zeros((sensors, planes + 1, planes + 1), dtype=np.complex128)
    both[:, 0, 0] = np.where(scatter > 0.0, scatter, np.nan) ** 2
    both[:, 1:, 1:] = saved.covariance
    carry = np.eye(planes + 1, dtype=np.complex128)
    carry[0, 1:] = -masses
    unknown = np.isnan(both).any(axis=(1, 2))
    both[unknown] = 0.0
    spread = carry @ both @ carry.conj().T
    spread[unknown] = np.nan
    missing = ~np.isfinite(vibration)
    influence = np.where(missing[:, None], np.nan, saved.influence)
    return InfluenceFit(
        influence=influence,
        initial=np.where(missing, np.nan, vibration - saved.influence @ masses),
        covariance=spread,
        dof=np.zeros(sensors, dtype=np.int64),
        scatter_dof=np.where(unknown | missing, 0.0, KNOWN_SCATTER),
        condition=condition(saved.influence[~missing]),
        residuals=np.where(missing, np.nan, 0j)[None, :],
        chi_square=np.full(sensors, np.nan),
        leverage=np.ones((1, sensors)),
        labels=labels or Labels(),
    )


def learn(saved: SavedInfluence, fit: InfluenceFit) -> Learned:
    """Combine saved coefficients with those of a new session, sensor by sensor.

    Where both covariances are known the two weigh by their inverses, and what they differ by beyond them is added to
    the covariance of both; otherwise they weigh by the number of sessions. A row with
    any coefficient beyond `LARGEST_CHANGE` or `LARGEST_TURN` is not updated, nor is one that the session lacks.
    """
    old, new = saved.influence, fit.influence
    if new.shape != old.shape:
        raise NumericsError(Message("numerics.coefficients_shape", saved=old.shape, new=new.shape), field="influence")
    ratio = np.divide(new, old, out=np.full(old.shape, complex(np.inf)), where=np.abs(old) > 0.0)
    change, turn = np.abs(ratio) - 1.0, np.angle(ratio)
    refused = (np.abs(change) > LARGEST_CHANGE) | (np.abs(turn) > LARGEST_TURN)
    influence, covariance = old.copy(), saved.covariance.copy()
    for s in range(len(old)):
        if refused[s].any() or not np.isfinite(new[s]).all():
            continue
        influence[s], covariance[s] = _combined(
            old[s], saved.covariance[s], saved.sessions, new[s], fit.covariance[s, 1:, 1:]
        )
    return Learned(SavedInfluence(influence, covariance, saved.sessions + 1), refused, change, turn)


def typical(influences: ComplexArray) -> SavedInfluence:
    """Coefficients (N, S, P) of N machines of one type as one: their mean, and their spread as its covariance.

    The covariance is that of the next machine, not of the mean. Raises NumericsError for fewer than two machines.
    """
    count = len(influences)
    if influences.ndim != 3 or count < 2:
        raise NumericsError(Message("numerics.coefficients_of_type_shape", shape=influences.shape), field="influences")
    mean = influences.mean(axis=0)
    away = influences - mean
    spread = np.einsum("nsp,nsq->spq", away, away.conj()) / (2.0 * (count - 1)) * (1.0 + 1.0 / count)
    return SavedInfluence(mean, spread, count)


def _between(off: ComplexArray, spread: ComplexArray) -> ComplexArray:
    """What two sessions differ by beyond their covariances, as a covariance: they never become surer than that."""
    excess = float(np.vdot(off, np.linalg.solve(spread.T, off)).real) / (2.0 * len(off))
    return 0.5 * np.outer(off, off.conj()) if excess > _SPREAD else np.zeros_like(spread)


def _combined(
    old: ComplexArray, old_spread: ComplexArray, sessions: int, new: ComplexArray, new_spread: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    if np.isfinite(old_spread).all() and np.isfinite(new_spread).all():
        # Old and new are independent: the gain is C_old (C_old + C_new)^-1. Rows of A err as row vectors.
        gain = np.linalg.solve((old_spread + new_spread).T, old_spread.T).T
        return old + gain @ (new - old), old_spread - gain @ old_spread + _between(new - old, old_spread + new_spread)
    return old + (new - old) / (sessions + 1), np.full_like(old_spread, complex(np.nan, np.nan))
