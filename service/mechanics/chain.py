"""A planar linkage as data: ground points, a crank, and dyads placed one after the other.

Every link has named points in its own local frame. A dyad joins two links at one point; each of the two has exactly
one other point that is placed already: on the ground, on the crank or on a link of an earlier dyad.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Literal

from service.mechanics.bodies import Body, check_body
from service.mechanics.refusals import Refusal
from service.messages import Message

GROUND = "ground"
"""Name of the frame where a joint's links are named."""
SHORTEST = 1e-9
"""Two points of a link nearer than this, in m, are one."""
Side = Literal["left", "right"]


@dataclass(frozen=True)
class Link:
    """A moving link. points: local coordinates x + i y in m by name; body: its mass in the same frame."""

    name: str
    points: Mapping[str, complex]
    body: Body


@dataclass(frozen=True)
class Dyad:
    """Two links joined at `joint`; side: of the ray from the placed point of the first to that of the second.

    Of later dyads that hang on the joint the second link carries the pin, unless `carrier` names the first.
    """

    joint: str
    links: tuple[str, str]
    side: Side
    carrier: str | None = None


@dataclass(frozen=True)
class Linkage:
    """A chain of dyads behind a crank. ground: x + i y in m by name. crank: its link; turns about its ground point.

    moment_point: ground point about which the shaking moment is taken; the crank's pivot if None.
    gravity: m/s2, downwards (-y).
    """

    ground: Mapping[str, complex]
    crank: str
    links: tuple[Link, ...]
    dyads: tuple[Dyad, ...]
    moment_point: str | None = None
    gravity: float = 0.0

    @cached_property
    def layout(self) -> Layout:
        """The order in which the links are placed; raises Refusal for a chain that cannot be placed."""
        return _layout(self)


@dataclass(frozen=True)
class Support:
    """A point by which a link hangs on another. carrier: index of that link, None for the ground."""

    name: str
    carrier: int | None
    on_carrier: complex
    on_link: complex


@dataclass(frozen=True)
class Pair:
    """A dyad with everything resolved. links: indices; supports: of both; ends: the joint in both local frames."""

    joint: str
    links: tuple[int, int]
    supports: tuple[Support, Support]
    ends: tuple[complex, complex]
    left: bool

    @property
    def lengths(self) -> tuple[float, float]:
        """Distances from the supports to the joint, m."""
        first, second = (abs(end - support.on_link) for end, support in zip(self.ends, self.supports, strict=True))
        return first, second


@dataclass(frozen=True)
class Layout:
    """A resolved chain. pivot: name, place on the ground and place on the crank; order: index of the crank's link."""

    crank: int
    pivot: Support
    pairs: tuple[Pair, ...]
    origin: complex


def _layout(linkage: Linkage) -> Layout:
    _check(linkage)
    index = {link.name: number for number, link in enumerate(linkage.links)}
    crank = _known(index, linkage.crank, "crank")
    pivots = [name for name in linkage.links[crank].points if name in linkage.ground]
    if len(pivots) != 1:
        raise Refusal(Message("linkage_crank_pivot", field="crank", value=_listed(pivots)))
    pivot = Support(pivots[0], None, linkage.ground[pivots[0]], linkage.links[crank].points[pivots[0]])
    placed: dict[str, tuple[int | None, complex]] = {name: (None, place) for name, place in linkage.ground.items()}
    _place(placed, linkage, crank)
    done, pairs = {crank}, []
    for number, dyad in enumerate(linkage.dyads):
        pairs.append(_pair(linkage, dyad, index, placed, done, f"dyad.{number + 1}"))
    left_over = [link.name for link in linkage.links if index[link.name] not in done]
    if left_over:
        raise Refusal(Message("linkage_link_unplaced", field="links", value=_listed(left_over)))
    name = linkage.moment_point or pivot.name
    if name not in linkage.ground:
        raise Refusal(Message("linkage_unknown_link", field="moment_point", value=name, known=_listed(linkage.ground)))
    return Layout(crank, pivot, tuple(pairs), linkage.ground[name])


