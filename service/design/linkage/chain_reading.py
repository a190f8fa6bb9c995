"""Linkages in design documents: the chain with its bodies, and its speed."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from typing import get_args

from service.design.findings import of_error
from service.design.reading import Table, refused
from service.errors import NumericsError
from service.mechanics.bodies import Body
from service.mechanics.chain import Dyad, Link, Linkage, Side
from service.messages import Message

MAX_LINKS = 50
MAX_POINTS = 20
MIN_SAMPLES, MAX_SAMPLES = 24, 7200
STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True)
class StatedLinkage:
    """A linkage with the speed of its crank, rad/s, and the number of crank angles over a turn."""

    linkage: Linkage
    speed: float
    samples: int


def read_linkage(root: Table) -> StatedLinkage | None:
    """The linkage of a document; None, with the problems noted, where it is none."""
    table = root.table("linkage")
    if table is None:
        return None
    problems = root.problems
    speed = table.number("speed", "speed")
    if speed == 0.0:
        problems.add(Message("design_speed_zero", field=table.at("speed")))
    samples = table.whole("samples", default=360, least=MIN_SAMPLES, most=MAX_SAMPLES)
    gravity = table.number("gravity", "acceleration", default=0.0, least=0.0)
    ground = _points(table, "ground")
    links = tuple(_link(one) for one in table.tables("link", least=3, most=MAX_LINKS))
    dyads = tuple(_dyad(one) for one in table.tables("dyad", least=1, most=MAX_LINKS))
    crank = table.text("crank")
    moment_point = table.text("moment_point", default="") or None
    table.close()
    if refused(problems):
        return None
    stated = StatedLinkage(Linkage(ground, crank, links, dyads, moment_point, gravity), speed, samples)
    try:
        _ = stated.linkage.layout
    except NumericsError as error:
        problems.found.append(of_error(error, "linkage"))
        return None
    return stated


def _link(table: Table) -> Link:
    name = table.text("name")
    points = _points(table, "points")
    body = read_body(table)
    table.close()
    return Link(name, points, body)


def read_body(table: Table) -> Body:
    """Mass, centre (as x and y or as radius and angle) and inertia of a body, stated in a table among other fields."""
    mass = table.number("mass", "mass", above=0.0)
    if "radius" in table:
        radius = table.number("radius", "length", least=0.0)
        centre = cmath.rect(radius, table.number("angle", "angle", default=0.0))
    else:
        centre = complex(*table.numbers("centre", "length", count=2))
    inertia = table.number("inertia", "inertia", above=0.0)
    about = table.text("inertia_about", default="centre", choices=("centre", "origin"))
    make = Body.about_centre if about == "centre" else Body.about_origin
    return make(mass, centre, inertia)


def _points(table: Table, name: str) -> dict[str, complex]:
    held = table.table(name)
    if held is None:
        return {}
    if not 1 <= len(held.values) <= MAX_POINTS:
        table.problems.add(
            Message("design_count_out_of_range", field=table.at(name), value=len(held.values), least=1, most=MAX_POINTS)
        )
        return {}
    points = {str(point): complex(*held.numbers(str(point), "length", count=2)) for point in held.values}
    held.close()
    return points


def _dyad(table: Table) -> Dyad:
    joint = table.text("joint")
    first, second = table.texts("links", count=2)
    side: Side = "left" if table.text("side", choices=get_args(Side)) == "left" else "right"
    carrier = table.text("carrier", default="") or None
    table.close()
    return Dyad(joint, (first, second), side, carrier)
