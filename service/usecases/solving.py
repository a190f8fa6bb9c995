"""From documents to answers, without storage: what the service, `drumtrue solve` and the replay of logs share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from db.documents.correction import Correction, CorrectionRequest, PlaneMass, SensorVector
from db.documents.machine import Machine
from db.documents.run import MassOnRotor, Run, RunOut
from service.balancing.corrections import least_squares
from service.balancing.fit import InfluenceFit, fit_influence, predict
from service.balancing.phasors import ComplexArray
from service.errors import InvalidInput
from service.usecases import mapping
from service.usecases.mapping import Channel
from service.usecases.rules import check_masses

Stop = Callable[[], bool]


@dataclass(frozen=True)
class Fitted:
    """A fit with the rows it is of."""

    rows: tuple[Channel, ...]
    fit: InfluenceFit


def fit_runs(machine: Machine, runs: Sequence[Run], run_out: Sequence[RunOut]) -> Fitted:
    """Influence coefficients from runs. Raises NumericsError where they do not determine them."""
    if not runs:
        raise InvalidInput(
            "there is no run to fit",
            code="too_few_runs",
            field="runs",
            value=0,
            advice="take an initial run, then a trial run in each plane",
        )
    rows = mapping.channels(machine, runs)
    return Fitted(rows, fit_influence(mapping.run_set(machine, runs, run_out, rows), incomplete="leave_out"))


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
    if request.source == "balancer":
        return _balancer(machine, runs, request, number, key)
    for name in ("masses", "answer_id"):
        if getattr(request, name) is not None:
            raise InvalidInput(
                f"{name} belongs to a balancer's answer, the source is 'fit'",
                field=name,
                value=name,
                advice=f"leave {name} out, or ask for source 'balancer'",
            )
    fitted = fit_runs(machine, runs, run_out)
    answer = least_squares(fitted.fit)
    dof = int(fitted.fit.scatter_dof.min())
    as_found = predict(fitted.fit, np.zeros(len(machine.planes), dtype=complex))
    return Correction(
        id=key,
        number=number,
        request=request,
        runs=tuple(run.number for run in runs),
        influence=mapping.coefficients(machine, fitted.rows, fitted.fit),
        initial=mapping.sensor_vectors(machine, fitted.rows, as_found),
        corrections=mapping.plane_masses(machine, answer.masses, answer.covariance, dof),
        trim=_trim(machine, answer.masses, runs),
        predicted=mapping.sensor_vectors(machine, fitted.rows, answer.predicted),
        diagnostics=(),
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
    if request.method is not None:
        raise InvalidInput(
            "a balancer's answer is taken as it is",
            field="method",
            value=request.method,
            advice="leave the method out, or ask for source 'fit'",
        )
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
        diagnostics=(),
    )


def _trim(machine: Machine, total: ComplexArray, runs: Sequence[Run]) -> tuple[PlaneMass, ...]:
    present = mapping.mass_vectors(machine, runs[-1].masses) if runs else np.zeros(len(total), dtype=complex)
    return mapping.plane_masses(machine, total - present)
