"""Arrangements: the answer with its pictures, what each further move brings, mounted behind a lock, on paper."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated

from fastapi import APIRouter, Path
from fastapi.responses import HTMLResponse, Response

from service.errors import DrumtrueError, OutOfOrder, Unavailable
from service.messages import Message
from service.model.arrangement import Arrangement, ArrangementWhatIf, Mounted, MountedRequest
from service.model.machine import StoredMachine
from service.runtime.context import AppContext
from service.usecases.arrangements import arrangements
from service.usecases.machines import machines
from service.web.certificate.document import Sheet
from service.web.form_guard import again, done
from service.web.forms import Form, TypedDep
from service.web.language import N_
from service.web.parts import mounting, paper, views
from service.web.pictures.reader import Reader
from service.web.pictures.svg import to_svg
from service.web.rendering import LongPageDep, Page, PageDep
from service.web.routers.reports import file_answer
from service.web.routers.stops import LOCK, RELEASE, ticked

router = APIRouter(prefix="/arrangements/{arrangement_id}")
files = APIRouter()
"""The PDF: beside the page, and under the API's prefix too."""

Key = Annotated[str, Path(min_length=1, max_length=32, pattern="^[0-9A-Za-z_-]+$")]
Verb = Callable[[AppContext], Arrangement]
EMPTY = "-"
"""Stands for no part in the lists of parts."""


@router.get("")
def arrangement_page(page: PageDep, arrangement_id: Key) -> HTMLResponse:
    """What is proved, what to do, what it leaves and gains."""
    made = arrangements.get(page.work, arrangement_id)
    return _page(page, made, Form(preferences=page.preferences))


@router.get("/front")
def arrangement_front(page: LongPageDep, arrangement_id: Key) -> HTMLResponse:
    """What each further move brings."""
    made = arrangements.get(page.work, arrangement_id)
    reader = Reader(page.preferences)
    points = arrangements.front(page.work, arrangement_id)
    values = [views.objective(made, one.offer.objective_value, reader) for one in points]
    most = max((one.offer.objective_value or 0.0 for one in points), default=0.0) or 1.0
    shares = [(one.offer.objective_value or 0.0) / most for one in points]
    return page.render("parts/front.html", made=made, points=list(zip(points, values, shares, strict=True)))


@router.post("/again")
def arrange_again(page: PageDep, typed: TypedDep, arrangement_id: Key) -> Response:
    """The arrangement with at most this many moves."""
    made, form = arrangements.get(page.work, arrangement_id), Form(typed, page.preferences)
    most = form.whole("max_moves", low=0, high=len(made.places))
    if most is None:
        return _page(page, made, form, 422)
    request = replace(made.request, mode="best", limit=None, max_moves=most)
    try:
        return done(page, typed, lambda work: f"/arrangements/{arrangements.propose(work, request).id}")
    except Unavailable as busy:
        return again(page, typed, busy)
    except DrumtrueError as error:
        form.refused(error)
        return _page(page, made, form, error.status)


@router.get("/replacement")
def replacement_page(page: LongPageDep, arrangement_id: Key, place: str) -> HTMLResponse:
    """The mass that a part in one place should have, all others staying."""
    made = arrangements.get(page.work, arrangement_id)
    found = arrangements.what_if(page.work, arrangement_id, ArrangementWhatIf(replace=place)).replacement
    reader = Reader(page.preferences)
    values = [] if found is None else [found.objective_value, found.shelf_objective_value]
    told = [views.objective(made, value, reader) for value in values]
    return page.render("parts/replacement.html", made=made, found=found, told=told)


@router.get("/mount")
def mount_page(page: PageDep, arrangement_id: Key) -> Response:
    """Lock, move, release: the step that is next."""
    made = arrangements.get(page.work, arrangement_id)
    if made.released_at is not None:
        return page.goto(f"/arrangements/{made.id}")
    return _mount(page, made, Form(preferences=page.preferences))


@router.post("/lock")
def lock_drum(page: PageDep, typed: TypedDep, arrangement_id: Key) -> Response:
    """The drum stands still, the key is out, the drum is blocked."""
    form = ticked(page, typed, LOCK)
    return _then(page, typed, form, arrangement_id, lambda work: arrangements.lock(work, arrangement_id))


