"""The report of a run as a sheet, which the certificate's writer makes a PDF of."""

from __future__ import annotations

from service.model.design import DesignEvaluation
from service.model.design_run import DesignRun
from service.web.certificate.document import Facts, Lines, Mood, Part, Pictures, Section, Sheet, Table
from service.web.designs import tables
from service.web.designs.figures import Figures, front_picture
from service.web.designs.names import METHODS, RESPONSES, STATES, STUDIES, name_of
from service.web.pictures.reader import Reader

MAX_POINTS = 60


def sheet_of(run: DesignRun, before: DesignEvaluation, after: DesignEvaluation | None, reader: Reader) -> Sheet:
    """The report: verdict, facts, present next to optimum, limits, pictures. after: what an optimum does."""
    _ = reader.gettext
    verdict, mood = _verdict(run, reader)
    sections = [Section(_("What was computed"), (Facts(_facts(run, reader)),))]
    sections.append(Section(_("Present design and optimum"), (_table(before, after, reader),)))
    limits = _limits(before, after, reader)
    if limits:
        sections.append(Section(_("Limits"), (Lines(limits),)))
    if run.front is not None and run.front.points:
        sections.append(Section(_("Front"), _front(run, reader)))
    figures = Figures(before if after is None else after, None if after is None else before, reader)
    pictures = tuple(figures.all().values())
    if pictures:
        sections.append(Section(_("Pictures"), (Pictures(pictures, 2),)))
    title = str(run.document.get("title") or name_of(STUDIES, str(run.document.get("study")), _))
    return Sheet(
        language=reader.preferences.language,
        title=_("Report of a design study"),
        subject=title[:200],
        verdict=verdict,
        mood=mood,
        sections=tuple(sections),
        signatures=((_("Checked by, date"), ""),),
        foot=_("Design study, run %(run)s") % {"run": run.id},
        page_of=_("page %(page)s of %(pages)s"),
        dated=run.ended_at or run.created_at,
        unprinted=_("%(count)s signs cannot be printed, a box stands for each: %(signs)s"),
    )


def _verdict(run: DesignRun, reader: Reader) -> tuple[str, Mood]:
    _ = reader.gettext
    if run.outcome is not None:
        said = name_of(STATES, run.outcome.status, _)
        value = tables.value_of(run.outcome.value, run.outcome.unit, reader)
        name = name_of(RESPONSES, run.outcome.objective, _)
        mood: Mood = "bad" if run.outcome.status == "infeasible" else "good"
        return f"{name}: {value} ({said})", mood
    if run.front is not None:
        return _("Front of %(count)s designs") % {"count": len(run.front.points)}, "good"
    return name_of(STATES, run.state, _), "open"


def _facts(run: DesignRun, reader: Reader) -> tuple[tuple[str, str], ...]:
    _ = reader.gettext
    method = run.request.method if run.outcome is None else run.outcome.method
    pairs = [
        (_("Study"), name_of(STUDIES, str(run.document.get("study")), _)),
        (_("Version"), "\N{EM DASH}" if run.study_version is None else str(run.study_version)),
        (_("Begun"), reader.moment(run.created_at)),
        (_("State"), name_of(STATES, run.state, _)),
        (_("Method"), name_of(METHODS, method or "sqp", _)),
        (_("Seed"), str(run.request.seed)),
        (_("Evaluations"), str(run.progress.evaluations)),
        (_("Time"), reader.show.seconds(run.progress.seconds)),
    ]
    if run.outcome is not None:
        pairs.append((_("What speaks for it"), tables.evidence(run.outcome.evidence, reader)))
    return tuple(pairs)


def _table(before: DesignEvaluation, after: DesignEvaluation | None, reader: Reader) -> Table:
    _ = reader.gettext
    found = tables.rows(before.responses, None if after is None else after.responses, reader)
    heads = (_("Response"), _("Present"), _("Optimum"), _("Change"))
    return Table(
        heads,
        tuple((one.name, one.before, one.after, one.change) for one in found),
        (46, 20, 20, 14),
        frozenset({1, 2, 3}),
    )


def _limits(before: DesignEvaluation, after: DesignEvaluation | None, reader: Reader) -> tuple[str, ...]:
    _ = reader.gettext
    lines = [f"{_('Present design breaks')}: {one}" for one in tables.broken(before.responses.limits, reader)]
    if after is not None:
        lines += [f"{_('Optimum breaks')}: {one}" for one in tables.broken(after.responses.limits, reader)]
        holding = tables.holding(after.responses.limits, reader)
        if holding:
            lines.append(_("Held back by: %(limits)s") % {"limits": ", ".join(holding)})
    return tuple(lines)


def _front(run: DesignRun, reader: Reader) -> tuple[Part, ...]:
    assert run.front is not None  # noqa: S101
    heads = tuple(name_of(RESPONSES, one, reader.gettext) for one in run.front.names)
    found = tables.points(run.front, reader)
    step = max(1, len(found) // MAX_POINTS)
    return (
        Pictures((front_picture(run.front, reader),), 1),
        Table(heads, tuple(found[::step]), (50, 50), frozenset({0, 1})),
    )
