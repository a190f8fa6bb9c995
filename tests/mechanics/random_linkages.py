"""Linkages of one to three dyads that close over the whole turn, in local frames that lie anywhere."""

from __future__ import annotations

import cmath
import math

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from service.mechanics.bodies import Body
from service.mechanics.chain import Dyad, Link, Linkage
from tests.mechanics.spectral import places

SAMPLES = 128
unit = st.floats(0.0, 1.0)


@st.composite
def linkages(draw: st.DrawFn) -> Linkage:
    """A linkage whose dyads stay well clear of their dead points."""
    ground = {"A": complex(draw(unit), draw(unit))}
    links = [_link(draw, "crank", {"A": 0j, "P": complex(0.1 + 0.1 * draw(unit))}, turned=0.0)]
    dyads: list[Dyad] = []
    for number in range(draw(st.integers(1, 3))):
        ground[f"G{number}"] = ground["A"] + cmath.rect(0.4 + draw(unit), 2.0 * math.pi * draw(unit))
        so_far = Linkage(dict(ground), "crank", tuple(links), tuple(dyads))
        moving = [point for link in links for point in link.points if point not in ground]
        first = draw(st.sampled_from(moving))
        second = draw(st.sampled_from([f"G{number}", *(point for point in moving if point != first)]))
        apart = _apart(so_far, first, second)
        assume(apart.min() > 0.15)
        total = apart.max() * (1.25 + draw(unit))
        difference = apart.min() * 0.7 * (2.0 * draw(unit) - 1.0)
        joint, names = f"J{number}", (f"a{number}", f"b{number}")
        for name, support, length in zip(
            names, (first, second), ((total + difference) / 2.0, (total - difference) / 2.0), strict=True
        ):
            further = complex(draw(unit), draw(unit)) - 0.5 - 0.5j
            assume(min(abs(further), abs(further - length)) > 1e-3)
            points = {support: 0j, joint: complex(length), f"X{name}": further}
            links.append(_link(draw, name, points, turned=2.0 * math.pi * draw(unit)))
        dyads.append(
            Dyad(joint, names, draw(st.sampled_from(["left", "right"])), draw(st.sampled_from([None, *names])))
        )
    gravity = draw(st.sampled_from([0.0, 9.81]))
    return Linkage(ground, "crank", tuple(links), tuple(dyads), draw(st.sampled_from([None, *ground])), gravity)


def _link(draw: st.DrawFn, name: str, points: dict[str, complex], turned: float) -> Link:
    shift = complex(draw(unit), draw(unit)) - 0.5
    body = Body.about_centre(0.05 + draw(unit), complex(draw(unit), draw(unit)) - 0.5, 0.001 + 0.1 * draw(unit))
    return Link(name, {point: place * cmath.exp(1j * turned) + shift for point, place in points.items()}, body)


def _apart(linkage: Linkage, first: str, second: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    angles = 2.0 * math.pi * np.arange(SAMPLES) / SAMPLES
    where = {name: np.full(SAMPLES, place) for name, place in linkage.ground.items()}
    for name, (origin, axis) in places(linkage, angles).items():
        link = next(one for one in linkage.links if one.name == name)
        for point, local in link.points.items():
            where.setdefault(point, origin + axis * local)
    return np.asarray(np.abs(where[first] - where[second]))
