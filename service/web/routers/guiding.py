"""A session step by step: opened, shown where it stands, looked back at, closed."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Path
from fastapi.responses import HTMLResponse, Response

from db.documents.session import SessionPatch, SessionRequest
from service.errors import Conflict, DrumtrueError
from service.usecases import catalogues, machines, sessions
from service.web import steps
from service.web.forms import Form, TypedDep
from service.web.guide import STEPS, Guide, look
from service.web.language import N_
from service.web.rendering import Page, PageDep

router = APIRouter(prefix="/sessions")

MOST_LISTED = 200
Key = Annotated[str, Path(min_length=1, max_length=32, pattern="^[0-9A-Za-z_-]+$")]
CHANGED = N_(
    "Somebody has gone on with this session meanwhile, on another tablet perhaps. What you sent was not stored. "
    "This is how the session stands now."
)


class Stale(Exception):
    """A form was sent from a page that shows an older state of the session."""

    def __init__(self, page: Page, guide: Guide, typed: dict[str, str]) -> None:
        self.page, self.guide, self.typed = page, guide, typed

    def answer(self) -> HTMLResponse:
        """The newer state, with what was typed kept where its form is still there."""
        form = Form(self.typed, self.page.language)
        return steps.show(self.page, self.guide, form=form, status=409, notice=self.page.text(CHANGED), typing=True)


def fresh(page: PageDep, session_id: Key, typed: TypedDep) -> Guide:
    """The session, once the form is known to be of its present state. Raises Stale."""
    guide = look(page.work, session_id)
    if typed.get("stamp") != guide.stamp:
        raise Stale(page, guide, typed)
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
            return page.goto(f"/sessions/{sessions.open_on(page.work, request).id}")
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
    box = form.text("catalogue_id", required=True)
    if box is None:
        return steps.show(page, guide, form=form, status=422)
    return changed(page, guide, form, SessionPatch(catalogue_id=box))


@router.post("/{session_id}/close")
def close_session(page: PageDep, guide: GuideDep, typed: TypedDep) -> Response:
    """The session is finished."""
    return changed(page, guide, Form(typed, page.language), SessionPatch(state="closed"))


def changed(page: Page, guide: Guide, form: Form, patch: SessionPatch) -> Response:
    """The session with a change, shown where it stands then."""
    try:
        sessions.change(page.work, guide.session.id, patch)
    except Conflict as error:
        return steps.refused(page, guide, form, error)
    return page.goto(f"/sessions/{guide.session.id}")
