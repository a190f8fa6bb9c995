"""Fit influence models from every source: runs, earlier sessions, saved coefficients, amplitudes alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.influence.amplitude_only import AmplitudeFit, fit_amplitudes
from service.balancing.influence.fit import InfluenceFit, RunSet, fit_influence
from service.balancing.influence.saved import one_run
from service.balancing.influence.speed_scatter import with_speed_scatter
from service.engine import mapping
from service.engine.mapping import Channel
from service.engine.saved_influence import as_arrays
from service.errors import Conflict, InvalidInput
from service.messages import Message, Quantity
from service.model.correction import Correction
from service.model.influence import SavedInfluence
from service.model.machine import Machine
from service.model.run import Run, RunOut

_SEED = 20260101
"""Of the starting points where amplitudes alone are fitted: the same runs give the same answer."""


@dataclass(frozen=True)
class Fitted:
    """A fit with the rows it is of, and the runs as arrays, their scatter widened by their speeds."""

    rows: tuple[Channel, ...]
    fit: InfluenceFit
    runs: RunSet
    amplitudes: AmplitudeFit | None = None


def fit_runs(
    machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], earlier: Sequence[Sequence[Run]] = ()
) -> Fitted:
    """Influence coefficients from runs. Raises InvalidInput, NumericsError where they do not determine them.

    earlier: runs of other sessions on the machine. Each has an as-found vibration of its own: its difference is fitted
    as one more unknown beside the planes, and dropped.
    """
    require_runs(runs)
    rows = mapping.channels(machine, runs)
    known = mapping.run_set(machine, runs, run_out, rows)
    _require_phase(runs, known)
    speeds = [mapping.speeds(runs, rows)]
    if not any(earlier):
        known = with_speed_scatter(known, speeds[0])
        return Fitted(rows, fit_influence(known, incomplete="leave_out"), known)
    sets = [known]
    for group in earlier:
        usable = [run for run in group if run.nominal_speed_rpm in {row.speed_rpm for row in rows}]
        sets.append(mapping.run_set(machine, usable, run_out, rows))
        speeds.append(mapping.speeds(usable, rows))
    count, planes = len(known.masses), len(machine.planes)
    own = np.concatenate([np.full(len(s.masses), g, dtype=np.int64) for g, s in enumerate(sets)])
    # The mark of an earlier session is scaled like a mass, so that the design stays well conditioned.
    marks = (own[:, None] == np.arange(1, len(sets))).astype(complex)
    everything = RunSet(
        masses=np.concatenate([np.concatenate([s.masses for s in sets]), marks], axis=1),
        vibration=np.concatenate([s.vibration for s in sets]),
        scatter=np.concatenate([s.scatter for s in sets]),
        labels=known.labels,
    )
    everything = with_speed_scatter(everything, np.concatenate(speeds))
    fit = fit_influence(everything, incomplete="leave_out")
    narrowed = replace(
        fit,
        influence=fit.influence[:, :planes],
        covariance=fit.covariance[:, : planes + 1, : planes + 1],
        residuals=fit.residuals[:count],
        leverage=fit.leverage[:count],
    )
    return Fitted(rows, narrowed, replace(known, scatter=everything.scatter[:count]))


def fit_saved(
    machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], saved: SavedInfluence
) -> tuple[Fitted, int]:
    """The latest run with saved coefficients, and its number. Raises InvalidInput, or Conflict for another speed.

    The coefficients hold at the nominal speed: what the run turned beside it widens the scatter of its readings.
    """
    require_runs(runs)
    run = runs[-1]
    rows = mapping.channels(machine, [run])
    known = mapping.run_set(machine, [run], run_out, rows)
    _require_phase([run], known)
    known = with_speed_scatter(known, mapping.speeds([run], rows), run.nominal_speed_rpm)
    arrays = as_arrays(machine, saved, rows)
    if not np.isfinite(arrays.influence).any():
        raise Conflict(
            Message("no_influence.other_speed", speed=Quantity(run.nominal_speed_rpm, "r/min")),
            field="source",
            value=run.nominal_speed_rpm,
        )
    fit = one_run(arrays, known.masses[0], known.vibration[0], known.scatter[0], known.labels)
    return Fitted(rows, fit, known), run.number


def fit_without_phase(machine: Machine, runs: Sequence[Run]) -> Fitted:
    """Coefficients from amplitudes alone, the best model first. Raises NumericsError where there are too few runs."""
    require_runs(runs)
    rows = mapping.channels(machine, runs)
    known = mapping.run_set(machine, runs, (), rows)
    found = fit_amplitudes(
        known.masses, mapping.amplitudes(runs, rows), np.random.default_rng(_SEED), labels=known.labels
    )
    return Fitted(rows, found.models[0], known, found)


def fit_again(
    machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], correction: Correction
) -> Fitted | None:
    """The fit that a correction rests on, from the runs it names; None for a balancer's answer."""
    used = [run for run in runs if run.number in correction.runs]
    match correction.request.source:
        case "fit":
            return fit_runs(machine, used, run_out, correction.earlier_runs)
        case "saved_influence" if correction.saved_influence is not None:
            return fit_saved(machine, used, run_out, correction.saved_influence)[0]
        case "amplitude_only":
            return fit_without_phase(machine, used)
    return None


def _require_phase(runs: Sequence[Run], known: RunSet) -> None:
    """Raise InvalidInput where amplitudes were measured and not one of them has a phase."""
    if np.isfinite(known.vibration).any() or not any(reading.amplitude for run in runs for reading in run.readings):
        return
    raise InvalidInput(
        f"no reading of {'the run' if len(runs) == 1 else f'the {len(runs)} runs'} has a phase",
        code="no_phase",
        field="source",
        value=len(runs),
        advice="ask for source amplitude_only, which fits amplitudes alone (each trial mass at three angles), or check "
        "the key-phasor and measure again",
    )


def require_runs(runs: Sequence[Run]) -> None:
    """Raise InvalidInput where there is no run."""
    if not runs:
        raise InvalidInput(Message("too_few_runs.none"), field="runs", value=0)


def used(runs: Iterable[Run]) -> tuple[Run, ...]:
    """The runs that enter the fit: all but the excluded."""
    return tuple(run for run in runs if not run.excluded)
