"""What sessions of known truth must be told: each a kind of session that was once answered wrongly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from itertools import count

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.balancing.rotor.units import Scale, convert_amplitude
from service.bench.trust.cases import CASES
from service.bench.trust.coverage import as_run, flat, machine_of
from service.bench.trust.world import ErrorSet, World
from service.engine.correction_solver import solve_correction
from service.engine.plan_solver import solve_plan
from service.engine.selection_problem import PlanContext
from service.errors import NumericsError
from service.model.correction import Correction, CorrectionRequest
from service.model.machine import CatalogueItem, Machine
from service.model.plan import Plan, PlanInputs, PlanRequest
from service.model.run import Run

BOX = tuple(CatalogueItem(mass_g=m, count=8) for m in (5.0, 10.0, 20.0, 50.0, 100.0, 200.0))
UNITS = {
    "velocity": ("mm/s", "in/s"),
    "displacement": ("um", "mm", "mil"),
}
DETECTIONS = ("rms", "peak", "peak_to_peak")


def _runs(name: str, errors: ErrorSet, seed: int = 1, scale: float = 1.0) -> tuple[Machine, tuple[Run, ...]]:
    """As found and a trial in each plane; scale: of the rotor's own unbalance."""
    case = CASES[name]
    machine, world = machine_of(case, None), World(case, errors, np.random.default_rng(seed))
    world.own = world.own * scale
    runs = [as_run(machine, 1, "initial", (), world.run())]
    for plane in range(len(case.planes)):
        pieces = (world.piece(plane, case.trial_g * np.exp(0.7j * (plane + 1))),)
        runs.append(as_run(machine, len(runs) + 1, "trial", pieces, world.run(pieces)))
    return machine, flat(runs)


def _solved(machine: Machine, runs: tuple[Run, ...], **asked: object) -> Correction:
    return solve_correction(machine, runs, (), CorrectionRequest(source="fit", **asked), number=1, key="c")  # type: ignore[arg-type]


def _planned(machine: Machine, runs: tuple[Run, ...], correction: Correction, **asked: object) -> Plan:
    inputs = PlanInputs(version="0", counts=tuple(item.count for item in BOX), present=())
    ground = PlanContext(machine, BOX, runs, (), (), correction, inputs)
    request = PlanRequest(correction_id="c", objective="residual_vibration", time_limit_s=2.0, **asked)  # type: ignore[arg-type]
    return solve_plan(
        ground,
        request,
        number=1,
        key="p",
        session_id="s",
        at=datetime(2026, 1, 1, tzinfo=UTC),
        monotonic=_ticking(),
    )


def _ticking() -> Callable[[], float]:
    """Clock that goes on by a millisecond whenever it is asked: the same effort on a busy machine as on an idle one."""
    ticks = count()
    return lambda: 1e-3 * next(ticks)


def _codes(correction: Correction) -> set[str]:
    return {one.code for one in correction.diagnostics}


def _in_other_units(
    machine: Machine, runs: tuple[Run, ...], choice: list[tuple[str, str]]
) -> tuple[Machine, tuple[Run, ...]]:
    """The same session with each sensor typed in another unit and detection of its quantity."""
    sensors, factors = [], {}
    for sensor, (unit, detection) in zip(machine.sensors, choice, strict=True):
        old, new = (
            Scale(sensor.quantity, sensor.unit, sensor.detection),
            Scale(sensor.quantity, unit, detection),  # type: ignore[arg-type]
        )
        factors[sensor.name] = convert_amplitude(1.0, old, new)
        sensors.append(replace(sensor, unit=unit, detection=detection))  # type: ignore[arg-type]
    typed = [
        replace(
            run,
            readings=tuple(
                replace(
                    r,
                    amplitude=r.amplitude * factors[r.sensor],
                    scatter=None if r.scatter is None else r.scatter * factors[r.sensor],
                )
                for r in run.readings
            ),
        )
        for run in runs
    ]
    return replace(machine, sensors=tuple(sensors)), tuple(typed)


