"""What a certificate says of what was measured, computed, fitted and reached."""

from __future__ import annotations

from service.engine.validation import hole_label, position_index
from service.model.machine import Machine, Sensor
from service.model.plan import Placement, Plan
from service.model.report import BeforeAfter, Outcome, Report
from service.model.run import Run
from service.model.session import Session
from service.web.certificate.document import Facts, Lines, Mood, Part, Pictures, Table
from service.web.certificate.facts import DASH, grade
from service.web.pictures import bars, end_view, polar
from service.web.pictures.reader import Reader
from service.web.pictures.words import mass_words

MAX_RUNS = 40
"""Runs in the table of a certificate: the first, which all others are compared with, and the latest."""
MAX_POLAR = 4
"""Polar plots on a certificate; with more sensors the table of runs has to do."""


def verdict(report: Report, reader: Reader) -> tuple[str, Mood]:
    """Whether what was asked for is reached by the drum as it is now, in a sentence or two."""
    _ = reader.gettext
    found = report.verdict
    said: dict[Outcome, tuple[str, Mood]] = {
        "unchecked": (_("Not finished: the drum as it is now has not been checked."), "open"),
        "above_limit": (_("Above the limit: %(sensors)s.") % {"sensors": ", ".join(found.above)}, "bad"),
        "grade_not_reached": (_("The balance quality asked for is not reached."), "bad"),
        "partly_judged": (_("Vibration within its limit; the balance quality asked for is not judged."), "open"),
        "nothing_asked": (_("Not judged: no limit and no balance quality was stated."), "open"),
        "reached": (_("Balanced: within what was asked for."), "good"),
    }
    sentence, mood = said[found.outcome]
    return " ".join((sentence, *(f"{reader.message(one)}." for one in found.unjudged))), mood


def before_after(machine: Machine, lines: tuple[BeforeAfter, ...], reader: Reader) -> tuple[Part, ...]:
    """Bars, and the same as a table."""
    _, show = reader.gettext, reader.show
    if not lines:
        return (Lines((_("No run as found has been taken."),)),)
    sensor = {s.name: s for s in machine.sensors}
    zones = any(line.zone_before for line in lines)
    several = len({line.speed_rpm for line in lines}) > 1
    heads = (_("Sensor"), _("Speed measured"), _("Before"), _("After"), _("Change"), _("Limit"), _("Within"))
    rows = tuple(
        (
            f"{line.sensor}, {show.speed(line.speed_rpm)}" if several else line.sensor,
            _measured_speeds(line, reader),
            show.amplitude(sensor[line.sensor], line.before) + _zone(line.zone_before),
            show.amplitude(sensor[line.sensor], line.after) + _zone(line.zone_after),
            DASH if line.reduction is None else f"{reader.signed(-100.0 * line.reduction)} %",
            show.amplitude(sensor[line.sensor], line.limit),
            DASH if line.within_limit is None else _("yes") if line.within_limit else _("no"),
        )
        for line in lines
    )
    table = Table(heads, rows, (14, 19, 16, 16, 11, 14, 10), frozenset({1, 2, 3, 4, 5}))
    said: tuple[Part, ...] = (Lines((_("Zones A to D by ISO 20816-3, of the broadband value."),)),) if zones else ()
    return (
        (Pictures((bars.before_after(machine, lines, reader),), 1), table, *said) if len(lines) <= 4 else (table, *said)
    )


def _measured_speeds(line: BeforeAfter, reader: Reader) -> str:
    """What the tachometer read before and after; a speed that no one measured is not stated."""
    before, after = (
        DASH if rpm is None else reader.show.measured_speed(rpm) for rpm in (line.before_rpm, line.after_rpm)
    )
    return before if before == after else f"{before} / {after}"


