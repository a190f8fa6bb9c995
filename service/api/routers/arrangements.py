"""Arrangements of weighed parts, the machine's sets of places, and the history of its parts."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query

from service.api.dependencies import Key, Limit, Offset, WorkDep, errors
from service.api.strict_json import StrictRoute
from service.model.arrangement import (
    Arrangement,
    ArrangementAnswer,
    ArrangementPoint,
    ArrangementRequest,
    ArrangementWhatIf,
    MountedRequest,
)
from service.model.parts import PartRecord, PlaceSet, PlaceSetRequest, WeighRequest
from service.usecases.arrangements import arrangements, parts, place_sets

router = APIRouter(route_class=StrictRoute)
SetName = Annotated[str, Path(min_length=1, max_length=100, pattern=r"^[^\x00-\x1f\x7f/]+$", description="Set's name.")]


@router.post("/arrangements", status_code=201, tags=["arrangements"], responses=errors(404, 409, 503))
def add_arrangement(work: WorkDep, arrangement: ArrangementRequest) -> Arrangement:
    """Say which weighed part goes into which place, proved; an infeasible problem is answered with its reason.

    Masses in g, moments and unbalance in g.mm, radii and axial positions in mm, angles in degrees in the machine's
    `angle_sense` (without a machine against the rotation), the objective in `objective_unit`, times in s.
    """
    return arrangements.propose(work, arrangement)


@router.get("/arrangements", tags=["arrangements"], responses=errors())
def list_arrangements(
    work: WorkDep,
    limit: Limit = 50,
    offset: Offset = 0,
    machine_id: Annotated[str | None, Query(max_length=32, description="Only of this machine.")] = None,
    session_id: Annotated[str | None, Query(max_length=32, description="Only of this session.")] = None,
) -> tuple[Arrangement, ...]:
    """Arrangements, newest first. Units as in `add_arrangement`: g, g.mm, mm, degrees, s."""
    return arrangements.find(work, limit, offset, machine_id=machine_id, session_id=session_id)


@router.get("/arrangements/{arrangement_id}", tags=["arrangements"], responses=errors(404))
def get_arrangement(work: WorkDep, arrangement_id: Key) -> Arrangement:
    """One arrangement. Units as in `add_arrangement`: g, g.mm, mm, degrees, s."""
    return arrangements.get(work, arrangement_id)


@router.get("/arrangements/{arrangement_id}/front", tags=["arrangements"], responses=errors(404, 409, 503))
def get_arrangement_front(work: WorkDep, arrangement_id: Key) -> tuple[ArrangementPoint, ...]:
    """The best arrangement for each number of moves, as far as more moves make it better.

    Objective in the arrangement's `objective_unit`, unbalance in g.mm, angles in degrees.
    """
    return arrangements.front(work, arrangement_id)


@router.post("/arrangements/{arrangement_id}/what-if", tags=["arrangements"], responses=errors(404, 409, 503))
def ask_arrangement_what_if(work: WorkDep, arrangement_id: Key, what_if: ArrangementWhatIf) -> ArrangementAnswer:
    """The arrangement with parts missing, others on the shelf, or some that stay; nothing is stored.

    With `replace` also the mass, g, that the part in a place should have. Units as in `add_arrangement`: g, g.mm.
    """
    return arrangements.what_if(work, arrangement_id, what_if)


@router.post("/arrangements/{arrangement_id}/mounted", tags=["arrangements"], responses=errors(404, 409))
def mount_arrangement(work: WorkDep, arrangement_id: Key, mounted: MountedRequest) -> Arrangement:
    """Report what was really mounted where: the parts become part of the machine's history. Unbalance in g.mm."""
    return arrangements.mounted(work, arrangement_id, mounted)


@router.put("/machines/{machine_id}/place-sets/{name}", tags=["arrangements"], responses=errors(404))
def put_place_set(work: WorkDep, machine_id: Key, name: SetName, places: PlaceSetRequest) -> PlaceSet:
    """Store or replace a machine's set of places. Radii and axial positions in mm, angles in degrees."""
    return place_sets.put(work, machine_id, name, places)


@router.get("/machines/{machine_id}/place-sets", tags=["arrangements"], responses=errors(404))
def list_place_sets(work: WorkDep, machine_id: Key) -> tuple[PlaceSet, ...]:
    """A machine's sets of places. Radii and axial positions in mm, angles in degrees."""
    return place_sets.find(work, machine_id)


@router.get("/machines/{machine_id}/parts", tags=["arrangements"], responses=errors(404))
def list_parts(work: WorkDep, machine_id: Key) -> tuple[PartRecord, ...]:
    """Every part of a machine as it was last weighed, mounted or taken off. Masses in g, moments in g.mm."""
    return parts.current(work, machine_id)


@router.post("/machines/{machine_id}/parts", status_code=201, tags=["arrangements"], responses=errors(404))
def weigh_parts(work: WorkDep, machine_id: Key, weighed: WeighRequest) -> tuple[PartRecord, ...]:
    """Write down what the scale says of parts, and where they are. Masses in g, moments in g.mm."""
    return parts.weigh(work, machine_id, weighed)


@router.get("/machines/{machine_id}/parts/history", tags=["arrangements"], responses=errors(404))
def list_part_history(
    work: WorkDep,
    machine_id: Key,
    limit: Limit = 50,
    offset: Offset = 0,
    part: Annotated[str | None, Query(max_length=100, description="Only of this part.")] = None,
) -> tuple[PartRecord, ...]:
    """What happened to a machine's parts, newest first. Masses in g, moments in g.mm."""
    return parts.history(work, machine_id, part, limit, offset)
