"""A helical gear pair sized for tooth bending and flank pressure (a Lewis type of sizing, not ISO 6336).

Two models. `sound`: forces in N, lengths in mm, angles taken as degrees where they are degrees. `as_printed`: the
formulas of the source (B.Tech thesis, 2014) as its tables follow from them: the cosine of 20 radians, pitch line
velocity in mm/s where m/s is meant, a stray factor of a million in the bending load, penalties of slope 1. It is kept
to reproduce the tables and to show what is wrong in them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from service.mechanics.bodies import FloatArray
from service.mechanics.refusals import Refusal
from service.messages import Message

Cut = Literal[
    "ordinary",
    "careful",
    "cut_and_ground",
    "hobbed",
    "precision_with_dynamic_load",
    "precision",
    "hardened_and_lapped",
    "non_metallic",
]
CUTS: tuple[Cut, ...] = (
    "ordinary",
    "careful",
    "cut_and_ground",
    "hobbed",
    "precision_with_dynamic_load",
    "precision",
    "hardened_and_lapped",
    "non_metallic",
)
"""Kinds of cut; the source numbers them 1 to 8."""
STEEL = 7850e-9
"""Density of the sound model, kg/mm3."""
PRINTED_DENSITY = 7730.14
"""kg/m3; recovered from the printed tables."""
PRINTED_PI = 3.14
SLENDER, STOUT = 20.0, 40.0
"""Limits of the face width in modules."""


@dataclass(frozen=True)
class GearDuty:
    """What a pair must carry. power: W; speed: of the pinion, rad/s; helix: rad; stresses: N/mm2.

    working_factor, overlap_ratio, stress_concentration, material_factor, flank_factor, overlap_factor: of the source.
    """

    power: float
    speed: float
    ratio: float
    hardness: float
    strength: float
    helix: float
    cut: Cut
    working_factor: float = 1.25
    overlap_ratio: float = 1.6
    stress_concentration: float = 1.5
    material_factor: float = 271.11
    flank_factor: float = 1.76
    overlap_factor: float = 0.79

    def __post_init__(self) -> None:
        """Refuse data that no pair can have."""
        positive = {
            "power": self.power,
            "speed": self.speed,
            "hardness": self.hardness,
            "strength": self.strength,
            "working_factor": self.working_factor,
            "stress_concentration": self.stress_concentration,
            "material_factor": self.material_factor,
            "flank_factor": self.flank_factor,
            "overlap_factor": self.overlap_factor,
        }
        for name, value in positive.items():
            if not (math.isfinite(value) and value > 0.0):
                raise Refusal(Message("gear_not_positive", field=name, value=value))
        if not (math.isfinite(self.ratio) and self.ratio >= 1.0):
            raise Refusal(Message("gear_ratio", field="ratio", value=self.ratio))
        if not (math.isfinite(self.overlap_ratio) and self.overlap_ratio >= 1.0):
            raise Refusal(Message("gear_overlap", field="overlap_ratio", value=self.overlap_ratio))
        if not 0.0 <= self.helix < math.pi / 4.0:
            raise Refusal(Message("gear_helix", field="helix", value=math.degrees(self.helix)))

    @property
    def revolutions(self) -> float:
        """Pinion speed in r/min, the unit of the source's formulas."""
        return self.speed * 30.0 / math.pi


@dataclass(frozen=True)
class Pair:
    """Responses of pairs (...). Lengths in mm, velocity m/s, force N, mass kg; loads as parts of the allowable."""

    diameter: FloatArray
    velocity: FloatArray
    tangential: FloatArray
    dynamic: FloatArray
    form: FloatArray
    bending: FloatArray
    contact: FloatArray
    mass: FloatArray
    distance: FloatArray


def dynamic_factor(cut: Cut, velocity: FloatArray, *, printed: bool = False) -> FloatArray:
    """Dynamic factor kd (...) of a kind of cut at pitch line velocities (...), m/s.

    printed: as the source's program has it, where precision with dynamic load has half instead of the square root.
    """
    v = np.asarray(velocity, dtype=np.float64)
    root = np.sqrt(200.0 * v)
    precise = 78.0 / (78.0 + root)
    table: dict[Cut, FloatArray] = {
        "ordinary": 3.0 / (3.0 + v),
        "careful": 4.5 / (4.5 + v),
        "cut_and_ground": 6.0 / (6.0 + v),
        "hobbed": 50.0 / (50.0 + root),
        "precision_with_dynamic_load": precise / 2.0 if printed else np.sqrt(precise),
        "precision": np.ones_like(v),
        "hardened_and_lapped": 5.6 / (5.6 + np.sqrt(v)),
        "non_metallic": 0.75 / (1.0 + v) + 0.25,
    }
    return table[cut]


