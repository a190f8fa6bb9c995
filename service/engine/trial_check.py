"""A trial mass before the drum turns with it, and what it did right after its run."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from service.balancing.influence.trial_mass import GRAVITY, SHARE_OF_LOAD, centrifugal_force
from service.engine.balance_quality import carried_kg
from service.engine.mapping import vectors_with_phase
from service.engine.validation import plane_index
from service.errors import InvalidInput
from service.messages import Message, Quantity
from service.model.machine import Machine
from service.model.run import MassOnRotor, Run, RunOut

MAX_SHARE = 1.0
"""Share of the static load of its bearing above which the force of a trial mass lifts the drum: refused."""
TIMES_SUGGESTED = 3.0
"""A trial mass is asked about where it is this many times the suggested one, or this many times less."""
MIN_CHANGE = 0.3
"""Share by which a trial mass must change an amplitude, or `MIN_TURN_DEG` its phase: the rule of the field."""
MIN_TURN_DEG = 30.0
NO_CHANGE = 0.03
"""Change of every vector, as a share of it, at which a run repeats the one before: no mass was on."""

Doubt = Literal["force_large", "mass_above_suggested", "mass_below_suggested"]
Answer = Literal["clear", "small", "none"]


@dataclass(frozen=True)
class TrialForce:
    """Force of a trial mass at service speed, N; share: of the static load of its bearing, None where unknown."""

    mass_g: float
    force_n: float
    share: float | None
    doubts: tuple[Doubt, ...]

    @property
    def bearable(self) -> bool:
        """Whether the drum may turn with it."""
        return self.share is None or self.share <= MAX_SHARE


@dataclass(frozen=True)
class TrialEffect:
    """What a trial mass did to one sensor: change of its vector and of its amplitude as shares, turn in degrees."""

    sensor: str
    change: float
    amplitude_change: float
    turn_deg: float | None

    @property
    def clear(self) -> bool:
        """Whether the rule of the field is met: 30 % or 30 degrees."""
        turned = self.turn_deg is not None and abs(self.turn_deg) >= MIN_TURN_DEG
        return abs(self.amplitude_change) >= MIN_CHANGE or turned


def force_of(machine: Machine, plane: str, mass_g: float, suggested_g: float | None = None) -> TrialForce:
    """Compare the force of a trial mass with the static load of its bearing, and the mass with the suggested one."""
    p = plane_index(machine, plane, "plane")
    force = centrifugal_force(abs(mass_g), machine.planes[p].radius_mm, machine.service_speed_rpm)
    load = carried_kg(machine, p) * GRAVITY
    share = force / load if load > 0.0 else None
    doubts: list[Doubt] = []
    if share is not None and share > SHARE_OF_LOAD * (1.0 + 1e-9):
        doubts.append("force_large")
    if suggested_g is not None and abs(mass_g) > TIMES_SUGGESTED * suggested_g:
        doubts.append("mass_above_suggested")
    if suggested_g is not None and abs(mass_g) * TIMES_SUGGESTED < suggested_g:
        doubts.append("mass_below_suggested")
    return TrialForce(mass_g, force, share, tuple(doubts))


def require_bearable(machine: Machine, masses: Sequence[MassOnRotor]) -> None:
    """Refuse masses that pull harder at service speed than their bearing carries at rest. Raises InvalidInput."""
    for index, mass in enumerate(masses):
        found = force_of(machine, mass.plane, mass.mass_g)
        if not found.bearable:
            raise InvalidInput(
                Message(
                    "trial_force_too_great",
                    mass=Quantity(mass.mass_g, "g"),
                    force=Quantity(found.force_n, "N"),
                    share=found.share,
                ),
                field=f"masses[{index}].mass_g" if len(masses) > 1 else "masses.mass_g",
                value=mass.mass_g,
            )


def effect_of(machine: Machine, before: Run, after: Run, run_out: Sequence[RunOut]) -> tuple[TrialEffect, ...]:
    """Compare a run with an earlier one, sensor by sensor; sensors without an amplitude in both are left out."""
    old, new = (vectors_with_phase(machine, run, run_out) for run in (before, after))
    plain = [{r.sensor: r.amplitude for r in run.readings} for run in (before, after)]
    out = []
    for sensor in machine.sensors:
        name = sensor.name
        if name in old and name in new and abs(old[name]) > 0.0:
            turn = math.degrees(cmath.phase(new[name] / old[name])) if abs(new[name]) > 0.0 else 0.0
            size = abs(new[name]) / abs(old[name]) - 1.0
            out.append(TrialEffect(name, abs(new[name] - old[name]) / abs(old[name]), size, turn))
        elif all(name in one for one in plain) and plain[0][name] > 0.0:
            size = plain[1][name] / plain[0][name] - 1.0
            out.append(TrialEffect(name, abs(size), size, None))
    return tuple(out)


def answer_of(effects: Sequence[TrialEffect]) -> Answer:
    """Judge a trial run: clear, small (no sensor meets the rule of the field), or none (it repeats the run before)."""
    if any(effect.clear for effect in effects):
        return "clear"
    return "none" if all(effect.change <= NO_CHANGE for effect in effects) else "small"
