"""Machines: listed, described, changed; what became of each over its sessions."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path
from fastapi.responses import HTMLResponse, Response
from pydantic import ValidationError

from service.engine.mapping import Channel, bearing_places, limit_of
from service.errors import DrumtrueError
from service.model.base import read_json, to_plain, write_json
from service.model.faults import message_of
from service.model.machine import Machine, StoredMachine
from service.usecases.arrangements import place_sets
from service.usecases.machines import influence, machines
from service.usecases.sessions import sessions
from service.web import machine_forms, trends
from service.web.form_guard import done
from service.web.forms import Form, TypedDep
from service.web.rendering import Page, PageDep

router = APIRouter(prefix="/machines")

MAX_LISTED = 200
MAX_SESSIONS = 30
Key = Annotated[str, Path(min_length=1, max_length=32, pattern="^[0-9A-Za-z_-]+$")]


@router.get("")
def machines_page(page: PageDep) -> HTMLResponse:
    """All machines."""
    return page.render("machines.html", machines=machines.find(page.work, MAX_LISTED, 0))


@router.get("/new")
def new_machine(page: PageDep, then: str = "") -> HTMLResponse:
    """An empty description, of a drum with two planes."""
    return _form(page, machine_forms.blank(page), then=then)


@router.post("/new")
def store_machine(page: PageDep, typed: TypedDep) -> Response:
    """Store a machine; or show the form again with one plane or sensor more or less."""
    form, then = Form(typed, page.preferences), typed.get("then", "")
    if machine_forms.resized(form):
        return _form(page, form, then=then)
    machine = machine_forms.read(page, form)
    if machine is not None:
        try:
            described = _checked(machine)
            on = "/sessions/new?machine=" if then == "session" else "/machines/"
            return done(page, typed, lambda work: f"{on}{machines.create(work, described).id}")
        except (DrumtrueError, ValidationError) as refused:
            _refused(page, form, refused)
    return _form(page, form, then=then, status=422)


@router.get("/{machine_id}")
def machine_page(page: PageDep, machine_id: Key) -> HTMLResponse:
    """One machine: its description, its sessions, its trend."""
    machine = machines.get(page.work, machine_id)
    found = sessions.find(page.work, MAX_SESSIONS, 0, machine_id=machine_id)
    return page.render(
        "machine.html",
        machine=machine,
        sessions=found,
        trends=trends.of_machine(page, machine),
        detections=machine_forms.DETECTIONS,
        learned=next(iter(influence.history_of(page.work, machine_id, 1)), None),
        limits={one.name: limit_of(machine, Channel(one, machine.service_speed_rpm)) for one in machine.sensors},
        places=bearing_places(machine),
        stated=machine_forms.stated_bearings(machine),
        part_sets=place_sets.find(page.work, machine_id),
    )


@router.get("/{machine_id}/edit")
def edit_machine(page: PageDep, machine_id: Key) -> HTMLResponse:
    """The description as a form."""
    machine = machines.get(page.work, machine_id)
    return _form(page, machine_forms.filled(page, machine), before=machine)


@router.post("/{machine_id}/edit")
def save_machine(page: PageDep, typed: TypedDep, machine_id: Key) -> Response:
    """Change a machine; sessions keep the copy they were opened with."""
    form, before = Form(typed, page.preferences), machines.get(page.work, machine_id)
    if machine_forms.resized(form):
        return _form(page, form, before=before)
    machine = machine_forms.read(page, form, before)
    if machine is not None:
        try:
            known = to_plain(_checked(machine), Machine)
            machines.change(page.work, machine_id, known)
            return page.goto(f"/machines/{machine_id}")
        except (DrumtrueError, ValidationError) as refused:
            _refused(page, form, refused)
    return _form(page, form, before=before, status=422)


def _form(
    page: Page, form: Form, *, before: StoredMachine | None = None, then: str = "", status: int = 200
) -> HTMLResponse:
    return page.render(
        "machine_form.html",
        status=status,
        form=form,
        machine_id="" if before is None else before.id,
        bearings=machine_forms.stated_bearings(before),
        then=then,
        planes=machine_forms.count(form, "planes"),
        sensors=machine_forms.count(form, "sensors"),
        **machine_forms.CHOICES,
    )


def _checked(machine: Machine) -> Machine:
    """The machine once its fields keep their rules: a document made in code is not checked by itself."""
    return read_json(Machine, write_json(machine))


def _refused(page: Page, form: Form, error: DrumtrueError | ValidationError) -> None:
    if isinstance(error, DrumtrueError):
        form.refused(error)
        return
    for fault in error.errors():
        path = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in fault["loc"]).lstrip(".")
        beside = max((name for name in form.values if path.startswith(name)), key=len, default="")
        form.errors.setdefault(beside, page.words(message_of(fault)))