def pair(duty: GearDuty, module: FloatArray, width: FloatArray, teeth: FloatArray) -> Pair:
    """Responses of the sound model for modules and widths in mm and whole numbers of pinion teeth (...)."""
    cosine, ratio = math.cos(duty.helix), duty.ratio
    torque = duty.working_factor * duty.power * 1e3 / duty.speed
    diameter = module * teeth / cosine
    velocity = math.pi * diameter * duty.revolutions / 60000.0
    tangential = 2.0 * torque / diameter
    dynamic = dynamic_factor(duty.cut, velocity)
    form = math.pi * (0.154 - 0.912 * cosine**3 / teeth)
    allowed = duty.overlap_ratio * module * form * 0.55 * duty.strength
    bending = tangential * duty.stress_concentration / (dynamic * width * allowed)
    flank = (duty.material_factor * duty.flank_factor * duty.overlap_factor * math.sqrt(cosine)) ** 2
    contact = flank * tangential * (1.0 + ratio) / ratio / (dynamic * width * diameter * (duty.hardness / 4.0) ** 2)
    return Pair(
        diameter,
        velocity,
        tangential,
        dynamic,
        form,
        bending,
        contact,
        math.pi / 4.0 * diameter**2 * (1.0 + ratio**2) * width * STEEL,
        diameter * (1.0 + ratio) / 2.0,
    )


def least_width(duty: GearDuty, module: FloatArray, teeth: FloatArray) -> FloatArray:
    """Least face width (...) in mm that carries the load: bending and contact both go as 1 / width."""
    one = pair(duty, module, np.ones_like(module), teeth)
    return np.maximum(one.bending, one.contact)


@dataclass(frozen=True)
class Printed:
    """Parts of the printed objective (...): cost, and the four penalties."""

    cost: FloatArray
    bending: FloatArray
    contact: FloatArray
    slender: FloatArray
    stout: FloatArray

    @property
    def value(self) -> FloatArray:
        """Cost and penalties of slope 1."""
        return self.cost + self.bending + self.contact + self.slender + self.stout


def printed_loads(duty: GearDuty) -> tuple[float, float]:
    """The printed bending load L and contact load G; cosines of degrees taken as radians."""
    n, kilowatts = duty.revolutions, duty.power / 1e3
    bending = (
        duty.stress_concentration * kilowatts * 1e6 * math.cos(20.0) * 2.0
        / (n * 2.0 * PRINTED_PI * duty.overlap_ratio * 0.55 * duty.strength)
    ) * 1e6  # fmt: skip
    helix = math.degrees(duty.helix)
    flank = (duty.material_factor * duty.flank_factor * duty.overlap_factor) ** 2 * math.cos(helix) * math.cos(20.0)
    contact = flank * 60.0 * kilowatts * 1e6 / (n * PRINTED_PI * duty.ratio * (duty.hardness / 4.0) ** 2)
    return bending, contact


def as_printed(duty: GearDuty, module: FloatArray, width: FloatArray, teeth: FloatArray, weight: float) -> Printed:
    """The printed objective; weight: of the mass against the centre distance."""
    square = module**2 * width * teeth**2
    velocity = PRINTED_PI * module * teeth * duty.revolutions / 60.0
    form = 0.48356 * teeth - 2.86368
    dynamic = dynamic_factor(duty.cut, velocity, printed=True)
    mass = 7.7005 * square * PRINTED_DENSITY * (1.0 + duty.ratio**2) / 1e9
    distance = 0.5 * module * teeth * (1.0 + duty.ratio) / 1000.0
    bending, contact = printed_loads(duty)
    return Printed(
        weight * mass + (1.0 - weight) * distance,
        np.maximum(0.0, bending - square / (dynamic * form)),
        np.maximum(0.0, contact - square / dynamic),
        np.maximum(0.0, SLENDER * module - width),
        np.maximum(0.0, width - STOUT * module),
    )
