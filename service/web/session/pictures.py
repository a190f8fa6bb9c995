"""The pictures that a step shows, drawn for the reader."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from markupsafe import Markup

from service.engine import mapping
from service.model.correction import Correction
from service.model.plan import BlockedPosition, FrontPoint, Plan
from service.model.report import BeforeAfter
from service.model.session import Session
from service.web.pictures.angle_axis import compass_of, flipped
from service.web.pictures.bars import before_after
from service.web.pictures.dials import amplitude_dial, phase_dial
from service.web.pictures.end_view import Part, Piece, end_view
from service.web.pictures.front import front_chart
from service.web.pictures.masses import mass_plot
from service.web.pictures.polar import polar_plot
from service.web.pictures.reader import Reader
from service.web.pictures.svg import to_svg
from service.web.preferences import Preferences
from service.web.session.moves import Move

_PARTS: dict[str, Part] = {"on": "add", "off": "remove", "stay": "keep"}
MIRRORED = "sense_mirrored"
"""The finding that one of the two senses is the other way round."""


def ends(
    session: Session,
    moves: Iterable[Move],
    preferences: Preferences,
    *,
    blocked: Sequence[BlockedPosition] = (),
    planes: Sequence[str] = (),
    other_end: bool = False,
) -> list[Markup]:
    """The end view of each plane (of all, unless some are named), with what goes on, comes off and stays."""
    pieces = [Piece(move.plane, move.angle_deg, move.mass_g, _PARTS[move.action]) for move in moves]
    pieces += [Piece(p.plane, p.position_deg, p.mass_g, "fixed") for p in session.on_rotor if p.may == "stay"]
    reader = Reader(preferences)
    return [
        to_svg(end_view(session.machine, plane.name, reader, pieces=pieces, blocked=blocked, from_other_end=other_end))
        for plane in session.machine.planes
        if not planes or plane.name in planes
    ]


def vectors(
    session: Session, correction: Correction | None, plan: Plan | None, preferences: Preferences
) -> list[Markup]:
    """What each sensor saw in every run, with what to expect; then what each plane needs."""
    reader = Reader(preferences)
    expected = plan.predicted if plan is not None else correction.predicted if correction is not None else ()
    out = []
    for sensor in session.machine.sensors:
        predicted = next((one for one in expected if one.sensor == sensor.name), None)
        out.append(
            to_svg(
                polar_plot(
                    session.machine, sensor.name, session.runs, reader, run_out=session.run_out, predicted=predicted
                )
            )
        )
    if correction is not None:
        out += [to_svg(mass_plot(session.machine, one, reader, plan=plan)) for one in correction.corrections]
    return out


def mirrored(session: Session, correction: Correction | None, preferences: Preferences) -> list[tuple[Markup, Markup]]:
    """Where a sense is the other way round: the end view as the machine states it, and the mirrored one beside it."""
    if correction is None or not any(one.code == MIRRORED for one in correction.diagnostics):
        return []
    reader, machine = Reader(preferences), session.machine
    trials = [run for run in session.runs if run.masses and not run.excluded][-1:]
    pieces = [Piece(m.plane, m.angle_deg, m.mass_g, "keep") for run in trials for m in run.masses]
    planes = dict.fromkeys(piece.plane for piece in pieces)
    return [
        (
            to_svg(end_view(machine, plane, reader, pieces=pieces)),
            to_svg(end_view(flipped(machine, "angle_sense"), plane, reader, pieces=pieces)),
        )
        for plane in planes
    ]


def bars(session: Session, lines: Sequence[BeforeAfter], preferences: Preferences) -> list[Markup]:
    """Before and after of every sensor."""
    return [to_svg(before_after(session.machine, lines, Reader(preferences)))] if lines else []


def front(plan: Plan, points: Sequence[FrontPoint], preferences: Preferences) -> Markup:
    """What each further piece brings."""
    limit = 1.0 if plan.request.objective == "residual_vibration" and plan.request.norm == "max" else None
    reader, chosen = Reader(preferences), len(plan.placements)
    shares = plan.request.objective == "residual_vibration" and plan.objective_unit == "1"
    unit = reader.gettext("share of the limit") if shares else plan.objective_unit
    return to_svg(front_chart(points, unit, reader, chosen=chosen, limit=limit))


def dials(session: Session, scales: dict[str, float], preferences: Preferences) -> dict[str, tuple[Markup, Markup]]:
    """Amplitude and phase of each sensor, without a value yet: the page turns the needles."""
    reader, machine = Reader(preferences), session.machine
    return {
        sensor.name: (
            to_svg(amplitude_dial(sensor, None, reader, limit=limit_of(session, sensor.name), top=scales[sensor.name])),
            to_svg(phase_dial(machine, sensor, None, reader)),
        )
        for sensor in machine.sensors
    }


def limit_of(session: Session, sensor: str) -> float | None:
    """The limit of a sensor at service speed, in its unit."""
    found = next(one for one in session.machine.sensors if one.name == sensor)
    return mapping.limit_of(session.machine, mapping.Channel(found, session.machine.service_speed_rpm))


def larger_dial(session: Session, sensor: str, amplitude: float, preferences: Preferences) -> Markup:
    """The dial of an amplitude that goes beyond the scale of the one from `dials`."""
    found = next(one for one in session.machine.sensors if one.name == sensor)
    limit = limit_of(session, sensor)
    return to_svg(amplitude_dial(found, amplitude, Reader(preferences), limit=limit, top=1.25 * amplitude))


def phase_sign(session: Session) -> int:
    """1 where a phase's needle turns clockwise with it, -1 where the other way."""
    machine = session.machine
    return 1 if compass_of(machine, (0.0, 0.0)).clockwise == (machine.phase_sense == "lag") else -1
