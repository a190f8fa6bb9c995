"""From documents to answers, without storage: what the service, `drumtrue solve` and the replay of logs share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from db.documents.correction import Correction, CorrectionRequest, FitQuality, PlaneMass, SensorVector
from db.documents.machine import Machine
from db.documents.run import MassOnRotor, Run, RunOut
from service.balancing.analysis import Method, analyse
from service.balancing.corrections import Correction as Answer
from service.balancing.corrections import Wishes
from service.balancing.diagnosis.findings import Circumstances
from service.balancing.diagnosis.planes import significance
from service.balancing.fit import InfluenceFit, fit_influence, predict
from service.balancing.phasors import ComplexArray
from service.errors import InvalidInput
from service.usecases import mapping
from service.usecases.mapping import Channel
from service.usecases.rules import check_masses, plane_index

_FIT_ONLY = ("method", "damping", "max_mass_g", "planes", "mounted_later")


@dataclass(frozen=True)
class Fitted:
    """A fit with the rows it is of."""

    rows: tuple[Channel, ...]
    fit: InfluenceFit


def fit_runs(machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut]) -> Fitted:
    """Influence coefficients from runs. Raises NumericsError where they do not determine them."""
    require_runs(runs)
    rows = mapping.channels(machine, runs)
    return Fitted(rows, fit_influence(mapping.run_set(machine, runs, run_out, rows), incomplete="leave_out"))


def require_runs(runs: Sequence[Run]) -> None:
    """Raise InvalidInput where there is no run."""
    if not runs:
        raise InvalidInput(
            "there is no run to fit",
            code="too_few_runs",
            field="runs",
            value=0,
            advice="take an initial run, then a trial run in each plane",
        )


def solve_correction(
    machine: Machine,
    runs: Sequence[Run],
    run_out: Sequence[RunOut],
    request: CorrectionRequest,
    *,
    number: int,
    key: str,
) -> Correction:
    """Continuous correction masses of a session; `runs` are those that are not excluded, in order.

    Raises InvalidInput or NumericsError where the request or the runs do not allow an answer.
    """
    _check_fields(request)
    if request.source == "balancer":
        return _balancer(machine, runs, request, number, key)
    require_runs(runs)
    rows = mapping.channels(machine, runs)
    run_set = mapping.run_set(machine, runs, run_out, rows)
    method: Method = "minimax" if request.method == "minimax" else "least_squares"
    found = analyse(run_set, wishes(machine, runs, rows, request), method, circumstances(runs, rows))
    fit, answer = found.fit, found.correction
    as_found = predict(fit, np.zeros(len(machine.planes), dtype=complex))
    return Correction(
        id=key,
        number=number,
        request=request,
        runs=tuple(run.number for run in runs),
        influence=mapping.coefficients(machine, rows, fit),
        initial=mapping.sensor_vectors(machine, rows, as_found),
        corrections=mapping.plane_masses(machine, answer.masses, answer.covariance, int(fit.scatter_dof.min())),
        trim=_trim(machine, answer.masses, runs),
        predicted=mapping.sensor_vectors(machine, rows, answer.predicted),
        quality=_quality(fit, answer),
        diagnostics=mapping.diagnostics(machine, runs, rows, found.findings),
    )


def wishes(machine: Machine, runs: Sequence[Run], rows: Sequence[Channel], request: CorrectionRequest) -> Wishes:
    """What the correction must respect, in arrays. Raises InvalidInput for an unknown plane."""
    count = len(machine.planes)
    planes: tuple[int, ...] | None = None
    if request.planes is not None:
        planes = tuple(plane_index(machine, name, f"planes[{i}]") for i, name in enumerate(request.planes))
    later = request.mounted_later
    if later is not None:
        check_masses(machine, later, "mounted_later")
    weighted = request.method in ("weighted", "minimax")
    return Wishes(
        weights=1.0 / mapping.limits(machine, rows) if weighted else None,
        max_mass=None if request.max_mass_g is None else np.full(count, request.max_mass_g),
        planes=planes,
        held=mapping.mass_vectors(machine, runs[-1].masses) if planes else None,
        mounted_later=None if later is None else mapping.mass_vectors(machine, later, "mounted_later"),
        damping=request.damping or 0.0,
    )


def circumstances(runs: Sequence[Run], rows: Sequence[Channel]) -> Circumstances:
    """What else the runs tell, in arrays: speeds, broadband values, what a run was for."""
    speed, overall = mapping.speeds(runs, rows), mapping.overalls(runs, rows)
    return Circumstances(
        speed_rpm=speed if np.isfinite(speed).any() else None,
        nominal_rpm=np.array([row.speed_rpm for row in rows]),
        overall=overall if np.isfinite(overall).any() else None,
        check=np.array([run.kind == "check" for run in runs]),
        direction=tuple(row.sensor.direction if row.sensor.direction != "radial" else None for row in rows),
        bearing=tuple(row.sensor.bearing for row in rows),
    )


def correction_vectors(machine: Machine, correction: Correction) -> ComplexArray:
    """Total masses (P,) complex g of a correction."""
    return mapping.mass_vectors(
        machine,
        [MassOnRotor(plane=c.plane, mass_g=c.mass_g, angle_deg=c.angle_deg) for c in correction.corrections],
    )


def predicted_with(machine: Machine, fitted: Fitted | None, masses: ComplexArray) -> tuple[SensorVector, ...]:
    """Vibration to expect with masses (P,) complex g on the as-found rotor; empty without a fit."""
    if fitted is None:
        return ()
    return mapping.sensor_vectors(machine, fitted.rows, predict(fitted.fit, masses))


def _balancer(machine: Machine, runs: Sequence[Run], request: CorrectionRequest, number: int, key: str) -> Correction:
    if request.masses is None:
        raise InvalidInput(
            "a balancer's answer has masses",
            field="masses",
            value=None,
            advice="state masses:[{plane, mass_g, angle_deg}], one a plane, or the answer_id of a stored answer",
        )
    check_masses(machine, request.masses)
    named = [mass.plane for mass in request.masses]
    if len(set(named)) != len(named):
        raise InvalidInput(
            "a plane appears twice in the balancer's answer",
            field="masses",
            value=named,
            advice="state one continuous mass for each plane",
        )
    vectors = mapping.mass_vectors(machine, request.masses)
    return Correction(
        id=key,
        number=number,
        request=request,
        runs=(),
        influence=(),
        initial=(),
        corrections=mapping.plane_masses(machine, vectors),
        trim=_trim(machine, vectors, runs),
        predicted=(),
        quality=None,
        diagnostics=(),
    )


def _check_fields(request: CorrectionRequest) -> None:
    """Refuse fields that belong to another source than the one asked for."""
    foreign = {"fit": ("masses", "answer_id"), "balancer": _FIT_ONLY}[request.source]
    for name in foreign:
        if getattr(request, name) is not None:
            raise InvalidInput(
                f"{name} does not go with source {request.source!r}",
                field=name,
                value=name,
                advice=f"leave {name} out, or ask for the other source",
            )


def _quality(fit: InfluenceFit, answer: Answer) -> FitQuality:
    used = np.isfinite(fit.initial)
    return FitQuality(
        condition=mapping.known(fit.condition),
        significance=tuple(float(share) for share in significance(fit.influence[used])),
        degrees_of_freedom=tuple(int(dof) for dof in fit.dof[used]),
        objective_value=answer.objective,
        lower_bound=answer.lower_bound,
    )


def _trim(machine: Machine, total: ComplexArray, runs: Sequence[Run]) -> tuple[PlaneMass, ...]:
    present = mapping.mass_vectors(machine, runs[-1].masses) if runs else np.zeros(len(total), dtype=complex)
    return mapping.plane_masses(machine, total - present)
