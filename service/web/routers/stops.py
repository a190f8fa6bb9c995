"""Stops to change masses: lock, change, release; each is stated on the page and stored."""

from __future__ import annotations

from collections.abc import Callable

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, Response

from service.engine import mapping
from service.engine.trial_check import Doubt, force_of
from service.errors import DrumtrueError, NotFound
from service.messages import Message
from service.model.plan import ActualPlacement
from service.model.run import MassOnRotor
from service.model.stop import Stop, StopPurpose, StopRequest
from service.runtime.context import AppContext
from service.usecases.sessions import stops
from service.web.form_guard import done_in
from service.web.forms import Form, TypedDep
from service.web.language import N_
from service.web.rendering import Page, PageDep
from service.web.routers.session_steps import GuideDep, Key
from service.web.session import steps
from service.web.session.guide import Guide, look

router = APIRouter(prefix="/sessions/{session_id}/stops")

LOCK = ("standstill", "key_out", "blocked")
RELEASE = ("torqued", "tools_out", "guards_on")
NOT_YET = N_("Do this first, then tick it.")
DOUBTS: dict[Doubt, str] = {
    "force_large": N_(
        "Really %(mass)s? It pulls with %(force)s at service speed, %(share)s of the load on the bearing."
    ),
    "mass_above_suggested": N_("Really %(mass)s? That is more than three times the usual. It pulls with %(force)s."),
    "mass_below_suggested": N_("Really %(mass)s? That is less than a third of the usual: it may show nothing."),
}
MAX_G = 1e5
PURPOSES: dict[str, StopPurpose] = {"trial": "trial", "plan": "plan", "bare": "bare"}


@router.post("")
def begin_stop(page: PageDep, guide: GuideDep, typed: TypedDep) -> Response:
    """Stop the machine for a trial mass or for the masses of a plan."""
    form = Form(typed, page.preferences)
    purpose = form.choice("purpose", PURPOSES) or "trial"
    alternative = form.whole("alternative", low=0, high=100, required=False)
    request = StopRequest(
        purpose=PURPOSES[purpose],
        plane=form.text("plane"),
        plan_id=form.text("plan_id"),
        alternative=alternative,
    )
    return _then(page, guide, typed, form, lambda work: stops.begin(work, guide.session.id, request))


@router.post("/{number}/lock")
def lock_machine(page: PageDep, guide: GuideDep, typed: TypedDep, number: int) -> Response:
    """The drum stands still, the key is out, the drum is blocked."""
    form = ticked(page, typed, LOCK)
    return _then(page, guide, typed, form, lambda work: stops.lock(work, guide.session.id, number))


@router.post("/{number}/trial")
def trial_mass_on(page: PageDep, guide: GuideDep, typed: TypedDep, number: int) -> Response:
    """The trial mass as it was really bolted on, and whether the one before is off."""
    form = Form(typed, page.preferences)
    plane = guide.stop.plane if guide.stop is not None else None
    grams = form.number("masses.mass_g", above=0.0, high=MAX_G, unit=page.display.mass_unit())
    angle = form.angle("masses.angle_deg")
    kept = guide.on_rotor if form.ticked("keep") else _carried(guide)
    if not form.ok or grams is None or angle is None or plane is None:
        return steps.show(page, guide, form=form, status=422)
    if _asked(page, guide, form, plane, grams):
        return steps.show(page, guide, form=form, status=422)
    masses = (*kept, MassOnRotor(plane=plane, mass_g=grams, angle_deg=angle))
    return _then(page, guide, typed, form, lambda work: stops.change(work, guide.session.id, number, masses))


@router.get("/{number}/picture")
def draw_trial(page: PageDep, session_id: Key, number: int) -> HTMLResponse:
    """The plane with the trial mass as it is typed at this moment; without it where that is no mass yet."""
    guide = look(page.work, session_id)
    stop = guide.stop
    if stop is None or stop.number != number or stop.plane is None:
        raise NotFound(Message("not_found.stop", session=session_id, number=number), field="number", value=number)
    form = Form(dict(page.request.query_params), page.preferences)
    grams = form.number("masses.mass_g", above=0.0, high=MAX_G, unit=page.display.mass_unit())
    angle = form.angle("masses.angle_deg")
    shown = grams if form.ok else None
    drawn = steps.trial_picture(page, guide, stop.plane, shown, angle, keep=form.ticked("keep"))
    return page.render("steps/_ends.html", pictures=drawn)


