"""Corrections and plans: computed, compared, made again with a hole or a piece struck out, undone."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

from fastapi import APIRouter, Path
from fastapi.responses import HTMLResponse, Response

from service.errors import DrumtrueError, NotFound, Unavailable
from service.messages import Message
from service.model.correction import CorrectionRequest, CorrectionSource
from service.model.influence import LearnRequest
from service.model.machine import CataloguePatch, Pieces
from service.model.plan import BlockedPosition, Mode, ObjectiveName, PlanRequest
from service.model.run import MassOnRotor
from service.runtime.context import AppContext
from service.usecases.machines import influence
from service.usecases.plans import corrections, plans
from service.usecases.stock import catalogues
from service.web.form_guard import again, done_in, done_on
from service.web.forms import Form, TypedDep
from service.web.rendering import LongPageDep, Page, PageDep
from service.web.routers.session_steps import GuideDep, Key
from service.web.session import pictures, steps
from service.web.session.guide import Guide, look

router = APIRouter(prefix="/sessions/{session_id}")

ALTERNATIVES = 3
TIME_LIMIT_S = 8.0
SOURCES: dict[str, CorrectionSource] = {
    "fit": "fit",
    "saved_influence": "saved_influence",
    "amplitude_only": "amplitude_only",
    "balancer": "balancer",
}
OBJECTIVES: dict[str, ObjectiveName] = {
    "residual_vibration": "residual_vibration",
    "components": "components",
    "bearing_force": "bearing_force",
    "robust": "robust",
}
MODES: dict[str, Mode] = {"best": "best", "fewest": "fewest"}
PlanKey = Annotated[str, Path(min_length=1, max_length=32)]


@router.post("/corrections")
def make_correction(page: PageDep, guide: GuideDep, typed: TypedDep) -> Response:
    """The continuous masses that would bring the drum to rest."""
    form = Form(typed, page.preferences)
    source = form.choice("source", SOURCES) or "fit"
    masses = _balancer_masses(page, guide, form) if source == "balancer" else None
    if not form.ok:
        return steps.show(page, guide, form=form, status=422)
    if source == "fit" and not any(r.phase_deg is not None for run in guide.used for r in run.readings):
        source = "amplitude_only"
    request = CorrectionRequest(source=SOURCES[source], masses=masses)

    def compute(work: AppContext) -> str:
        corrections.add(work, guide.session.id, request)
        return f"/sessions/{guide.session.id}/step/correction"

    try:
        return done_in(page, guide, typed, compute)
    except DrumtrueError as error:
        return steps.refused(page, guide, form, error)


@router.post("/teach")
def teach_machine(page: PageDep, guide: GuideDep, typed: TypedDep) -> Response:
    """Keep the coefficients of the session's runs with the machine: next time the run as found may be enough."""
    session = guide.session

    def teach(work: AppContext) -> str:
        influence.learn_from(work, session.machine_id, LearnRequest(session_id=session.id))
        return f"/sessions/{session.id}"

    try:
        return done_in(page, guide, typed, teach)
    except DrumtrueError as error:
        return steps.refused(page, guide, Form(typed, page.preferences), error)


@router.post("/plans")
def make_plan(page: PageDep, guide: GuideDep, typed: TypedDep) -> Response:
    """The best selection of what is in the box."""
    form = Form(typed, page.preferences)
    correction = guide.correction
    objective = form.choice("objective", OBJECTIVES) or "residual_vibration"
    mode = form.choice("mode", MODES, required=False) or "best"
    most = form.whole("max_masses_per_plane", low=1, high=20, required=False)
    if not form.ok or correction is None:
        return steps.show(page, guide, "plan", form=form, status=422)
    request = PlanRequest(
        correction_id=correction.id,
        objective=OBJECTIVES[objective],
        mode=MODES[mode],
        max_masses_per_plane=most,
        alternatives=ALTERNATIVES if mode == "best" else 0,
        time_limit_s=TIME_LIMIT_S,
    )
    return _proposed(page, guide, typed, form, request)


@router.post("/plans/{plan_id}/again")
def make_plan_again(page: PageDep, guide: GuideDep, typed: TypedDep, plan_id: PlanKey) -> Response:
    """The plan again, without a hole that cannot be used or a piece that is not in the box."""
    form = Form(typed, page.preferences)
    before = plans.get(page.work, plan_id)
    blocked = before.request.blocked
    if form.value("clear"):
        blocked = ()
    if form.value("blocked_plane"):
        angle = form.angle("blocked_deg")
        if angle is not None and form.ok:
            blocked = (*blocked, BlockedPosition(plane=form.value("blocked_plane"), position_deg=angle))
    missing = form.number("missing_g", above=0.0, high=1e6, required=False)
    if not form.ok:
        return steps.show(page, guide, "plan", form=form, status=422)
    try:
        if missing is not None:
            done_in(page, guide, {**typed, "struck": "yes"}, lambda work: _strike_out(work, guide, missing))
    except DrumtrueError as error:
        return steps.refused(page, guide, form, error, "plan")
    correction = guide.correction.id if guide.correction is not None else before.correction_id
    return _proposed(page, guide, typed, form, replace(before.request, correction_id=correction, blocked=blocked))


@router.get("/plans/{plan_id}/front")
def show_front(page: LongPageDep, session_id: Key, plan_id: PlanKey) -> HTMLResponse:
    """What each further piece brings."""
    session = look(page.work, session_id).session
    plan = next((one for one in session.plans if one.id == plan_id), None)
    if plan is None:
        raise NotFound(Message("not_found.plan"), field="plan_id", value=plan_id)
    points = plans.front(page.work, plan_id)
    return page.render(
        "front.html",
        session=session,
        plan=plan,
        points=points,
        picture=pictures.front(plan, points, page.preferences),
    )


def _proposed(page: Page, guide: Guide, typed: dict[str, str], form: Form, request: PlanRequest) -> Response:
    def propose(work: AppContext) -> str:
        plans.propose(work.having_seen(guide.session.version), guide.session.id, request)
        return f"/sessions/{guide.session.id}/step/plan"

    try:
        # Others measure while it is solved: the session is looked at before and after, and not held meanwhile.
        return done_on(page, guide, typed, propose)
    except Unavailable as busy:
        return again(page, typed, busy)
    except DrumtrueError as error:
        return steps.refused(page, guide, form, error, "plan")


def _strike_out(work: AppContext, guide: Guide, mass_g: float) -> str:
    """One piece that the box should hold is not there: book what a count would find."""
    box = catalogues.get(work, guide.session.catalogue_id or "")
    item = next((one for one in box.items if abs(one.mass_g - mass_g) < 1e-9), None)
    if item is not None and item.on_hand:
        counted = (Pieces(mass_g=item.mass_g, pieces=item.on_hand - 1),)
        catalogues.change(work, box.id, CataloguePatch(counted=counted))
    return f"/sessions/{guide.session.id}"


def _balancer_masses(page: Page, guide: Guide, form: Form) -> tuple[MassOnRotor, ...]:
    out = []
    for index, plane in enumerate(guide.session.machine.planes):
        grams = form.number(f"masses[{index}].mass_g", low=0.0, high=1e5, unit=page.display.mass_unit())
        angle = form.angle(f"masses[{index}].angle_deg")
        if grams and angle is not None:
            out.append(MassOnRotor(plane=plane.name, mass_g=grams, angle_deg=angle))
    return tuple(out)
