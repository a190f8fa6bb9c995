"""Parts of a machine: their masses and places, line by line, as they were weighed, mounted and taken off."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from typing import Literal

from db.rows import MachineRow, PartEntryRow
from db.store import Store
from service.engine.arrangement import check_weighed
from service.errors import InvalidInput
from service.messages import Message
from service.model.arrangement import Arrangement, PartToArrange
from service.model.parts import PartRecord, PartWeighed, Place, PlaceSet, WeighRequest
from service.runtime.context import AppContext, require
from service.usecases.arrangements import place_sets


def current(work: AppContext, machine_id: str) -> tuple[PartRecord, ...]:
    """The latest line of every part of a machine, by part. Raises NotFound."""
    with work.read() as store:
        require(store, MachineRow, machine_id)
        return tuple(row.record for row in store.latest_part_entries(machine_id))


def history(work: AppContext, machine_id: str, part: str | None, limit: int, offset: int) -> tuple[PartRecord, ...]:
    """Lines of a machine's parts, newest first; part: of this one. Raises NotFound."""
    with work.read() as store:
        require(store, MachineRow, machine_id)
        return tuple(row.record for row in store.part_entries(machine_id, limit, offset, part=part))


def of_set(records: tuple[PartRecord, ...], sets: tuple[PlaceSet, ...], name: str) -> tuple[PartRecord, ...]:
    """Records of the parts of one set of places; those that name none belong to it where it is the only one."""
    return tuple(one for one in records if one.place_set == name or (one.place_set is None and len(sets) == 1))


def weigh(work: AppContext, machine_id: str, request: WeighRequest) -> tuple[PartRecord, ...]:
    """Write down what the scale says of parts, and where they are.

    What was in the place of one of them before is taken off. Raises NotFound, or InvalidInput where a mass cannot be
    meant, a place is not known, or a part belongs to another set.
    """
    with work.write() as store:
        require(store, MachineRow, machine_id, lock=True)
        known = {row.part: row.record for row in store.latest_part_entries(machine_id)}
        _check(store, machine_id, request, known)
        at, made = work.now(), list[PartRecord]()
        for part in request.parts:
            for other in tuple(known.values()):
                if part.place is not None and _in_same_place(other, part, request.place_set):
                    known[other.part] = _write(store, machine_id, _off(other, request.note, at))
            made.append(_write(store, machine_id, _weighed(part, request, at)))
            known[part.part] = made[-1]
        return tuple(made)


def weighed(store: Store, machine_id: str, made: Arrangement) -> None:
    """Write down the masses that an arrangement was asked with, where they are new."""
    known = {row.part: row.record for row in store.latest_part_entries(machine_id)}
    for part in made.request.parts:
        before = known.get(part.id)
        if part.mass_g is None and part.moment_g_mm is None:
            continue
        if before is not None and (before.mass_g, before.moment_g_mm) == (part.mass_g, part.moment_g_mm):
            continue
        place = part.present if before is None else before.place
        _write(store, machine_id, _record(part, "weighed", place, made, None, made.created_at))


def mounted(store: Store, machine_id: str, made: Arrangement, note: str | None, now: datetime) -> None:
    """Write down which parts are mounted where now, and which were taken off."""
    where = {one.part: one.place for one in made.mounted or () if one.part is not None}
    known = {row.part: row.record for row in store.latest_part_entries(machine_id)}
    asked = {part.id: part for part in made.request.parts}
    for part in asked.values():
        before = known[part.id].place if part.id in known else part.present
        mounted_before = part.id in known and known[part.id].event == "mounted"
        if part.id in where and (where[part.id] != before or not mounted_before):
            _write(store, machine_id, _record(part, "mounted", where[part.id], made, note, now))
        elif part.id not in where and (before is not None or part.present is not None):
            _write(store, machine_id, _record(part, "taken_off", None, made, note, now))


def _check(store: Store, machine_id: str, request: WeighRequest, known: dict[str, PartRecord]) -> None:
    own: tuple[PartRecord, ...] = tuple(known.values())
    places: tuple[Place, ...] = ()
    if request.place_set is not None:
        places = place_sets.named(store, machine_id, request.place_set).places
        own = tuple(one for one in own if one.place_set in (None, request.place_set))
    check_weighed(request, places, own)
    for index, part in enumerate(request.parts):
        before = known.get(part.part)
        if before is not None and before.place_set not in (None, request.place_set):
            raise InvalidInput(
                Message("part_of_other_set", part=part.part, set=before.place_set),
                field=f"parts[{index}].part",
                value=part.part,
            )


def _in_same_place(other: PartRecord, part: PartWeighed, place_set: str | None) -> bool:
    return other.part != part.part and other.place == part.place and other.place_set in (None, place_set)


def _weighed(part: PartWeighed, request: WeighRequest, at: datetime) -> PartRecord:
    return PartRecord(
        part=part.part,
        event="weighed",
        place=part.place,
        mass_g=part.mass_g,
        moment_g_mm=part.moment_g_mm,
        kind=part.kind,
        place_set=request.place_set,
        arrangement_id=None,
        note=request.note,
        at=at,
    )


def _off(record: PartRecord, note: str | None, at: datetime) -> PartRecord:
    return replace(record, event="taken_off", place=None, arrangement_id=None, note=note, at=at)


def _record(
    part: PartToArrange,
    what: Literal["mounted", "taken_off", "weighed"],
    place: str | None,
    made: Arrangement,
    note: str | None,
    at: datetime,
) -> PartRecord:
    return PartRecord(
        part=part.id,
        event=what,
        place=place,
        mass_g=part.mass_g,
        moment_g_mm=part.moment_g_mm,
        kind=part.kind,
        place_set=made.request.set,
        arrangement_id=made.id,
        note=note,
        at=at,
    )


def _write(store: Store, machine_id: str, record: PartRecord) -> PartRecord:
    store.add(
        PartEntryRow(machine_id=machine_id, part=record.part, arrangement_id=record.arrangement_id, record=record)
    )
    return record
