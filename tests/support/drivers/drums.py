"""Drums at random, for properties that hold for every drum."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import strategies as st

from drivers.simulator.rotor import Bearing, Rotation, Rotor, Unbalance
from drivers.simulator.sensors import Sensor
from drivers.simulator.spec import DrumSpec, FittedMass, Plane

angles = st.floats(-360.0, 360.0)
rotations: st.SearchStrategy[Rotation] = st.sampled_from(["cw", "ccw"])


@st.composite
def bearings(draw: st.DrawFn, name: str, side: int) -> Bearing:
    """A bearing with its axes at any slant, damped by 2 to 40 % of the critical damping of 100 kg."""
    stiff = draw(st.tuples(st.floats(1e5, 1e7), st.floats(1e5, 1e7)))
    damp = draw(st.tuples(st.floats(0.02, 0.4), st.floats(0.02, 0.4)))
    c_x, c_y = (2.0 * ratio * (100.0 * k) ** 0.5 for ratio, k in zip(damp, stiff, strict=True))
    return Bearing(name, side * draw(st.floats(150.0, 900.0)), *stiff, c_x, c_y, draw(st.floats(-90.0, 90.0)))


@st.composite
def drums(draw: st.DrawFn) -> DrumSpec:
    """A drum with any unbalance, below or above its resonances, turning either way, senses as by default."""
    rotor = Rotor(
        draw(st.floats(20.0, 400.0)),
        draw(st.floats(0.5, 30.0)),
        draw(st.floats(0.5, 60.0)),
        (draw(bearings("P", -1)), draw(bearings("Q", 1))),
    )
    unbalance = st.builds(Unbalance, st.floats(-600.0, 600.0), st.floats(1e3, 2e5), angles)
    sensor_at = st.tuples(st.floats(-900.0, 900.0), angles)
    return DrumSpec(
        name="any drum",
        rotor=rotor,
        planes=(Plane("1", draw(st.floats(100.0, 500.0)), -300.0), Plane("2", draw(st.floats(100.0, 500.0)), 350.0)),
        sensors=tuple(Sensor(name, *draw(sensor_at)) for name in ("P", "Q")),
        unbalances=tuple(draw(st.lists(unbalance, min_size=1, max_size=3))),
        speed_rpm=draw(st.floats(100.0, 6000.0)),
        rotation=draw(rotations),
        pickup_deg=draw(angles),
    )


pieces = st.lists(
    st.builds(FittedMass, st.sampled_from(["1", "2"]), st.floats(1.0, 500.0), angles), min_size=1, max_size=3
)


def turned(spec: DrumSpec, geometric_deg: float) -> DrumSpec:
    """The drum with its whole unbalance moved counter-clockwise by so many degrees."""
    moved = tuple(replace(one, angle_deg=one.angle_deg + geometric_deg) for one in spec.unbalances)
    return replace(spec, unbalances=moved)


def mirrored(spec: DrumSpec) -> DrumSpec:
    """What a mirror lying along x shows: y is turned round, so is every angle, so is the rotation."""
    first, second = (replace(bearing, axes_deg=-bearing.axes_deg) for bearing in spec.rotor.bearings)
    return replace(
        spec,
        rotor=replace(spec.rotor, bearings=(first, second)),
        sensors=tuple(replace(one, direction_deg=-one.direction_deg) for one in spec.sensors),
        unbalances=tuple(replace(one, angle_deg=-one.angle_deg) for one in spec.unbalances),
        rotation="cw" if spec.rotation == "ccw" else "ccw",
        pickup_deg=-spec.pickup_deg,
    )
