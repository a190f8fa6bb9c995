"""Correction of a plane on polar paper: what is needed, the region that holds it, and the pieces that make it up."""

from __future__ import annotations

import math
from dataclasses import replace

from service.balancing.rotor.phasors import phasor, polar, to_radians
from service.engine import mapping
from service.model.correction import Ellipse, PlaneMass
from service.model.machine import Machine
from service.model.plan import Plan
from service.model.run import MassOnRotor
from service.web.pictures.angle_axis import arrow_head, compass_of
from service.web.pictures.drawing import Circle, Item, Line, Picture, Point, Words
from service.web.pictures.polar_axes import Paper, key_mark, sense_arrows
from service.web.pictures.reader import Reader

WIDTH, RADIUS = 560.0, 200.0
CENTRE: Point = (WIDTH / 2, 262.0)
_STEPS = 72


def mass_plot(machine: Machine, needed: PlaneMass, reader: Reader, *, plan: Plan | None = None) -> Picture:
    """Draw the correction of a plane as a vector with its ellipse, and a plan's changes of it head to tail.

    The changes are those of the as-found rotor: pieces that come off are drawn the other way, fasteners count. Angles
    as in `compass`.
    """
    _ = reader.gettext
    unit = reader.show.mass_unit()
    here = [mass for mass in _changes(plan) if mass.plane == needed.plane]
    wanted = phasor(unit.show(needed.mass_g), needed.angle_deg, machine.angle_sense)
    ends = [0j]
    for mass in here:
        ends.append(ends[-1] + phasor(unit.show(mass.mass_g), mass.angle_deg, machine.angle_sense))
    reach = 0.0 if needed.ellipse is None else unit.show(needed.ellipse.major_g)
    paper = Paper(compass_of(machine, CENTRE), RADIUS, max(abs(wanted) + reach, *map(abs, ends)))
    items: list[Item] = list(paper.grid(reader, machine.angle_sense))
    if needed.ellipse is not None:
        region = _region(machine, paper, wanted, needed.ellipse, 1.0 / unit.size)
        items.append(Line(region, "pic-region", closed=True))
    tip = paper.tip(wanted)
    items += [Line((CENTRE, tip), "pic-predicted"), Circle(tip, 6.0, "pic-predicted-tip")]
    for begin, end in zip(map(paper.tip, ends), map(paper.tip, ends[1:]), strict=False):
        items += [Line((begin, end), "pic-vector pic-trial"), arrow_head(begin, end, "pic-influence-head", 13.0)]
    items.append(key_mark((CENTRE[0], CENTRE[1] - RADIUS + 14.0)))
    counted = _("mass angle")
    items += sense_arrows(paper.compass, RADIUS + 32.0, machine.angle_sense, counted, _("rotation"))
    title = _("Correction in plane %(plane)s, %(unit)s") % {"plane": needed.plane, "unit": unit.sign}
    items.append(Words((WIDTH / 2, 20.0), title, "pic-title", size=17.0))
    words = [_("needed: %(mass)s @ %(angle)s") % _stated(reader, needed.mass_g, needed.angle_deg)]
    if here:
        vector = ends[-1] * unit.size
        grams, angle = polar(vector, machine.angle_sense)
        words.append(_("pieces together: %(mass)s @ %(angle)s") % _stated(reader, grams, angle))
    y = CENTRE[1] + RADIUS + 50.0
    items += _legend_line(y, words[0], "pic-predicted")
    if len(words) > 1:
        items += _legend_line(y + 22.0, words[1], "pic-vector pic-trial")
    return Picture(WIDTH, y + 22.0 * len(words) - 6.0, title, "; ".join(words), tuple(items))


def _changes(plan: Plan | None) -> tuple[MassOnRotor, ...]:
    """Masses that the plan puts on the as-found rotor; what comes off it is negative."""
    if plan is None:
        return ()
    off = (replace(mass, mass_g=-mass.mass_g) for mass in mapping.as_masses(plan.taken_off))
    return (*mapping.as_masses(plan.placements if plan.fitted is None else plan.fitted), *off)


def _region(machine: Machine, paper: Paper, centre: complex, region: Ellipse, factor: float) -> tuple[Point, ...]:
    """Outline of an ellipse of confidence about an internal vector, in the unit shown."""
    turn = to_radians(region.angle_deg, machine.angle_sense)
    axes = complex(math.cos(turn), math.sin(turn))
    out = []
    for step in range(_STEPS):
        t = 2.0 * math.pi * step / _STEPS
        out.append(
            paper.tip(centre + factor * axes * complex(region.major_g * math.cos(t), region.minor_g * math.sin(t)))
        )
    return tuple(out)


def _stated(reader: Reader, mass_g: float, angle_deg: float) -> dict[str, str]:
    return {"mass": reader.mass(mass_g), "angle": reader.angle(angle_deg)}


def _legend_line(y: float, text: str, cls: str) -> list[Item]:
    return [Line(((46.0, y), (76.0, y)), cls), Words((86.0, y + 5.0), text, "pic-words", "start", 14.0)]
