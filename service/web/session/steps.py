"""What each step of a session shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fastapi.responses import HTMLResponse
from markupsafe import Markup

from service.engine import mapping
from service.engine.evidence.follow_up import STOPS
from service.engine.rotor_state import changes_to, mounted, trial_piece
from service.engine.trial_check import Answer, TrialEffect, answer_of, effect_of, force_of
from service.engine.validation import highest_speed, label_at
from service.errors import DrumtrueError, InvalidInput
from service.messages import Message
from service.model.diagnostic import Diagnostic
from service.model.influence import TrialMassSuggestion
from service.model.machine import StoredCatalogue
from service.model.plan import Plan
from service.model.run import Run
from service.model.stop import Stop
from service.usecases.machines import influence
from service.usecases.plans import plans
from service.usecases.readings import sources
from service.usecases.sessions import reports
from service.usecases.stock import catalogues
from service.web.certificate import results
from service.web.forms import Form
from service.web.pictures.reader import Reader
from service.web.rendering import Page
from service.web.session import pictures
from service.web.session.guide import STEPS, TITLES, Guide, holes
from service.web.session.moves import Move, force, moves
from service.web.session.refused_form import Kept, kept

MAX_BOXES = 200
RUN_STEPS = frozenset({"initial", "trial", "check"})
"""Steps that a run is taken in."""


def show(
    page: Page,
    guide: Guide,
    step: str | None = None,
    *,
    form: Form | None = None,
    status: int = 200,
    notice: str | None = None,
    typing: bool = False,
    held: Kept | None = None,
    template: str | None = None,
    runs: Sequence[Run] = (),
) -> HTMLResponse:
    """A step of a session; the next one unless another is asked for, to look back."""
    shown = step if step in STEPS and guide.reached(step) else guide.step
    return page.render(
        f"steps/{template or shown}.html",
        status=status,
        guide=guide,
        session=guide.session,
        machine=guide.session.machine,
        step="" if template else shown,
        active=shown == guide.step and guide.session.state != "closed",
        steps=[(name, TITLES[name], guide.place(name), guide.reached(name)) for name in STEPS],
        form=form or Form(preferences=page.preferences),
        notice=notice,
        hole_at=lambda mass: label_at(guide.plane(mass.plane), mass.angle_deg),
        force=lambda plane, grams: force(guide.session.machine, plane, grams),
        over_speed=highest_speed(guide.session.machine),
        typing=typing,
        kept=held,
        runs=runs,
        **_OF_STEP[shown](page, guide),
    )


def show_all(page: Page, guide: Guide, before: int | None = None) -> HTMLResponse:
    """Runs of a session, newest first, whatever the step; those with a number below `before`, page by page."""
    runs = tuple(run for run in guide.session.runs if before is None or run.number < before)
    return show(page, guide, "initial", template="runs", runs=runs)


# ---------------------------------------------------------------- of each step
@dataclass(frozen=True)
class TrialAdvice:
    """Trial mass for a plane: what the rules say, and what fits of it."""

    plane: str
    suggestion: TrialMassSuggestion | None
    piece_g: float | None
    """The piece of the box next to the suggestion, g."""
    hole_deg: float
    """Angle of the hole to use."""
    why_not: Message | None


def trial_advice(page: Page, guide: Guide, plane: str) -> TrialAdvice:
    """Advice for a plane; without the rotor's mass it says why there is none."""
    suggestion, why_not = None, None
    try:
        found = influence.suggest_trials(page.work, guide.session.id)
        suggestion = next(one for one in found if one.plane == plane)
    except InvalidInput as refused:
        why_not = refused.data
    positions = guide.plane(plane).positions_deg
    wanted = suggestion.angle_deg if suggestion is not None and suggestion.angle_deg is not None else positions[0]
    hole = min(positions, key=lambda at: abs((at - wanted + 180.0) % 360.0 - 180.0))
    return TrialAdvice(plane, suggestion, _piece(page, guide, plane, suggestion), hole, why_not)