def quality(report: Report, reader: Reader) -> tuple[Part, ...]:
    """Balance quality by ISO 21940-11, with its interval; or why it is not stated."""
    _, show, tolerance = reader.gettext, reader.show, report.tolerance
    if tolerance is None and report.tolerance_missing is not None:
        return (
            Lines(
                (
                    _("Not stated: %(reason)s.")
                    % {"reason": reader.words(report.tolerance_missing_data or report.tolerance_missing)},
                )
            ),
        )
    if tolerance is None:
        return (Lines((_("Not stated: it needs grade, mass of the rotor, two bearings, and runs with phase."),)),)
    reached = grade(tolerance.grade_reached_mm_s, reader) or DASH
    if tolerance.interval is not None:
        low, high = (reader.number(x) for x in (tolerance.interval.low, tolerance.interval.high))
        reached += f" ({low} – {high})"
    if not tolerance.within:
        said = _("not reached")
    else:
        said = _("reached, its whole interval too") if tolerance.surely else _("reached, its interval not wholly")
    facts = Facts(
        (
            (_("Asked for"), grade(tolerance.grade_mm_s, reader) or DASH),
            (_("Reached"), f"{reached}: {said}"),
            (_("Permissible residual unbalance"), show.unbalance(tolerance.permissible_gmm)),
        )
    )
    rows = tuple(
        (b.bearing, show.unbalance(b.permissible_gmm), show.unbalance(b.residual_gmm)) for b in tolerance.bearings
    )
    heads = (_("Bearing"), _("Permissible"), _("Residual"))
    assumed = Lines((_("Assumes a rigid rotor, all of whose vibration at the speed of rotation is from unbalance."),))
    return facts, Table(heads, rows, (40, 30, 30), frozenset({1, 2})), assumed


def masses(session: Session, plan: Plan | None, reader: Reader) -> tuple[Part, ...]:
    """Where the masses are: a picture of each plane, and the same as a table."""
    _ = reader.gettext
    if plan is None:
        return (Lines((_("No mass has been fitted."),)),)
    machine = session.machine
    placed = plan.placements if plan.fitted is None else plan.fitted
    pieces = [*(_piece(p, "add") for p in placed), *(_piece(p, "remove") for p in plan.taken_off)]
    gone = {(p.plane, p.position_deg, p.mass_g) for p in plan.taken_off}
    for found in session.on_rotor:
        if (found.plane, found.position_deg, found.mass_g) not in gone:
            pieces.append(end_view.Piece(found.plane, found.position_deg, found.mass_g, "fixed"))
    views = tuple(end_view.end_view(machine, p.name, reader, pieces=pieces, done=True) for p in machine.planes)
    words = {"add": _("bolted in"), "remove": _("taken off"), "fixed": _("as found, stays")}
    rows = tuple(
        (
            piece.plane,
            _hole(machine, piece),
            reader.angle(piece.position_deg),
            reader.mass(piece.mass_g),
            words[piece.part],
        )
        for piece in sorted(
            pieces, key=lambda one: ([p.name for p in machine.planes].index(one.plane), one.position_deg)
        )
    )
    heads = (_("Plane"), _("Hole"), _("Angle"), _("Mass"), _("What"))
    across = 2 if len(views) <= 2 else 3 if len(views) <= 6 else 4
    table = Table(heads, rows, (24, 16, 16, 20, 24), frozenset({2, 3}))
    return (Pictures(views, across), *((table,) if rows else ()), Lines(_weighed(placed, reader)))


def proof(report: Report, reader: Reader) -> Lines:
    """What is proved of the choice of masses, in a sentence; nothing without a plan."""
    _ = reader.gettext
    said = {
        "optimal": _("Proved: nothing in the box does better."),
        "within_uncertainty": _("Proved: what is better in the box is better by no more than can be measured."),
        "limit_reached": _("The time for the search was over: something in the box may do better."),
        "heuristic": _("Nothing is proved of this choice of masses."),
        "infeasible": _("There was no choice of masses that keeps all limits."),
    }
    if report.plan_status is None:
        return Lines(())
    share = report.plan_probability_within
    cases = _("By the scatter of the readings, all limits are kept in %(cases)s of 100 cases.")
    likely = () if share is None else (cases % {"cases": reader.number(100.0 * share)},)
    return Lines((said[report.plan_status], *likely))


def polar_plots(session: Session, plan: Plan | None, reader: Reader) -> tuple[Part, ...]:
    """A polar plot of every sensor at the service speed, if there are not too many."""
    machine = session.machine
    if len(machine.sensors) > MAX_POLAR or not any(_phased(run) for run in session.runs):
        return ()
    predicted = (
        {} if plan is None else {v.sensor: v for v in plan.predicted if v.speed_rpm == machine.service_speed_rpm}
    )
    plots = tuple(
        polar.polar_plot(
            machine,
            s.name,
            session.runs,
            reader,
            run_out=session.run_out,
            predicted=predicted.get(s.name),
            legend=False,
        )
        for s in machine.sensors
    )
    return (Pictures(plots, 2 if len(plots) <= 2 else 4),)


