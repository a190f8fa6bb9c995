"""What the runs of a machine err by: stated of it, learned from its runs, or usual; and the pieces on its rotor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from service.balancing.influence.fit import KNOWN_SCATTER, RunSet
from service.balancing.influence.run_errors import (
    ANGLE_SD,
    MASS_SD,
    REPEATABILITY,
    Errors,
    Pieces,
    Repeats,
    learned,
    repeats_of,
)
from service.balancing.rotor.phasors import phasor
from service.engine.validation import plane_index
from service.model.correction import Repeatability
from service.model.machine import Machine, Uncertainty
from service.model.run import Run

Key = tuple[str, float, float]
"""Plane, mass in g and angle in degrees of a piece: two of the same in one plane cannot be told apart."""


@dataclass(frozen=True)
class KnownErrors:
    """The errors as numbers, and the repeatability among them as it is shown."""

    errors: Errors
    repeatability: Repeatability


def errors_of(machine: Machine, sets: Sequence[RunSet], before: Repeats | None = None) -> KnownErrors:
    """What the runs of sessions on a machine err by; before: what its earlier sessions told of its repeatability."""
    stated = machine.uncertainty or Uncertainty()
    found = learned((*(repeats_of(one) for one in sets), *(() if before is None else (before,))))
    if stated.repeatability is not None:
        shown = Repeatability(share=stated.repeatability, source="stated", degrees_of_freedom=None)
    elif found.dof:
        shown = Repeatability(share=found.share, source="learned", degrees_of_freedom=found.dof)
    else:
        shown = Repeatability(share=REPEATABILITY, source="default", degrees_of_freedom=None)
    worse = shown.source == "learned" and shown.share > REPEATABILITY
    angle = stated.angle_sd_deg
    errors = Errors(
        repeatability=shown.share,
        drift=stated.drift_per_run or 0.0,
        mass_sd=MASS_SD if stated.mass_sd is None else stated.mass_sd,
        angle_sd=ANGLE_SD if angle is None else float(np.radians(angle)),
        dof=found.dof if worse else KNOWN_SCATTER,
    )
    return KnownErrors(errors, shown)


def pieces_of(machine: Machine, runs: Sequence[Run]) -> tuple[Pieces, tuple[Key, ...]]:
    """The pieces of all runs: one that is stated in several runs with the same place and mass is the same piece."""
    on: dict[Key, list[bool]] = {}
    for k, run in enumerate(runs):
        for mass in run.masses:
            key = (mass.plane, mass.mass_g, mass.angle_deg % 360.0)
            on.setdefault(key, [False] * len(runs))[k] = True
    keys = tuple(on)
    pieces = Pieces(
        plane=np.array([plane_index(machine, plane, "masses") for plane, _, _ in keys], dtype=np.int64),
        mass=np.array([phasor(grams, angle, machine.angle_sense) for _, grams, angle in keys], dtype=np.complex128),
        on=np.array([on[key] for key in keys], dtype=bool).reshape(len(keys), len(runs)).T,
    )
    return pieces, keys
