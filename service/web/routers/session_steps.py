"""A session step by step: opened, shown where it stands, looked back at, closed."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Path
from fastapi.responses import HTMLResponse, Response

from service.errors import DrumtrueError
from service.model.machine import StoredMachine
from service.model.run import RunOut
from service.model.session import AsFoundPiece, SessionPatch, SessionRequest
from service.runtime.context import AppContext
from service.usecases.machines import machines
from service.usecases.sessions import sessions
from service.usecases.stock import catalogues
from service.web.form_guard import done, done_in, require_fresh
from service.web.forms import Form, TypedDep
from service.web.language import N_
from service.web.rendering import Page, PageDep
from service.web.session import as_found, steps
from service.web.session.guide import STEPS, Guide, look

router = APIRouter(prefix="/sessions")

MAX_LISTED = 200
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
    return _opening(page, Form({"machine_id": machine}, page.preferences))


@router.post("/new")
def begin_session(page: PageDep, typed: TypedDep) -> Response:
    """Open a session on a machine, or show the form with what may be known of its drum."""
    form = Form(typed, page.preferences)
    listed = form.text("machine_id", required=True)
    machine = next((one for one in _machines(page) if one.id == listed), None)
    if form.value("more"):
        form.values["known"] = "yes" if machine is not None else ""
        return _opening(page, form, 200 if form.ok else 422)
    box, technician, note = form.text("catalogue_id"), form.text("technician"), form.text("note", most=2000)
    found, run_out = _known(page, form, machine)
    if form.ok and listed is not None:
        request = SessionRequest(
            machine_id=listed, catalogue_id=box, technician=technician, note=note, on_rotor=found, run_out=run_out
        )
        try:
            return done(page, typed, lambda work: f"/sessions/{sessions.open_on(work, request).id}")
        except DrumtrueError as error:
            form.refused(error)
    return _opening(page, form, 422)


def _machines(page: Page) -> tuple[StoredMachine, ...]:
    return machines.find(page.work, MAX_LISTED, 0)


def _known(
    page: Page, form: Form, machine: StoredMachine | None
) -> tuple[tuple[AsFoundPiece, ...], tuple[RunOut, ...]]:
    """Pieces and run-out, where the form asks for them: of the machine that it showed them for."""
    if not form.ticked("known") or machine is None:
        return (), ()
    if form.value("known_of") not in ("", machine.id):
        form.wrong("machine_id", N_("The pieces and the run-out were typed for another machine."))
        return (), ()
    return as_found.read_pieces(page, form, machine), as_found.read_run_out(page, form, machine)


def _opening(page: Page, form: Form, status: int = 200) -> HTMLResponse:
    found = _machines(page)
    machine = next((one for one in found if one.id == form.value("machine_id")), None)
    known = machine if form.ticked("known") else None
    return page.render(
        "session_new.html",
        status=status,
        form=form,
        machines=found,
        boxes=catalogues.find(page.work, MAX_LISTED, 0),
        known=known,
        places=[] if known is None else as_found.places(page, known),
        may=as_found.MAY,
        pieces=as_found.PIECES,
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
    form = Form(typed, page.preferences)
    box = form.choice("catalogue_id", [one.id for one in catalogues.find(page.work, steps.MAX_BOXES, 0)])
    if box is None:
        return steps.show(page, guide, form=form, status=422)
    return changed(page, guide, typed, SessionPatch(catalogue_id=box))


@router.post("/{session_id}/close")
def close_session(page: PageDep, guide: GuideDep, typed: TypedDep) -> Response:
    """The session is finished."""
    return changed(page, guide, typed, SessionPatch(state="closed"))


def changed(page: Page, guide: Guide, typed: dict[str, str], patch: SessionPatch) -> Response:
    """The session with a change, shown where it stands then."""

    def change(work: AppContext) -> str:
        return f"/sessions/{sessions.change(work, guide.session.id, patch).id}"

    try:
        return done_in(page, guide, typed, change)
    except DrumtrueError as error:
        return steps.refused(page, guide, Form(typed, page.preferences), error)
