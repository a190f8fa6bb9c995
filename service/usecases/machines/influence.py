"""Coefficients that sessions teach: per machine with history, statistics per type, trial masses from them."""

from __future__ import annotations

import numpy as np

from db.rows import InfluenceRow, MachineRow, SessionRow
from db.store import Store
from service.balancing.influence.saved import from_fit, learn, typical
from service.balancing.selection.problem import BoolArray
from service.engine import balance_quality, mapping, saved_influence
from service.engine.influence_fits import FittedModel, fit_runs, used
from service.engine.learned_on import for_machine, learned_on
from service.errors import Conflict, InvalidInput, NotFound, NumericsError
from service.messages import Message
from service.model.influence import (
    LearnedInfluence,
    LearnRequest,
    RefusedUpdate,
    SavedInfluence,
    TrialMassSuggestion,
    TypicalInfluence,
)
from service.model.machine import Machine
from service.runtime.context import AppContext, require

QUARANTINE = 20
"""Latest sessions of a machine that are asked whether its coefficients were found wrong."""


def learn_from(work: AppContext, machine_id: str, request: LearnRequest) -> LearnedInfluence:
    """Fit a session's runs and combine the coefficients with the machine's, within bounds.

    Raises NotFound, Conflict for a session of another machine or one that has taught already, NumericsError where the
    runs do not determine the coefficients.
    """
    with work.write() as store:
        machine = require(store, MachineRow, machine_id, lock=True)
        session = require(store, SessionRow, request.session_id)
        _check_session(store, machine_id, session)
        fitted = fit_runs(session.machine, used(row.run for row in store.runs(session.id)), session.run_out)
        before = _before(store, session)
        saved, refused = _combined(session.machine, fitted, before)
        learned = LearnedInfluence(
            id=work.new_id(),
            machine_id=machine_id,
            session_id=session.id,
            learned_at=work.now(),
            saved=saved,
            coefficients=saved_influence.shown(session.machine, saved),
            refused=refused,
        )
        store.add(
            InfluenceRow(
                id=learned.id,
                machine_id=machine_id,
                session_id=session.id,
                machine_type=machine.spec.type,
                learned_at=learned.learned_at,
                learned=learned,
            )
        )
        return learned


def history_of(work: AppContext, machine_id: str, limit: int, offset: int = 0) -> tuple[LearnedInfluence, ...]:
    """What a machine's coefficients were, latest first. Raises NotFound."""
    with work.read() as store:
        require(store, MachineRow, machine_id)
        return tuple(row.learned for row in store.influences(machine_id, limit, offset))


def has_taught(work: AppContext, session_id: str) -> bool:
    """Whether a machine has learned its coefficients from this session."""
    with work.read() as store:
        return store.influence_of(session_id) is not None


def typical_of(work: AppContext, machine_type: str) -> TypicalInfluence:
    """Statistics over the machines of a type. Raises NotFound where fewer than two of them have coefficients alike."""
    with work.read() as store:
        machine, saved, count = _typical(store, machine_type)
        return TypicalInfluence(
            type=machine_type, machines=count, typical=saved, coefficients=saved_influence.shown(machine, saved)
        )


def saved_for(store: Store, session: SessionRow, whose: str) -> SavedInfluence | None:
    """Coefficients for a session: the machine's own latest, or its type's. Raises NotFound for a type without."""
    if whose == "type":
        if session.machine.type is None:
            raise InvalidInput(Message("invalid_input.no_type"), field="influence_of", value="type")
        return _typical(store, session.machine.type, session.machine)[1]
    row = next(iter(store.influences(session.machine_id, 1)), None)
    if row is None:
        return None
    _require_still_valid(store, session, row)
    return _on(store, row, session.machine)


def _on(store: Store, row: InfluenceRow, machine: Machine) -> SavedInfluence:
    """What a machine learned, as it is on the machine as it stands. Raises Conflict where that cannot be told."""
    saved = row.learned.saved
    taught = None if saved.learned_on is not None else store.get(SessionRow, row.session_id)
    return for_machine(saved, machine, None if taught is None else learned_on(taught.machine))


def _before(store: Store, session: SessionRow) -> SavedInfluence | None:
    """What the machine learned before, on the geometry of a session; nothing where it was learned on another one."""
    row = next(iter(store.influences(session.machine_id, 1)), None)
    try:
        return None if row is None else _on(store, row, session.machine)
    except Conflict:
        return None


