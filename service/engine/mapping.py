"""Map documents to arrays and back: degrees, senses and names on one side, internal vectors on the other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.influence.diagnosis.findings import Finding
from service.balancing.influence.fit import InfluenceFit, Prediction, RunSet, amplitude_interval
from service.balancing.influence.uncertainty import Ellipses, ellipses, mass_interval
from service.balancing.rotor.labels import Labels
from service.balancing.rotor.phasors import ComplexArray, FloatArray, phasor, polar, to_degrees
from service.balancing.rotor.units import Scale, convert_amplitude
from service.engine.validation import plane_index
from service.errors import InvalidInput
from service.messages import Message, Part, Quantity, Word
from service.model.correction import Ellipse, Interval, PlaneMass, SensorVector
from service.model.diagnostic import Diagnostic, diagnostic
from service.model.influence import Coefficient
from service.model.machine import Machine, Sensor
from service.model.plan import Placement, Plan
from service.model.run import MassOnRotor, Run, RunOut, RunReading

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Channel:
    """A sensor at a nominal speed: one row of the influence matrix."""

    sensor: Sensor
    speed_rpm: float


def channels(machine: Machine, runs: Iterable[Run]) -> tuple[Channel, ...]:
    """Every sensor at every nominal speed of the runs; the service speed first, sensors in the machine's order."""
    speeds = sorted({run.nominal_speed_rpm for run in runs}, key=lambda rpm: (rpm != machine.service_speed_rpm, rpm))
    return tuple(Channel(sensor, speed) for speed in speeds for sensor in machine.sensors)


def mass_vectors(machine: Machine, masses: Iterable[MassOnRotor], field: str = "masses") -> ComplexArray:
    """Vector sum of masses per plane, (P,) complex g."""
    vectors = np.zeros(len(machine.planes), dtype=complex)
    for index, mass in enumerate(masses):
        plane = plane_index(machine, mass.plane, f"{field}[{index}].plane")
        vectors[plane] += phasor(mass.mass_g, mass.angle_deg, machine.angle_sense)
    return vectors


def placement_vectors(machine: Machine, placements: Iterable[Placement]) -> ComplexArray:
    """Vector sum of pieces with their fasteners per plane, (P,) complex g."""
    return mass_vectors(machine, as_masses(placements))


def as_masses(placements: Iterable[Placement]) -> tuple[MassOnRotor, ...]:
    """Pieces as masses on the rotor: as weighed where they were, fasteners included."""
    return tuple(
        MassOnRotor(
            plane=p.plane,
            mass_g=(p.mass_g if p.weighed_g is None else p.weighed_g) + p.fastener_g,
            angle_deg=p.position_deg,
        )
        for p in placements
    )


def masses_on_rotor(plan: Plan) -> tuple[MassOnRotor, ...]:
    """Masses on the rotor with a fitted plan, relative to as-found: what came off counts as negative."""
    off = (replace(mass, mass_g=-mass.mass_g) for mass in as_masses(plan.taken_off))
    return (*as_masses(plan.fitted or ()), *off)


def run_set(machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], rows: Sequence[Channel]) -> RunSet:
    """Arrays of a set of runs; a reading without phase counts as missing."""
    column = {(row.sensor.name, row.speed_rpm): index for index, row in enumerate(rows)}
    vibration = np.full((len(runs), len(rows)), np.nan + 0j)
    scatter = np.full((len(runs), len(rows)), np.nan)
    for k, run in enumerate(runs):
        vectors = vectors_with_phase(machine, run, run_out)
        for reading in run.readings:
            if reading.sensor in vectors:
                s = column[reading.sensor, run.nominal_speed_rpm]
                vibration[k, s] = vectors[reading.sensor]
                scatter[k, s] = np.nan if reading.scatter is None else reading.scatter
    masses = np.array([mass_vectors(machine, run.masses) for run in runs]).reshape(len(runs), len(machine.planes))
    return RunSet(masses=masses, vibration=vibration, scatter=scatter, labels=labels(machine, runs, rows))


def amplitudes_of(machine: Machine, run: Run, run_out: Sequence[RunOut]) -> dict[str, float]:
    """Amplitude by sensor, run-out subtracted where there is a phase to subtract it by."""
    plain = {reading.sensor: reading.amplitude for reading in run.readings}
    return plain | {name: abs(vector) for name, vector in vectors_with_phase(machine, run, run_out).items()}


def vectors_with_phase(machine: Machine, run: Run, run_out: Sequence[RunOut]) -> dict[str, complex]:
    """Vectors by sensor, run-out subtracted, of the readings that have a phase."""
    offsets = {r.sensor: phasor(r.amplitude, r.phase_deg, machine.phase_sense) for r in run_out}
    return {
        r.sensor: phasor(r.amplitude, r.phase_deg, machine.phase_sense) - offsets.get(r.sensor, 0.0)
        for r in run.readings
        if r.phase_deg is not None
    }


def speeds(runs: Sequence[Run], rows: Sequence[Channel]) -> FloatArray:
    """Measured speed (K, S), r/min; nan where not stated."""
    return _table(runs, rows, lambda reading, _sensor: reading.speed_rpm)


