"""Sessions on the simulated drum, whose mechanics know nothing of the fit: what a technician would have recorded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from drivers.clock import ManualClock
from drivers.simulator.drum_driver import SimulatedDrum
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.faults import NO_FAULTS, Faults
from drivers.simulator.spec import DrumSpec, FittedMass, Scatter
from service.balancing.influence.corrections import least_squares
from service.balancing.influence.diagnosis.findings import Direction, RunConditions
from service.balancing.influence.fit import RunSet, fit_influence
from service.balancing.rotor.phasors import ComplexArray, FloatArray, phasor

DIRECTIONS: dict[str, Direction] = {"H": "horizontal", "V": "vertical", "A": "axial"}
"""By the last letter of a sensor's name; its first is the bearing."""


@dataclass
class Session:
    """A drum and the runs recorded on it. angles as stated, in the drum's senses; rounds averaged per run."""

    seed: int
    rounds: int = 8
    stated: bool = True
    altered: Callable[[DrumSpec], DrumSpec] = lambda spec: spec
    rows: list[tuple[ComplexArray, ...]] = field(default_factory=list)
    wrong: int = -1
    checks: list[bool] = field(default_factory=list)
    overall: list[FloatArray] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng([self.seed, 99])
        spec = threshing_drum_example(self.seed)
        share = self.rng.uniform(0.01, 0.05)
        scatter = Scatter(amplitude=share, phase_deg=float(np.degrees(share)), run_speed=0.003)
        self.spec = self.altered(replace(spec, rotation=("cw", "ccw")[self.seed % 2], scatter=scatter))
        self.drum = SimulatedDrum(self.spec, seed=self.seed, clock=ManualClock())
        self.drum.open()
        self.drum.new_run()

    def run(
        self,
        masses: ComplexArray,
        *,
        faults: Faults = NO_FAULTS,
        typed: Callable[[ComplexArray], ComplexArray] = lambda v: v,
        speed: float = 1.0,
        really: ComplexArray | None = None,
        check: bool = False,
    ) -> None:
        """Bolt on `masses` (P,) (or `really`), measure, and record them with the readings, as `typed`."""
        fitted = masses if really is None else really
        self.drum.set_faults(faults)
        self.drum.set_speed(self.spec.speed_rpm * speed)
        self.drum.fit_masses(
            FittedMass(plane.name, abs(u), float(np.degrees(np.angle(u))))
            for plane, u in zip(self.spec.planes, fitted, strict=True)
            if u != 0
        )
        readings = self.drum.measure(self.rounds)
        first = {reading.sensor: reading for reading in reversed(readings)}
        names = [sensor.name for sensor in self.spec.sensors]
        vectors = np.full((len(names), self.rounds), np.nan + 0j)
        for s, name in enumerate(names):
            if name in first:
                vectors[s] = [phasor(r.amplitude, r.phase_deg or 0.0, "lag") for r in readings if r.sensor == name]
        spread = (
            np.sqrt(np.var(vectors, axis=1, ddof=1) / (2 * self.rounds))
            if self.rounds > 1
            else np.full(len(names), np.nan)
        )
        speeds = np.array([first[name].speed_rpm or np.nan if name in first else np.nan for name in names])
        self.rows.append((masses, typed(vectors.mean(axis=1)), spread + 0j, speeds + 0j))
        self.overall.append(
            np.array([first[name].overall_rms or np.nan if name in first else np.nan for name in names])
        )
        self.checks.append(check)

    def trial(self, size: float = 200.0) -> ComplexArray:
        """Trial masses (P,), one for each plane, at random angles."""
        return np.asarray(size * self.rng.uniform(0.7, 1.5, 2) * np.exp(2j * np.pi * self.rng.random(2)))

    def recorded(self) -> RunSet:
        masses, vibration, scatter, _ = (np.array(part, dtype=complex) for part in zip(*self.rows, strict=True))
        known = scatter.real if self.stated else np.full(vibration.shape, np.nan)
        return RunSet(masses, vibration, known)

    def circumstances(self) -> RunConditions:
        return RunConditions(
            speed_rpm=np.array([row[3].real for row in self.rows]),
            nominal_rpm=np.full(len(self.spec.sensors), self.spec.speed_rpm),
            overall=np.array(self.overall),
            check=np.array(self.checks),
            direction=tuple(DIRECTIONS.get(sensor.name[-1]) for sensor in self.spec.sensors),
            bearing=tuple(sensor.name[0] for sensor in self.spec.sensors),
        )

    def correction(self) -> ComplexArray:
        return least_squares(fit_influence(self.recorded())).masses


def three_ways(spec: DrumSpec) -> DrumSpec:
    """The drum with a horizontal, a vertical and an axial sensor at each bearing."""
    sensors = []
    for sensor in spec.sensors:
        name = sensor.name
        sensors.append(replace(sensor, name=f"{name}H", direction_deg=0.0))
        sensors.append(replace(sensor, name=f"{name}V", direction_deg=90.0))
        sensors.append(replace(sensor, name=f"{name}A", direction_deg=90.0, axial_arm_mm=80.0))
    return replace(spec, sensors=tuple(sensors))


def as_it_is(spec: DrumSpec) -> DrumSpec:
    return spec


def sound(
    seed: int, stated: bool = True, rounds: int = 8, altered: Callable[[DrumSpec], DrumSpec] = as_it_is
) -> Session:
    """A session without a fault: as found, trials, and by turns a check run, a repeat, trials left in."""
    session = Session(seed, stated=stated, rounds=rounds, altered=altered)
    first, second = session.trial()
    session.run(np.zeros(2, complex))
    session.run(np.array([first, 0]))
    session.run(np.array([first if seed % 3 == 0 else 0, second]))
    if seed % 5 == 1:
        session.run(np.zeros(2, complex))
    if seed % 2:
        session.run(np.array([0, 0.7j * second]))
        session.run(np.array([-0.8 * first, 0.5 * second]))
    if seed % 4 != 3:
        session.run(session.correction(), check=True)
    return session