@router.post("/mounted")
def parts_mounted(page: PageDep, typed: TypedDep, arrangement_id: Key) -> Response:
    """The parts are where they should be, or where they really are."""
    form, made = Form(typed, page.preferences), arrangements.get(page.work, arrangement_id)
    request = MountedRequest(actual=_actual(form, made) if form.ticked("differs") else None, note=form.text("note"))

    def mount(work: AppContext) -> Arrangement:
        if made.locked_at is None:
            raise OutOfOrder(Message("arrangement_not_locked"), field="arrangement_id", value=made.id)
        return arrangements.mounted(work, arrangement_id, request)

    return _then(page, typed, form, arrangement_id, mount)


@router.post("/release")
def release_drum(page: PageDep, typed: TypedDep, arrangement_id: Key) -> Response:
    """Bolts are torqued, tools are out, guards are on."""
    form = ticked(page, typed, RELEASE)
    return _then(page, typed, form, arrangement_id, lambda work: arrangements.release(work, arrangement_id))


@router.get("/report")
def show_arrangement_report(page: PageDep, arrangement_id: Key) -> HTMLResponse:
    """The certificate as a page that prints well."""
    sheet = _sheet(page, arrangement_id)
    return page.render("parts/report.html", sheet=sheet, svg=to_svg, arrangement_id=arrangement_id)


@files.get("/arrangements/{arrangement_id}/report.pdf")
def get_arrangement_pdf(page: PageDep, arrangement_id: Key) -> Response:
    """The certificate as PDF, in the language and units of the cookie or of Accept-Language."""
    from service.web.certificate.pdf import to_pdf

    sheet = _sheet(page, arrangement_id)
    return file_answer(to_pdf(sheet), "application/pdf", f"arrangement-{arrangement_id}.pdf")


def _sheet(page: Page, arrangement_id: str) -> Sheet:
    made = arrangements.get(page.work, arrangement_id)
    return paper.certificate(made, _machine(page, made), Reader(page.preferences))


def _machine(page: Page, made: Arrangement) -> StoredMachine | None:
    return None if made.machine_id is None else machines.get(page.work, made.machine_id)


def _actual(form: Form, made: Arrangement) -> tuple[Mounted, ...]:
    """Every place whose list was changed."""
    known = {part.id for part in made.request.parts}
    out = []
    for index, one in enumerate(made.arrangement):
        name = f"actual[{index}]"
        part = form.value(name)
        if not part:
            continue
        if part != EMPTY and part not in known:
            form.wrong(name, N_("Choose one of the list."))
        elif part != (one.part or EMPTY):
            out.append(Mounted(place=one.place, part=None if part == EMPTY else part))
    return tuple(out)


def _then(page: Page, typed: dict[str, str], form: Form, key: str, verb: Verb) -> Response:
    """Do one step of mounting and show the next; the same step again where a tick is missing or it is refused."""
    status = 422
    if form.ok:

        def act(work: AppContext) -> str:
            verb(work)
            return f"/arrangements/{key}/mount"

        try:
            return done(page, typed, act)
        except DrumtrueError as error:
            form.refused(error)
            status = error.status
    return _mount(page, arrangements.get(page.work, key), form, status)


def _page(page: Page, made: Arrangement, form: Form, status: int = 200) -> HTMLResponse:
    reader = Reader(page.preferences)
    places = views.placed(made)
    drawn = views.pictures(_machine(page, made), places, reader, made) if made.arrangement or made.mounted else ()
    return page.render(
        "parts/arrangement.html",
        status=status,
        made=made,
        form=form,
        machine=_machine(page, made),
        handlings=mounting.handlings(made),
        figures=views.figures(made, reader),
        pictures=[to_svg(one) for one in drawn],
        places=places,
        masses=views.masses_by_part(made),
        mass=views.mass,
        gone=[part for part in made.request.parts if part.may == "gone" and part.present],
    )


def _mount(page: Page, made: Arrangement, form: Form, status: int = 200) -> HTMLResponse:
    step = "release" if made.state == "mounted" else "move" if made.locked_at is not None else "lock"
    drawn = views.pictures(_machine(page, made), views.placed(made), Reader(page.preferences), made)
    return page.render(
        "parts/mount.html",
        status=status,
        made=made,
        form=form,
        step=step,
        handlings=mounting.handlings(made),
        pictures=[to_svg(one) for one in drawn],
        differing=views.differing(made),
        every=sorted(part.id for part in made.request.parts if part.may != "gone"),
        empty=EMPTY,
    )