def amplitudes(runs: Sequence[Run], rows: Sequence[Channel]) -> FloatArray:
    """Amplitude (K, S); nan where not measured."""
    return _table(runs, rows, lambda reading, _sensor: reading.amplitude)


def overalls(runs: Sequence[Run], rows: Sequence[Channel]) -> FloatArray:
    """Broadband value (K, S) on the scale of the amplitude: a pure sine reads the same in both."""

    def as_amplitude(reading: RunReading, sensor: Sensor) -> float | None:
        if reading.overall_rms is None:
            return None
        rms = Scale(sensor.quantity, sensor.unit, "rms")
        return convert_amplitude(reading.overall_rms, rms, Scale(sensor.quantity, sensor.unit, sensor.detection))

    return _table(runs, rows, as_amplitude)


def diagnostics(
    machine: Machine, runs: Sequence[Run], rows: Sequence[Channel], findings: Iterable[Finding]
) -> tuple[Diagnostic, ...]:
    """Findings with names for indices."""
    return tuple(
        diagnostic(
            finding.data,
            finding.severity,
            runs=tuple(runs[k].number for k in finding.runs),
            planes=tuple(machine.planes[p].name for p in finding.planes),
            sensors=tuple(rows[s].sensor.name for s in finding.sensors),
        )
        for finding in findings
    )


def _table(
    runs: Sequence[Run], rows: Sequence[Channel], value: Callable[[RunReading, Sensor], float | None]
) -> FloatArray:
    """One number of every reading (K, S); nan where there is none."""
    out = np.full((len(runs), len(rows)), np.nan)
    for k, run in enumerate(runs):
        by_sensor = {reading.sensor: reading for reading in run.readings}
        for s, row in enumerate(rows):
            reading = by_sensor.get(row.sensor.name) if row.speed_rpm == run.nominal_speed_rpm else None
            number = None if reading is None else value(reading, row.sensor)
            out[k, s] = np.nan if number is None else number
    return out


def labels(machine: Machine, runs: Sequence[Run], rows: Sequence[Channel]) -> Labels:
    """Names for the messages of the numerics."""
    several = len({row.speed_rpm for row in rows}) > 1
    return Labels(
        runs=tuple(Part("run", run.number, note=Word(run.kind)) for run in runs),
        planes=tuple(plane.name for plane in machine.planes),
        sensors=tuple(
            Part("sensor", number, row.sensor.name, Quantity(row.speed_rpm, "r/min") if several else None)
            for number, row in enumerate(rows, start=1)
        ),
    )


def limit_of(machine: Machine, row: Channel) -> float | None:
    """Limit that applies to a row, in the sensor's unit: its own, else the machine's converted, else None."""
    sensor = row.sensor
    if sensor.limit is not None:
        return sensor.limit
    if machine.vibration_limit_mm_s is None:
        return None
    target = Scale(sensor.quantity, sensor.unit, sensor.detection)
    return convert_amplitude(machine.vibration_limit_mm_s, Scale(), target, row.speed_rpm)


def limits(machine: Machine, rows: Sequence[Channel]) -> FloatArray:
    """Limits (S,); where none is stated 1 in the sensor's unit, or 1 mm/s rms where sensors differ in it."""
    one = scales(rows)
    return np.array([limit_of(machine, row) or float(least) for row, least in zip(rows, one, strict=True)])


def of_different_kind(rows: Sequence[Channel]) -> bool:
    """Whether sensors differ in quantity, unit or detection, so that their numbers cannot be compared."""
    return len({(row.sensor.quantity, row.sensor.unit, row.sensor.detection) for row in rows}) > 1


def scales(rows: Sequence[Channel]) -> FloatArray:
    """What 1 mm/s rms of velocity is (S,) in each row's unit at its speed; 1 where all sensors are of one kind."""
    if not of_different_kind(rows):
        return np.ones(len(rows))
    targets = [Scale(row.sensor.quantity, row.sensor.unit, row.sensor.detection) for row in rows]
    each = zip(targets, rows, strict=True)
    return np.array([convert_amplitude(1.0, Scale(), target, row.speed_rpm) for target, row in each])


def weights(machine: Machine, rows: Sequence[Channel], method: str | None) -> FloatArray | None:
    """Weights (S,) of the sensors in a correction; None where all count alike as they are."""
    if method in ("weighted", "minimax"):
        return 1.0 / limits(machine, rows)
    return 1.0 / scales(rows) if of_different_kind(rows) else None


