"""The part of a linkage document that says what may change, its limits, and what is aimed at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from service.design.linkage.chain_reading import StatedLinkage, read_body
from service.design.linkage.mass_designs import (
    Counterweights,
    MassDesign,
    MassNumbers,
    PointMasses,
    number_variables,
    point_variables,
)
from service.design.linkage.mass_limits import MassLimit
from service.design.reading import Table
from service.design.study import Variable
from service.mechanics.bodies import Body, FloatArray, as_three_points
from service.mechanics.dynamics import Quantity, mass_numbers
from service.messages import Message

Scale = Literal["crank", "present", "none"]
_COUNTERWEIGHTS, _POINTS, _NUMBERS = "counterweights", "point_masses", "mass_numbers"


@dataclass(frozen=True)
class StatedAim:
    """Weights of the quantities; each is divided by its scale and raised to the power. front: two to trade off."""

    weights: dict[Quantity, float]
    scale: Scale
    power: int
    front: tuple[Quantity, Quantity] | None


@dataclass(frozen=True)
class StatedDesign:
    """What may change. present: x (d,) of the document's own design; p: its mass numbers (4 links,).

    angles: (link, lower, upper) directions of mass centres, rad.
    """

    variation: MassDesign
    present: FloatArray
    p: FloatArray
    limits: tuple[MassLimit, ...]
    angles: tuple[tuple[int, float, float], ...]


def read_aim(root: Table) -> StatedAim:
    """The aim of a document; force and moment alike where none is stated."""
    table = root.table("aim", optional=True)
    if table is None:
        return StatedAim({"force": 0.5, "moment": 0.5, "torque": 0.0}, "present", 1, None)
    weights_table = table.table("weights", optional=True)
    weights: dict[Quantity, float] = {"force": 0.5, "moment": 0.5, "torque": 0.0}
    if weights_table is not None:
        weights = {name: weights_table.number(name, default=0.0) for name in get_args(Quantity)}
        weights_table.close()
        if min(weights.values()) < 0.0 or sum(weights.values()) <= 0.0:
            stated = ", ".join(f"{name} {value:g}" for name, value in weights.items())
            root.problems.add(Message("design_weights", field=weights_table.path, value=stated))
    chosen = table.text("scale", default="present", choices=get_args(Scale))
    scale: Scale = next(one for one in get_args(Scale) if one == chosen)
    power = table.whole("power", default=1, least=1, most=2)
    pair = table.texts("front", count=2, optional=True)
    front: tuple[Quantity, Quantity] | None = None
    if pair:
        chosen_pair = [next((one for one in get_args(Quantity) if one == name), None) for name in pair]
        if chosen_pair[0] is None or chosen_pair[1] is None or pair[0] == pair[1]:
            known = ", ".join(get_args(Quantity))
            root.problems.add(
                Message("design_name_unknown", field=table.at("front"), value=", ".join(pair), known=known)
            )
        else:
            front = (chosen_pair[0], chosen_pair[1])
    table.close()
    return StatedAim(weights, scale, power, front)


def read_design(root: Table, stated: StatedLinkage) -> StatedDesign | None:
    """What may change on a linkage; None where the document states no design."""
    table = root.table("design", optional=True)
    if table is None:
        return None
    kind = table.text("kind", choices=(_COUNTERWEIGHTS, _POINTS, _NUMBERS))
    design = _counterweights(table, stated) if kind == _COUNTERWEIGHTS else _redistribution(table, stated, kind)
    table.close()
    return design


def _counterweights(table: Table, stated: StatedLinkage) -> StatedDesign:
    density = table.number("density", "density", above=0.0)
    bounds = [
        ("x", table.bounds("x_bounds", "length")),
        ("y", table.bounds("y_bounds", "length")),
        ("thickness", table.bounds("thickness_bounds", "length")),
    ]
    if bounds[2][1][0] < 0.0:
        lower = bounds[2][1][0]
        table.problems.add(
            Message("design_out_of_range.at_least", field=table.at("thickness_bounds"), value=lower, bound=0.0)
        )
    discs = table.tables("counterweight", least=1, most=len(stated.linkage.links))
    links: list[tuple[int, str]] = []
    variables: list[Variable] = []
    present: list[float] = []
    for one in discs:
        link = _link(one, stated)
        _once(one, link, links)
        links.append(link)
        for name, (low, high) in bounds:
            value = one.number(name, "length", least=0.0 if name == "thickness" else None)
            variables.append(Variable(f"{link[1]}.{name}", low, high, value, "length"))
            present.append(value)
        one.close()
    base, x = mass_numbers(stated.linkage), np.array(present)
    variation = Counterweights(base, tuple(links), density, tuple(variables))
    return StatedDesign(variation, x, variation.numbers(x), (), ())


def _redistribution(table: Table, stated: StatedLinkage, kind: str) -> StatedDesign:
    links: list[tuple[int, str]] = []
    variables: list[Variable] = []
    limits: list[MassLimit] = []
    angles: list[tuple[int, float, float]] = []
    p = mass_numbers(stated.linkage)
    for one in table.tables("link", least=1, most=len(stated.linkage.links)):
        link = _link(one, stated)
        _once(one, link, links)
        links.append(link)
        old = stated.linkage.links[link[0]].body
        own = one.table("body", optional=True)
        body = old
        if own is not None:
            body = read_body(own)
            own.close()
        p[4 * link[0] : 4 * link[0] + 4] = body.numbers
        found, factors = _limits(one, link[0], old)
        limits += found
        if "centre_angle" in one:
            angles.append((link[0], *one.bounds("centre_angle", "angle")))
        variables += _variables(one, link[1], kind, old, body, factors)
        one.close()
    base = mass_numbers(stated.linkage)
    variation: MassDesign = (
        PointMasses(base, tuple(links), tuple(variables))
        if kind == _POINTS
        else MassNumbers(base, tuple(links), tuple(variables))
    )
    present = np.array([variable.present for variable in variables])
    return StatedDesign(variation, present, p, tuple(limits), tuple(angles))


@dataclass(frozen=True)
class _Reach:
    """How far the mass numbers of a link can go: greatest mass, first moment and inertia."""

    mass: float
    moment: float
    inertia: float


def _limits(table: Table, link: int, old: Body) -> tuple[list[MassLimit], _Reach]:
    """Limits stated for a link: factors of what it has, and radii."""
    mass = table.bounds("mass_factor", default=(1e-3, 3.0))
    radius = table.bounds("centre_radius", "length", default=(0.0, np.inf))
    most_inertia = table.number("inertia_origin_factor", default=np.inf, above=0.0)
    least_inertia = table.number("inertia_centre_factor", default=0.0, least=0.0)
    bounds = [
        MassLimit("mass_min", link, mass[0] * old.mass, old.mass, old.inertia),
        MassLimit("mass_max", link, mass[1] * old.mass, old.mass, old.inertia),
        MassLimit("centre_radius_min", link, radius[0], old.mass, old.inertia),
        MassLimit("centre_radius_max", link, radius[1], old.mass, old.inertia),
        MassLimit("inertia_origin_max", link, most_inertia * old.inertia, old.mass, old.inertia),
        MassLimit("inertia_centre_min", link, least_inertia * old.central_inertia, old.mass, old.inertia),
    ]
    stated = {
        "mass_min": "mass_factor" in table,
        "mass_max": "mass_factor" in table,
        "centre_radius_min": radius[0] > 0.0,
        "centre_radius_max": np.isfinite(radius[1]),
        "inertia_origin_max": np.isfinite(most_inertia),
        "inertia_centre_min": True,
    }
    heaviest = mass[1] * old.mass
    inertia = (most_inertia if np.isfinite(most_inertia) else 10.0) * old.inertia
    moment = min(heaviest * radius[1], float(np.sqrt(heaviest * inertia)))
    return [one for one in bounds if stated[one.kind]], _Reach(heaviest, moment, inertia)


def _variables(table: Table, name: str, kind: str, old: Body, body: Body, reach: _Reach) -> list[Variable]:
    if kind == _NUMBERS:
        return number_variables(name, body, reach.mass, reach.moment, reach.inertia)
    masses = table.bounds("point_mass", "mass")
    factors = table.bounds("point_radius_factor", default=(0.25, 2.0))
    _, radius = as_three_points(old)
    return point_variables(name, body, masses, (factors[0] * radius, factors[1] * radius))


def _link(table: Table, stated: StatedLinkage) -> tuple[int, str]:
    names = [link.name for link in stated.linkage.links]
    name = table.pick("link", names)
    return names.index(name), name


def _once(table: Table, link: tuple[int, str], links: list[tuple[int, str]]) -> None:
    if link in links:
        table.problems.add(Message("design_name_twice", field=table.at("link"), value=link[1]))
