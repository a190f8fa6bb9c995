"""A rigid drum on two elastic, damped bearings: mechanics only.

Frame: an observer stands at the positive axial end and looks at the drum; x points to the right, y up, z along the axis
towards the observer (right-handed), its origin in the mass centre. `ccw` and `cw` are as this observer sees them.
Rotor-fixed angles are geometric: counter-clockwise from the key-phasor mark, whatever the direction of rotation. At
t = 0 the mark points along x, so at time t it points to the angle s w t, with s = +1 for ccw and -1 for cw.

Coordinates q = (x, y, a, b): the axis stands at x + a z and y + b z. With mass M, transverse and polar moment of
inertia It and Ip about the mass centre, and forces F at the axial places z (small tilts; angular momentum):

    M x'' = sum Fx          It a'' + Ip s w b' = sum z Fx
    M y'' = sum Fy          It b'' - Ip s w a' = sum z Fy

An unbalance of amount U at the rotor angle g pulls with U w^2 towards the angle s w t + g. Bearings pull back with
stiffness and damping along two perpendicular axes of their own. Masses are taken as small against the drum: they add
unbalance, no inertia. A point of the drum at X, Y beside the axis moves along it by -(a X + b Y); housings follow.
Every signal is a real time signal Re(p exp(j w t)) of its phasor p.
The equations are Newton's and Euler's for a spinning rigid body; tests/drivers/simulator/test_rotor.py
integrates them in time.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from drivers.checks import require, require_finite

Rotation = Literal["cw", "ccw"]
SPIN: dict[Rotation, int] = {"ccw": 1, "cw": -1}
G_MM = 1e-6
"""kg m in one g mm."""


@dataclass(frozen=True, slots=True)
class Bearing:
    """Support at axial_mm from the mass centre: stiffness in N/m and damping in N s/m along its own x and y axes.

    The axes stand axes_deg counter-clockwise from the frame's. All four are > 0: undamped resonance has no bound.
    """

    name: str
    axial_mm: float
    stiffness_x: float
    stiffness_y: float
    damping_x: float
    damping_y: float
    axes_deg: float = 0.0

    def __post_init__(self) -> None:
        require_finite(self)
        for name in ("stiffness_x", "stiffness_y", "damping_x", "damping_y"):
            require(getattr(self, name) > 0.0, f"{name} {getattr(self, name)} of bearing {self.name!r}", "be > 0")


@dataclass(frozen=True, slots=True)
class Rotor:
    """Rigid drum: mass, moments of inertia about the mass centre (kg m2), two bearings at different places."""

    mass_kg: float
    polar_inertia: float
    transverse_inertia: float
    bearings: tuple[Bearing, Bearing]

    def __post_init__(self) -> None:
        require_finite(self)
        for name in ("mass_kg", "polar_inertia", "transverse_inertia"):
            require(getattr(self, name) > 0.0, f"{name} {getattr(self, name)}", "be > 0")
        require(len(self.bearings) == 2, f"number of bearings {len(self.bearings)}", "be two")
        first, second = self.bearings
        require(first.axial_mm != second.axial_mm, f"axial_mm {first.axial_mm} of both bearings", "differ")
        require(first.name != second.name, f"name {first.name!r} of both bearings", "differ")


@dataclass(frozen=True, slots=True)
class Unbalance:
    """Amount in g mm at axial_mm from the mass centre, at a geometric rotor-fixed angle (see the module)."""

    axial_mm: float
    amount_g_mm: float
    angle_deg: float

    def __post_init__(self) -> None:
        require_finite(self)


@dataclass(frozen=True, slots=True)
class Bend:
    """The journals of a bent shaft stand at tilt_mrad to its axis of rotation, towards a geometric rotor-fixed angle.

    The housings rock with them once a turn, whatever the speed. What the bend does to the drum between the bearings is
    unbalance like any other, and belongs to the unbalances.
    """

    tilt_mrad: float
    angle_deg: float

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.tilt_mrad >= 0.0, f"tilt_mrad {self.tilt_mrad} of the bend", "be >= 0")


@dataclass(frozen=True, slots=True)
class Motion:
    """Steady motion at omega rad/s: phasors (4,) of x, y in m and the tilts a, b in rad, peak values.

    rocking: phasors of the tilts a, b that the housings make on their own, by a bend.
    """

    omega: float
    spin: int
    phasors: NDArray[np.complex128]
    rocking: tuple[complex, complex] = (0j, 0j)

    def centre(self, axial_mm: float) -> NDArray[np.complex128]:
        """Phasors (2,) of the axis at axial_mm: x and y displacement, m, peak."""
        z = axial_mm / 1000.0
        return self.phasors[:2] + z * self.phasors[2:]

    def displacement(self, axial_mm: float, direction_deg: float) -> complex:
        """Phasor of the displacement at axial_mm towards direction_deg (ccw from x, fixed in space), m, peak."""
        turn = math.radians(direction_deg)
        x, y = self.centre(axial_mm)
        return complex(x * math.cos(turn) + y * math.sin(turn))

    def along_axis(self, arm_mm: float, direction_deg: float) -> complex:
        """Phasor of a housing's displacement along z, m, peak: at arm_mm from the axis, direction_deg ccw from x."""
        turn = math.radians(direction_deg)
        a, b = self.phasors[2] + self.rocking[0], self.phasors[3] + self.rocking[1]
        return complex(-arm_mm / 1000.0 * (a * math.cos(turn) + b * math.sin(turn)))

    def bent(self, bend: Bend) -> Motion:
        """Return the same motion of a drum whose shaft is bent: a = t cos(s w t + g) and b = t sin(s w t + g) more."""
        turn = bend.tilt_mrad / 1000.0 * np.exp(1j * self.spin * math.radians(bend.angle_deg))
        return replace(self, rocking=(complex(turn), complex(-1j * self.spin * turn)))

    def reaction(self, bearing: Bearing) -> NDArray[np.complex128]:
        """Phasors (2,) of the force on the bearing, x and y, N, peak."""
        stiffness, damping = bearing_matrices(bearing)
        return np.asarray((stiffness + 1j * self.omega * damping) @ self.centre(bearing.axial_mm))


