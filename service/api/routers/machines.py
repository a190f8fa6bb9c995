"""Machines and boxes of stock masses."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, Query

from service.api.dependencies import Key, Limit, Offset, WorkDep, errors
from service.api.strict_json import StrictRoute
from service.model.influence import LearnedInfluence, LearnRequest, TypicalInfluence
from service.model.machine import Catalogue, CataloguePatch, Machine, StoredCatalogue, StoredMachine
from service.model.stock import Stock, StockBooking
from service.usecases.machines import influence, machines
from service.usecases.stock import catalogues

router = APIRouter(route_class=StrictRoute)


@router.post("/machines", status_code=201, tags=["machines"], responses=errors(409))
def create_machine(work: WorkDep, machine: Machine) -> StoredMachine:
    """Store a machine with its conventions.

    Radii and axial positions in mm (axial from the mass centre), masses in g, rotor mass in kg, speed in r/min, angles
    in degrees from the key-phasor mark in the machine's `angle_sense`.
    """
    return machines.create(work, machine)


@router.get("/machines", tags=["machines"], responses=errors())
def list_machines(work: WorkDep, limit: Limit = 50, offset: Offset = 0) -> tuple[StoredMachine, ...]:
    """Machines, newest first. Units as in `create_machine`: mm, g, kg, r/min, degrees."""
    return machines.find(work, limit, offset)


@router.get("/machines/{machine_id}", tags=["machines"], responses=errors(404))
def get_machine(work: WorkDep, machine_id: Key) -> StoredMachine:
    """One machine. Units as in `create_machine`: mm, g, kg, r/min, degrees."""
    return machines.get(work, machine_id)


@router.patch("/machines/{machine_id}", tags=["machines"], responses=errors(404, 409))
def change_machine(work: WorkDep, machine_id: Key, patch: Annotated[dict[str, Any], Body()]) -> StoredMachine:
    """Change a machine by a merge patch (RFC 7396): fields given replace the present ones, null takes one away.

    Sessions keep the copy they were opened with. Units as in `create_machine`: mm, g, kg, r/min, degrees.
    """
    return machines.change(work, machine_id, patch)


@router.post("/machines/{machine_id}/influence", status_code=201, tags=["influence"], responses=errors(404, 409))
def learn_influence(work: WorkDep, machine_id: Key, learn: LearnRequest) -> LearnedInfluence:
    """Save what a session teaches of a machine's influence coefficients: no update above 50 % or 45 degrees.

    Coefficients in the sensor's unit per g, phases in degrees in the machine's `phase_sense`, speeds in r/min.
    """
    return influence.learn_from(work, machine_id, learn)


@router.get("/machines/{machine_id}/influence", tags=["influence"], responses=errors(404))
def list_influence(
    work: WorkDep, machine_id: Key, limit: Limit = 50, offset: Offset = 0
) -> tuple[LearnedInfluence, ...]:
    """A machine's influence coefficients after each session, latest first. Units as in `learn_influence`: per g."""
    return influence.history_of(work, machine_id, limit, offset)


@router.get("/influence-statistics", tags=["influence"], responses=errors(404))
def get_typical_influence(
    work: WorkDep, machine_type: Annotated[str, Query(alias="type", min_length=1, max_length=100, description="Type.")]
) -> TypicalInfluence:
    """Statistics of the coefficients of all machines of a type. Units as in `learn_influence`: per g, degrees."""
    return influence.typical_of(work, machine_type)


@router.post("/catalogues", status_code=201, tags=["catalogues"], responses=errors(409))
def create_catalogue(work: WorkDep, catalogue: Catalogue) -> StoredCatalogue:
    """Store a box of stock masses. Masses in g; `count` in pieces, null where unlimited."""
    return catalogues.create(work, catalogue)


@router.get("/catalogues", tags=["catalogues"], responses=errors())
def list_catalogues(work: WorkDep, limit: Limit = 50, offset: Offset = 0) -> tuple[StoredCatalogue, ...]:
    """Boxes, newest first, with what is left in each. Masses in g, stock in pieces."""
    return catalogues.find(work, limit, offset)


@router.get("/catalogues/{catalogue_id}", tags=["catalogues"], responses=errors(404))
def get_catalogue(work: WorkDep, catalogue_id: Key) -> StoredCatalogue:
    """One box with what is left in it. Masses in g, stock in pieces."""
    return catalogues.get(work, catalogue_id)


@router.patch("/catalogues/{catalogue_id}", tags=["catalogues"], responses=errors(404, 409))
def change_catalogue(work: WorkDep, catalogue_id: Key, patch: CataloguePatch) -> StoredCatalogue:
    """Rename a box, book pieces received, or book a count. Masses in g, stock in pieces."""
    return catalogues.change(work, catalogue_id, patch)


@router.get("/catalogues/{catalogue_id}/stock", tags=["catalogues"], responses=errors(404))
def get_stock(work: WorkDep, catalogue_id: Key, limit: Limit = 50, offset: Offset = 0) -> Stock:
    """Balances of a box, what is held for whom, and its movements, newest first. Masses in g, stock in pieces."""
    return catalogues.stock_of(work, catalogue_id, limit, offset)


@router.post("/catalogues/{catalogue_id}/stock", status_code=201, tags=["catalogues"], responses=errors(404, 409))
def book_stock(work: WorkDep, catalogue_id: Key, booking: StockBooking) -> Stock:
    """Book pieces received, returned, withdrawn or counted. Masses in g, stock in pieces."""
    return catalogues.book(work, catalogue_id, booking)
