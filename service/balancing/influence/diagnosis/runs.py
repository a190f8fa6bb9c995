"""Runs that contradict each other or the model, and senses that are turned."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from service.balancing.influence.diagnosis.blame import check_missed, named_alone, one_of_several
from service.balancing.influence.diagnosis.findings import Finding, RunConditions
from service.balancing.influence.diagnosis.misfit import Misfit, improbable, misfit_of, worst_miss
from service.balancing.influence.diagnosis.suspects import suspects_of
from service.balancing.influence.fit import InfluenceFit, RunSet, fit_influence
from service.balancing.rotor.phasors import IntArray
from service.messages import Message

# Two readings of one state this many standard deviations apart contradict each other.
_APART = 6.0
# Without a scatter, this share of the amplitude (or as many radians) does.
_APART_UNSTATED = 0.3

_BAD_RUN = 2e-4
# A misfit below this share of the amplitude does not spoil a correction, however significant.
_WORTH_SAYING = 0.1
_CHECK_MISSED = 0.15
_CHECK_MISSED_UNSTATED = 0.6
# The mirrored model must leave less than this share of the misfit.
_MIRROR = 0.1


def examine(runs: RunSet, fit: InfluenceFit, known: RunConditions) -> list[Finding]:
    """Examine the runs against each other, against the model and against its mirror image."""
    found = _contradictions(runs)
    if len(runs.masses) == runs.masses.shape[1] + 1:
        return found
    if found:
        return found + _named_of_contradictory(runs, fit, known)
    if worst_miss(runs, fit) <= _WORTH_SAYING:
        return found  # the usual session ends here
    misfit = misfit_of(runs, fit)
    mirrored = _mirrored(runs, misfit)
    return [mirrored] if mirrored else _misfits(runs, fit, misfit, known)


@lru_cache(maxsize=16)
def _pairs(count: int) -> tuple[IntArray, IntArray]:
    first, second = np.triu_indices(count, 1)
    return first, second


def _contradictions(runs: RunSet) -> list[Finding]:
    """Pairs of runs with the same masses and different readings."""
    tolerance = 1e-6 * np.abs(runs.masses).max()
    first, second = _pairs(len(runs.masses))
    same = (np.abs(runs.masses[first] - runs.masses[second]) <= tolerance).all(axis=1)
    if not same.any():
        return []
    first, second = first[same], second[same]
    gap = np.abs(runs.vibration[first] - runs.vibration[second])
    spread = np.sqrt(runs.scatter[first] ** 2 + runs.scatter[second] ** 2)
    size = np.maximum(np.abs(runs.vibration[first]), np.abs(runs.vibration[second]))
    allowed = np.where(spread > 0.0, _APART * spread, _APART_UNSTATED * size)
    name, found = runs.labels, []
    for pair, sensor in np.argwhere(gap > allowed):
        a, b, s = int(first[pair]), int(second[pair]), int(sensor)
        found.append(
            Finding(
                Message(
                    "runs_contradict",
                    run=name.run(a),
                    other=name.run(b),
                    sensor=name.sensor(s),
                    share=gap[pair, sensor] / size[pair, sensor],
                ),
                "error",
                runs=(a, b),
                sensors=(s,),
            )
        )
    return found


def _named_of_contradictory(runs: RunSet, fit: InfluenceFit, known: RunConditions) -> list[Finding]:
    """The one run that is wrong, where runs of the same masses differ and the others tell which."""
    found = suspects_of(runs, fit, known.nominal_rpm)
    return [named_alone(runs.labels, found, worst_miss(runs, fit))] if found.named else []


def _mirrored(runs: RunSet, misfit: Misfit) -> Finding | None:
    """Find that mirrored masses explain the runs far better than those stated."""
    if misfit.relative.max() < _CHECK_MISSED:
        return None
    if misfit.dof and not bool(improbable(np.array(misfit.total), np.array(misfit.dof), _BAD_RUN)):
        return None
    mirror = misfit_of(runs, fit_influence(RunSet(runs.masses.conj(), runs.vibration, runs.scatter), "leave_out"))
    squares = float(np.nansum(np.abs(misfit.missed / misfit.size) ** 2))
    if float(np.nansum(np.abs(mirror.missed / mirror.size) ** 2)) > _MIRROR * squares:
        return None
    return Finding(
        Message("sense_mirrored", missed=misfit.relative.max()),
        "error",
    )


def _misfits(runs: RunSet, fit: InfluenceFit, misfit: Misfit, known: RunConditions) -> list[Finding]:
    """Find the run that is wrong, or the runs of which one is, or that no single run is to blame."""
    check = known.check if known.check is not None else np.zeros(len(runs.masses), dtype=bool)
    improbably = improbable(misfit.statistic, misfit.freedom, _BAD_RUN) & (misfit.relative > _WORTH_SAYING)
    blind = (misfit.freedom == 0) & (misfit.relative > _CHECK_MISSED_UNSTATED)
    missed = [int(k) for k in np.flatnonzero(check & (misfit.relative > _CHECK_MISSED) & (improbably | blind))]
    wrong = [int(k) for k in np.flatnonzero(improbably)]
    if not missed and not wrong:
        return []
    found = suspects_of(runs, fit, known.nominal_rpm)
    worst = float(misfit.relative.max())
    if found.named and (not missed or found.candidates[0].fault.runs != (missed[-1],)):
        return [named_alone(runs.labels, found, worst)]
    if missed:
        return [check_missed(runs.labels, found, missed[-1], float(misfit.relative[missed[-1]]))]
    if found.sound:
        return [one_of_several(runs.labels, found, worst)]
    told = Message("not_linear", runs=map(runs.labels.run, wrong), missed=worst)
    return [Finding(told, "warning", runs=tuple(wrong))]
