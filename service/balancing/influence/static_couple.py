"""Static and couple parts of a two-plane answer, and fits in such modes instead of planes.

A static pair has its resultant at the mass centre and no moment about it; a couple pair has a moment and no resultant.
Any other set of modes (columns of mass ratios, for example of a flexible rotor's modes) is used in the same way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from service.balancing.influence.fit import RunSet
from service.balancing.rotor.labels import Labels
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.errors import NumericsError
from service.messages import Message


@dataclass(frozen=True)
class StaticCouple:
    """Two-plane masses taken apart: static + couple = masses, each (2,) complex g.

    unbalance: complex g.mm, the resultant. moment: complex g.mm^2 about the mass centre.
    """

    static: ComplexArray
    couple: ComplexArray
    unbalance: complex
    moment: complex


def static_couple_modes(radius_mm: FloatArray, axial_mm: FloatArray) -> FloatArray:
    """Columns (2, 2): masses in the planes of a static pair, 1 g in the first, and of a couple pair, 1 g in the first.

    axial_mm: (2,) measured from the mass centre. Raises NumericsError for planes on one side of the mass centre or in
    one place: a static pair there would need masses against each other, or does not exist.
    """
    z, radius = np.asarray(axial_mm, dtype=np.float64), np.asarray(radius_mm, dtype=np.float64)
    if z.shape != (2,) or radius.shape != (2,) or not (radius > 0.0).all() or not z[0] * z[1] < 0.0:
        raise NumericsError(
            Message("numerics.planes_on_one_side", places=z.tolist()), field="axial_mm", value=z.tolist()
        )
    static = np.array([1.0, -radius[0] * z[0] / (radius[1] * z[1])])
    couple = np.array([1.0, -radius[0] / radius[1]])
    return np.stack([static, couple], axis=1)


def decompose(masses: ComplexArray, radius_mm: FloatArray, axial_mm: FloatArray) -> StaticCouple:
    """Take two-plane masses (2,) complex g apart; errors as `static_couple_modes`."""
    modes = static_couple_modes(radius_mm, axial_mm)
    amounts = np.linalg.solve(modes, masses)
    unbalance = masses * radius_mm
    return StaticCouple(
        static=modes[:, 0] * amounts[0],
        couple=modes[:, 1] * amounts[1],
        unbalance=complex(unbalance.sum()),
        moment=complex((unbalance * axial_mm).sum()),
    )


def in_modes(runs: RunSet, modes: FloatArray, names: tuple[str, ...] = ()) -> RunSet:
    """Runs whose masses are stated in modes (P, Q) instead of planes, so that a fit needs Q + 1 runs.

    With the static mode alone, one run with a static pair corrects the static part; the couple pair follows. A
    correction in modes becomes masses in planes by `modes @ correction.masses`. Raises NumericsError for masses that
    the modes cannot make.
    """
    amounts = np.linalg.lstsq(modes, runs.masses.T, rcond=None)[0]
    missed = np.abs(modes @ amounts - runs.masses.T).max(axis=0)
    wrong = np.flatnonzero(missed > 1e-6 * np.abs(runs.masses).max(initial=1e-300))
    if len(wrong):
        raise NumericsError(
            Message("numerics.masses_not_of_modes", run=runs.labels.run(int(wrong[0])), count=modes.shape[1]),
            field="masses",
            value=int(wrong[0]),
        )
    labels = Labels(runs.labels.runs, names, runs.labels.sensors)
    return RunSet(np.ascontiguousarray(amounts.T), runs.vibration, runs.scatter, labels)


def decoupled(influence: ComplexArray, initial: ComplexArray, modes: FloatArray) -> ComplexArray:
    """Masses (2,) by the classic static-couple method: each mode corrected by its own part of the vibration.

    influence (2, 2) per g and initial (2,) of one sensor at each end. Half the sum of the two readings is corrected
    with the static pair, half the difference with the couple pair, and what each does to the other is left out: good
    for rotors and supports alike at both ends, otherwise worse than least squares.
    """
    if influence.shape != (2, 2) or initial.shape != (2,):
        raise NumericsError(Message("numerics.static_couple_size"), field="influence")
    parts = np.array([[0.5, 0.5], [0.5, -0.5]])
    own = (parts @ influence @ modes).diagonal()
    if not (np.abs(own) > 0.0).all():
        raise NumericsError(Message("numerics.mode_without_effect"), field="influence")
    return np.asarray(modes @ (-(parts @ initial) / own))