def expected_g(page: Page, guide: Guide, plane: str) -> float | None:
    """The trial mass that is usual here: as suggested, else the mean of what was bolted on before."""
    advice = trial_advice(page, guide, plane)
    if advice.suggestion is not None:
        return advice.piece_g or advice.suggestion.mass_g
    before = [abs(mass.mass_g) for run in guide.runs("trial") for mass in run.masses]
    return sum(before) / len(before) if before else None


def sure(grams: float) -> str:
    """The name of the tick that says that this very mass is meant."""
    return f"sure.{grams:.6g}"


def _piece(page: Page, guide: Guide, plane: str, suggestion: TrialMassSuggestion | None) -> float | None:
    box = box_of(page, guide)
    if box is None or suggestion is None:
        return None
    most = guide.plane(plane).max_force_n or float("inf")
    fits = [
        item.mass_g + item.fastener_g
        for item in box.items
        if item.on_hand != 0 and force(guide.session.machine, plane, item.mass_g + item.fastener_g) <= most
    ]
    light = [grams for grams in fits if "force_large" not in force_of(guide.session.machine, plane, grams).doubts]
    fits = light or fits
    return min(fits, key=lambda grams: abs(grams - suggestion.mass_g), default=None)


def box_of(page: Page, guide: Guide) -> StoredCatalogue | None:
    """The session's box, with what is left in it."""
    key = guide.session.catalogue_id
    return None if key is None else catalogues.get(page.work, key)


def _initial(page: Page, guide: Guide) -> dict[str, Any]:
    return _entry(page, guide)


def _trial(page: Page, guide: Guide) -> dict[str, Any]:
    if guide.step != "trial":
        return {}
    stop = guide.stop if guide.stop is not None and guide.stop.purpose == "trial" else None
    asked = page.request.query_params.get("plane")
    names = [plane.name for plane in guide.session.machine.planes]
    plane = (
        stop.plane
        if stop is not None and stop.plane is not None
        else asked
        if asked in names
        else (guide.planes_to_try or names)[0]
    )
    advice = trial_advice(page, guide, plane)
    return {
        "plane": guide.plane(plane),
        "advice": advice,
        "holes": holes(guide.plane(plane)),
        "part": guide.part if stop is not None else "begin",
        "effect": effect(guide),
        "taught": bool(influence.history_of(page.work, guide.session.machine_id, 1)),
        "pictures": _trial_picture(page, guide, advice),
        **_entry(page, guide),
    }


@dataclass(frozen=True)
class Effect:
    """What the latest trial mass did, right after its run."""

    run: Run
    plane: str
    answer: Answer
    sensors: tuple[TrialEffect, ...]


def effect(guide: Guide) -> Effect | None:
    """The effect of the latest trial run against the run as found; None where the latest run is no such run."""
    last = guide.used[-1] if guide.used else None
    first = next((run for run in guide.used if run.kind == "initial"), None)
    if last is None or first is None or last.kind != "trial" or not last.masses:
        return None
    if last.nominal_speed_rpm != first.nominal_speed_rpm:
        return None
    found = effect_of(guide.session.machine, first, last, guide.session.run_out)
    return Effect(last, last.masses[-1].plane, answer_of(found), found) if found else None


def _trial_picture(page: Page, guide: Guide, advice: TrialAdvice) -> list[Markup]:
    """The plane with the trial mass as advised; earlier trial masses come off."""
    grams = advice.piece_g or (advice.suggestion.mass_g if advice.suggestion is not None else None)
    return trial_picture(page, guide, advice.plane, grams, advice.hole_deg)


