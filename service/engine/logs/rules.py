"""Rules of a session log that go beyond the types of its fields."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import datetime

from pydantic import ValidationError

from service.engine.validation import (
    check_as_found,
    check_catalogue,
    check_masses,
    normalised,
    plane_index,
    require_unique,
    sensor_index,
)
from service.errors import InvalidInput
from service.messages import Message, Word
from service.model.base import YEARS
from service.model.session import SessionLog, SessionRecord

KEY = re.compile(r"[0-9A-Za-z_.-]{1,32}")
"""As long as the columns that hold identifiers."""
_CLOSED = Message("log_rule.closed")
_BOXES = Message("log_rule.box")


def checked(log: SessionLog) -> SessionLog:
    """The log with its machine normalised, once machine, boxes, runs and as-found pieces keep the rules.

    Raises InvalidInput.
    """
    machine = normalised(log.machine)
    for box in (log.catalogue, *(earlier.catalogue for earlier in log.earlier_boxes)):
        if box is not None:
            check_catalogue(box)
    for index, run in enumerate(log.runs):
        check_masses(machine, run.masses, f"runs[{index}].masses")
        for place, reading in enumerate(run.readings):
            sensor_index(machine, reading.sensor, f"runs[{index}].readings[{place}].sensor")
    check_as_found(machine, log.on_rotor)
    return replace(log, machine=machine)


def not_a_log(wrong: ValueError | RecursionError) -> InvalidInput:
    """What to say of a text that is no session log."""
    if isinstance(wrong, ValidationError):
        first = wrong.errors(include_url=False, include_context=False)[0]
        field = ".".join(str(part) for part in first["loc"])
        return InvalidInput(
            Message("invalid_log.document", field=field or Word("the_log"), rule=first["msg"]),
            field=field,
            value=first.get("input") if not isinstance(first.get("input"), dict | list) else None,
        )
    return InvalidInput(Message("invalid_log.json", reason=wrong))


def checked_record(log: SessionLog) -> SessionLog:
    """The log, once it is whole enough to be stored and its parts fit together. Raises InvalidInput."""
    record = log.record
    if record is None:
        raise InvalidInput(Message("invalid_log.record_missing"), field="record")
    if log.unreadable:
        part = log.unreadable[0]
        raise InvalidInput(
            Message("log_incomplete", kind=Word(part.kind), number=part.number), field="unreadable", value=part.id
        )
    _require_keys(log, record)
    for name in ("runs", "corrections", "plans"):
        _require_numbers(name, [part.number for part in getattr(log, name)])
    _require_numbers("record.stops", [stop.number for stop in record.stops])
    for field, moment in _moments(log, record):
        dated = moment is None or (moment.tzinfo is not None and moment.year in YEARS)
        _require(dated, field, moment, Message("log_rule.zoned"))
    closed = record.closed_at
    _require((record.state == "closed") == (closed is not None), "record.closed_at", closed, _CLOSED)
    _require_plans(log, record)
    return log


def _require_keys(log: SessionLog, record: SessionRecord) -> None:
    keys: dict[str, list[str]] = {
        "session_id": [log.session_id or ""],
        "runs": [run.id for run in log.runs],
        "corrections": [correction.id for correction in log.corrections],
        "plans": [plan.id for plan in log.plans],
        "record.stops": [stop.id for stop in record.stops],
        "earlier_boxes": [box.catalogue_id for box in log.earlier_boxes],
    }
    for field, ids in keys.items():
        require_unique(field, ids)
        for key in ids:
            _require(KEY.fullmatch(key) is not None, field, key, Message("log_rule.identifier"))


def _require_plans(log: SessionLog, record: SessionRecord) -> None:
    boxes = {record.catalogue_id, None, *(box.catalogue_id for box in log.earlier_boxes)}
    _require((record.catalogue_id is None) == (log.catalogue is None), "catalogue", record.catalogue_id, _BOXES)
    corrections = {correction.id for correction in log.corrections}
    for index, correction in enumerate(log.corrections):
        for mass in correction.corrections:
            plane_index(log.machine, mass.plane, f"corrections[{index}].corrections")
    for index, plan in enumerate(log.plans):
        where = f"plans[{index}]"
        _require(
            plan.session_id == log.session_id, f"{where}.session_id", plan.session_id, Message("log_rule.of_session")
        )
        _require(
            plan.correction_id in corrections, f"{where}.correction_id", plan.correction_id, Message("log_rule.of_log")
        )
        _require(plan.inputs.catalogue_id in boxes, f"{where}.inputs.catalogue_id", plan.inputs.catalogue_id, _BOXES)
        for piece in (*plan.placements, *plan.taken_off, *(plan.fitted or ())):
            plane_index(log.machine, piece.plane, f"{where}.placements")
    fitted = [plan.id for plan in log.plans if plan.state == "fitted" and plan.fitted is not None]
    stated = [] if record.fitted_plan_id is None else [record.fitted_plan_id]
    _require(fitted == stated, "record.fitted_plan_id", record.fitted_plan_id, Message("log_rule.fitted_plan"))


def _require_numbers(field: str, numbers: Sequence[int]) -> None:
    _require(list(numbers) == list(range(1, len(numbers) + 1)), field, list(numbers)[:20], Message("log_rule.numbered"))


def _moments(log: SessionLog, record: SessionRecord) -> Iterator[tuple[str, datetime | None]]:
    yield "record.created_at", record.created_at
    yield "record.closed_at", record.closed_at
    for index, run in enumerate(log.runs):
        yield f"runs[{index}].taken_at", run.taken_at
    for index, plan in enumerate(log.plans):
        yield f"plans[{index}].created_at", plan.created_at
    for index, stop in enumerate(record.stops):
        for name in ("begun_at", "locked_at", "changed_at", "released_at"):
            yield f"record.stops[{index}].{name}", getattr(stop, name)


def _require(true: bool, field: str, value: object, rule: Message) -> None:
    if not true:
        shown = value.isoformat() if isinstance(value, datetime) else value
        raise InvalidInput(
            Message("invalid_log.rule", field=field, value=repr(shown), rule=rule), field=field, value=shown
        )
