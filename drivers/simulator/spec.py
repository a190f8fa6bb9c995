"""The description of a simulated drum, the pieces bolted to it, and what its instruments read when nothing scatters."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

from drivers.checks import require, require_distinct, require_finite, require_known
from drivers.simulator.rotor import SPIN, Motion, Rotation, Rotor, Unbalance, steady_motion
from drivers.simulator.sensors import Sensor, lag_degrees, sense

AngleSense = Literal["against_rotation", "with_rotation"]
PhaseSense = Literal["lag", "lead"]


@dataclass(frozen=True, slots=True)
class Plane:
    """Correction plane at axial_mm from the mass centre; positions_deg: drilled angles in the drum's angle sense."""

    name: str
    radius_mm: float
    axial_mm: float
    positions_deg: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.radius_mm > 0.0, f"radius_mm {self.radius_mm} of plane {self.name!r}", "be > 0")


@dataclass(frozen=True, slots=True)
class FittedMass:
    """A piece bolted into a plane at its radius: angle_deg from the key-phasor mark, in the drum's angle sense."""

    plane: str
    mass_g: float
    angle_deg: float

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.mass_g > 0.0, f"mass_g {self.mass_g} in plane {self.plane!r}", "be > 0; leave out what is off")


@dataclass(frozen=True, slots=True)
class Scatter:
    """How readings of an unchanged drum differ; all standard deviations, all zero by default.

    amplitude (relative) and phase_deg: each reading of each sensor on its own. run_amplitude (relative) and
    run_phase_deg: drawn for each sensor when a run starts, kept throughout it. run_speed (relative): speed against the
    nominal one, drawn when a run starts. What adds to a signal instead is the sensor's own `noise`.
    """

    amplitude: float = 0.0
    phase_deg: float = 0.0
    run_amplitude: float = 0.0
    run_phase_deg: float = 0.0
    run_speed: float = 0.0

    def __post_init__(self) -> None:
        require_finite(self)
        for name in ("amplitude", "run_amplitude", "run_speed"):
            value = getattr(self, name)
            require(0.0 <= value <= 0.2, f"scatter {name} {value}", "be within 0 and 0.2, as a fraction of the value")
        for name in ("phase_deg", "run_phase_deg"):
            require(0.0 <= getattr(self, name) <= 60.0, f"scatter {name} {getattr(self, name)}", "be within 0 and 60")


@dataclass(frozen=True, slots=True)
class DrumSpec:
    """A drum with its unbalance and its instruments.

    Fixed in space (frame of drivers.simulator.rotor, seen_from names the observer's, positive axial, end): rotation,
    sensor directions, pickup_deg where the key-phasor's pick-up stands. unbalances: what is wrong with the bare drum,
    at geometric angles. angle_sense: how angles of fitted masses are stated, `against_rotation` or `with_rotation` from
    the mark. phase_sense: how phases are reported. speed_rpm: speed of service.
    """

    name: str
    rotor: Rotor
    planes: tuple[Plane, ...]
    sensors: tuple[Sensor, ...]
    unbalances: tuple[Unbalance, ...]
    speed_rpm: float
    rotation: Rotation = "ccw"
    angle_sense: AngleSense = "against_rotation"
    phase_sense: PhaseSense = "lag"
    pickup_deg: float = 0.0
    seen_from: str = "positive axial end"
    scatter: Scatter = field(default_factory=Scatter)

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.speed_rpm > 0.0, f"speed_rpm {self.speed_rpm}", "be > 0")
        require(bool(self.sensors), "number of sensors 0", "be one or more")
        require_distinct((plane.name for plane in self.planes), "plane")
        require_distinct((sensor.name for sensor in self.sensors), "sensor")
        for name, value, rule in (
            ("rotation", self.rotation, ("cw", "ccw")),
            ("angle_sense", self.angle_sense, ("against_rotation", "with_rotation")),
            ("phase_sense", self.phase_sense, ("lag", "lead")),
        ):
            require(value in rule, f"{name} {value!r}", f"be one of {', '.join(rule)}")

    @property
    def spin(self) -> int:
        """+1 for ccw, -1 for cw."""
        return SPIN[self.rotation]

    def plane(self, name: str) -> Plane:
        """Return the plane of this name; raises `InvalidSetting` naming the known ones."""
        require_known(name, (plane.name for plane in self.planes), "plane")
        return next(plane for plane in self.planes if plane.name == name)


def geometric_degrees(angle_deg: float, angle_sense: AngleSense, spin: int) -> float:
    """Geometric rotor angle (ccw from the mark) of an angle stated from the mark in `angle_sense`."""
    with_rotation = angle_deg if angle_sense == "with_rotation" else -angle_deg
    return spin * with_rotation


def stated_degrees(geometric_deg: float, angle_sense: AngleSense, spin: int) -> float:
    """Angle from the mark in `angle_sense`, 0 <= angle < 360, of a geometric rotor angle."""
    stated = geometric_degrees(geometric_deg, angle_sense, spin) % 360.0  # the mapping is its own inverse
    return 0.0 if stated >= 360.0 else stated


def unbalance_of(spec: DrumSpec, piece: FittedMass, *, angle_sense: AngleSense | None = None) -> Unbalance:
    """Unbalance that a fitted piece adds; angle_sense: the sense it was really counted in, the drum's own by default.

    Raises `InvalidSetting` for an unknown plane.
    """
    plane = spec.plane(piece.plane)
    geometric = geometric_degrees(piece.angle_deg, angle_sense or spec.angle_sense, spec.spin)
    return Unbalance(plane.axial_mm, piece.mass_g * plane.radius_mm, geometric)


def motion_of(spec: DrumSpec, masses: Iterable[FittedMass] = (), *, speed_rpm: float | None = None) -> Motion:
    """Steady motion of the drum with these pieces bolted on, at speed_rpm, else at the speed of service."""
    unbalances = [*spec.unbalances, *(unbalance_of(spec, piece) for piece in masses)]
    return steady_motion(spec.rotor, unbalances, speed_rpm or spec.speed_rpm, spec.rotation)


def stated_phase(spec: DrumSpec, phasor: complex) -> float:
    """Phase in degrees, 0 <= phase < 360, of a sensor's phasor, in the drum's phase sense."""
    lag = lag_degrees(phasor, spec.spin, spec.pickup_deg)
    return lag if spec.phase_sense == "lag" or lag == 0.0 else 360.0 - lag


def true_readings(
    spec: DrumSpec, masses: Iterable[FittedMass] = (), *, speed_rpm: float | None = None
) -> dict[str, tuple[float, float]]:
    """Amplitude (sensor's unit and detection) and phase in degrees (drum's sense) of each sensor, without scatter."""
    motion = motion_of(spec, masses, speed_rpm=speed_rpm)
    phasors = {sensor.name: sense(sensor, motion) for sensor in spec.sensors}
    return {name: (math.hypot(p.real, p.imag), stated_phase(spec, p)) for name, p in phasors.items()}