def trial_picture(
    page: Page, guide: Guide, plane: str, grams: float | None, at_deg: float | None, *, keep: bool = False
) -> list[Markup]:
    """A plane with this trial mass in this hole; keep: earlier trial masses stay on."""
    stays, off = ((), ()) if guide.fitted is None else (guide.fitted.fitted or (), guide.fitted.taken_off)
    before = [mass for mass in guide.on_rotor if keep and guide.fitted is None and mass.mass_g > 0.0]
    earlier = tuple(trial_piece(guide.plane(mass.plane), mass.mass_g, mass.angle_deg) for mass in before)
    added = () if grams is None or at_deg is None else (trial_piece(guide.plane(plane), grams, at_deg),)
    todo = moves(guide.session.machine, changes_to(guide.drum, (*stays, *earlier, *added), off))
    return pictures.ends(guide.session, todo, page.preferences, planes=(plane,), other_end=_other_end(page))


def _other_end(page: Page) -> bool:
    """Whether the reader stands at the end opposite to the one that the machine is described from."""
    return page.request.query_params.get("end") == "other"


def _correction(page: Page, guide: Guide) -> dict[str, Any]:
    found = guide.session.corrections
    correction = guide.correction or (found[-1] if found else None)
    return {
        "correction": correction,
        "effect": effect(guide),
        "pictures": pictures.vectors(guide.session, correction, None, page.preferences),
        "mirrored": pictures.mirrored(guide.session, correction, page.preferences),
    }


def _plan(page: Page, guide: Guide) -> dict[str, Any]:
    made = guide.session.plans
    drawn = {"moves": [], "pictures": [], "vectors": []} if guide.plan is None else _drawn(page, guide, guide.plan)
    return {
        "plan": guide.plan or (made[-1] if made else None),
        "box": box_of(page, guide),
        "boxes": [] if guide.session.catalogue_id else catalogues.find(page.work, MAX_BOXES, 0),
        "correction": guide.correction,
        "expected": _of_alternatives(page, guide),
        "objectives": _objectives(guide),
        "may_choose": not any(piece.may != "stay" for piece in guide.session.on_rotor),
        **drawn,
    }


def _objectives(guide: Guide) -> list[str]:
    """What a plan may aim at, the usual first: vibration needs coefficients, forces need places along the shaft."""
    machine, correction = guide.session.machine, guide.correction
    out = ["residual_vibration"] if correction is not None and correction.influence else []
    placed = mapping.bearing_places(machine) is not None and mapping.plane_places(machine) is not None
    robust = ["robust"] if correction is not None and any(one.interval for one in correction.initial) else []
    return [*out, "components", *(["bearing_force"] if placed else []), *(robust if out else [])]


def _of_alternatives(page: Page, guide: Guide) -> tuple[Plan, ...]:
    """What is to be expected of each of a plan's alternatives."""
    plan = guide.plan
    if plan is None or not plan.alternatives or guide.session.catalogue_id is None:
        return ()
    return plans.expected(page.work, plan.id, [offer.placements for offer in plan.alternatives])


def _drawn(page: Page, guide: Guide, plan: Plan) -> dict[str, list[Any]]:
    """What a plan asks to be done, as text and in pictures."""
    todo = moves(guide.session.machine, plan.changes)
    ends = pictures.ends(
        guide.session, todo, page.preferences, blocked=plan.request.blocked, other_end=_other_end(page)
    )
    vectors = pictures.vectors(guide.session, guide.correction, plan, page.preferences)
    return {"moves": todo, "pictures": ends, "vectors": vectors}


def _fit(page: Page, guide: Guide) -> dict[str, Any]:
    stop = guide.stop if guide.stop is not None and guide.stop.purpose in ("plan", "bare") else None
    todo = _to_fit(guide, stop)
    return {
        "plan": _to_expect(page, guide, stop),
        "stop": stop,
        "box": box_of(page, guide),
        "moves": todo,
        "pictures": pictures.ends(guide.session, todo, page.preferences, other_end=_other_end(page)),
        "holes": {plane.name: holes(plane) for plane in guide.session.machine.planes},
        "part": guide.part if stop is not None else "done",
    }


def _to_expect(page: Page, guide: Guide, stop: Stop | None) -> Plan | None:
    """The plan to fit or fitted, with what to expect: of an alternative that was chosen, what it promises."""
    if stop is None or stop.purpose == "bare":
        return guide.fitted
    plan = next((one for one in guide.session.plans if one.id == stop.plan_id), None)
    if plan is None or plan.state == "fitted" or stop.placements == plan.placements:
        return plan
    return plans.expected(page.work, plan.id, [stop.placements])[0]


