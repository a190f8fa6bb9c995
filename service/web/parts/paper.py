"""The certificate of an arrangement: which part is in which place, what that leaves, and what is proved."""

from __future__ import annotations

from service.model.arrangement import Arrangement, PlaneResidual
from service.model.machine import Machine
from service.web.certificate import facts
from service.web.certificate.document import Facts, Lines, Mood, Part, Pictures, Section, Sheet, Table
from service.web.parts import mounting, views
from service.web.pictures.reader import Reader

DASH = facts.DASH
PROVED: frozenset[str] = frozenset({"optimal", "within_uncertainty"})


def certificate(made: Arrangement, machine: Machine | None, reader: Reader) -> Sheet:
    """The certificate of an arrangement, in the reader's language and units; made again it is the same."""
    _ = reader.gettext
    dated = made.released_at or made.mounted_at or made.created_at
    sections = (
        Section(_("Machine"), (*((facts.machine_facts(machine, reader),) if machine else ()), _told(made, reader))),
        Section(_("Parts in their places"), (*_pictures(made, machine, reader), _table(made, reader))),
        Section(_("Moves"), _moves(made, reader)),
        Section(_("What is left"), _left(made, reader)),
        Section(_("Proof"), _proof(made, reader)),
        Section(_("Conventions"), (facts.conventions(machine, reader),) if machine else ()),
    )
    said, mood = _verdict(made, reader)
    return Sheet(
        language=reader.preferences.language,
        title=_("Certificate of an arrangement of parts"),
        subject=(machine.name if machine else None) or made.request.set or made.id,
        verdict=said,
        mood=mood,
        sections=tuple(section for section in sections if section.parts),
        signatures=((_("Place and date"), ""), (_("Mounted by"), ""), (_("Checked by"), "")),
        foot=f"Drumtrue · {_('arrangement')} {made.id} · {reader.moment(dated)}",
        page_of=_("page %(page)s of %(pages)s"),
        dated=dated,
        unprinted=_("%(count)s signs cannot be printed, a box stands for each: %(signs)s"),
    )


def _verdict(made: Arrangement, reader: Reader) -> tuple[str, Mood]:
    _ = reader.gettext
    if not made.arrangement and made.mounted is None:
        return f"{reader.words(made.reason_data or made.reason)}.", "bad"
    if made.state == "mounted":
        if made.mounted == made.arrangement:
            return _("Mounted as computed."), "good"
        return _("Mounted, not everywhere as computed: see what is left."), "open"
    return _("Computed, not reported as mounted."), "open"


def _told(made: Arrangement, reader: Reader) -> Facts:
    _ = reader.gettext
    offsets = {
        None: _("the bare drum is balanced"),
        "measured": _("measured with the parts that were mounted"),
        "in_balance_with_old": _("in balance with the parts that were mounted"),
    }
    offset = made.request.offset
    asked = [
        (_("Parts"), made.request.set),
        (_("Places"), str(len(made.places))),
        (_("Starts from"), offsets[offset] if offset is None or isinstance(offset, str) else _("stated unbalance")),
        (_("Computed"), reader.moment(made.created_at)),
        (_("Mounted"), None if made.mounted_at is None else reader.moment(made.mounted_at)),
        (_("Arrangement"), made.id),
    ]
    return Facts(tuple((name, value) for name, value in asked if value is not None))


def _pictures(made: Arrangement, machine: Machine | None, reader: Reader) -> tuple[Part, ...]:
    places = views.placed(made)
    if all(place.part is None for place in places):
        return ()
    return (Pictures(views.pictures(machine, places, reader, made), 2),)


def _table(made: Arrangement, reader: Reader) -> Table:
    _ = reader.gettext
    masses = views.masses_by_part(made)
    before = {part.present: part.id for part in made.request.parts if part.present is not None}
    rows = tuple(
        (
            place.label,
            reader.angle(place.degrees),
            place.part or _("empty"),
            views.mass(reader.show, masses.get(place.part or "")),
            before.get(place.label, DASH),
        )
        for place in views.placed(made)
    )
    heads = (_("Place"), _("Angle"), _("Part"), _("Mass"), _("Was there"))
    return Table(heads, rows, (16, 16, 24, 26, 18), frozenset({1, 3}))


def _moves(made: Arrangement, reader: Reader) -> tuple[Part, ...]:
    _ = reader.gettext
    said = {"off": _("take off"), "lay": _("take off, lay down"), "move": _("move"), "on": _("mount")}
    rows = tuple(
        (str(number), said[one.action], one.part, one.leaves or DASH, one.to or DASH)
        for number, one in enumerate(mounting.handlings(made), 1)
    )
    heads = ("", _("What"), _("Part"), _("From place"), _("To place"))
    return (Table(heads, rows, (8, 32, 24, 18, 18)),) if rows else ()


def _left(made: Arrangement, reader: Reader) -> tuple[Part, ...]:
    _, show = reader.gettext, reader.show
    left: tuple[PlaneResidual, ...] = made.mounted_residual or made.residual
    rows = tuple(
        (
            one.plane,
            show.unbalance(one.unbalance_g_mm),
            reader.angle(one.angle_deg),
            DASH
            if one.interval is None
            else f"{show.unbalance(one.interval.low)} – {show.unbalance(one.interval.high)}",
        )
        for one in left
    )
    heads = (_("Plane"), _("Unbalance left"), _("Angle"), _("Between"))
    return (Table(heads, rows, (20, 26, 16, 38), frozenset({1, 2, 3})),) if rows else ()


def _proof(made: Arrangement, reader: Reader) -> tuple[Part, ...]:
    _ = reader.gettext
    lines = [f"{reader.words(made.message_data or made.message)}."]
    if made.objective_value is not None:
        found = views.figures(made, reader)
        lines.append(_("This order leaves %(value)s.") % {"value": views.objective(made, made.objective_value, reader)})
        if found.now is not None:
            lines.append(
                _("The order before left %(value)s.") % {"value": views.objective(made, made.objective_now, reader)}
            )
        if made.makers_rule is not None:
            told = views.objective(made, made.makers_rule.objective_value, reader)
            lines.append(_("The maker's rule, heaviest parts opposite, would leave %(value)s.") % {"value": told})
        if found.scale is not None:
            lines.append(_("What the scale cannot tell: %(value)s, one standard deviation.") % {"value": found.scale})
    return (Lines(tuple(lines)),)