def runs(session: Session, reader: Reader) -> tuple[Part, ...]:
    """Every run: kind, speed, masses, readings; excluded ones with the reason. Of many the first and the latest."""
    _ = reader.gettext
    kinds = {"initial": _("as found"), "trial": _("trial"), "check": _("check"), "correction": _("with corrections")}
    sensors = {sensor.name: sensor for sensor in session.machine.sensors}
    if not session.runs:
        return (Lines((_("No run has been taken."),)),)
    rows = []
    left_out = max(len(session.runs) - MAX_RUNS, 0)
    for run in (*session.runs[:1], *session.runs[1 + left_out :]):
        kind = kinds[run.kind]
        if run.excluded:
            kind = _("%(kind)s (excluded: %(reason)s)") % {"kind": kind, "reason": run.reason or DASH}
        fitted = mass_words(run.masses, reader, most=8) or DASH
        rows.append((str(run.number), kind, _run_speed(run, reader), fitted, _readings(run, sensors, reader)))
    heads = (_("Run"), _("Kind"), _("Speed measured"), _("Masses on the drum"), _("Readings"))
    table = Table(heads, tuple(rows), (5, 16, 10, 30, 39), frozenset({0, 2}))
    if not left_out:
        return (table,)
    said = _("%(count)s earlier runs are not in this table; the data of the session (JSON) have them all.")
    return (table, Lines((said % {"count": left_out},)))


def _run_speed(run: Run, reader: Reader) -> str:
    """The mean of the speeds that were measured in a run; a dash where none was."""
    measured = [reading.speed_rpm for reading in run.readings if reading.speed_rpm is not None]
    return reader.show.measured_speed(sum(measured) / len(measured)) if measured else DASH


def coefficients(report: Report, reader: Reader) -> tuple[Part, ...]:
    """Influence coefficients of all runs together."""
    _, show = reader.gettext, reader.show
    if not report.influence:
        return (Lines((_("The runs do not determine influence coefficients."),)),)
    sensors = {sensor.name: sensor for sensor in report.machine.sensors}
    mass = show.mass_unit()
    rows = []
    for row in report.influence:
        for c in row:
            unit = reader.amplitude_unit(sensors[c.sensor])
            value = f"{reader.number(unit.show(c.amplitude_per_g) * mass.size)}"
            spread = None if c.scatter_per_g is None else reader.number(unit.show(c.scatter_per_g) * mass.size, 2)
            sign = f"{_(unit.sign)} / {mass.sign}"
            shown = value if spread in (None, "0") else f"{value} ± {spread}"
            rows.append((c.sensor, c.plane, show.speed(c.speed_rpm), shown, sign, reader.angle(c.phase_deg)))
    heads = (_("Sensor"), _("Plane"), _("Nominal speed"), _("Influence"), _("Unit"), _("Phase"))
    return (Table(heads, tuple(rows), (20, 20, 15, 22, 13, 10), frozenset({2, 3, 5})),)


def findings(report: Report, reader: Reader) -> tuple[Part, ...]:
    """What the runs say of themselves, worst first."""
    _ = reader.gettext
    if not report.influence:
        return (Lines((_("Not examined: that needs runs with phase that determine the influence coefficients."),)),)
    if not report.diagnostics:
        return (Lines((_("Nothing speaks against the runs."),)),)
    grave = {"error": _("error"), "warning": _("warning"), "info": _("note")}
    return (Lines(tuple(f"{grave[d.severity]}: {reader.message(d)}. {reader.advice(d)}" for d in report.diagnostics)),)


def _phased(run: Run) -> bool:
    return any(reading.phase_deg is not None for reading in run.readings)


def _readings(run: Run, sensors: dict[str, Sensor], reader: Reader) -> str:
    out = []
    for r in run.readings:
        phase = "" if r.phase_deg is None else f" @ {reader.angle(r.phase_deg)}"
        out.append(f"{r.sensor}: {reader.show.amplitude(sensors[r.sensor], r.amplitude)}{phase}")
    return "; ".join(out)


def _piece(placement: Placement, part: end_view.Part) -> end_view.Piece:
    return end_view.Piece(placement.plane, placement.position_deg, placement.mass_g, part)


def _hole(machine: Machine, piece: end_view.Piece) -> str:
    plane = next(p for p in machine.planes if p.name == piece.plane)
    return hole_label(plane, position_index(plane, piece.position_deg, "position_deg"))


def _weighed(placed: tuple[Placement, ...], reader: Reader) -> tuple[str, ...]:
    """Pieces that weighed something else than the box says."""
    return tuple(
        reader.gettext("Plane %(plane)s, hole %(hole)s: weighed %(mass)s.")
        % {"plane": p.plane, "hole": p.hole, "mass": reader.mass(p.weighed_g)}
        for p in placed
        if p.weighed_g is not None
    )


def _zone(zone: str | None) -> str:
    return "" if zone is None else f" ({zone})"
