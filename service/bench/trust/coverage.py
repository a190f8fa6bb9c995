"""How often what is stated is true: ellipses, residuals, next readings, before and after the check run."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime

import numpy as np

from service.balancing.rotor.phasors import phasor
from service.bench.trust.cases import CASES, Case
from service.bench.trust.rotor import Complex, Real
from service.bench.trust.world import ErrorSet, Piece, Seen, World, on_planes
from service.engine.correction_solver import predicted_with, solve_correction
from service.engine.influence_fits import fit_again
from service.model.correction import Correction, CorrectionRequest, SensorVector
from service.model.machine import Machine, Plane, Sensor, Uncertainty
from service.model.plan import Placement
from service.model.run import MassOnRotor, Run, RunKind, RunReading

BOLTED = {"mass": 0.005, "angle_deg": 0.5}
"""How pieces are bolted on: share of the mass, and degrees."""
ERROR_SETS: dict[str, tuple[ErrorSet, Uncertainty | None]] = {
    "within a run 1 %": (ErrorSet(within=0.01), Uncertainty(repeatability=0.0, mass_sd=0.0, angle_sd_deg=0.0)),
    "repeats to 1 %, stated": (ErrorSet(repeat=0.01, **BOLTED), Uncertainty(repeatability=0.01)),
    "repeats to 2 %, stated": (ErrorSet(repeat=0.02, **BOLTED), Uncertainty(repeatability=0.02)),
    "repeats to 1 %, default": (ErrorSet(repeat=0.01, **BOLTED), None),
    "repeats to 2 %, default": (ErrorSet(repeat=0.02, **BOLTED), None),
    "placement 0.5 %, 0.5 deg": (
        ErrorSet(within=0.005, **BOLTED),
        Uncertainty(repeatability=0.0),
    ),
    "drift 1 % a run, stated": (
        ErrorSet(within=0.003, repeat=0.005, drift=0.01, **BOLTED),
        Uncertainty(repeatability=0.005, drift_per_run=0.01),
    ),
    "warm-up 2 %, default": (ErrorSet(within=0.003, warm=0.02, **BOLTED), None),
    "quantised 2 %, default": (ErrorSet(step=0.02, **BOLTED), None),
    "severe mixture, stated": (
        ErrorSet(within=0.005, repeat=0.04, drift=0.01, speed=0.007, **BOLTED),
        Uncertainty(repeatability=0.04, drift_per_run=0.01),
    ),
}
"""Errors of the rotor, and what is stated of them."""
WHAT = ("ellipse", "residual", "reading", "ellipse after", "residual after", "reading after")
NOW = datetime(2026, 1, 1, tzinfo=UTC)
STOCK_G = 5.0


def coverage(case: Case, name: str, sessions: int, seed: int = 1) -> dict[str, tuple[float, int]]:
    """Share of stated intervals that hold the truth, by `WHAT`, and how many were stated."""
    errors, stated = ERROR_SETS[name]
    machine = machine_of(case, stated)
    held: dict[str, list[bool]] = defaultdict(list)
    for number in range(sessions):
        world = World(case, errors, np.random.default_rng([seed, number]))
        for what, holds in _session(world, machine):
            held[what].append(holds)
    return {what: (float(np.mean(held[what])) if held[what] else float("nan"), len(held[what])) for what in WHAT}


def _session(world: World, machine: Machine) -> Iterator[tuple[str, bool]]:
    case = world.case
    runs = [as_run(machine, 1, "initial", (), world.run())]
    for plane in range(len(case.planes)):
        trial = (world.piece(plane, complex(case.trial_g)),)
        runs.append(as_run(machine, len(runs) + 1, "trial", trial, world.run(trial)))
    pieces: tuple[Piece, ...] = ()
    for after in ("", " after"):
        used = flat(runs)
        correction = solve_correction(machine, used, (), CorrectionRequest(source="fit"), number=1, key="c")
        best = np.asarray(np.linalg.lstsq(world.influence, -world.initial, rcond=None)[0], dtype=np.complex128)
        yield from ((f"ellipse{after}", inside) for inside in _ellipses(machine, correction, best))
        fitted = fit_again(machine, used, (), correction)
        wanted = rounded(machine, correction)
        pieces = bolted(world, pieces, wanted)
        placed = [_placement(machine, piece) for piece in pieces]
        expected = predicted_with(machine, fitted, on_planes(pieces, len(case.planes), true=False), placed)
        truth = np.abs(world.true(on_planes(pieces, len(case.planes), true=True)))
        yield from ((f"residual{after}", inside) for inside in _within(expected, truth, next_reading=False))
        seen = world.run(pieces)
        yield from (
            (f"reading{after}", inside) for inside in _within(expected, np.abs(seen.vibration), next_reading=True)
        )
        runs.append(as_run(machine, len(runs) + 1, "check", pieces, seen))


def machine_of(case: Case, uncertainty: Uncertainty | None) -> Machine:
    """The machine of a case, as it is typed in."""
    positions = tuple(15.0 * k for k in range(24))
    return Machine(
        name=case.name,
        service_speed_rpm=case.speeds[0],
        planes=tuple(
            Plane(name=f"P{p}", radius_mm=1e3 * case.radius, positions_deg=positions, max_masses=8)
            for p in range(len(case.planes))
        ),
        sensors=tuple(
            Sensor(name=f"S{s}", quantity="displacement", unit="um", detection="peak_to_peak")
            if probe.displacement
            else Sensor(name=f"S{s}")
            for s, probe in enumerate(case.probes)
        ),
        uncertainty=uncertainty,
    )


def as_run(machine: Machine, number: int, kind: RunKind, pieces: Sequence[Piece], seen: Seen) -> list[Run]:
    """A run as documents, one a speed."""
    masses = tuple(
        MassOnRotor(
            plane=machine.planes[p.plane].name, mass_g=abs(p.stated), angle_deg=float(np.degrees(np.angle(p.stated)))
        )
        for p in pieces
    )
    count = len(machine.sensors)
    speeds = CASES[machine.name].speeds
    return [
        Run(
            id=f"run-{number}-{k}",
            number=number * len(speeds) + k,
            kind=kind,
            masses=masses,
            readings=tuple(
                RunReading(
                    sensor=sensor.name,
                    amplitude=float(abs(v)),
                    phase_deg=float(np.degrees(np.angle(v))),
                    speed_rpm=rpm * (1.0 + seen.speed),
                    scatter=float(s),
                )
                for sensor, v, s in zip(
                    machine.sensors,
                    seen.vibration[k * count : (k + 1) * count],
                    seen.scatter[k * count : (k + 1) * count],
                    strict=True,
                )
            ),
            nominal_speed_rpm=rpm,
            taken_at=NOW,
        )
        for k, rpm in enumerate(speeds)
    ]


def flat(runs: Sequence[list[Run]]) -> tuple[Run, ...]:
    """Runs of all speeds in one row."""
    return tuple(run for one in runs for run in one)


def _ellipses(machine: Machine, correction: Correction, best: Complex) -> Iterator[bool]:
    for mass, truth in zip(correction.corrections, best, strict=True):
        if mass.ellipse is None:
            continue
        off = truth - phasor(mass.mass_g, mass.angle_deg, machine.angle_sense)
        turned = off * np.exp(-1j * np.radians(mass.ellipse.angle_deg))
        yield bool((turned.real / mass.ellipse.major_g) ** 2 + (turned.imag / mass.ellipse.minor_g) ** 2 <= 1.0)


def _within(expected: Sequence[SensorVector], truth: Real, *, next_reading: bool) -> Iterator[bool]:
    for one, value in zip(expected, truth, strict=True):
        span = one.reading_interval if next_reading else one.interval
        if span is not None:
            yield bool(span.low <= value <= span.high)


def rounded(machine: Machine, correction: Correction) -> list[tuple[int, complex]]:
    """Pieces of the stock nearest to a correction: in each plane two in the holes beside it, in steps of 5 g."""
    wanted = []
    for p, mass in enumerate(correction.corrections):
        step = 360.0 / len(machine.planes[p].positions_deg)
        low = np.floor(mass.angle_deg / step) * step
        one, other = (np.exp(1j * np.radians(at)) for at in (low, low + step))
        target = mass.mass_g * np.exp(1j * np.radians(mass.angle_deg))
        shares = np.linalg.solve(np.array([[one.real, other.real], [one.imag, other.imag]]), [target.real, target.imag])
        size = STOCK_G if mass.mass_g > 10.0 * STOCK_G else 0.1 * STOCK_G
        for share, direction in zip(shares, (one, other), strict=True):
            grams = round(float(share) / size) * size
            if grams > 0.0:
                wanted.append((p, complex(grams * direction)))
    return wanted


def bolted(world: World, before: Sequence[Piece], wanted: Sequence[tuple[int, complex]]) -> tuple[Piece, ...]:
    """The pieces wanted: those that are on already stay as they are."""
    left = list(before)
    out = []
    for plane, stated in wanted:
        same = next((p for p in left if p.plane == plane and abs(p.stated - stated) < 1e-9), None)
        if same is not None:
            left.remove(same)
        out.append(same or world.piece(plane, stated))
    return tuple(out)


def _placement(machine: Machine, piece: Piece) -> Placement:
    angle = float(np.degrees(np.angle(piece.stated)))
    return Placement(
        plane=machine.planes[piece.plane].name, position_deg=angle, hole="", mass_g=float(abs(piece.stated))
    )
