"""Sets of places of a machine: bars, knives, hammers."""

from __future__ import annotations

from db.rows import MachineRow, PlaceSetRow
from db.store import Store
from service.engine.arrangement import check_places
from service.errors import NotFound
from service.messages import Message
from service.model.parts import PlaceSet, PlaceSetRequest
from service.runtime.context import AppContext, require


def put(work: AppContext, machine_id: str, name: str, request: PlaceSetRequest) -> PlaceSet:
    """Store or replace a set of places. Raises NotFound, or InvalidInput where a rule is broken."""
    check_places(request.places)
    with work.write() as store:
        require(store, MachineRow, machine_id, lock=True)
        row = next((row for row in store.place_sets(machine_id) if row.name == name), None)
        if row is None:
            row = PlaceSetRow(
                id=work.new_id(), machine_id=machine_id, name=name, places=request.places, updated_at=work.now()
            )
            store.add(row)
        else:
            row.places, row.updated_at = request.places, work.now()
        return _view(row)


def find(work: AppContext, machine_id: str) -> tuple[PlaceSet, ...]:
    """A machine's sets of places, by name. Raises NotFound."""
    with work.read() as store:
        require(store, MachineRow, machine_id)
        return tuple(_view(row) for row in store.place_sets(machine_id))


def named(store: Store, machine_id: str, name: str) -> PlaceSet:
    """One set of places. Raises NotFound."""
    row = next((row for row in store.place_sets(machine_id) if row.name == name), None)
    if row is None:
        raise NotFound(Message("place_set_not_found", name=name), field="set", value=name)
    return _view(row)


def _view(row: PlaceSetRow) -> PlaceSet:
    return PlaceSet(name=row.name, places=row.places, updated_at=row.updated_at)
