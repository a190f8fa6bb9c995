"""What a certificate says, in order."""

from __future__ import annotations

from service.model.report import Report
from service.model.session import Session
from service.web.certificate import facts, results
from service.web.certificate.document import Section, Sheet
from service.web.pictures.reader import Reader


def certificate(session: Session, report: Report, reader: Reader) -> Sheet:
    """The certificate of a session and its report, in the reader's language and units.

    It holds nothing but what is stored and what follows from it: made again it is the same.
    """
    _ = reader.gettext
    machine = session.machine
    plan = next((p for p in session.plans if p.id == session.fitted_plan_id), None)
    noun = _("session")
    said, mood = results.verdict(report, reader)
    sections = (
        Section(
            _("Machine"),
            (facts.machine_facts(machine, reader), facts.session_facts(session, reader), facts.note(session, reader)),
        ),
        Section(_("Before and after"), results.before_after(machine, report.before_after, reader)),
        Section(_("Balance quality (ISO 21940-11)"), results.quality(report, reader)),
        Section(_("Masses"), (*results.masses(session, plan, reader), results.proof(report, reader))),
        Section(_("Vibration"), results.polar_plots(session, plan, reader)),
        Section(_("Runs"), results.runs(session, reader)),
        Section(_("Influence coefficients"), results.coefficients(report, reader)),
        Section(_("Findings"), results.findings(report, reader)),
        Section(_("Instruments and planes"), (facts.sensors(machine, reader), facts.planes(machine, reader))),
        Section(_("Conventions"), (facts.conventions(machine, reader),)),
    )
    shown = tuple(section for section in sections if section.parts)
    last = session.runs[-1].taken_at if session.runs else session.created_at
    return Sheet(
        language=reader.preferences.language,
        title=_("Balancing certificate"),
        subject=machine.name,
        verdict=said,
        mood=mood,
        sections=shown,
        signatures=((_("Place and date"), ""), (_("Balanced by"), session.technician or ""), (_("Checked by"), "")),
        signed=next(index for index, section in enumerate(shown) if section.heading == _("Before and after")),
        foot=f"Drumtrue {report.version} · {noun} {session.id} · {reader.moment(session.closed_at or last)}",
        page_of=_("page %(page)s of %(pages)s"),
        dated=session.closed_at or last,
        unprinted=_("%(count)s signs cannot be printed, a box stands for each: %(signs)s"),
    )
