"""Runs: typed in, taken from the live source, excluded, taken in again."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path
from fastapi.responses import Response

from service.engine.validation import highest_speed
from service.errors import DrumtrueError, OutOfOrder
from service.messages import Message
from service.model.run import RunKind, RunPatch, RunReading, RunRequest, Take
from service.model.stop import StopRequest
from service.runtime.context import AppContext
from service.usecases.sessions import live, runs, stops
from service.web.form_guard import done_in, require_fresh
from service.web.forms import Form, TypedDep
from service.web.language import N_
from service.web.rendering import Page, PageDep
from service.web.routers.session_steps import GuideDep, Key
from service.web.session import steps
from service.web.session.guide import Guide, look
from service.web.units import TURNS

router = APIRouter(prefix="/sessions/{session_id}/runs")

MAX_AMPLITUDE = 1e6
_KIND: dict[str, RunKind] = {"initial": "initial", "trial": "trial", "check": "check"}
TOO_FAST = N_("%(speed)s is above the service speed of %(service)s. Slow the machine down, then take the run again.")


@router.post("")
def type_run(page: PageDep, session_id: Key, typed: TypedDep) -> Response:
    """A run as it was typed in; sent again because the answer was lost, it is stored once."""
    guide = look(page.work, session_id)
    form = Form(typed, page.preferences)
    machine = guide.session.machine
    speed = form.number("speed_rpm", low=1.0, high=1e6, unit=TURNS, required=False)
    if speed is not None and speed > highest_speed(machine):
        form.wrong("speed_rpm", TOO_FAST, **_speeds(page, guide, page.display.speed(speed)))
    readings = [_reading(page, guide, form, index, speed) for index in range(len(machine.sensors))]
    stated = tuple(reading for reading in readings if reading is not None)
    require_fresh(page, guide, typed)
    if form.ok and not stated:
        form.wrong("readings[0].amplitude", N_("Fill in this field."))
    if not form.ok:
        return steps.show(page, guide, form=form, status=422, typing=True)
    return _stored(page, guide, typed, form, readings=stated)


@router.post("/take")
def take_run(page: PageDep, guide: GuideDep, typed: TypedDep) -> Response:
    """The newest readings of the live source, averaged."""
    form = Form(typed, page.preferences)
    now = live.look(page.work, guide.session.id, guide.turning_since)
    take = live.window(page.work, guide.session.id, guide.turning_since)
    if take is None:
        form.wrong("", N_("There is no live value. Check that the source delivers, or type the run in."))
    elif now.steady and not now.ready:
        form.wrong("", N_("The clock of the source is not known well enough yet. Wait ten seconds, then take the run."))
    elif not now.steady and not form.ticked("anyway"):
        form.wrong("", N_("The readings are not steady any more. Let the machine settle, then take the run."))
    fastest = max((s.speed_rpm for s in now.sensors if s.speed_rpm is not None), default=0.0)
    if fastest > highest_speed(guide.session.machine):
        form.wrong("", TOO_FAST, **_speeds(page, guide, page.display.measured_speed(fastest)))
    if not form.ok or take is None:
        return steps.show(page, guide, form=form, status=422)
    return _stored(page, guide, typed, form, take=take)


@router.post("/{run_id}/exclude")
def exclude_run(
    page: PageDep, guide: GuideDep, typed: TypedDep, run_id: Annotated[str, Path(max_length=32)]
) -> Response:
    """Leave a run out of everything, or take it in again; nothing is erased."""
    form = Form(typed, page.preferences)
    back = typed.get("step", "")
    excluded = typed.get("excluded") == "yes"
    reason = form.text("reason", most=500) or page.text(
        N_("excluded on the page") if excluded else N_("taken in again")
    )

    def change(work: AppContext) -> str:
        runs.change(work, guide.session.id, run_id, RunPatch(excluded=excluded, reason=reason))
        return f"/sessions/{guide.session.id}"

    if not form.ok:
        return steps.show(page, guide, back, form=form, status=422)
    try:
        return done_in(page, guide, typed, change)
    except DrumtrueError as error:
        return steps.refused(page, guide, form, error, back)


@router.post("/{run_id}/repeat")
def repeat_trial(
    page: PageDep, guide: GuideDep, typed: TypedDep, run_id: Annotated[str, Path(max_length=32)]
) -> Response:
    """Leave a trial run out and stop the machine to take it again in the same plane."""
    run = next((one for one in guide.session.runs if one.id == run_id), None)
    plane = run.masses[-1].plane if run is not None and run.masses else None

    def again(work: AppContext) -> str:
        runs.change(
            work, guide.session.id, run_id, RunPatch(excluded=True, reason=page.text(N_("the trial is repeated")))
        )
        stops.begin(work, guide.session.id, StopRequest(purpose="trial", plane=plane))
        return f"/sessions/{guide.session.id}"

    try:
        return done_in(page, guide, typed, again)
    except DrumtrueError as error:
        return steps.refused(page, guide, Form(typed, page.preferences), error)


def _reading(page: Page, guide: Guide, form: Form, index: int, speed: float | None) -> RunReading | None:
    """What was typed for a sensor; None where its fields are both empty or wrong."""
    sensor = guide.session.machine.sensors[index]
    amplitude_name, phase_name = f"readings[{index}].amplitude", f"readings[{index}].phase_deg"
    if not form.value(amplitude_name).strip() and not form.value(phase_name).strip() and index > 0:
        return None
    unit = page.display.amplitude_unit(sensor)
    amplitude = form.number(amplitude_name, low=0.0, high=MAX_AMPLITUDE, unit=unit)
    phase = form.angle(phase_name, required=False)
    if amplitude is None or amplitude_name in form.errors or phase_name in form.errors:
        return None
    return RunReading(sensor=sensor.name, amplitude=amplitude, phase_deg=phase, speed_rpm=speed)


def _request(guide: Guide, *, readings: tuple[RunReading, ...] | None = None, take: Take | None = None) -> RunRequest:
    """The run that is next: its masses are those stated when they were fitted."""
    kind = _KIND.get(guide.step)
    if kind is None:
        raise OutOfOrder(Message("out_of_order.no_run_now"), field="kind", value=guide.step)
    masses = () if kind == "initial" else None if kind == "check" else guide.on_rotor
    return RunRequest(kind=kind, masses=masses, readings=readings, take=take)


def _stored(
    page: Page,
    guide: Guide,
    typed: dict[str, str],
    form: Form,
    *,
    readings: tuple[RunReading, ...] | None = None,
    take: Take | None = None,
) -> Response:
    try:
        request = _request(guide, readings=readings, take=take)

        def store(work: AppContext) -> str:
            runs.add(work, guide.session.id, request)
            return f"/sessions/{guide.session.id}"

        return done_in(page, guide, typed, store)
    except DrumtrueError as error:
        return steps.refused(page, guide, form, error, typing=readings is not None)


def _speeds(page: Page, guide: Guide, speed: str) -> dict[str, str]:
    return {"speed": speed, "service": page.display.speed(guide.session.machine.service_speed_rpm)}
