"""Import sessions of another service from their logs, whole or not at all.

Identifiers, numbers, times, state and version stay what they are; the machine and the boxes are found here by their
identifier or name, or created. Stock is not touched: a box that comes with a session is created empty, nothing is held
for its plans, and no movement is booked; pieces taken off an imported drum later go into the box here. Coefficients
learned from the session are not part of its log; they can be learned from it again.

The history gets one entry, `imported`, with the digest of the document; that of the service it comes from stays there.
A closed session is sealed in the same unit of work, as it is stored here: it is immutable from then on.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from datetime import datetime
from typing import cast

from sqlalchemy.exc import IntegrityError

from db.audit_chain import digest
from db.rows import CatalogueRow, CorrectionRow, MachineRow, PlanRow, RunRow, SessionRow, StopRow
from db.store import Store
from service.engine.logs.rules import checked, checked_record, not_a_log
from service.errors import Conflict
from service.messages import Message
from service.model.base import document, read_json, to_plain
from service.model.machine import Catalogue, Machine
from service.model.plan import Plan
from service.model.session import Session, SessionLog, SessionRecord
from service.runtime.context import AppContext, require
from service.usecases.session_view import session_view
from service.usecases.sessions.sessions import log_of

MAX_OTHERS = 3
"""Other imports that may store parts of a session (itself, its machine, its box) while this one is about to."""


@document
class Imported:
    """What became of session logs."""

    stored: int
    """Sessions that are new here."""
    known: int
    """Sessions that were here already, the same in everything."""


def read_whole_log(text: str | bytes) -> SessionLog:
    """A session log with its record. Raises InvalidInput for text that is none, or a broken rule."""
    try:
        log = read_json(SessionLog, text)
    except ValueError as wrong:
        raise not_a_log(wrong) from None
    return checked_record(checked(log))


def import_one(work: AppContext, log: SessionLog) -> Session:
    """Store the session of a log; one that is here already, and the same, stays as it is.

    Raises InvalidInput for a log without record or with a broken rule, Conflict where another session has its
    identifier, or a box of its name holds other kinds of mass.
    """
    log = checked_record(checked(log))
    import_all(work, [log])
    # In the unit that wrote it where there is one around: until it commits nobody else sees the session.
    with work.read() if work.joined is None else work.write() as store:
        return session_view(store, require(store, SessionRow, log.session_id or ""))


def import_all(work: AppContext, logs: Iterable[SessionLog]) -> Imported:
    """Store the sessions of logs that `read_whole_log` read, all or none. Raises as `import_one`."""
    stored = known = 0
    session_id: str | None = None
    try:
        with work.write() as store:
            for log in logs:
                session_id = log.session_id
                new = _import_after_others(store, log, work.now())
                stored, known = stored + new, known + (not new)
    except IntegrityError as taken:
        raise Conflict(Message("identifier_taken", session=session_id), field="session_id", value=session_id) from taken
    return Imported(stored=stored, known=known)


def _import_after_others(store: Store, log: SessionLog, now: datetime) -> bool:
    """As `_import`; where another import stores the same meanwhile, it is waited for, and what it stored is known."""
    for _ in range(MAX_OTHERS):
        with suppress(IntegrityError), store.part():
            return _import(store, log, now)
    with store.part():
        return _import(store, log, now)


def _import(store: Store, log: SessionLog, now: datetime) -> bool:
    """Store the session unless it is here; whether it was not."""
    record = cast(SessionRecord, log.record)
    session_id = log.session_id or ""
    there = store.get(SessionRow, session_id)
    if there is not None:
        _require_same(log_of(store, there), log)
        return False
    boxes = {key: _box(store, key, box, now) for key, box in _boxes(log, record).items()}
    plans = [_plan(plan, boxes) for plan in log.plans]
    row = {
        **vars(record),
        "id": session_id,
        "machine_id": _machine(store, record.machine_id, log.machine, now),
        "machine_name": log.machine.name,
        "machine": log.machine,
        "catalogue_id": boxes.get(record.catalogue_id or ""),
        "run_out": log.run_out,
        "on_rotor": log.on_rotor,
    }
    del row["stops"]
    parts = {
        RunRow: [{"id": part.id, "number": part.number, "run": part} for part in log.runs],
        CorrectionRow: [{"id": part.id, "number": part.number, "correction": part} for part in log.corrections],
        PlanRow: [{"id": part.id, "number": part.number, "plan": part} for part in plans],
        StopRow: [{"id": part.id, "number": part.number, "stop": part} for part in record.stops],
    }
    told = {"state": record.state, "version": record.version, "log_sha256": digest(to_plain(log))}
    store.import_session(row, parts, told)
    return True


def _plan(plan: Plan, boxes: Mapping[str, str]) -> Plan:
    """The plan, of the box here, with nothing held for it."""
    box = boxes.get(plan.inputs.catalogue_id or "")
    return replace(plan, inputs=replace(plan.inputs, catalogue_id=box), reserved_until=None)


def _machine(store: Store, key: str, machine: Machine, now: datetime) -> str:
    """The machine here of this identifier, else of this name, else a new one: its identifier."""
    found = store.get(MachineRow, key) or store.machine_named(machine.name)
    if found is None:
        found = MachineRow(id=key, name=machine.name, spec=machine, created_at=now, updated_at=now)
        store.add(found)
    return found.id


def _box(store: Store, key: str, box: Catalogue, now: datetime) -> str:
    """The box here of this identifier, else of this name, else a new, empty one: its identifier."""
    found = store.get(CatalogueRow, key) or store.catalogue_named(box.name)
    if found is None:
        found = CatalogueRow(id=key, name=box.name, items=box.items, created_at=now)
        store.add(found)
        store.open_stock(key, [index for index, item in enumerate(box.items) if item.count is not None])
    elif _kinds(Catalogue(name=found.name, items=found.items)) != _kinds(box):
        raise Conflict(Message("box_differs", box=found.name), field="catalogue", value=found.name)
    return found.id


def _kinds(box: Catalogue) -> list[tuple[float, float]]:
    return [(item.mass_g, item.fastener_g) for item in box.items]


def _boxes(log: SessionLog, record: SessionRecord) -> Mapping[str, Catalogue]:
    boxes = {earlier.catalogue_id: earlier.catalogue for earlier in log.earlier_boxes}
    if record.catalogue_id is not None and log.catalogue is not None:
        boxes[record.catalogue_id] = log.catalogue
    return boxes


def _require_same(here: SessionLog, log: SessionLog) -> None:
    if _own(here) != _own(log):
        raise Conflict(Message("session_differs", session=log.session_id), field="session_id", value=log.session_id)


def _own(log: SessionLog) -> SessionLog:
    """The log without what is the service's: its version, its machine's and boxes' identifiers, its stock."""
    plans = tuple(_plan(plan, {}) for plan in log.plans)
    record = replace(cast(SessionRecord, log.record), machine_id="here", catalogue_id=None)
    return replace(log, version="", catalogue=None, earlier_boxes=(), plans=plans, record=record)
