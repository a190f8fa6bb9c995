"""Fit influence models from every source: runs, earlier sessions, saved coefficients, amplitudes alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.influence.amplitude_only import AmplitudeFit, fit_amplitudes
from service.balancing.influence.fit import InfluenceFit, RunSet
from service.balancing.influence.run_errors import Errors, Repeats, fit_with_errors, with_repeatability
from service.balancing.influence.saved import one_run
from service.balancing.influence.speed_scatter import with_speed_scatter
from service.balancing.influence.uncertainty import blur, placement_covariance
from service.balancing.rotor.phasors import ComplexArray, FloatArray, phasor
from service.engine import mapping
from service.engine.evidence.follow_up import coefficients_outdated, outdated_sensors
from service.engine.evidence.known_errors import Key, KnownErrors, errors_of, pieces_of
from service.engine.mapping import Channel
from service.engine.saved_influence import as_arrays
from service.engine.validation import plane_index
from service.errors import Conflict, InvalidInput
from service.messages import Message, Quantity
from service.model.correction import Correction
from service.model.diagnostic import Diagnostic
from service.model.influence import SavedInfluence
from service.model.machine import Machine
from service.model.plan import Placement
from service.model.run import Run, RunOut

_SEED = 20260101
"""Of the starting points where amplitudes alone are fitted: the same runs give the same answer."""


MAX_BLUR = 0.3
"""Uncertainty of the coefficients, see `blur`, up to which runs that were not made for it may take over a fit."""


@dataclass(frozen=True)
class FittedModel:
    """A fit with the rows it is of, and the runs as arrays, their scatter widened by all that a run errs by.

    known: what that is. pieces: the pieces behind the first of the fit's shared errors, in their order. reading: (S,)
    scatter of a reading per real component, by itself; nan where none is stated.
    """

    rows: tuple[Channel, ...]
    fit: InfluenceFit
    runs: RunSet
    amplitudes: AmplitudeFit | None = None
    known: KnownErrors | None = None
    pieces: tuple[Key, ...] = ()
    reading: FloatArray | None = None


def fit_runs(
    machine: Machine,
    runs: Sequence[Run],
    run_out: Sequence[RunOut],
    earlier: Sequence[Sequence[Run]] = (),
    before: Repeats | None = None,
) -> FittedModel:
    """Influence coefficients from runs. Raises InvalidInput, NumericsError where they do not determine them.

    earlier: runs of other sessions on the machine. Each has an as-found vibration of its own: its difference is fitted
    as one more unknown beside the planes, and dropped. before: what earlier sessions told of the repeatability.
    """
    require_runs(runs)
    rows = mapping.channels(machine, runs)
    known = mapping.run_set(machine, runs, run_out, rows)
    _require_phase(runs, known)
    speeds = [mapping.speeds(runs, rows)]
    sets, everyone = [known], list(runs)
    for group in earlier:
        usable = [run for run in group if run.nominal_speed_rpm in {row.speed_rpm for row in rows}]
        sets.append(mapping.run_set(machine, usable, run_out, rows))
        speeds.append(mapping.speeds(usable, rows))
        everyone += usable
    errors = errors_of(machine, sets, before)
    pieces, keys = pieces_of(machine, everyone)
    whole = with_repeatability(with_speed_scatter(_joined(sets), np.concatenate(speeds)), errors.errors)
    fit = fit_with_errors(whole, errors.errors, pieces)
    count, planes = len(known.masses), len(machine.planes)
    if len(sets) > 1:
        fit = replace(
            fit,
            influence=fit.influence[:, :planes],
            covariance=fit.covariance[:, : planes + 1, : planes + 1],
            residuals=fit.residuals[:count],
            leverage=fit.leverage[:count],
            estimator=fit.estimator[:, : planes + 1, :count],
            shared=fit.shared[:, :, : planes + 1],
        )
    return FittedModel(
        rows,
        fit,
        replace(known, scatter=whole.scatter[:count]),
        known=errors,
        pieces=keys,
        reading=_of_a_reading(known.scatter),
    )


def _joined(sets: Sequence[RunSet]) -> RunSet:
    """Runs of several sessions as one; each but the first has a mark, scaled like a mass, as one more plane."""
    if len(sets) == 1:
        return sets[0]
    own = np.concatenate([np.full(len(s.masses), g, dtype=np.int64) for g, s in enumerate(sets)])
    marks = (own[:, None] == np.arange(1, len(sets))).astype(complex)
    return RunSet(
        masses=np.concatenate([np.concatenate([s.masses for s in sets]), marks], axis=1),
        vibration=np.concatenate([s.vibration for s in sets]),
        scatter=np.concatenate([s.scatter for s in sets]),
        labels=sets[0].labels,
    )


def _of_a_reading(scatter: FloatArray) -> FloatArray:
    """Typical scatter (S,) of a reading: the root mean square of those stated (K, S); nan where none is."""
    known = scatter > 0.0
    count = known.sum(axis=0)
    square = np.where(known, scatter, 0.0) ** 2
    return np.asarray(np.where(count > 0, np.sqrt(square.sum(axis=0) / np.maximum(count, 1)), np.nan))


def fit_saved(
    machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], saved: SavedInfluence
) -> tuple[FittedModel, int]:
    """The latest run with saved coefficients, and its number. Raises InvalidInput, or Conflict for another speed.

    The coefficients hold at the nominal speed: what the run turned beside it widens the scatter of its readings.
    """
    require_runs(runs)
    run = runs[-1]
    rows = mapping.channels(machine, [run])
    known = mapping.run_set(machine, [run], run_out, rows)
    _require_phase([run], known)
    alike = [one for one in runs if one.nominal_speed_rpm == run.nominal_speed_rpm]
    errors = errors_of(machine, (mapping.run_set(machine, alike, run_out, rows),))
    reading = _of_a_reading(known.scatter)
    known = with_speed_scatter(known, mapping.speeds([run], rows), run.nominal_speed_rpm)
    known = with_repeatability(known, errors.errors)
    arrays = as_arrays(machine, saved, rows)
    if not np.isfinite(arrays.influence).any():
        raise Conflict(
            Message("no_influence.other_speed", speed=Quantity(run.nominal_speed_rpm, "r/min")),
            field="source",
            value=run.nominal_speed_rpm,
        )
    fit = one_run(arrays, known.masses[0], known.vibration[0], known.scatter[0], known.labels)
    return FittedModel(rows, fit, known, known=errors, reading=reading), run.number


def fit_saved_or_runs(
    machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], saved: SavedInfluence
) -> tuple[FittedModel, tuple[int, ...], tuple[Diagnostic, ...]]:
    """The latest run with saved coefficients, unless the session's own runs contradict them: then a fit of these.

    Returns the fit, the numbers of the runs in it, and what is to be said of the coefficients. Where the runs do not
    determine a fit, the saved coefficients stay, with a finding of severity error. Raises as `fit_saved`.
    """
    fitted, last = fit_saved(machine, runs, run_out, saved)
    alike = [run for run in runs if run.nominal_speed_rpm == runs[-1].nominal_speed_rpm]
    share = fitted.known.errors.per_component if fitted.known is not None else 0.0
    sensors = outdated_sensors(as_arrays(machine, saved, fitted.rows), machine, alike, run_out, share)
    if not sensors:
        return fitted, (last,), ()
    own = _own_fit(machine, alike, run_out)
    if own is None:
        return fitted, (last,), (coefficients_outdated(sensors, replaced=False),)
    return own, tuple(run.number for run in alike), (coefficients_outdated(sensors, replaced=True),)


def _own_fit(machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut]) -> FittedModel | None:
    """A fit of the session's own runs, where they tell the planes apart well enough to correct by."""
    try:
        fitted = fit_runs(machine, runs, run_out)
    except InvalidInput:
        return None
    seen = blur(fitted.fit)
    good = seen <= MAX_BLUR if np.isfinite(seen) else fitted.fit.condition <= 1.0 / MAX_BLUR
    return fitted if good and np.isfinite(fitted.fit.initial).any() else None


