"""Sessions with one fault each, on the simulated drum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drivers.simulator.faults import NO_FAULTS, Faults, LooseMass
from drivers.simulator.rotor import Bend
from drivers.simulator.spec import DrumSpec, Scatter
from service.balancing.rotor.phasors import ComplexArray
from tests.balancing.influence.diagnosis.sessions import Session, three_ways

NONE = np.zeros(2, dtype=complex)


def trials(session: Session, faults: Faults = NO_FAULTS) -> ComplexArray:
    masses = session.trial()
    for state in (NONE, masses * [1, 0], masses * [0, 1]):
        session.run(state, faults=faults)
    return masses


def small_trial(seed: int) -> Session:
    session = Session(seed)
    masses = session.trial() * [1.0, 0.004]
    session.run(NONE)
    session.run(masses * [1, 0])
    session.run(masses * [0, 1])
    return session


def small_trial_without_scatter(seed: int) -> Session:
    session = Session(seed, stated=False)
    masses = session.trial() * [0.08, 1.0]
    session.run(NONE)
    session.run(masses * [1, 0])
    session.run(masses * [0, 1])
    return session


def drifting(seed: int) -> Session:
    session = Session(seed)
    masses = session.trial()
    session.run(NONE)
    session.run(masses * [1, 0], speed=1.06 if seed % 2 else 0.94)
    session.run(masses * [0, 1])
    return session


def at_another_speed(seed: int) -> Session:
    """Every run agrees with the others, and none turns at the speed that it is taken for."""
    session = Session(seed)
    masses = session.trial()
    speed = 1.15 if seed % 2 else 0.85
    for state in (NONE, masses * [1, 0], masses * [0, 1]):
        session.run(state, speed=speed)
    return session


def mistyped(seed: int) -> Session:
    """One run of six whose phase, amplitude or masses were typed wrong."""
    session = Session(seed)
    a, b = session.trial()
    states = [NONE, [a, 0], [0, b], [a, b], [-a, 0.5j * b], [0.5j * a, -b]]
    wrong = 1 + seed % 5
    for k, masses in enumerate(np.array(state, dtype=complex) for state in states):
        if k != wrong:
            session.run(masses)
        elif seed % 3 == 0:
            session.run(masses, typed=lambda v: v * np.exp(1j * np.radians(70.0)))
        elif seed % 3 == 1:
            session.run(masses, typed=lambda v: v * 2.0)
        else:
            session.run(masses, really=masses * np.exp(1j * np.radians(120.0)))
    session.wrong = wrong
    return session


def wrong_phase_sense(seed: int) -> Session:
    session = Session(seed)
    faults = Faults(wrong_phase_sense=True)
    trials(session, faults)
    session.run(session.correction(), faults=faults, check=True)
    return session


def wrong_angle_sense(seed: int) -> Session:
    session = Session(seed)
    faults = Faults(wrong_angle_sense=True)
    masses = trials(session, faults)
    session.run(masses * [1j, -1], faults=faults)
    return session


def lost_mass(seed: int) -> Session:
    session = Session(seed)
    trials(session)
    plane = session.spec.planes[seed % 2].name
    loose = LooseMass(plane, lost=True) if seed % 3 else LooseMass(plane, slip_deg=60.0)
    session.run(session.correction(), faults=Faults(loose_trial_mass=loose), check=True)
    return session


def bent(seed: int) -> Session:
    """A support that stiffens: the reading grows with the root of what it should be."""
    session = Session(seed)
    a, b = session.trial(350.0)
    for state in (NONE, [a, 0], [0, b], [a, b], [-a, 0.5j * b], [0.5j * a, -b], [-a, -b]):
        session.run(np.array(state, dtype=complex), typed=lambda v: v / np.sqrt(np.abs(v) / 3.0))
    return session


def rattling(seed: int) -> Session:
    def altered(spec: DrumSpec) -> DrumSpec:
        return replace(spec, sensors=tuple(replace(sensor, broadband_rms=15.0) for sensor in spec.sensors))

    session = Session(seed, altered=altered)
    trials(session)
    return session


def beating(seed: int) -> Session:
    session = Session(
        seed, rounds=4, altered=lambda spec: replace(spec, scatter=Scatter(phase_deg=60.0, amplitude=0.1))
    )
    trials(session)
    return session


def contradicting(seed: int) -> Session:
    session = Session(seed)
    trials(session)
    session.run(NONE, typed=lambda v: v * 1.35)
    return session


def stuck(seed: int) -> Session:
    session = Session(seed)
    trials(session, Faults(stuck=(session.spec.sensors[seed % 2].name,)))
    return session


def silent(seed: int) -> Session:
    session = Session(seed)
    masses = session.trial()
    for state in (NONE, masses * [1, 0], masses * [0, 1]):
        session.run(state, typed=lambda v: v * [1, 0])
    return session


def planes_side_by_side(seed: int) -> Session:
    def altered(spec: DrumSpec) -> DrumSpec:
        left, right = spec.planes
        return replace(spec, planes=(replace(left, axial_mm=290.0), right))

    session = Session(seed, altered=altered)
    trials(session)
    return session


def balanced_already(seed: int) -> Session:
    session = Session(seed, altered=lambda spec: replace(spec, unbalances=()))
    trials(session)
    return session


def lost_in_every_trial(seed: int) -> Session:
    """A cable that breaks after the first run."""
    session = Session(seed, altered=three_ways)
    name = session.spec.sensors[seed % 6].name
    masses = session.trial()
    for k, state in enumerate((NONE, masses * [1, 0], masses * [0, 1])):
        session.run(state, faults=Faults(silent=(name,)) if k else NO_FAULTS)
    return session


def one_plane_only(seed: int) -> Session:
    """All the unbalance stands in the first plane."""

    def altered(spec: DrumSpec) -> DrumSpec:
        return replace(spec, unbalances=tuple(u for u in spec.unbalances if u.axial_mm == spec.planes[0].axial_mm))

    session = Session(seed, altered=altered)
    trials(session)
    return session


def narrow(seed: int) -> Session:
    """Two planes 12 mm apart on a drum that is wrong in the middle: hardly a couple, and much mass to make it."""

    def altered(spec: DrumSpec) -> DrumSpec:
        planes = tuple(replace(p, axial_mm=place) for p, place in zip(spec.planes, (-6.0, 6.0), strict=True))
        static = replace(spec.unbalances[0], axial_mm=0.0, amount_g_mm=60_000.0)
        couple = [replace(spec.unbalances[1], axial_mm=z, amount_g_mm=sign * 1_750.0) for z, sign in ENDS]
        return replace(spec, planes=planes, unbalances=(static, *couple))

    session = Session(seed, rounds=64, altered=altered)
    trials(session)
    return session


ENDS = ((-330.0, -1.0), (330.0, 1.0))


def loose_foot(seed: int, axes_deg: float, share: float) -> Session:
    """A support that gives way along one axis, `share` of its stiffness left."""

    def altered(spec: DrumSpec) -> DrumSpec:
        soft = [
            replace(b, stiffness_x=share * b.stiffness_x, stiffness_y=b.stiffness_x, axes_deg=axes_deg)
            for b in spec.rotor.bearings
        ]
        return three_ways(replace(spec, rotor=replace(spec.rotor, bearings=(soft[0], soft[1]))))

    session = Session(seed, altered=altered)
    trials(session)
    return session


def loose_across(seed: int) -> Session:
    return loose_foot(seed, 0.0 if seed % 2 else 90.0, 0.22)


def loose_askew(seed: int) -> Session:
    return loose_foot(seed, 45.0 if seed % 2 else -45.0, 0.3)


def bent_shaft(seed: int) -> Session:
    session = Session(seed, altered=three_ways)
    rng = np.random.default_rng([seed, 7])
    trials(session, Faults(bent_shaft=Bend(rng.uniform(8.0, 15.0), rng.uniform(0.0, 360.0))))
    return session


def one_of_four(seed: int) -> Session:
    """As found, two trials and one run more: enough to see that one reading is wrong, too little to say which."""
    session = Session(seed)
    a, b = session.trial()
    session.run(NONE)
    session.run(np.array([a, 0]), typed=lambda v: v * np.array([1.0, 1.5j]))
    session.run(np.array([0, b]))
    session.run(np.array([-a, 0.5 * b]))
    return session