def sensor_vectors(
    machine: Machine, rows: Sequence[Channel], prediction: Prediction, reading: Prediction | None = None
) -> tuple[SensorVector, ...]:
    """Predicted vectors with their intervals; rows that the fit left out are left out here.

    reading: the same for what the next run will read.
    """
    low, high = amplitude_interval(prediction.vibration, prediction.scatter, prediction.dof, CONFIDENCE)
    lowest, highest = np.full(len(rows), np.nan), np.full(len(rows), np.nan)
    if reading is not None:
        lowest, highest = amplitude_interval(reading.vibration, reading.scatter, reading.dof, CONFIDENCE)
    out = []
    for s, row in enumerate(rows):
        if not np.isfinite(prediction.vibration[s]):
            continue
        amplitude, phase = polar(complex(prediction.vibration[s]), machine.phase_sense)
        out.append(
            SensorVector(
                sensor=row.sensor.name,
                speed_rpm=row.speed_rpm,
                amplitude=amplitude,
                phase_deg=phase,
                scatter=known(prediction.scatter[s]),
                interval=interval(low[s], high[s]),
                limit=limit_of(machine, row),
                reading_interval=interval(lowest[s], highest[s]),
            )
        )
    return tuple(out)


def coefficients(machine: Machine, rows: Sequence[Channel], fit: InfluenceFit) -> tuple[tuple[Coefficient, ...], ...]:
    """Influence coefficients [sensor][plane] with their scatter."""
    out = []
    for s, row in enumerate(rows):
        if not np.isfinite(fit.influence[s]).all():
            continue
        line = []
        for p, plane in enumerate(machine.planes):
            amplitude, phase = polar(complex(fit.influence[s, p]), machine.phase_sense)
            line.append(
                Coefficient(
                    sensor=row.sensor.name,
                    plane=plane.name,
                    speed_rpm=row.speed_rpm,
                    amplitude_per_g=amplitude,
                    phase_deg=phase,
                    scatter_per_g=known(math.sqrt(abs(fit.covariance[s, p + 1, p + 1]))),
                )
            )
        out.append(tuple(line))
    return tuple(out)


def plane_masses(
    machine: Machine, vectors: ComplexArray, covariance: FloatArray | None = None, dof: float = 0.0
) -> tuple[PlaneMass, ...]:
    """Continuous masses (P,) complex g with intervals from their covariance (2P, 2P)."""
    if covariance is None:
        covariance = np.full((2 * len(vectors), 2 * len(vectors)), np.nan)
    low, high = mass_interval(vectors, covariance, dof, CONFIDENCE)
    regions = ellipses(vectors, covariance, dof, CONFIDENCE)
    out = []
    for p, plane in enumerate(machine.planes):
        mass, angle = polar(complex(vectors[p]), machine.angle_sense)
        span = interval(low[p], high[p])
        out.append(
            PlaneMass(
                plane=plane.name,
                mass_g=mass,
                angle_deg=angle,
                unbalance_gmm=mass * plane.radius_mm,
                interval=span,
                angle_interval=_angle_interval(mass, angle, span),
                ellipse=_ellipse(machine, regions, p),
            )
        )
    return tuple(out)


def bearing_places(machine: Machine) -> tuple[tuple[str, ...], FloatArray] | None:
    """Names and axial positions (2,) mm of the two bearings; None where there are not exactly two places."""
    if machine.bearings:
        places = {bearing.name: bearing.axial_mm for bearing in machine.bearings}
    else:
        by_place = {s.axial_mm: s.name for s in machine.sensors if s.axial_mm is not None}
        places = {name: place for place, name in by_place.items()}
    if len(places) != 2:
        return None
    return tuple(places), np.array(list(places.values()))


def plane_places(machine: Machine) -> FloatArray | None:
    """Axial positions (P,) mm of the planes; None where one is not stated."""
    places = [plane.axial_mm for plane in machine.planes if plane.axial_mm is not None]
    return np.array(places) if len(places) == len(machine.planes) else None


def require_geometry(machine: Machine) -> tuple[tuple[str, ...], FloatArray, FloatArray]:
    """Bearing names, their places (2,) and the planes' places (P,), mm. Raises InvalidInput where one is missing."""
    bearings, planes = bearing_places(machine), plane_places(machine)
    if bearings is None:
        raise InvalidInput(Message("invalid_input.bearings_missing"), field="objective", value="bearing_force")
    if planes is None:
        raise InvalidInput(Message("invalid_input.plane_places_missing"), field="objective", value="bearing_force")
    return *bearings, planes


def known(value: float) -> float | None:
    """A number, or None where it cannot be known."""
    return float(value) if math.isfinite(value) else None


def interval(low: float, high: float) -> Interval | None:
    """An interval, or None where it cannot be known."""
    if not (math.isfinite(low) and math.isfinite(high)):
        return None
    return Interval(low=float(low), high=float(high), confidence=CONFIDENCE)


def _ellipse(machine: Machine, regions: Ellipses, p: int) -> Ellipse | None:
    if not math.isfinite(regions.major[p]):
        return None
    return Ellipse(
        major_g=float(regions.major[p]),
        minor_g=float(regions.minor[p]),
        angle_deg=to_degrees(float(regions.turn[p]), machine.angle_sense),
        confidence=CONFIDENCE,
    )


def _angle_interval(mass: float, angle: float, span: Interval | None) -> Interval | None:
    """Angle over which the mass vector may swing; None where its circle of uncertainty holds the centre."""
    if span is None or mass <= 0.0 or span.high - mass >= mass:
        return None
    swing = math.degrees(math.asin((span.high - mass) / mass))
    return Interval(low=angle - swing, high=angle + swing, confidence=span.confidence)
