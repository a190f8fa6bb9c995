"""A session step by step: opened, shown where it stands, looked back at, closed."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Path
from fastapi.responses import HTMLResponse, Response

from db.documents.session import SessionPatch, SessionRequest
from service.errors import DrumtrueError
from service.usecases import catalogues, machines, sessions
from service.usecases.work import Work
from service.web import steps
from service.web.doing import done, done_in, require_fresh
from service.web.forms import Form, TypedDep
from service.web.guide import STEPS, Guide, look
from service.web.rendering import Page, PageDep

router = APIRouter(prefix="/sessions")

MOST_LISTED = 200
Key = Annotated[str, Path(min_length=1, max_length=32, pattern="^[0-9A-Za-z_-]+$")]


def fresh(page: PageDep, session_id: Key, typed: TypedDep) -> Guide:
    """The session, once the form is known to be of its present state. Raises Stale, Done."""
    guide = look(page.work, session_id)
    require_fresh(page, guide, typed)
    return guide


GuideDep = Annotated[Guide, Depends(fresh)]


@router.get("/new")
def new_session(page: PageDep, machine: str = "") -> HTMLResponse:
    """Which machine, which box."""
    return _opening(page, Form({"machine_id": machine}, page.language))


@router.post("/new")
def begin_session(page: PageDep, typed: TypedDep) -> Response:
    """Open a session on a machine."""
    form = Form(typed, page.language)
    machine = form.text("machine_id", required=True)
    box, technician, note = form.text("catalogue_id"), form.text("technician"), form.text("note", most=2000)
    if form.ok and machine is not None:
        request = SessionRequest(machine_id=machine, catalogue_id=box, technician=technician, note=note)
        try:
            return done(page, typed, lambda work: f"/sessions/{sessions.open_on(work, request).id}")
        except DrumtrueError as error:
            form.refused(error)
    return _opening(page, form, 422)


def _opening(page: Page, form: Form, status: int = 200) -> HTMLResponse:
    return page.render(
        "session_new.html",
        status=status,
        form=form,
        machines=machines.find(page.work, MOST_LISTED, 0),
        boxes=catalogues.find(page.work, MOST_LISTED, 0),
    )


@router.get("/{session_id}")
def show_session(page: PageDep, session_id: Key) -> HTMLResponse:
    """The one next thing to do."""
    return steps.show(page, look(page.work, session_id))


@router.get("/{session_id}/step/{step}")
def show_step(page: PageDep, session_id: Key, step: str) -> Response:
    """One step, to look back at it; the next one where it is not reached yet."""
    guide = look(page.work, session_id)
    if step not in STEPS or not guide.reached(step):
        return page.goto(f"/sessions/{session_id}")
    return steps.show(page, guide, step)


@router.post("/{session_id}/box")
def choose_box(page: PageDep, guide: GuideDep, typed: TypedDep) -> Response:
    """Give the session its box of stock masses."""
    form = Form(typed, page.language)
    box = form.choice("catalogue_id", [one.id for one in catalogues.find(page.work, steps.MOST_BOXES, 0)])
    if box is None:
        return steps.show(page, guide, form=form, status=422)
    return changed(page, guide, typed, SessionPatch(catalogue_id=box))


@router.post("/{session_id}/close")
def close_session(page: PageDep, guide: GuideDep, typed: TypedDep) -> Response:
    """The session is finished."""
    return changed(page, guide, typed, SessionPatch(state="closed"))


def changed(page: Page, guide: Guide, typed: dict[str, str], patch: SessionPatch) -> Response:
    """The session with a change, shown where it stands then."""

    def change(work: Work) -> str:
        return f"/sessions/{sessions.change(work, guide.session.id, patch).id}"

    try:
        return done_in(page, guide, typed, change)
    except DrumtrueError as error:
        return steps.refused(page, guide, Form(typed, page.language), error)