@router.post("/{number}/correct")
def correct_stop(page: PageDep, guide: GuideDep, typed: TypedDep, number: int) -> Response:
    """Take back what was stated of the masses, before the drum has turned."""
    form = Form(typed, page.preferences)
    return _then(page, guide, typed, form, lambda work: stops.reopen(work, guide.session.id, number))


@router.post("/{number}/plan")
def plan_on(page: PageDep, guide: GuideDep, typed: TypedDep, number: int) -> Response:
    """The masses of a plan are on: as planned, or as they were really fitted."""
    form = Form(typed, page.preferences)
    actual = _actual(page, guide, form) if form.ticked("differs") else None
    return _then(page, guide, typed, form, lambda work: stops.fit(work, guide.session.id, number, actual))


@router.post("/{number}/bare")
def masses_off(page: PageDep, guide: GuideDep, typed: TypedDep, number: int) -> Response:
    """All masses are off: a fitted plan is undone, its masses go back into the box."""
    form = Form(typed, page.preferences)
    return _then(page, guide, typed, form, lambda work: stops.bare(work, guide.session.id, number))


@router.post("/{number}/release")
def release_machine(page: PageDep, guide: GuideDep, typed: TypedDep, number: int) -> Response:
    """Bolts are torqued, tools are out, guards are on."""
    form = ticked(page, typed, RELEASE)
    return _then(page, guide, typed, form, lambda work: stops.release(work, guide.session.id, number))


@router.post("/{number}/cancel")
def cancel_stop(page: PageDep, guide: GuideDep, typed: TypedDep, number: int) -> Response:
    """Go back before anything was changed."""
    form = Form(typed, page.preferences)
    return _then(page, guide, typed, form, lambda work: stops.cancel(work, guide.session.id, number))


def ticked(page: Page, typed: dict[str, str], names: tuple[str, ...]) -> Form:
    """The form, with a fault beside each of these boxes that is not ticked."""
    form = Form(typed, page.preferences)
    for name in names:
        if not form.ticked(name):
            form.wrong(name, NOT_YET)
    return form


def _then(page: Page, guide: Guide, typed: dict[str, str], form: Form, verb: Callable[[AppContext], Stop]) -> Response:
    def act(work: AppContext) -> str:
        verb(work)
        return f"/sessions/{guide.session.id}"

    if form.ok:
        try:
            return done_in(page, guide, typed, act)
        except DrumtrueError as error:
            return steps.refused(page, guide, form, error)
    return steps.show(page, guide, form=form, status=422)


def _asked(page: Page, guide: Guide, form: Form, plane: str, grams: float) -> bool:
    """Ask about a trial mass that pulls hard or is far from the suggested one; the tick holds for this mass alone."""
    found = force_of(guide.session.machine, plane, grams, steps.expected_g(page, guide, plane))
    if not found.doubts or not found.bearable or form.ticked(steps.sure(grams)):
        return False
    show = page.display
    form.wrong(
        steps.sure(grams),
        DOUBTS[found.doubts[0]],
        mass=show.mass(grams),
        force=show.force(found.force_n),
        share=show.percent(found.share),
    )
    return True


def _carried(guide: Guide) -> tuple[MassOnRotor, ...]:
    """What stays on the rotor once trial masses are off: the pieces of a fitted plan."""
    return () if guide.fitted is None else mapping.masses_on_rotor(guide.fitted)


def _actual(page: Page, guide: Guide, form: Form) -> tuple[ActualPlacement, ...]:
    """Each piece of the plan as it was really fitted; one that was not fitted is left out."""
    out = []
    planned = guide.stop.placements if guide.stop is not None else ()
    for index, piece in enumerate(p for p in planned if p.from_box):
        where = f"actual[{index}]"
        if form.ticked(f"{where}.left_out"):
            continue
        angle = form.angle(f"{where}.position_deg")
        grams = form.number(f"{where}.mass_g", above=0.0, high=MAX_G)
        weighed = form.number(
            f"{where}.weighed_g", above=0.0, high=MAX_G, unit=page.display.mass_unit(), required=False
        )
        if angle is not None and grams is not None:
            out.append(ActualPlacement(plane=piece.plane, position_deg=angle, mass_g=grams, weighed_g=weighed))
    return tuple(out)


__all__ = ["Key", "router"]
