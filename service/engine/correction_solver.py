"""Solve a correction: from runs to continuous masses, without storage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from service.balancing.influence.analysis import diagnose
from service.balancing.influence.corrections import Correction as Answer
from service.balancing.influence.corrections import CorrectionOptions, least_squares, minimax
from service.balancing.influence.diagnosis.findings import RunConditions
from service.balancing.influence.diagnosis.planes import significance
from service.balancing.influence.diagnosis.readings import examine as examine_readings
from service.balancing.influence.fit import Prediction, condition, predict
from service.balancing.influence.static_couple import decoupled, static_couple_modes
from service.balancing.influence.uncertainty import blur, predict_fitted, resampled_covariance, simulated_moment
from service.balancing.rotor.phasors import ComplexArray, polar
from service.engine import balance_quality, mapping
from service.engine.evidence.verdict import off_speed
from service.engine.influence_fits import (
    FittedModel,
    fit_runs,
    fit_saved_or_runs,
    fit_without_phase,
    placement_errors,
)
from service.engine.mapping import Channel
from service.engine.validation import check_answer, check_masses, plane_index, require_unique
from service.errors import InvalidInput, NumericsError
from service.messages import Message, Quantity, render
from service.model.correction import Correction, CorrectionRequest, FitQuality, PlaneMass, SensorVector
from service.model.diagnostic import Diagnostic, diagnostic
from service.model.influence import SavedInfluence
from service.model.machine import Machine
from service.model.message import message_data
from service.model.plan import Placement
from service.model.run import MassOnRotor, Run, RunOut

_OF_A_FIT = ("method", "damping", "max_mass_g", "planes", "mounted_later")
_OF_A_BALANCER = ("masses", "answer_id")
_FOREIGN = {
    "fit": (*_OF_A_BALANCER, "influence_of"),
    "balancer": (*_OF_A_FIT, "earlier_sessions", "influence_of"),
    "saved_influence": (*_OF_A_BALANCER, "earlier_sessions"),
    "amplitude_only": (*_OF_A_BALANCER, "earlier_sessions", "influence_of"),
}
NO_RESPONSE = 1e-10
"""Part of the vibration below which a change is rounding of the numbers sent."""
_BLURRED = 0.1
"""Uncertainty of the coefficients, see `blur`, from which the scatter of a correction is simulated."""
_RESAMPLING_SEED = 20260102
"""Of the draws behind intervals that have no closed form: the same runs give the same intervals."""


def solve_correction(
    machine: Machine,
    runs: Sequence[Run],
    run_out: Sequence[RunOut],
    request: CorrectionRequest,
    *,
    number: int,
    key: str,
    saved: SavedInfluence | None = None,
    earlier: tuple[tuple[Run, ...], ...] = (),
    on_rotor: tuple[MassOnRotor, ...] | None = None,
) -> Correction:
    """Continuous correction masses of a session; `runs` are those that are not excluded, in order.

    saved: coefficients for source saved_influence. earlier: runs of the earlier sessions asked for. on_rotor: ALL
    masses on the rotor now, which the trim is counted from; None: those of the latest run. Raises InvalidInput
    or NumericsError where the request or the runs do not allow an answer.
    """
    check_fields(request)
    if request.source == "balancer":
        return _balancer(machine, runs, request, number, key, on_rotor)
    used = tuple(run.number for run in runs)
    held: tuple[Diagnostic, ...] = ()
    if request.source == "saved_influence":
        if saved is None:
            raise InvalidInput(Message("no_influence.not_saved"), field="source", value=request.source)
        fitted, used, held = fit_saved_or_runs(machine, runs, run_out, saved)
    elif request.source == "amplitude_only":
        fitted = fit_without_phase(machine, runs)
    else:
        fitted = fit_runs(machine, runs, run_out, earlier)
    answer = _answered(machine, runs, request, fitted, number, key, used, saved, earlier, on_rotor)
    return replace(answer, diagnostics=(*held, *answer.diagnostics))


def _answered(
    machine: Machine,
    runs: Sequence[Run],
    request: CorrectionRequest,
    fitted: FittedModel,
    number: int,
    key: str,
    used: tuple[int, ...],
    saved: SavedInfluence | None,
    earlier: tuple[tuple[Run, ...], ...],
    on_rotor: tuple[MassOnRotor, ...] | None,
) -> Correction:
    if request.source == "fit" and not any(earlier):
        _require_response(fitted)
    asked = wishes(machine, runs, fitted.rows, request, on_rotor)
    answer = _solved(machine, runs, fitted, request, asked)
    fit, dof = fitted.fit, float(fitted.fit.scatter_dof.min())
    as_found = predict(fit, np.zeros(len(machine.planes), dtype=complex))
    present = _present(machine, runs, on_rotor)
    ungraded = balance_quality.tolerance_missing(machine)
    return Correction(
        id=key,
        number=number,
        request=request,
        runs=used,
        influence=mapping.coefficients(machine, fitted.rows, fit),
        initial=mapping.sensor_vectors(machine, fitted.rows, as_found),
        corrections=mapping.plane_masses(machine, answer.masses, answer.covariance, dof),
        trim=mapping.plane_masses(machine, answer.masses - present),
        predicted=expected_vectors(machine, fitted, answer.predicted),
        quality=_quality(fitted, answer),
        static_couple=balance_quality.static_couple_of(machine, answer.masses),
        tolerance=balance_quality.tolerance_of(machine, answer.masses - present, answer.covariance, dof),
        tolerance_missing=None if ungraded is None else render(ungraded),
        tolerance_missing_data=message_data(ungraded),
        repeatability=None if fitted.known is None else fitted.known.repeatability,
        alternatives=_alternatives(machine, fitted, request, asked),
        saved_influence=saved if request.source == "saved_influence" else None,
        earlier_runs=earlier,
        diagnostics=_diagnostics(machine, runs, fitted, request, asked, answer),
        on_rotor=on_rotor,
    )


def wishes(
    machine: Machine,
    runs: Sequence[Run],
    rows: Sequence[Channel],
    request: CorrectionRequest,
    on_rotor: tuple[MassOnRotor, ...] | None = None,
) -> CorrectionOptions:
    """What the correction must respect, in arrays. Raises InvalidInput for an unknown plane."""
    planes: tuple[int, ...] | None = None
    if request.planes is not None:
        require_unique("planes", request.planes)
        planes = tuple(plane_index(machine, name, f"planes[{i}]") for i, name in enumerate(request.planes))
    later = request.mounted_later
    if later is not None:
        check_masses(machine, later, "mounted_later")
    return CorrectionOptions(
        weights=mapping.weights(machine, rows, request.method),
        max_mass=None if request.max_mass_g is None else np.full(len(machine.planes), request.max_mass_g),
        planes=planes,
        held=_present(machine, runs, on_rotor) if planes else None,
        mounted_later=None if later is None else mapping.mass_vectors(machine, later, "mounted_later"),
        damping=request.damping or 0.0,
    )


def circumstances(runs: Sequence[Run], rows: Sequence[Channel]) -> RunConditions:
    """What else the runs tell, in arrays: speeds, broadband values, what a run was for."""
    speed, overall = mapping.speeds(runs, rows), mapping.overalls(runs, rows)
    return RunConditions(
        speed_rpm=speed if np.isfinite(speed).any() else None,
        nominal_rpm=np.array([row.speed_rpm for row in rows]),
        overall=overall if np.isfinite(overall).any() else None,
        check=np.array([run.kind == "check" for run in runs]),
        direction=tuple(row.sensor.direction if row.sensor.direction != "radial" else None for row in rows),
        bearing=tuple(row.sensor.bearing for row in rows),
    )


def examined(machine: Machine, runs: Sequence[Run], fitted: FittedModel) -> tuple[Diagnostic, ...]:
    """What the runs of a fit say of themselves, worst first."""
    found = diagnose(fitted.runs, fitted.fit, None, None, circumstances(runs, fitted.rows))
    return mapping.diagnostics(machine, runs, fitted.rows, found)


def correction_vectors(machine: Machine, correction: Correction) -> ComplexArray:
    """Total masses (P,) complex g of a correction."""
    return mapping.mass_vectors(
        machine,
        [MassOnRotor(plane=c.plane, mass_g=c.mass_g, angle_deg=c.angle_deg) for c in correction.corrections],
    )


def predicted_with(
    machine: Machine,
    fitted: FittedModel | None,
    masses: ComplexArray,
    pieces: Sequence[Placement] = (),
    angle_sd_deg: float | None = None,
    mass_sd_g: float | None = None,
) -> tuple[SensorVector, ...]:
    """Vibration to expect with masses (P,) complex g on the as-found rotor; empty without a fit.

    pieces: how they are made up, placed with these standard deviations of angle and mass each; by default those that
    the fit takes for the pieces of its runs.
    """
    if fitted is None:
        return ()
    spread, kept = placement_errors(machine, fitted, pieces, angle_sd_deg, mass_sd_g)
    return expected_vectors(machine, fitted, predict_fitted(fitted.fit, masses, spread, kept=kept))


def expected_vectors(machine: Machine, fitted: FittedModel, true: Prediction) -> tuple[SensorVector, ...]:
    """Vectors to expect, with the interval of the true amplitude and that of the next reading."""
    if fitted.known is None or fitted.reading is None:
        return mapping.sensor_vectors(machine, fitted.rows, true)
    share = fitted.known.errors.per_component
    spread = np.sqrt(true.scatter**2 + fitted.reading**2 + (share * np.abs(true.vibration)) ** 2)
    return mapping.sensor_vectors(machine, fitted.rows, true, Prediction(true.vibration, spread, true.dof))


def _require_response(fitted: FittedModel) -> None:
    """Raise NumericsError where no mass of the runs moved any sensor by more than rounding."""
    used = np.isfinite(fitted.fit.initial)
    moved = np.abs(fitted.fit.influence[used]) @ np.abs(fitted.runs.masses).max(axis=0)
    if (moved <= NO_RESPONSE * np.nan_to_num(np.abs(fitted.runs.vibration[:, used])).max(axis=0)).all():
        raise NumericsError(Message("planes_dependent.no_response"), field="runs", value=float(moved.max(initial=0.0)))


def _solved(
    machine: Machine, runs: Sequence[Run], fitted: FittedModel, request: CorrectionRequest, asked: CorrectionOptions
) -> Answer:
    """Solve; where the planes cannot be told apart because a sensor is dead or gave nothing, raise that instead."""
    try:
        return _solve(machine, fitted, request, asked)
    except NumericsError as error:
        cause = _dead_sensor(runs, fitted) if error.code == "planes_dependent" else None
        if cause is None:
            raise
        raise cause from error


def _dead_sensor(runs: Sequence[Run], fitted: FittedModel) -> NumericsError | None:
    """A sensor that reads the same in all runs, or lacks too many readings: the first such sensor, and its runs."""
    vibration = fitted.runs.vibration
    for s, row in enumerate(fitted.rows):
        name, seen = row.sensor.name, np.isfinite(vibration[:, s])
        own = [run for run in runs if run.nominal_speed_rpm == row.speed_rpm]
        lacking = [run.number for run in own if all(r.sensor != name or r.phase_deg is None for r in run.readings)]
        if lacking and not np.isfinite(fitted.fit.initial[s]):
            return NumericsError(
                Message("sensor_incomplete.fit", sensor=name, runs=lacking), field="runs", value=lacking
            )
        if seen.sum() > 1 and np.ptp(np.abs(vibration[seen, s])) <= 1e-9 * np.abs(vibration[seen, s]).max():
            return NumericsError(
                Message(
                    "sensor_stuck.fit" if np.abs(vibration[seen, s]).max() > 0.0 else "sensor_silent.fit", sensor=name
                ),
                field="runs",
                value=name,
            )
    return None


def _solve(machine: Machine, fitted: FittedModel, request: CorrectionRequest, asked: CorrectionOptions) -> Answer:
    if request.method == "static_couple":
        return _static_couple(machine, fitted)
    solve = minimax if request.method == "minimax" else least_squares
    answer = solve(fitted.fit, None, asked)
    if request.source == "amplitude_only":
        return answer
    rng = np.random.default_rng(_RESAMPLING_SEED)
    if not np.isfinite(answer.covariance).all():
        # Minimax, and a limit that binds, have no derivative to carry the scatter through: resample instead.
        spread = resampled_covariance(fitted.fit, lambda fit: solve(fit, None, asked).masses, rng)
    elif _free(asked) and blur(fitted.fit, asked.weights) > _BLURRED:
        spread = simulated_moment(fitted.fit, asked.weights, rng)
    else:
        return answer
    return Answer(answer.masses, answer.predicted, spread, answer.objective, answer.lower_bound)


def _free(asked: CorrectionOptions) -> bool:
    """Whether nothing but the weights of the sensors decides a correction."""
    return asked.planes is None and asked.mounted_later is None and not asked.damping and asked.max_mass is None


def _static_couple(machine: Machine, fitted: FittedModel) -> Answer:
    """Static and couple part corrected by themselves. Raises InvalidInput but for two planes and two sensors."""
    places = mapping.plane_places(machine)
    used = np.flatnonzero(np.isfinite(fitted.fit.initial))
    if places is None or len(places) != 2 or len(used) != 2:
        raise InvalidInput(Message("invalid_input.static_couple_places"), field="method", value="static_couple")
    modes = static_couple_modes(np.array([plane.radius_mm for plane in machine.planes]), places)
    masses = decoupled(fitted.fit.influence[used], fitted.fit.initial[used], modes)
    predicted = predict(fitted.fit, masses)
    weights = mapping.weights(machine, fitted.rows, None)
    seen = np.abs(predicted.vibration[used]) * (1.0 if weights is None else weights[used])
    best = least_squares(fitted.fit, weights).objective
    return Answer(masses, predicted, np.full((4, 4), np.nan), float(np.sqrt((seen**2).sum())), best)


def _diagnostics(
    machine: Machine,
    runs: Sequence[Run],
    fitted: FittedModel,
    request: CorrectionRequest,
    asked: CorrectionOptions,
    answer: Answer,
) -> tuple[Diagnostic, ...]:
    speeds = (*_speeds(machine, fitted.rows), *_weighting(fitted.rows, request))
    if len(fitted.runs.masses) > 1 and request.source != "amplitude_only":
        found = diagnose(fitted.runs, fitted.fit, answer, asked, circumstances(runs, fitted.rows))
        return (*speeds, *mapping.diagnostics(machine, runs, fitted.rows, found))
    last = runs[-len(fitted.runs.masses) :]
    seen = mapping.diagnostics(
        machine, last, fitted.rows, tuple(examine_readings(fitted.runs, fitted.fit, circumstances(last, fitted.rows)))
    )
    if fitted.amplitudes is None or fitted.amplitudes.resolving_run is None:
        return (*speeds, *seen)
    names = [plane.name for plane in machine.planes]
    extra = [
        Message("piece_at", mass=Quantity(mass, "g"), angle=Quantity(angle, "deg"), plane=name)
        for name, vector in zip(names, fitted.amplitudes.resolving_run, strict=True)
        for mass, angle in [polar(complex(vector), machine.angle_sense)]
        if mass > 0.0
    ]
    told = Message("ambiguous_without_phase", corrections=len(fitted.amplitudes.models), masses=extra)
    return (*speeds, *seen, diagnostic(told, "warning"))


def _speeds(machine: Machine, rows: Sequence[Channel]) -> tuple[Diagnostic, ...]:
    """Say so where nothing was measured at the service speed: what was found holds for another one."""
    service = machine.service_speed_rpm
    measured = sorted({row.speed_rpm for row in rows})
    if any(not off_speed(rpm, service) for rpm in measured):
        return ()
    nearest = min(measured, key=lambda rpm: abs(rpm - service))
    return (
        diagnostic(
            Message("service_speed_not_measured", service_rpm=service, measured_rpm=nearest),
            "warning",
        ),
    )


def _weighting(rows: Sequence[Channel], request: CorrectionRequest) -> tuple[Diagnostic, ...]:
    """Say how sensors of different kinds are weighed against each other, where no limits are asked to decide it."""
    if request.method in ("weighted", "minimax") or not mapping.of_different_kind(rows):
        return ()
    return (diagnostic(Message("sensors_of_different_kind"), "info"),)


def _alternatives(
    machine: Machine, fitted: FittedModel, request: CorrectionRequest, asked: CorrectionOptions
) -> tuple[tuple[PlaneMass, ...], ...]:
    """Corrections of the other models that explain amplitudes without phase."""
    if fitted.amplitudes is None:
        return ()
    others = [FittedModel(fitted.rows, model, fitted.runs) for model in fitted.amplitudes.models[1:]]
    return tuple(mapping.plane_masses(machine, _solve(machine, other, request, asked).masses) for other in others)


def _balancer(
    machine: Machine,
    runs: Sequence[Run],
    request: CorrectionRequest,
    number: int,
    key: str,
    on_rotor: tuple[MassOnRotor, ...] | None,
) -> Correction:
    if request.masses is None:
        raise InvalidInput(Message("invalid_input.answer_without_masses"), field="masses", value=None)
    check_answer(machine, request.masses)
    vectors = mapping.mass_vectors(machine, request.masses)
    return Correction(
        id=key,
        number=number,
        request=request,
        runs=(),
        influence=(),
        initial=(),
        corrections=mapping.plane_masses(machine, vectors),
        trim=mapping.plane_masses(machine, vectors - _present(machine, runs, on_rotor)),
        predicted=(),
        quality=None,
        static_couple=balance_quality.static_couple_of(machine, vectors),
        tolerance=None,
        alternatives=(),
        saved_influence=None,
        earlier_runs=(),
        diagnostics=(),
        on_rotor=on_rotor,
    )


def check_fields(request: CorrectionRequest) -> None:
    """Refuse fields that belong to another source than the one asked for."""
    for name in _FOREIGN[request.source]:
        if getattr(request, name) is not None:
            raise InvalidInput(
                Message("invalid_input.option_of_other_source", name=name, source=request.source),
                field=name,
                value=name,
            )


def _quality(fitted: FittedModel, answer: Answer) -> FitQuality:
    used = np.isfinite(fitted.fit.initial)
    # Numbers of different units are compared as what they mean, or the condition would follow the unit typed.
    seen = fitted.fit.influence[used] / mapping.scales(fitted.rows)[used, None]
    return FitQuality(
        condition=mapping.known(condition(seen)),
        significance=tuple(float(share) for share in significance(seen)),
        degrees_of_freedom=tuple(int(dof) for dof in fitted.fit.dof[used]),
        objective_value=answer.objective,
        lower_bound=answer.lower_bound,
    )


def _present(machine: Machine, runs: Sequence[Run], on_rotor: tuple[MassOnRotor, ...] | None) -> ComplexArray:
    """Masses (P,) complex g on the rotor now; where that is not known, those of the latest run."""
    last = runs[-1].masses if runs else ()
    return mapping.mass_vectors(machine, last if on_rotor is None else on_rotor)
