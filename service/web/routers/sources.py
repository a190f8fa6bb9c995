"""Sources of readings: which machine each is mounted on, and whether it delivers."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, Response

from service.errors import DrumtrueError
from service.usecases.machines import machines
from service.usecases.readings import source_health, sources
from service.web.forms import Form, TypedDep
from service.web.rendering import Page, PageDep

router = APIRouter(prefix="/sources")

MAX_LISTED = 200
FRESH_S = 10.0


@router.get("")
def sources_page(page: PageDep) -> HTMLResponse:
    """All sources with how well each is heard."""
    return _sources(page, Form(preferences=page.preferences))


@router.post("")
def mount_source(page: PageDep, typed: TypedDep) -> Response:
    """Say which machine a source is mounted on."""
    form = Form(typed, page.preferences)
    name, machine = form.text("name", required=True), form.text("machine_id", required=True)
    if name is not None and machine is not None and form.ok:
        try:
            sources.bind(page.work, name, machine)
            return page.goto("/sources")
        except DrumtrueError as error:
            form.refused(error)
    return _sources(page, form, 422)


def _sources(page: Page, form: Form, status: int = 200) -> HTMLResponse:
    listed = machines.find(page.work, MAX_LISTED, 0)
    names = {machine.id: machine.name for machine in listed}
    now = page.work.now()
    found = []
    for one in source_health.health(page.work):
        age = None if one.newest_at is None else max((now - one.newest_at).total_seconds(), 0.0)
        found.append((one, names.get(one.machine_id, one.machine_id), age, age is not None and age < FRESH_S))
    return page.render("sources.html", status=status, form=form, sources=found, machines=listed)