def _check(linkage: Linkage) -> None:
    if not linkage.dyads:
        raise Refusal(Message("linkage_without_dyad", field="dyads"))
    names = [link.name for link in linkage.links]
    for name in names:
        if names.count(name) > 1:
            raise Refusal(Message("linkage_name_twice", field="links", value=name))
    for name, place in linkage.ground.items():
        _finite(f"ground.{name}", place)
    for link in linkage.links:
        for name, place in link.points.items():
            _finite(f"links.{link.name}.points.{name}", place)
        for (first, one), (second, other) in combinations(link.points.items(), 2):
            if abs(one - other) < SHORTEST:
                _coincident(link, first, second, abs(one - other))
        check_body(link.body, f"link {link.name}")
    _finite("gravity", complex(linkage.gravity))


def _pair(
    linkage: Linkage,
    dyad: Dyad,
    index: Mapping[str, int],
    placed: dict[str, tuple[int | None, complex]],
    done: set[int],
    name: str,
) -> Pair:
    """Resolve one dyad and place its links."""
    first, second = (_known(index, link, f"{name}.links") for link in dyad.links)
    if dyad.carrier is not None and dyad.carrier not in dyad.links:
        raise Refusal(
            Message("linkage_unknown_link", field=f"{name}.carrier", value=dyad.carrier, known=_listed(dyad.links))
        )
    for link in (first, second):
        if link in done or first == second:
            raise Refusal(
                Message("linkage_link_twice", field=f"{name}.links", value=linkage.links[link].name, joint=dyad.joint)
            )
    supports = tuple(_support(linkage.links[link], dyad.joint, placed, name) for link in (first, second))
    ends = (linkage.links[first].points[dyad.joint], linkage.links[second].points[dyad.joint])
    order = (first, second) if dyad.carrier == dyad.links[0] else (second, first)
    for link in order:
        _place(placed, linkage, link)
        done.add(link)
    return Pair(dyad.joint, (first, second), (supports[0], supports[1]), ends, dyad.side == "left")


def _support(link: Link, joint: str, placed: Mapping[str, tuple[int | None, complex]], name: str) -> Support:
    if joint not in link.points:
        raise Refusal(
            Message(
                "linkage_joint_missing", field=f"{name}.joint", value=_listed(link.points), link=link.name, joint=joint
            )
        )
    held = [point for point in link.points if point in placed and point != joint]
    if len(held) != 1 or joint in placed:
        raise Refusal(Message("linkage_dyad_support", field=name, value=_listed(held), link=link.name, joint=joint))
    carrier, place = placed[held[0]]
    return Support(held[0], carrier, place, link.points[held[0]])


def _place(placed: dict[str, tuple[int | None, complex]], linkage: Linkage, link: int) -> None:
    """Give the points of a link to later dyads; a point that is placed already stays with its first carrier."""
    for name, place in linkage.links[link].points.items():
        placed.setdefault(name, (link, place))


def _coincident(link: Link, first: str, second: str, apart: float) -> None:
    raise Refusal(
        Message(
            "linkage_zero_length",
            field=f"links.{link.name}.points",
            value=apart,
            first=first,
            second=second,
            link=link.name,
        )
    )


def _known(index: Mapping[str, int], name: str, field: str) -> int:
    if name not in index:
        raise Refusal(Message("linkage_unknown_link", field=field, value=name, known=_listed(index)))
    return index[name]


def _finite(field: str, place: complex) -> None:
    if not (math.isfinite(place.real) and math.isfinite(place.imag)):
        raise Refusal(Message("not_finite", field=field, value=place))


def _listed(names: Mapping[str, object] | list[str] | tuple[str, ...]) -> str:
    return ", ".join(names) or "none"
