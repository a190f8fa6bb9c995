"""Findings about single sensors and the conditions of the runs."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from service.balancing.influence.diagnosis.findings import Finding, RunConditions, Severity
from service.balancing.influence.fit import InfluenceFit, RunSet
from service.balancing.rotor.phasors import FloatArray
from service.messages import Message, Quantity

# Below this share of a sensor's greatest amplitude a phase means little and is not judged.
_SMALL = 0.2
# Standard deviation of the phase, in radians, above which it is unsteady.
_UNSTEADY = 0.2
_SPEED_DRIFT = 0.02
# Share by which a run's speed may be off the nominal one that its coefficients are used at.
_SPEED_OFF = 0.05
# Share of the broadband value that 1x must have: below it, more than half the energy is not unbalance.
_SHARE_OF_1X = 0.7
# CSI 2140 manual, page 250: 1x horizontal to vertical within 3 : 1, a quarter turn apart within 30 degrees.
_RATIO = 3.0
_QUARTER_TURN = np.radians(30.0)
# A mass that changes both directions in the ratio they stand in, within this factor, shows what the support does.
_ALIKE = np.log(1.6)


def examine(runs: RunSet, fit: InfluenceFit, known: RunConditions) -> list[Finding]:
    """Examine each sensor for silence, repetition and unsteadiness, and the runs for speed and cause."""
    amplitude = np.abs(runs.vibration)
    found = _dead(runs, fit, amplitude) + _unsteady(runs, amplitude)
    if known.speed_rpm is not None:
        found += _speed_drift(runs, known) or _speed_off_nominal(runs, known)
    if known.overall is not None:
        found += _not_1x(runs, known, amplitude)
    if any(known.direction):
        found += _directions(fit, known)
    return found


def _dead(runs: RunSet, fit: InfluenceFit, amplitude: FloatArray) -> list[Finding]:
    name, found = runs.labels.sensor, []
    first = runs.vibration[0]
    # The same number to the last digit in every run is no measurement.
    stuck = (np.abs(runs.vibration - first) <= 1e-9 * np.abs(first)).all(axis=0) & (len(amplitude) > 2)
    for s in np.flatnonzero(stuck):
        silent = first[s] == 0.0
        found.append(
            Finding(
                Message("sensor_silent" if silent else "sensor_stuck", sensor=name(int(s)), runs=len(amplitude)),
                "error",
                sensors=(int(s),),
            )
        )
    for s in np.flatnonzero(np.isnan(fit.initial)):
        told = Message("sensor_incomplete", sensor=name(int(s)))
        found.append(Finding(told, "warning", sensors=(int(s),)))
    return found


def _unsteady(runs: RunSet, amplitude: FloatArray) -> list[Finding]:
    if not (runs.scatter > _UNSTEADY * amplitude).any():
        return []
    judged = (amplitude >= _SMALL * np.nanmax(amplitude, axis=0, initial=0.0)) & (runs.scatter > 0.0)
    judged &= amplitude > 0.0
    turn = np.divide(runs.scatter, amplitude, out=np.zeros_like(amplitude), where=judged)
    # More than half of the runs: a single poor run is the business of the run's own check.
    bad = np.flatnonzero(2 * (turn > _UNSTEADY).sum(axis=0) > np.maximum(judged.sum(axis=0), 1))
    return [
        Finding(
            Message(
                "phase_unsteady",
                sensor=runs.labels.sensor(int(s)),
                turn=Quantity(float(np.degrees(turn[:, s].max())), "deg"),
            ),
            "warning",
            sensors=(int(s),),
        )
        for s in bad
    ]


def _speed_drift(runs: RunSet, known: RunConditions) -> list[Finding]:
    assert known.speed_rpm is not None  # noqa: S101
    speed = known.speed_rpm
    slowest = speed.min(axis=0)
    if (speed.max(axis=0) - slowest <= _SPEED_DRIFT * slowest).all():
        return []
    seen = np.isfinite(speed)
    reference = known.nominal_rpm
    if reference is None:
        pairs = zip(speed.T, seen.T, strict=True)
        reference = np.array([np.median(column[ok]) if ok.any() else 1.0 for column, ok in pairs])
    share = speed / reference
    each = np.where(seen, share, 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
    judged = seen.any(axis=1)
    if not judged.any():
        return []
    off = np.where(judged, each / np.median(each[judged]) - 1.0, 0.0)
    bad = [int(k) for k in np.flatnonzero(np.abs(off) > _SPEED_DRIFT)]
    if not bad:
        return []
    return [
        Finding(
            Message("speed_drift", runs=map(runs.labels.run, bad), share=np.abs(off).max()),
            "warning",
            runs=tuple(bad),
        )
    ]


def _speed_off_nominal(runs: RunSet, known: RunConditions) -> list[Finding]:
    """Runs whose measured speed is not the nominal one, though they agree, or one alone was measured."""
    if known.nominal_rpm is None or known.speed_rpm is None:
        return []
    off = np.abs(known.speed_rpm / known.nominal_rpm - 1.0)
    worst = np.where(np.isfinite(off), off, 0.0).max(axis=1)
    bad = [int(k) for k in np.flatnonzero(worst > _SPEED_OFF)]
    if not bad:
        return []
    return [
        Finding(
            Message("speed_off_nominal", runs=map(runs.labels.run, bad), share=worst.max()),
            "warning",
            runs=tuple(bad),
        )
    ]


def _not_1x(runs: RunSet, known: RunConditions, amplitude: FloatArray) -> list[Finding]:
    assert known.overall is not None  # noqa: S101
    if (amplitude >= _SHARE_OF_1X * known.overall).all():
        return []
    # The run with the least mass on the rotor shows what is wrong with the rotor itself.
    bare = int(np.argmin(np.abs(runs.masses).sum(axis=1)))
    judged = (known.overall[bare] > 0.0) & np.isfinite(amplitude[bare])
    share = np.divide(amplitude[bare], known.overall[bare], out=np.ones(len(judged)), where=judged)
    low = [int(s) for s in np.flatnonzero(share < _SHARE_OF_1X)]
    if 2 * len(low) <= judged.sum() or not low:
        return []
    return [
        Finding(
            Message("not_unbalance_1x_share", share=share[low].min(), sensors=map(runs.labels.sensor, low)),
            "warning",
            sensors=tuple(low),
        )
    ]


def _directions(fit: InfluenceFit, known: RunConditions) -> list[Finding]:
    """Compare directions at the same bearing: horizontal with vertical, axial with radial."""
    found = []
    count = len(known.direction)
    bearing = known.bearing or (None,) * count
    for a, b in combinations(range(count), 2):
        if bearing[a] is None or bearing[a] != bearing[b] or not np.isfinite(fit.initial[[a, b]]).all():
            continue
        kinds = {known.direction[a]: a, known.direction[b]: b}
        if "horizontal" in kinds and "vertical" in kinds:
            found += _across(fit, kinds["horizontal"], kinds["vertical"])
        elif "axial" in kinds and len(kinds) == 2 and None not in kinds:
            found += _along(fit, kinds["axial"], b if kinds["axial"] == a else a)
    return found


def _across(fit: InfluenceFit, horizontal: int, vertical: int) -> list[Finding]:
    name = fit.labels.sensor
    h, v = fit.initial[horizontal], fit.initial[vertical]
    great, small = max(abs(h), abs(v)), min(abs(h), abs(v))
    # What masses do alike is what the support does, by design or because a foot is loose: told, but no warning.
    severity: Severity = "info" if _as_masses_do(fit, horizontal, vertical) else "warning"
    if great > _RATIO * small:
        return [
            Finding(
                Message("not_unbalance_direction", horizontal=name(horizontal), vertical=name(vertical), ratio=_RATIO),
                severity,
                sensors=(horizontal, vertical),
            )
        ]
    turn = abs(np.angle(h / v)) if small > 0.0 else 0.5 * np.pi
    if abs(turn - 0.5 * np.pi) <= _QUARTER_TURN:
        return []
    return [
        Finding(
            Message(
                "not_unbalance_phase",
                horizontal=name(horizontal),
                vertical=name(vertical),
                turn=Quantity(float(np.degrees(turn)), "deg"),
            ),
            "info",
            sensors=(horizontal, vertical),
        )
    ]


def _as_masses_do(fit: InfluenceFit, one: int, other: int) -> bool:
    """Whether a mass moves two sensors in the ratio and phase in which they stand as found.

    Then the support is softer in one direction, and nothing but unbalance is needed to explain what they read.
    """
    a, b = fit.influence[one], fit.influence[other]
    if not np.isfinite(a).all() or not np.isfinite(b).all() or not (fit.initial[one] and fit.initial[other]):
        return False
    seen = (np.abs(a) > 0.0) & (np.abs(b) > 0.0)
    ratios = a[seen] / b[seen] / (fit.initial[one] / fit.initial[other])
    return bool(((np.abs(np.log(np.abs(ratios))) < _ALIKE) & (np.abs(np.angle(ratios)) < _QUARTER_TURN)).any())


def _along(fit: InfluenceFit, axial: int, radial: int) -> list[Finding]:
    if abs(fit.initial[axial]) < abs(fit.initial[radial]):
        return []
    return [
        Finding(
            Message("not_unbalance_axial", axial=fit.labels.sensor(axial), radial=fit.labels.sensor(radial)),
            "warning",
            sensors=(axial, radial),
        )
    ]
