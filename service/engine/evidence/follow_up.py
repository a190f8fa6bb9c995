"""Every plan is followed by its check: whether the drum did what was predicted, and got better at all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from service.balancing.influence.saved import SavedInfluence as Arrays
from service.balancing.rotor.phasors import phasor
from service.engine import mapping
from service.engine.mapping import Channel
from service.messages import Message
from service.model.diagnostic import Diagnostic, diagnostic
from service.model.machine import Machine
from service.model.plan import Plan
from service.model.run import Run, RunOut

MISSED = 0.15
"""Share of the as-found amplitude by which a check run may miss its prediction before it is said."""
MISSED_GRAVELY = 0.6
SURE = 4.0
"""Standard deviations per real component that a miss must have: chance alone does so once in 3,000."""
STOPS = ("round_worse", "coefficients_outdated")
"""What a check run may say that stops a session: another round like it would make matters worse."""
WORSE = 1.05
"""A round is worse where it leaves more than this times the vibration before it: repeatability does not do that."""


def follow_up(
    machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], check: Run, plan: Plan, source: str
) -> tuple[Diagnostic, ...]:
    """What a check run of a plan says of the plan, whatever its correction came from.

    runs: of the session before it, not excluded. source: of the plan's correction.
    """
    before = [run for run in runs if run.nominal_speed_rpm == check.nominal_speed_rpm]
    found = [_missed(machine, before, run_out, check, plan, source), _worse(machine, before, run_out, check)]
    return tuple(one for one in found if one is not None)


def outdated_sensors(
    arrays: Arrays, machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], share: float
) -> tuple[str, ...]:
    """Sensors at which runs of one speed contradict saved coefficients; share: repeatability per real component.

    Each run is compared with what the first run and the coefficients say of it. A difference counts where it is more
    than `MISSED` of the vibration as found and `SURE` times what readings, repeatability and coefficients err by.
    """
    if len(runs) < 2:
        return ()
    rows = [Channel(sensor, runs[0].nominal_speed_rpm) for sensor in machine.sensors]
    known = mapping.run_set(machine, runs, run_out, rows)
    steps = known.masses - known.masses[0]
    change = known.vibration - known.vibration[0]
    off = np.abs(change - steps @ arrays.influence.T)
    scatter = np.where(known.scatter > 0.0, known.scatter, 0.0) ** 2 + (share * np.abs(known.vibration)) ** 2
    spread = np.nan_to_num(np.einsum("kp,spq,kq->ks", steps, arrays.covariance, steps.conj()).real)
    allowed = np.maximum(MISSED * np.abs(known.vibration[0]), SURE * np.sqrt(scatter + scatter[0] + spread))
    bad = np.flatnonzero((off > allowed).any(axis=0))
    return tuple(machine.sensors[int(s)].name for s in bad)


def coefficients_outdated(sensors: Sequence[str], *, replaced: bool) -> Diagnostic:
    """Saved coefficients that the session's own runs contradict; replaced: a fit of these runs took their place."""
    if replaced:
        return diagnostic(Message("coefficients_replaced", sensors=sensors), "warning", sensors=tuple(sensors))
    return diagnostic(Message("coefficients_outdated", sensors=sensors), "error", sensors=tuple(sensors))


def _missed(
    machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], check: Run, plan: Plan, source: str
) -> Diagnostic | None:
    first = next((run for run in runs if run.kind == "initial"), None) or next(iter(runs), None)
    expected = {v.sensor: v for v in plan.predicted if v.speed_rpm == check.nominal_speed_rpm}
    if first is None or not expected:
        return None
    as_found = mapping.vectors_with_phase(machine, first, run_out)
    shares = {}
    for name, vector in mapping.vectors_with_phase(machine, check, run_out).items():
        size = abs(as_found.get(name, 0.0))
        if name not in expected or size == 0.0:
            continue
        wanted = expected[name]
        off = abs(vector - phasor(wanted.amplitude, wanted.phase_deg, machine.phase_sense))
        if off > MISSED * size and off > SURE * (wanted.scatter or 0.0):
            shares[name] = off / size
    if not shares:
        return None
    worst = max(shares.values())
    saved = source == "saved_influence"
    message = Message("coefficients_outdated.by_check" if saved else "prediction_missed.by_check", share=worst)
    return diagnostic(message, "error" if saved or worst > MISSED_GRAVELY else "warning", sensors=tuple(shares))


def _worse(machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut], check: Run) -> Diagnostic | None:
    """A check run that reads more than the drum did before the round: the run as found, or the check run before."""
    earlier = [run for run in runs if run.kind in ("initial", "check")]
    if not earlier:
        return None
    before = mapping.amplitudes_of(machine, earlier[-1], run_out)
    after = mapping.amplitudes_of(machine, check, run_out)
    shared = [name for name in after if before.get(name, 0.0) > 0.0]
    if not shared:
        return None
    limit = {s.name: mapping.limit_of(machine, Channel(s, check.nominal_speed_rpm)) for s in machine.sensors}
    # Within the limits a trim may well raise one sensor a little: that is no reason to stop.
    if all((limit[name] or 0.0) >= after[name] for name in shared):
        return None
    ratio = float(np.sqrt(np.mean([(after[name] / before[name]) ** 2 for name in shared])))
    if ratio <= WORSE:
        return None
    numbers = (earlier[-1].number, check.number)
    message = Message("round_worse", ratio=ratio, before=numbers[0], after=numbers[1])
    return diagnostic(message, "error", runs=numbers)
