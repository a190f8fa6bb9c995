"""Parts of a machine: their masses and places, line by line, as they were weighed, mounted and taken off."""

from __future__ import annotations

from datetime import datetime
from typing import Literal

from db.rows import MachineRow, PartEntryRow
from db.store import Store
from service.model.arrangement import Arrangement, PartRecord, PartToArrange
from service.runtime.context import AppContext, require


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
        _add(store, machine_id, part, "weighed", place, made, None, made.created_at)


def mounted(store: Store, machine_id: str, made: Arrangement, note: str | None, now: datetime) -> None:
    """Write down which parts are mounted where now, and which were taken off."""
    where = {one.part: one.place for one in made.mounted or () if one.part is not None}
    known = {row.part: row.record for row in store.latest_part_entries(machine_id)}
    asked = {part.id: part for part in made.request.parts}
    for part in asked.values():
        before = known[part.id].place if part.id in known else part.present
        mounted_before = part.id in known and known[part.id].event == "mounted"
        if part.id in where and (where[part.id] != before or not mounted_before):
            _add(store, machine_id, part, "mounted", where[part.id], made, note, now)
        elif part.id not in where and (before is not None or part.present is not None):
            _add(store, machine_id, part, "taken_off", None, made, note, now)


def _add(
    store: Store,
    machine_id: str,
    part: PartToArrange,
    what: Literal["mounted", "taken_off", "weighed"],
    place: str | None,
    made: Arrangement,
    note: str | None,
    at: datetime,
) -> None:
    record = PartRecord(
        part=part.id,
        event=what,
        place=place,
        mass_g=part.mass_g,
        moment_g_mm=part.moment_g_mm,
        kind=part.kind,
        arrangement_id=made.id,
        note=note,
        at=at,
    )
    store.add(PartEntryRow(machine_id=machine_id, part=part.id, arrangement_id=made.id, record=record))
