"""What is known of the drum as it is now: before and after, and whether what was asked for is reached."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from service.balancing.rotor.tolerance import vibration_zone
from service.balancing.rotor.units import Scale, convert_amplitude
from service.engine import mapping
from service.engine.mapping import Channel, amplitudes_of, limit_of
from service.engine.rotor_state import Drum
from service.messages import Message, Quantity
from service.model.correction import Tolerance
from service.model.diagnostic import Diagnostic, diagnostic
from service.model.machine import Machine
from service.model.report import BeforeAfter, Outcome, Verdict, Zone
from service.model.run import MassOnRotor, Run

OFF_SPEED = 0.02
"""Share by which a measured speed may differ from the nominal one for a reading to stand for it."""
_SAME_MASSES = 1e-6


def checks_of_now(drum: Drum) -> tuple[Run, ...]:
    """Check runs of exactly the masses that are on the drum now, taken after they were last changed."""
    plan = drum.fitted
    if plan is None:
        return ()
    wanted = tuple(mapping.masses_on_rotor(plan))
    found: list[Run] = []
    same = wanted  # masses of the run before, which long sessions repeat
    # Backwards, to the last run with other masses; an excluded run still tells what was on the drum.
    for run in reversed(drum.runs):
        if run.masses != same and not _same(drum.machine, run.masses, wanted):
            break
        same = run.masses
        if run.kind == "check" and not run.excluded and _after_last_change(drum, run):
            found.append(run)
    return tuple(reversed(found))


def before_after(drum: Drum) -> tuple[BeforeAfter, ...]:
    """Each sensor in the first as-found run, and in the latest check run of the drum as it is now, by speed."""
    afters = _afters(drum)
    out = []
    for first in _first_by_speed(drum.good):
        before = amplitudes_of(drum.machine, first, drum.run_out)
        for sensor in drum.machine.sensors:
            if sensor.name in before:
                row = Channel(sensor, first.nominal_speed_rpm)
                out.append(_line(drum, row, before[sensor.name], first, afters.get((sensor.name, row.speed_rpm))))
    return tuple(out)


def unchecked(drum: Drum) -> tuple[Diagnostic, ...]:
    """Why limits are not judged of the drum as it is now; empty where each was measured at each speed."""
    checks = checks_of_now(drum)
    if not checks:
        return (_no_check(drum),)
    afters = _afters(drum)
    out = []
    for speed in drum.speeds:
        missing = [
            sensor.name
            for sensor in drum.machine.sensors
            if limit_of(drum.machine, Channel(sensor, speed)) is not None and (sensor.name, speed) not in afters
        ]
        if missing:
            out.append(_not_measured(checks, speed, missing))
    return tuple(out)


def judged(drum: Drum, tolerance: Tolerance | None, no_grade: Message | None) -> Verdict:
    """Compare the drum as it is now with what was asked for.

    tolerance: balance quality of the masses on the drum now. no_grade: why there is none although a grade is stated.
    """
    open_limits = unchecked(drum)
    grade = drum.machine.balance_grade_mm_s
    ungraded = () if grade is None or tolerance is not None else (_grade_not_judged(grade, no_grade),)
    above, limits = _compared(drum)
    return Verdict(
        outcome=_outcome(bool(open_limits), bool(above), bool(limits), grade is not None, tolerance),
        check_runs=tuple(run.number for run in checks_of_now(drum)),
        unjudged=(*open_limits, *ungraded),
        above=above,
    )


def _outcome(open_limits: bool, above: bool, limits: bool, graded: bool, tolerance: Tolerance | None) -> Outcome:
    if above:
        return "above_limit"
    if open_limits:
        return "unchecked"
    if tolerance is not None and not tolerance.within:
        return "grade_not_reached"
    if graded and tolerance is None:
        return "partly_judged"
    return "reached" if limits or graded else "nothing_asked"


def _compared(drum: Drum) -> tuple[tuple[str, ...], int]:
    """Sensors above their limit, and how many limits there are."""
    several = len(drum.speeds) > 1
    afters = _afters(drum)
    above, count = [], 0
    for speed in drum.speeds:
        for sensor in drum.machine.sensors:
            limit = limit_of(drum.machine, Channel(sensor, speed))
            after = afters.get((sensor.name, speed))
            count += limit is not None
            if limit is not None and after is not None and after[0] > limit:
                above.append(f"{sensor.name} ({speed:g} r/min)" if several else sensor.name)
    return tuple(above), count


def _afters(drum: Drum) -> dict[tuple[str, float], tuple[float, Run]]:
    """Amplitude of the drum as it is now, by sensor and nominal speed, with the run it is from."""
    out: dict[tuple[str, float], tuple[float, Run]] = {}
    for run in checks_of_now(drum):
        measured = {reading.sensor: reading.speed_rpm for reading in run.readings}
        for name, amplitude in amplitudes_of(drum.machine, run, drum.run_out).items():
            if not off_speed(measured[name], run.nominal_speed_rpm):
                out[name, run.nominal_speed_rpm] = (amplitude, run)
    return out


def off_speed(measured_rpm: float | None, nominal_rpm: float) -> bool:
    """Whether a speed, where it was measured, is too far from another for a reading to stand for it."""
    return measured_rpm is not None and abs(measured_rpm / nominal_rpm - 1.0) > OFF_SPEED


def _after_last_change(drum: Drum, run: Run) -> bool:
    if run.number <= _changed_after(drum):
        return False
    moments = [stop.changed_at for stop in drum.stops if stop.changed_at is not None and not stop.cancelled]
    return not moments or run.taken_at >= moments[-1]


def _changed_after(drum: Drum) -> int:
    """Number of the latest run before a plan was last fitted or taken off."""
    return max((plan.changed_after_run or 0 for plan in drum.plans), default=0)


def _same(machine: Machine, masses: Iterable[MassOnRotor], others: Iterable[MassOnRotor]) -> bool:
    one, other = mapping.mass_vectors(machine, masses), mapping.mass_vectors(machine, others)
    size = max(float(np.abs(one).max(initial=0.0)), float(np.abs(other).max(initial=0.0)))
    return bool((np.abs(one - other) <= _SAME_MASSES * size).all())


def _first_by_speed(runs: Sequence[Run]) -> list[Run]:
    first: dict[float, Run] = {}
    for run in runs:
        if run.kind == "initial":
            first.setdefault(run.nominal_speed_rpm, run)
    return list(first.values())


def _line(drum: Drum, row: Channel, before: float, first: Run, found: tuple[float, Run] | None) -> BeforeAfter:
    after, last = found or (None, None)
    limit = limit_of(drum.machine, row)
    before_rpm, after_rpm = _speed(first, row), _speed(last, row)
    # A vibration at one speed says nothing of how much was gained at another.
    comparable = after is not None and before > 0.0 and not off_speed(before_rpm, row.speed_rpm)
    line = BeforeAfter(
        sensor=row.sensor.name,
        unit=f"{row.sensor.unit} {row.sensor.detection.replace('_', '-')}",
        speed_rpm=row.speed_rpm,
        before=before,
        after=after,
        reduction=1.0 - after / before if after is not None and comparable else None,
        limit=limit,
        within_limit=None if after is None or limit is None else after <= limit,
        before_rpm=before_rpm,
        after_rpm=after_rpm,
    )
    return replace(line, zone_before=_zone(drum.machine, row, first), zone_after=_zone(drum.machine, row, last))


def _speed(run: Run | None, row: Channel) -> float | None:
    if run is None:
        return None
    return next((reading.speed_rpm for reading in run.readings if reading.sensor == row.sensor.name), None)


def _zone(machine: Machine, row: Channel, run: Run | None) -> Zone | None:
    """Zone of ISO 20816-3 by the broadband velocity, where the machine states its group."""
    group = machine.iso_20816
    if group is None or run is None or row.sensor.quantity != "velocity":
        return None
    reading = next((r for r in run.readings if r.sensor == row.sensor.name), None)
    if reading is None or reading.overall_rms is None:
        return None
    velocity = convert_amplitude(reading.overall_rms, Scale("velocity", row.sensor.unit, "rms"), Scale())
    return vibration_zone(velocity, group.group, group.support)


def _no_check(drum: Drum) -> Diagnostic:
    if drum.fitted is None:
        return diagnostic(Message("not_fitted"), "warning")
    checks = [run for run in drum.good if run.kind == "check"]
    if not checks:
        return diagnostic(Message("not_checked"), "warning")
    last = checks[-1].number
    return diagnostic(Message("changed_after_check", run=last), "warning", runs=(last,))


def _not_measured(checks: Sequence[Run], speed: float, missing: Sequence[str]) -> Diagnostic:
    values = {"speed": Quantity(speed, "r/min"), "sensors": tuple(missing)}
    other = [run.number for run in checks if any(off_speed(r.speed_rpm, run.nominal_speed_rpm) for r in run.readings)]
    if other:
        told = Message("check_at_other_speed", run=other[-1], **values)
        return diagnostic(told, "warning", runs=(other[-1],), sensors=tuple(missing))
    return diagnostic(Message("sensor_not_checked", **values), "warning", sensors=tuple(missing))


def _grade_not_judged(grade: float, why: Message | None) -> Diagnostic:
    return diagnostic(
        Message("grade_not_judged", grade=grade, reason=why or Message("grade_not_judged.runs")), "warning"
    )