@settings(max_examples=12, deadline=None)
@given(
    data=st.data(),
    name=st.sampled_from(["a", "d", "e"]),
    method=st.sampled_from([None, "weighted"]),
    seed=st.integers(0, 50),
)
def test_the_same_session_in_any_units_has_the_same_answer(
    data: st.DataObject, name: str, method: str | None, seed: int
) -> None:
    machine, runs = _runs(name, ErrorSet(within=0.01), seed)
    machine = replace(machine, vibration_limit_mm_s=2.0)
    choice = [
        (data.draw(st.sampled_from(UNITS[s.quantity])), data.draw(st.sampled_from(DETECTIONS))) for s in machine.sensors
    ]
    # In case d the sensors are of two quantities from the start, in the others they may become of two units.
    plain = _solved(machine, runs, method=method)
    other = _solved(*_in_other_units(machine, runs, choice), method=method)
    masses = [
        np.array([c.mass_g * np.exp(1j * np.radians(c.angle_deg)) for c in one.corrections]) for one in (plain, other)
    ]
    np.testing.assert_allclose(masses[0], masses[1], rtol=0.0, atol=1e-9 * np.abs(masses[0]).max())
    assert _codes(plain) - {"sensors_of_different_kind"} == _codes(other) - {"sensors_of_different_kind"}


def test_sensors_of_different_kind_are_said_to_be_weighed() -> None:
    assert "sensors_of_different_kind" in _codes(_solved(*_runs("d", ErrorSet(within=0.01))))
    assert "sensors_of_different_kind" not in _codes(_solved(*_runs("a", ErrorSet(within=0.01))))


def test_a_drum_within_its_limits_gets_no_pieces() -> None:
    machine, runs = _runs("a", ErrorSet(within=0.01), scale=0.5)
    machine = replace(machine, vibration_limit_mm_s=2.0)
    correction = _solved(machine, runs)
    plan = _planned(machine, runs, correction)
    assert plan.placements == ()
    assert "within every limit already" in plan.message
    assert _planned(machine, runs, correction, even_if_within=True).placements != ()
    strict = replace(machine, vibration_limit_mm_s=1e-4)
    assert _planned(strict, runs, _solved(strict, runs), even_if_within=True).placements != ()


def test_a_correction_lost_in_the_readings_gets_no_pieces() -> None:
    machine, runs = _runs("a", ErrorSet(within=0.5), scale=1e-2)
    correction = _solved(machine, runs)
    assert "correction_in_noise" in _codes(correction)
    plan = _planned(machine, runs, correction)
    assert (plan.placements, plan.status) == ((), "within_uncertainty")


def test_an_unbalanced_drum_gets_pieces() -> None:
    machine, runs = _runs("a", ErrorSet(within=0.01))
    machine = replace(machine, vibration_limit_mm_s=0.1)
    assert _planned(machine, runs, _solved(machine, runs)).placements != ()


@pytest.mark.parametrize("seed", range(8))
def test_a_healthy_machine_on_soft_supports_raises_no_warning_of_direction(seed: int) -> None:
    machine, runs = _runs("e", ErrorSet(within=0.005, repeat=0.01), seed)
    ways = ("horizontal", "vertical")
    sensors = tuple(
        replace(s, direction=ways[k % 2], bearing=f"B{k // 2}")  # type: ignore[arg-type]
        for k, s in enumerate(machine.sensors)
    )
    solved = _solved(replace(machine, sensors=sensors), runs)
    found = {one.code for one in solved.diagnostics if one.severity != "info"}
    assert not found & {"not_unbalance_direction", "not_unbalance_phase"}


@pytest.mark.parametrize("case", ["a", "e"])
def test_a_missing_or_dead_reading_is_named_as_such(case: str) -> None:
    machine, runs = _runs(case, ErrorSet(within=0.01))
    name = machine.sensors[0].name
    missing = replace(runs[1], readings=tuple(r for r in runs[1].readings if r.sensor != name))
    dead = [
        replace(run, readings=tuple(replace(r, amplitude=0.0) if r.sensor == name else r for r in run.readings))
        for run in runs
    ]
    for changed, code in (((runs[0], missing, runs[2]), "sensor_incomplete"), (tuple(dead), "sensor_silent")):
        try:
            found = _codes(_solved(machine, changed))
        except NumericsError as error:
            found = {error.code}
        assert code in found
        assert "planes_dependent" not in found


def test_runs_at_another_speed_than_they_are_taken_for_are_said() -> None:
    machine, runs = _runs("a", ErrorSet(within=0.01))
    slow = tuple(replace(run, readings=tuple(replace(r, speed_rpm=400.0) for r in run.readings)) for run in runs)
    assert "speed_off_nominal" in _codes(_solved(machine, slow))
    typed = tuple(replace(run, nominal_speed_rpm=400.0) for run in slow)
    assert "service_speed_not_measured" in _codes(_solved(machine, typed))