def _to_fit(guide: Guide, stop: Stop | None) -> list[Move]:
    if stop is None or stop.masses is not None:
        now = mounted(guide.drum)
        return moves(guide.session.machine, changes_to(guide.drum, now.on, now.off))
    if stop.purpose == "bare":
        return moves(guide.session.machine, changes_to(guide.drum, ()))
    plan = next(one for one in guide.session.plans if one.id == stop.plan_id)
    return moves(guide.session.machine, changes_to(guide.drum, stop.placements, plan.taken_off))


def _check(page: Page, guide: Guide) -> dict[str, Any]:
    lines = reports.before_after(page.work, guide.session)
    return {
        "lines": lines,
        "pictures": pictures.bars(guide.session, lines, page.preferences),
        **_entry(page, guide),
    }


def _decide(page: Page, guide: Guide) -> dict[str, Any]:
    report = reports.report(page.work, guide.session.id)
    return {
        "report": report,
        "outcome": report.verdict.outcome,
        "verdict": results.verdict(report, Reader(page.preferences))[0],
        "unjudged": report.verdict.unjudged,
        "stopped": _stopped(guide),
        "taught": _taught(page, guide),
        "trim_source": trim_source(guide),
        "pictures": pictures.bars(guide.session, report.before_after, page.preferences),
        "vectors": pictures.vectors(guide.session, None, guide.fitted, page.preferences),
    }


def trim_source(guide: Guide) -> str:
    """What a trim is computed from: a fit as soon as the runs allow it, else what the last correction came from."""
    last = guide.session.corrections[-1].request.source if guide.session.corrections else "fit"
    return "fit" if guide.progress.can_fit else last


def _stopped(guide: Guide) -> tuple[Diagnostic, ...]:
    """Why no further round like the last one should be made."""
    last = guide.used[-1] if guide.used else None
    return () if last is None else tuple(one for one in last.warnings if one.code in STOPS)


def _taught(page: Page, guide: Guide) -> bool | None:
    """Whether the session has taught the machine its coefficients; None where it has no run to teach them by."""
    if not any(run.masses for run in guide.used):
        return None
    return influence.has_taught(page.work, guide.session.id)


def _entry(page: Page, guide: Guide) -> dict[str, Any]:
    """What a run is taken with: the live values, and a dial for each sensor."""
    if guide.step not in RUN_STEPS or guide.session.state == "closed":
        return {}
    sourced = any(source.machine_id == guide.session.machine_id for source in sources.bound(page.work))
    return {"sourced": sourced, "dials": pictures.dials(guide.session, scales(guide), page.preferences)}


def scales(guide: Guide) -> dict[str, float]:
    """Full scale of each sensor's dial, in its stored unit: room above what was measured and the limit."""
    out = {}
    for sensor in guide.session.machine.sensors:
        seen = [r.amplitude for run in guide.session.runs for r in run.readings if r.sensor == sensor.name]
        limit = pictures.limit_of(guide.session, sensor.name) or 0.0
        out[sensor.name] = 1.25 * max([*seen, 2.0 * limit, 1e-6])
    return out


def refused(
    page: Page, guide: Guide, form: Form, error: DrumtrueError, step: str | None = None, *, typing: bool = False
) -> HTMLResponse:
    """The step again, with what was refused beside its field and what was typed kept.

    What is refused for the state of the session may be of a form that this state has no more: it is shown too.
    """
    form.refused(error)
    held = None if error.status == 422 else kept(page, guide, form.values)
    return show(page, guide, step, form=form, status=error.status, typing=typing, held=held)


_OF_STEP = {
    "initial": _initial,
    "trial": _trial,
    "correction": _correction,
    "plan": _plan,
    "fit": _fit,
    "check": _check,
    "decide": _decide,
}