def steady_motion(rotor: Rotor, unbalances: Iterable[Unbalance], speed_rpm: float, rotation: Rotation) -> Motion:
    """Motion that the unbalances keep up at a constant speed, after all transients.

    Raises `InvalidSetting` for a speed that is not positive.
    """
    require(math.isfinite(speed_rpm) and speed_rpm > 0.0, f"speed {speed_rpm} rpm", "be a number above 0")
    omega = speed_rpm * math.tau / 60.0
    spin = SPIN[rotation]
    mass, damping, stiffness = matrices(rotor, spin * omega)
    force = sum((force_phasors(one, omega, spin) for one in unbalances), np.zeros(4, complex))
    # never singular: the dampers take power from every motion, the gyroscopic part takes none
    phasors = np.linalg.solve(stiffness + 1j * omega * damping - omega**2 * mass, force)
    return Motion(omega, spin, np.asarray(phasors, complex))


def force_phasors(unbalance: Unbalance, omega: float, spin: int) -> NDArray[np.complex128]:
    """Generalised force (4,): Fx, Fy in N and their moments z Fx, z Fy in N m.

    Fx = U w^2 cos(s w t + g) and Fy = U w^2 sin(s w t + g), each written as the real part of phasor times exp(j w t).
    """
    pull = unbalance.amount_g_mm * G_MM * omega**2
    turn = np.exp(1j * spin * math.radians(unbalance.angle_deg))
    plane = np.array([pull * turn, -1j * spin * pull * turn])
    return np.concatenate([plane, plane * unbalance.axial_mm / 1000.0])


def matrices(rotor: Rotor, spin_rad_s: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Mass, damping with gyroscopic part, and stiffness, (4, 4) each, for q = (x, y, a, b); signed speed in rad/s."""
    mass = np.diag([rotor.mass_kg, rotor.mass_kg, rotor.transverse_inertia, rotor.transverse_inertia])
    damping = np.zeros((4, 4))
    damping[2, 3] = rotor.polar_inertia * spin_rad_s
    damping[3, 2] = -rotor.polar_inertia * spin_rad_s
    stiffness = np.zeros((4, 4))
    for bearing in rotor.bearings:
        held, damped = _support(bearing)
        stiffness += held
        damping += damped
    return mass, damping, stiffness


@lru_cache(maxsize=64)  # a drum turns for thousands of readings in the same bearings
def _support(bearing: Bearing) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stiffness and damping (4, 4) that a bearing adds; not to be written to."""
    z = bearing.axial_mm / 1000.0
    lever = np.array([[1.0, z], [z, z * z]])
    stiffness, damping = bearing_matrices(bearing)
    return np.kron(lever, stiffness), np.kron(lever, damping)


def bearing_matrices(bearing: Bearing) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stiffness and damping (2, 2) of a bearing in the frame's x and y."""
    turn = math.radians(bearing.axes_deg)
    axes = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    stiffness = axes @ np.diag([bearing.stiffness_x, bearing.stiffness_y]) @ axes.T
    damping = axes @ np.diag([bearing.damping_x, bearing.damping_y]) @ axes.T
    return stiffness, damping