def fit_without_phase(machine: Machine, runs: Sequence[Run]) -> FittedModel:
    """Coefficients from amplitudes alone, the best model first. Raises NumericsError where there are too few runs."""
    require_runs(runs)
    rows = mapping.channels(machine, runs)
    known = mapping.run_set(machine, runs, (), rows)
    found = fit_amplitudes(
        known.masses, mapping.amplitudes(runs, rows), np.random.default_rng(_SEED), labels=known.labels
    )
    return FittedModel(rows, found.models[0], known, found)


def fit_again(
    machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], correction: Correction
) -> FittedModel | None:
    """The fit that a correction rests on, from the runs it names; None for a balancer's answer."""
    used = [run for run in runs if run.number in correction.runs]
    match correction.request.source:
        case "fit":
            return fit_runs(machine, used, run_out, correction.earlier_runs)
        case "saved_influence" if len(used) > 1:
            return fit_runs(machine, used, run_out)
        case "saved_influence" if correction.saved_influence is not None:
            return fit_saved(machine, used, run_out, correction.saved_influence)[0]
        case "amplitude_only":
            return fit_without_phase(machine, used)
    return None


def placement_errors(
    machine: Machine,
    fitted: FittedModel,
    pieces: Sequence[Placement],
    angle_sd_deg: float | None = None,
    mass_sd_g: float | None = None,
) -> tuple[FloatArray, ComplexArray]:
    """Covariance (2P, 2P) in g^2 of pieces that go on, and what those that were on already do, (J, S), as `shared`.

    Standard deviations of angle and mass that are not given are those of the pieces of the runs.
    """
    errors = fitted.known.errors if fitted.known is not None else Errors()
    count = len(machine.planes)
    kept = np.zeros(fitted.fit.shared.shape[:2], dtype=np.complex128)
    vectors, planes = [], []
    left = {key: j for j, key in enumerate(fitted.pieces[: len(kept)])}
    for mass in mapping.as_masses(pieces):
        plane = plane_index(machine, mass.plane, "plane")
        vector = phasor(mass.mass_g, mass.angle_deg, machine.angle_sense)
        before = left.pop((mass.plane, mass.mass_g, mass.angle_deg % 360.0), None)
        if before is not None and angle_sd_deg is None and mass_sd_g is None:
            kept[before] = fitted.fit.influence[:, plane] * errors.placement * abs(vector)
        else:
            vectors.append(vector)
            planes.append(plane)
    if not vectors:
        return np.zeros((2 * count, 2 * count)), kept
    placed = np.array(vectors)
    mass_sd = errors.mass_sd * np.abs(placed) if mass_sd_g is None else mass_sd_g
    angle_sd = errors.angle_sd if angle_sd_deg is None else float(np.radians(angle_sd_deg))
    return placement_covariance(placed, np.array(planes, dtype=np.int64), count, mass_sd, angle_sd), kept


def _require_phase(runs: Sequence[Run], known: RunSet) -> None:
    """Raise InvalidInput where amplitudes were measured and not one of them has a phase."""
    if np.isfinite(known.vibration).any() or not any(reading.amplitude for run in runs for reading in run.readings):
        return
    raise InvalidInput(Message("no_phase", count=len(runs)), field="source", value=len(runs))


def require_runs(runs: Sequence[Run]) -> None:
    """Raise InvalidInput where there is no run."""
    if not runs:
        raise InvalidInput(Message("too_few_runs.none"), field="runs", value=0)


def used(runs: Iterable[Run]) -> tuple[Run, ...]:
    """The runs that enter the fit: all but the excluded."""
    return tuple(run for run in runs if not run.excluded)
