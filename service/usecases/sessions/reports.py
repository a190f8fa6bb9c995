"""The report of a session."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from service.balancing.influence.corrections import least_squares
from service.balancing.influence.trim import combined, saved_mass
from service.balancing.rotor.phasors import phasor, polar
from service.engine import balance_quality, mapping
from service.engine.correction_solver import examined
from service.engine.evidence import verdict
from service.engine.influence_fits import fit_runs
from service.engine.rotor_state import Drum, on_rotor
from service.errors import InvalidInput
from service.messages import Message, render
from service.model.correction import Tolerance
from service.model.diagnostic import Diagnostic
from service.model.influence import Coefficient
from service.model.machine import Machine
from service.model.message import message_data
from service.model.plan import Placement
from service.model.report import BeforeAfter, PlaneLoad, Report
from service.model.run import MassOnRotor
from service.model.session import Session, SessionSummary
from service.model.stop import Stop
from service.runtime.context import AppContext
from service.usecases.session_view import stored_drum
from service.usecases.sessions import sessions, stops
from service.version import __version__


def report(work: AppContext, session_id: str) -> Report:
    """What the session came to, at one moment. Raises NotFound."""
    with work.one_moment() as one:
        session = sessions.get(one, session_id)
        drum = drum_of(session, stops.of(one, session_id))
    plan = drum.fitted
    fitted = () if plan is None else plan.fitted or ()
    known = _of_all_runs(drum)
    return Report(
        session=SessionSummary(**{name: getattr(session, name) for name in SessionSummary.__dataclass_fields__}),
        version=__version__,
        written_at=work.now(),
        machine=session.machine,
        conventions=conventions(session.machine),
        runs=len(session.runs),
        excluded_runs=tuple(run.number for run in session.runs if run.excluded),
        before_after=verdict.before_after(drum),
        fitted=fitted,
        planes=plane_loads(session.machine, fitted) if fitted else (),
        plan_status=None if plan is None else plan.status,
        plan_gap=None if plan is None else plan.gap,
        plan_probability_within=None if plan is None else plan.probability_within,
        plan_unit=None if plan is None else plan.objective_unit,
        tolerance=known.tolerance,
        tolerance_missing=None if known.ungraded is None else render(known.ungraded),
        tolerance_missing_data=message_data(known.ungraded),
        bearing_forces_n=None if plan is None else plan.bearing_forces_n,
        influence=known.influence,
        diagnostics=known.diagnostics,
        verdict=verdict.judged(drum, known.tolerance, known.ungraded),
    )


def drum_of(session: Session, stopped: tuple[Stop, ...]) -> Drum:
    """What is stored of a session's drum."""
    return Drum(session.machine, session.runs, session.run_out, session.plans, stopped, session.on_rotor)


@dataclass(frozen=True)
class _OfAllRuns:
    """What a fit of all runs says. ungraded: why there is no tolerance although the machine states a grade."""

    tolerance: Tolerance | None = None
    ungraded: Message | None = None
    influence: tuple[tuple[Coefficient, ...], ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


def _of_all_runs(drum: Drum) -> _OfAllRuns:
    machine, runs = drum.machine, drum.good
    missing = balance_quality.tolerance_missing(machine)
    try:
        fitted = fit_runs(machine, runs, drum.run_out)
        answer = least_squares(fitted.fit)
    except InvalidInput as error:
        # Too few runs, or runs without phase: the report says nothing of coefficients.
        graded = machine.balance_grade_mm_s is not None
        return _OfAllRuns(ungraded=missing or (error.data if graded else None))
    still = answer.masses - mapping.mass_vectors(machine, on_rotor(drum))
    return _OfAllRuns(
        tolerance=balance_quality.tolerance_of(machine, still, answer.covariance, float(fitted.fit.scatter_dof.min())),
        ungraded=missing,
        influence=mapping.coefficients(machine, fitted.rows, fitted.fit),
        diagnostics=examined(machine, runs, fitted),
    )


def plane_loads(machine: Machine, fitted: Sequence[Placement]) -> tuple[PlaneLoad, ...]:
    """What is bolted into each plane, and the one mass it comes to."""
    out = []
    for plane in machine.planes:
        pieces = tuple(piece for piece in fitted if piece.plane == plane.name)
        masses = mapping.as_masses(pieces)
        vectors = np.array([phasor(m.mass_g, m.angle_deg, machine.angle_sense) for m in masses], dtype=complex)
        planes = np.zeros(len(masses), dtype=np.int64)
        mass, angle = polar(complex(combined(vectors, planes, 1)[0]), machine.angle_sense)
        out.append(
            PlaneLoad(
                plane=plane.name,
                pieces=pieces,
                carried_g=sum(m.mass_g for m in masses),
                as_one=MassOnRotor(plane=plane.name, mass_g=mass, angle_deg=angle),
                saved=saved_mass(vectors, planes, 1),
            )
        )
    return tuple(out)


def before_after(work: AppContext, session: Session) -> tuple[BeforeAfter, ...]:
    """Each sensor in the first as-found run, and in the latest check run of the masses that are on the drum now."""
    return verdict.before_after(drum_of(session, stops.of(work, session.id)))


def trend(work: AppContext, machine_id: str, most: int) -> tuple[tuple[datetime, tuple[BeforeAfter, ...]], ...]:
    """When each of a machine's sessions was opened, and its sensors before and after: the newest first."""
    with work.read() as store:
        rows = store.sessions(most, 0, machine_id=machine_id)
        return tuple((row.created_at, verdict.before_after(stored_drum(store, row))) for row in rows)


def conventions(machine: Machine) -> tuple[str, ...]:
    """The conventions every number of the session is meant in."""
    angle = "against" if machine.angle_sense == "against_rotation" else "with"
    phase = (
        "degrees the rotor turns from the key-phasor mark passing the pick-up to the sensor's next positive peak"
        if machine.phase_sense == "lag"
        else "the negative of the degrees the rotor turns from the mark passing the pick-up to the next positive peak"
    )
    side = f", seen from {machine.seen_from}" if machine.seen_from else ""
    return (
        f"The rotor turns {machine.rotation}{side}.",
        f"Mass angles count in degrees from the key-phasor mark {angle} the rotation.",
        f"Phase ({machine.phase_sense}): {phase}.",
        "Amplitudes are the 1x component in each sensor's quantity, unit and detection.",
        "Corrections are the total to have on the as-found rotor, trial masses off.",
    )
