"""Compare the answers of a log with those computed again: one line for each difference."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Iterator, Sequence

from service.model.correction import Correction, Ellipse, PlaneMass, SensorVector
from service.model.plan import Plan

SCATTERS = 2.0
"""A predicted vector within this many standard deviations of what it was is within its uncertainty."""


def differences(
    was: tuple[Sequence[Correction], Sequence[Plan]],
    now: tuple[Sequence[Correction], Sequence[Plan]],
    tolerance: float,
) -> tuple[str, ...]:
    """Changes of corrections and plans; lists are shorter where the log holds none.

    tolerance: what two answers may differ by and be the same, relative to the greatest mass, vibration or objective of
    the answer. A change beyond it that the answer's own stated uncertainty covers is listed, and said to be covered.
    """
    out: list[str] = []
    for correction, again in zip(was[0], now[0], strict=False):
        out += (f"correction {correction.number}: {line}" for line in _of_correction(correction, again, tolerance))
    for plan, anew in zip(was[1], now[1], strict=False):
        out += (f"plan {plan.number}: {line}" for line in _of_plan(plan, anew, tolerance))
    return tuple(out)


def _of_correction(was: Correction, now: Correction, tolerance: float) -> Iterator[str]:
    yield from _masses(was.corrections, now.corrections, tolerance)
    scale = max((one.amplitude for one in (*was.initial, *was.predicted)), default=0.0)
    yield from _vibration(was.predicted, now.predicted, scale * tolerance)
    yield from _sets("diagnostics", (one.code for one in was.diagnostics), (one.code for one in now.diagnostics))


def _of_plan(was: Plan, now: Plan, tolerance: float) -> Iterator[str]:
    if was.status != now.status:
        yield f"status {was.status} -> {now.status}"
    yield from _sets(
        "placements",
        (f"{p.plane} {p.position_deg:g} deg {p.mass_g:g} g" for p in was.placements),
        (f"{p.plane} {p.position_deg:g} deg {p.mass_g:g} g" for p in now.placements),
    )
    old, new = was.objective_value, now.objective_value
    if (old is None) != (new is None) or (
        old is not None and new is not None and abs(new - old) > tolerance * max(abs(old), abs(new))
    ):
        yield f"objective {old} -> {new} {now.objective_unit or ''}".rstrip()
    scale = max((one.amplitude for one in was.predicted), default=0.0)
    yield from _vibration(was.predicted, now.predicted, scale * tolerance)


def _masses(was: Sequence[PlaneMass], now: Sequence[PlaneMass], tolerance: float) -> Iterator[str]:
    scale = max((abs(one.mass_g) for one in (*was, *now)), default=0.0)
    yield from _sets("planes", (one.plane for one in was), (one.plane for one in now))
    again = {one.plane: one for one in now}
    for old in was:
        new = again.get(old.plane)
        if new is None:
            continue
        moved = _vector(new.mass_g, new.angle_deg) - _vector(old.mass_g, old.angle_deg)
        if abs(moved) > tolerance * scale:
            covered = old.ellipse is not None and _inside(old.ellipse, moved)
            yield (
                f"plane {old.plane}: {old.mass_g:.6g} g at {old.angle_deg:.6g} deg -> {new.mass_g:.6g} g at "
                f"{new.angle_deg:.6g} deg{_covered(covered)}"
            )


def _vibration(was: Sequence[SensorVector], now: Sequence[SensorVector], least: float) -> Iterator[str]:
    again = {(one.sensor, one.speed_rpm): one for one in now}
    yield from _sets("predicted sensors", (one.sensor for one in was), (one.sensor for one in now))
    for old in was:
        new = again.get((old.sensor, old.speed_rpm))
        if new is None:
            continue
        moved = abs(_vector(new.amplitude, new.phase_deg) - _vector(old.amplitude, old.phase_deg))
        if moved > least:
            covered = old.scatter is not None and moved <= SCATTERS * old.scatter
            yield (
                f"predicted {old.sensor}: {old.amplitude:.6g} at {old.phase_deg:.6g} deg -> {new.amplitude:.6g} at "
                f"{new.phase_deg:.6g} deg{_covered(covered)}"
            )


def _sets(what: str, was: Iterable[str], now: Iterable[str]) -> Iterator[str]:
    old, new = sorted(was), sorted(now)
    if old != new:
        yield f"{what} {', '.join(old) or 'none'} -> {', '.join(new) or 'none'}"


def _covered(covered: bool) -> str:
    return " (within its stated uncertainty)" if covered else ""


def _vector(size: float, degrees: float) -> complex:
    return cmath.rect(size, math.radians(degrees))


def _inside(ellipse: Ellipse, moved: complex) -> bool:
    if not (ellipse.major_g > 0.0 and ellipse.minor_g > 0.0):
        return False
    turned = moved * cmath.rect(1.0, -math.radians(ellipse.angle_deg))
    return math.hypot(turned.real / ellipse.major_g, turned.imag / ellipse.minor_g) <= 1.0