def _require_still_valid(store: Store, session: SessionRow, row: InfluenceRow) -> None:
    """Refuse coefficients that another session found wrong after they were learned: until the machine learns again."""
    for other in store.sessions(QUARANTINE, 0, machine_id=session.machine_id):
        if other.id in (session.id, row.session_id):
            continue
        wrong = [
            one
            for run in store.runs(other.id)
            for one in run.run.warnings
            if one.code == "coefficients_outdated" and run.run.taken_at > row.learned_at
        ]
        if wrong:
            raise Conflict(
                Message("coefficients_quarantined", session=other.id), field="source", value="saved_influence"
            )


def suggest_trials(work: AppContext, session_id: str) -> tuple[TrialMassSuggestion, ...]:
    """Trial mass and, from earlier coefficients, angle for each plane. Raises NotFound, InvalidInput."""
    with work.read() as store:
        session = require(store, SessionRow, session_id)
        machine = session.machine
        try:
            saved = saved_for(store, session, "machine")
        except Conflict:
            saved = None  # a trial mass can do without
        initial = [run for run in used(row.run for row in store.runs(session.id)) if run.kind == "initial"]
        if saved is None or not initial:
            return balance_quality.trial_masses(machine, None, None)
        rows = mapping.channels(machine, initial[-1:])
        vibration = mapping.run_set(machine, initial[-1:], session.run_out, rows).vibration[0]
        influence = saved_influence.as_arrays(machine, saved, rows).influence
        good = np.isfinite(vibration) & np.isfinite(influence).all(axis=1)
        if not good.any():
            return balance_quality.trial_masses(machine, None, None)
        return balance_quality.trial_masses(machine, influence[good], vibration[good])


def _check_session(store: Store, machine_id: str, session: SessionRow) -> None:
    if session.machine_id != machine_id:
        raise Conflict(
            Message("session_of_other_machine.saving", session=session.id), field="session_id", value=session.id
        )
    if store.influence_of(session.id) is not None:
        raise Conflict(Message("learned_already", session=session.id), field="session_id", value=session.id)


def _combined(
    machine: Machine, fitted: FittedModel, before: SavedInfluence | None
) -> tuple[SavedInfluence, tuple[RefusedUpdate, ...]]:
    rows = fitted.rows
    fresh = from_fit(fitted.fit)
    if before is None:
        return saved_influence.as_document(machine, rows, fresh), ()
    old = saved_influence.as_arrays(machine, before, rows)
    unknown: BoolArray = np.asarray(~np.isfinite(old.influence).all(axis=1))
    # A sensor or speed that was never learned starts with what this session says.
    old.influence[unknown], old.covariance[unknown] = fresh.influence[unknown], fresh.covariance[unknown]
    result = learn(old, fitted.fit)
    refused = tuple(
        RefusedUpdate(
            sensor=rows[s].sensor.name,
            plane=machine.planes[p].name,
            change=float(result.change[s, p]),
            turn_deg=float(np.degrees(result.turn[s, p])),
        )
        for s, p in np.argwhere(result.refused & ~unknown[:, None])
    )
    return saved_influence.merged(before, saved_influence.as_document(machine, rows, result.saved)), refused


def _typical(store: Store, machine_type: str, on: Machine | None = None) -> tuple[Machine, SavedInfluence, int]:
    """Statistics over the machines that are alike in everything but radius, unit and detection, as on one of them."""
    latest = store.latest_influences_of_type(machine_type)
    if not latest:
        raise _too_few(machine_type, 0)
    first = require(store, MachineRow, latest[0].machine_id).spec if on is None else on
    rows = tuple(mapping.Channel(sensor, first.service_speed_rpm) for sensor in first.sensors)
    arrays = []
    for row in latest:
        try:
            arrays.append(saved_influence.as_arrays(first, _on(store, row, first), rows).influence)
        except Conflict:
            continue
    alike = [a for a in arrays if np.isfinite(a).all()]
    try:
        mean = typical(np.array(alike).reshape(len(alike), len(rows), len(first.planes)))
    except NumericsError:
        raise _too_few(machine_type, len(alike)) from None
    return first, saved_influence.as_document(first, rows, mean), len(alike)


def _too_few(machine_type: str, count: int) -> NotFound:
    return NotFound(
        Message("not_found.statistics_of_type", machines=count, type=machine_type), field="type", value=machine_type
    )
