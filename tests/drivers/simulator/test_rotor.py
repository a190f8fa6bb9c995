"""The mechanics against statics, closed forms, published reactions and an integration in time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from numpy.typing import NDArray

from drivers.errors import InvalidSetting
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.rotor import Bearing, Bend, Motion, Rotation, Rotor, Unbalance, steady_motion
from drivers.simulator.sensors import lag_degrees
from drivers.simulator.spec import DrumSpec
from tests.support.drivers.drums import drums

STIFF = 1e13
"""N/m: a bearing that does not give."""


def symmetric(stiffness: float, damping: float, *, polar: float = 5.0) -> Rotor:
    ends = (Bearing(n, z, stiffness, stiffness, damping, damping) for n, z in (("P", -400.0), ("Q", 400.0)))
    first, second = ends
    return Rotor(100.0, polar, 10.0, (first, second))


def amount(u_kg_m: complex) -> tuple[float, float]:
    return abs(u_kg_m) * 1e6, math.degrees(math.atan2(u_kg_m.imag, u_kg_m.real))


class TestLimits:
    def test_a_slow_drum_bends_its_bearings_as_the_force_standing_still_would(self) -> None:
        rotor = threshing_drum_example().rotor
        one = Unbalance(200.0, 5e4, 30.0)
        motion = steady_motion(rotor, [one], 1.0, "ccw")
        pull = 0.05 * motion.omega**2 * np.array([math.cos(math.radians(30.0)), math.sin(math.radians(30.0))])
        # statics of a beam on two springs: each bearing takes its share by the lever rule
        p, q = rotor.bearings
        share_q = (200.0 - p.axial_mm) / (q.axial_mm - p.axial_mm)
        for bearing, share in ((p, 1.0 - share_q), (q, share_q)):
            sag = share * pull / np.array([bearing.stiffness_x, bearing.stiffness_y])
            assert motion.centre(bearing.axial_mm).real == pytest.approx(sag, rel=1e-3)

    def test_the_lag_at_resonance_is_90_degrees_and_the_damper_alone_holds_it(self) -> None:
        stiffness, damping = 1e6, 500.0
        resonance = math.sqrt(2.0 * stiffness / 100.0)
        motion = steady_motion(
            symmetric(stiffness, damping), [Unbalance(0.0, 1e5, 0.0)], resonance * 60 / math.tau, "ccw"
        )
        expected = 0.1 * resonance**2 / (2.0 * damping * resonance)
        assert abs(motion.displacement(0.0, 0.0)) == pytest.approx(expected, rel=1e-9)
        assert lag_degrees(motion.displacement(0.0, 0.0), 1, 0.0) == pytest.approx(90.0, abs=1e-6)

    @pytest.mark.parametrize("rpm", [300.0, 1300.0, 5000.0])
    def test_a_static_unbalance_on_equal_bearings_follows_the_single_mass_formula(self, rpm: float) -> None:
        motion = steady_motion(symmetric(1e6, 500.0), [Unbalance(0.0, 1e5, 40.0)], rpm, "ccw")
        w = motion.omega
        response = 0.1 * w**2 / (2e6 - 100.0 * w**2 + 1j * w * 1000.0)
        assert motion.phasors[0] == pytest.approx(response * np.exp(1j * math.radians(40.0)), rel=1e-9)
        assert np.abs(motion.phasors[2:]).max() < 1e-15

    def test_a_couple_on_equal_bearings_tilts_without_moving_the_centre_and_the_spin_stiffens_it(self) -> None:
        pair = [Unbalance(300.0, 5e4, 0.0), Unbalance(-300.0, 5e4, 180.0)]
        for rotation in ("cw", "ccw"):
            motion = steady_motion(symmetric(1e6, 1e-6), pair, 900.0, rotation)
            w = motion.omega
            # synchronous whirl: (k_t - (It - Ip) w^2) tilt = couple, with k_t = 2 k l^2
            tilt = 0.05 * 0.6 * w**2 / (2e6 * 0.16 - (10.0 - 5.0) * w**2)
            assert np.abs(motion.phasors[:2]).max() < 1e-12
            assert motion.phasors[2] == pytest.approx(tilt, rel=1e-9)

    def test_far_above_resonance_the_drum_turns_about_its_mass_axis(self) -> None:
        motion = steady_motion(symmetric(1e5, 50.0), [Unbalance(0.0, 1e5, 0.0)], 60000.0, "ccw")
        assert motion.phasors[0] == pytest.approx(-0.1 / 100.0, rel=1e-3)

    def test_a_drum_at_rest_and_a_bearing_without_damping_are_refused(self) -> None:
        for rpm in (0.0, -460.0, math.nan, math.inf):
            with pytest.raises(InvalidSetting, match="speed"):
                steady_motion(symmetric(1e6, 100.0), [], rpm, "ccw")
        with pytest.raises(InvalidSetting, match=r"damping_x 0\.0 of bearing 'P'"):
            symmetric(1e6, 0.0)


class TestReactions:
    """Reactions of a rigid rotor, published for these three cases to 0.01 N.

    Thesis "dynamic performance improvement of the thresher machine", chapter 5, Eq 5.4 as corrected: reactions with no
    correction mass. Products of inertia are posed as the couple that has the same moment.
    """

    @pytest.mark.parametrize(
        ("mass", "rpm", "e_mm", "product", "places", "published"),
        [
            (60.0, 1500.0, 1.00 + 0.25j, 0.0, (-200.0, 300.0), (915.60, 610.40)),
            (60.0, 1500.0, 1.00 + 0.25j, -0.004 - 0.01j, (-200.0, 300.0), (742.27, 1017.34)),
            (120.0, 460.0, -0.154 + 1.20j, 0.0, (-480.0, 440.0), (161.12, 175.77)),
        ],
        ids=["static", "dynamic", "drum"],
    )
    def test_unyielding_bearings_carry_the_published_forces(
        self, mass: float, rpm: float, e_mm: complex, product: complex, places: tuple[float, float],
        published: tuple[float, float],
    ) -> None:  # fmt: skip
        p, q = (Bearing(n, z, STIFF, STIFF, 1.0, 1.0) for n, z in zip("PQ", places, strict=True))
        rotor = Rotor(mass, 2.0, 5.0, (p, q))
        arm = 0.25
        unbalances = [Unbalance(0.0, *amount(mass * e_mm / 1000.0))]
        unbalances += [Unbalance(side * 1000.0 * arm, *amount(-side * product / (2.0 * arm))) for side in (1, -1)]
        motion = steady_motion(rotor, unbalances, rpm, "ccw")
        found = [abs(complex(motion.reaction(bearing)[0])) for bearing in (p, q)]
        assert found == pytest.approx(published, abs=0.005)

    @given(drums())
    def test_reactions_and_inertia_balance_the_unbalance(self, spec: DrumSpec) -> None:
        motion = steady_motion(spec.rotor, spec.unbalances, spec.speed_rpm, spec.rotation)
        angles = [motion.spin * math.radians(one.angle_deg) for one in spec.unbalances]
        pull = sum(
            one.amount_g_mm * 1e-6 * motion.omega**2 * np.exp(1j * angle)
            for one, angle in zip(spec.unbalances, angles, strict=True)
        )
        carried = sum(motion.reaction(bearing)[0] for bearing in spec.rotor.bearings)
        accelerated = -spec.rotor.mass_kg * motion.omega**2 * motion.phasors[0]
        scale = sum(one.amount_g_mm for one in spec.unbalances) * 1e-6 * motion.omega**2 + abs(accelerated)
        assert abs(carried + accelerated - pull) <= 1e-9 * scale


class TestAgainstTime:
    """The steady motion against Newton's and Euler's laws integrated from rest, in rotations about x and y."""

    @pytest.mark.parametrize("rotation", ["cw", "ccw"])
    @pytest.mark.parametrize("rpm", [800.0, 2600.0])
    def test_it_is_what_the_drum_settles_to(self, rotation: Rotation, rpm: float) -> None:
        example = threshing_drum_example().rotor
        p, q = (
            replace(one, damping_x=4.0 * one.damping_x, damping_y=5.0 * one.damping_y, axes_deg=25.0)
            for one in example.bearings
        )
        rotor = replace(example, bearings=(p, q), polar_inertia=9.0)
        unbalances = [Unbalance(-330.0, 6e4, 110.0), Unbalance(250.0, 9e4, -35.0)]
        motion = steady_motion(rotor, unbalances, rpm, rotation)
        times, states = integrate(rotor, unbalances, motion, turns=40, steps=250)
        last = times > times[-1] - math.tau / motion.omega
        for z, direction in ((-480.0, 0.0), (440.0, 70.0)):
            turn = math.radians(direction)
            x = states[last, 0] + z / 1000.0 * states[last, 3]
            y = states[last, 1] - z / 1000.0 * states[last, 2]
            signal = x * math.cos(turn) + y * math.sin(turn)
            phasor = motion.displacement(z, direction)
            assert signal == pytest.approx(
                (phasor * np.exp(1j * motion.omega * times[last])).real, abs=2e-4 * abs(phasor)
            )
            # what a stroboscope shows: the mark turns from the pick-up, at 50 degrees, until the signal peaks
            seen = (math.degrees(motion.omega * peak_time(times[last], signal)) - motion.spin * 50.0) % 360.0
            apart = (lag_degrees(phasor, motion.spin, 50.0) - seen + 180.0) % 360.0 - 180.0
            assert abs(apart) <= 0.05
        # along the axis a housing moves as the drum's rotations about x and y make it
        moved = 0.08 * (math.sin(0.5) * states[last, 2] - math.cos(0.5) * states[last, 3])
        phasor = motion.along_axis(80.0, math.degrees(0.5))
        assert moved == pytest.approx((phasor * np.exp(1j * motion.omega * times[last])).real, abs=2e-4 * abs(phasor))


class TestBend:
    @pytest.mark.parametrize("rotation", ["cw", "ccw"])
    def test_housings_rock_with_the_shaft_and_nothing_else_changes(self, rotation: Rotation) -> None:
        rotor = threshing_drum_example().rotor
        straight = steady_motion(rotor, [Unbalance(-330.0, 6e4, 110.0)], 460.0, rotation)
        bent = straight.bent(Bend(tilt_mrad=3.0, angle_deg=40.0))
        for t in (0.0, 0.013, 0.05):
            # the journal's direction at this moment, in space
            towards = straight.spin * straight.omega * t + math.radians(40.0)
            for direction in (0.0, 90.0, 200.0):
                more = bent.along_axis(100.0, direction) - straight.along_axis(100.0, direction)
                expected = -0.1 * 0.003 * math.cos(towards - math.radians(direction))
                assert (more * np.exp(1j * straight.omega * t)).real == pytest.approx(expected, abs=1e-12)
        assert bent.displacement(440.0, 30.0) == straight.displacement(440.0, 30.0)


Floats = NDArray[np.float64]


def peak_time(times: Floats, signal: Floats) -> float:
    """Time of the greatest of periodic samples, by the parabola through it and its neighbours."""
    top = int(np.argmax(signal))
    before, here, after = signal[top - 1], signal[top], signal[(top + 1) % len(signal)]
    return float(times[top] + (times[1] - times[0]) * 0.5 * (before - after) / (before - 2.0 * here + after))


def integrate(
    rotor: Rotor, unbalances: list[Unbalance], motion: Motion, *, turns: int, steps: int
) -> tuple[Floats, Floats]:
    """Runge-Kutta from rest; states (x, y, rotation about x, about y, and their rates), so many steps a turn."""
    places = np.array([bearing.axial_mm / 1000.0 for bearing in rotor.bearings])
    turn = math.radians(rotor.bearings[0].axes_deg)
    axes = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    stiff = np.array([[bearing.stiffness_x, bearing.stiffness_y] for bearing in rotor.bearings])
    damp = np.array([[bearing.damping_x, bearing.damping_y] for bearing in rotor.bearings])
    # angular momentum It (rx, ry) + Ip W (axis), with the axis leaning by (about_y, -about_x)
    spin_momentum = rotor.polar_inertia * motion.spin * motion.omega

    def accelerations(forces: Floats, arms: Floats, rx: float, ry: float) -> list[float]:
        fx, fy = forces.sum(axis=0)
        moment_x, moment_y = -float(arms @ forces[:, 1]), float(arms @ forces[:, 0])
        about_x = (moment_x - spin_momentum * ry) / rotor.transverse_inertia
        about_y = (moment_y + spin_momentum * rx) / rotor.transverse_inertia
        return [fx / rotor.mass_kg, fy / rotor.mass_kg, about_x, about_y]

    def left_alone(state: Floats) -> Floats:
        (x, y, about_x, about_y), (vx, vy, rx, ry) = state[:4], state[4:]
        at = np.stack([x + places * about_y, y - places * about_x], axis=1) @ axes
        speed = np.stack([vx + places * ry, vy - places * rx], axis=1) @ axes
        held = -(stiff * at + damp * speed) @ axes.T
        return np.array([vx, vy, rx, ry, *accelerations(held, places, rx, ry)])

    def thrown(time: float) -> Floats:
        angles = motion.spin * motion.omega * time + np.radians([one.angle_deg for one in unbalances])
        pulls = np.array([one.amount_g_mm * 1e-6 * motion.omega**2 for one in unbalances])
        forces = np.stack([pulls * np.cos(angles), pulls * np.sin(angles)], axis=1)
        arms = np.array([one.axial_mm / 1000.0 for one in unbalances])
        return np.array([0.0, 0.0, 0.0, 0.0, *accelerations(forces, arms, 0.0, 0.0)])

    free = np.stack([left_alone(unit) for unit in np.eye(8)], axis=1)  # the drum's own motion is linear in its state
    step = math.tau / motion.omega / steps
    half_steps = np.array([thrown(0.5 * step * index) for index in range(2 * steps)])  # repeats with each turn
    state, states = np.zeros(8), []
    for index in range(turns * steps):
        states.append(state)
        start, middle, end = (half_steps[(2 * index + k) % (2 * steps)] for k in range(3))
        k1 = free @ state + start
        k2 = free @ (state + step / 2 * k1) + middle
        k3 = free @ (state + step / 2 * k2) + middle
        k4 = free @ (state + step * k3) + end
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return np.arange(turns * steps, dtype=float) * step, np.array(states)
