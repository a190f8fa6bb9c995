"""Angles lie on paper where the machine's conventions say, for every combination of senses."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.web.pictures import end_view, polar
from service.web.pictures.angle_axis import Compass, compass_of, flipped
from service.web.pictures.drawing import Circle, Group, Line, Picture
from service.web.pictures.reader import Reader
from tests.web.pictures.samples import HOLES, items, machine, run

ROTATIONS: tuple[Any, ...] = ("ccw", "cw")
ANGLES: tuple[Any, ...] = ("against_rotation", "with_rotation")
PHASES: tuple[Any, ...] = ("lag", "lead")
degrees = st.floats(-360.0, 360.0, allow_nan=False)


def clockwise_on_paper(rotation: str, sense: str) -> bool:
    """By hand: seen where the drum turns counter-clockwise, what counts against it counts clockwise."""
    return {("ccw", "against"): True, ("ccw", "with"): False, ("cw", "against"): False, ("cw", "with"): True}[
        rotation, "against" if sense in ("against_rotation", "lag") else "with"
    ]


def paper_angle(centre: tuple[float, float], point: tuple[float, float]) -> float:
    """Degrees clockwise from straight up."""
    return math.degrees(math.atan2(point[0] - centre[0], centre[1] - point[1])) % 360.0


def apart(a: float, b: float) -> float:
    return abs((a - b + 180.0) % 360.0 - 180.0)


def hole_centres(picture: Picture) -> dict[str, tuple[float, float]]:
    places = [item for item in items(picture) if isinstance(item, Group) and item.cls == "pic-place"]
    return {p.title or "": next(i.centre for i in p.items if isinstance(i, Circle)) for p in places}


@pytest.mark.parametrize(("rotation", "sense"), [*itertools.product(ROTATIONS, ANGLES)])
@pytest.mark.parametrize("other_end", [False, True])
def test_a_hole_lies_where_the_convention_says(rotation: Any, sense: Any, other_end: bool) -> None:
    drum = machine(rotation=rotation, angle_sense=sense)
    view = end_view.end_view(drum, "R", Reader(), from_other_end=other_end)
    way = 1.0 if clockwise_on_paper(rotation, sense) != other_end else -1.0
    centres = hole_centres(view)
    assert len(centres) == len(HOLES)
    for number, angle in enumerate(HOLES, start=1):
        assert apart(paper_angle(end_view.CENTRE, centres[str(number)]), way * angle) < 1e-6
        assert math.dist(end_view.CENTRE, centres[str(number)]) == pytest.approx(end_view.HOLES)


@pytest.mark.parametrize("rotation", ROTATIONS)
def test_the_arrow_turns_as_the_drum_does(rotation: Any) -> None:
    view = end_view.end_view(machine(rotation=rotation), "L", Reader())
    arc = next(i for i in items(view) if isinstance(i, Line) and i.cls == "pic-turning").points
    turned = paper_angle(end_view.CENTRE, arc[-1]) - paper_angle(end_view.CENTRE, arc[0])
    assert (turned > 0.0) == (rotation == "cw")
    seen = end_view.end_view(machine(rotation=rotation), "L", Reader(), from_other_end=True)
    back = next(i for i in items(seen) if isinstance(i, Line) and i.cls == "pic-turning").points
    assert (paper_angle(end_view.CENTRE, back[-1]) - paper_angle(end_view.CENTRE, back[0]) > 0.0) != (rotation == "cw")


def test_the_other_end_is_the_mirror_image() -> None:
    drum = machine(rotation="cw")
    here, there = (hole_centres(end_view.end_view(drum, "L", Reader(), from_other_end=end)) for end in (False, True))
    for label, (x, y) in here.items():
        assert there[label] == pytest.approx((2.0 * end_view.CENTRE[0] - x, y))


def tips(drum: Any, phase: float) -> list[tuple[float, float]]:
    picture = polar.polar_plot(drum, "P", [run(1, "initial", {"P": (2.0, phase)})], Reader())
    return [i.points[1] for i in items(picture) if isinstance(i, Line) and i.cls.startswith("pic-vector")]


@given(phase=degrees)
@pytest.mark.parametrize("rotation", ROTATIONS)
def test_a_vector_lies_in_one_place_whether_stated_as_lag_or_lead(rotation: Any, phase: float) -> None:
    (lag,), (lead,) = (
        tips(machine(rotation=rotation, phase_sense=sense), value)
        for sense, value in (("lag", phase), ("lead", -phase))
    )
    assert lag == pytest.approx(lead)
    way = 1.0 if clockwise_on_paper(rotation, "lag") else -1.0
    assert apart(paper_angle(polar.CENTRE, lag), way * phase) < 1e-6


@given(phase=degrees)
def test_a_flipped_sense_is_the_mirror_image_of_the_same_numbers(phase: float) -> None:
    drum = machine()
    (here,), (there,) = tips(drum, phase), tips(flipped(drum, "phase_sense"), phase)
    assert there == pytest.approx((2.0 * polar.CENTRE[0] - here[0], here[1]))
    assert flipped(flipped(drum, "angle_sense"), "angle_sense") == drum


@given(angle=degrees, radius=st.floats(0.1, 500.0), sense=st.sampled_from([*ANGLES, *PHASES]), clockwise=st.booleans())
def test_a_place_on_paper_is_read_back_as_its_angle(angle: float, radius: float, sense: Any, clockwise: bool) -> None:
    compass = Compass(clockwise, (280.0, 260.0))
    assert apart(compass.stated(compass.at(radius, angle, sense), sense), angle) < 1e-6


def test_masses_and_phases_turn_the_same_way() -> None:
    """A mass moved on by some degrees moves its effect by as many, on paper too, in every combination of senses."""
    for rotation, angle_sense, phase_sense in itertools.product(ROTATIONS, ANGLES, PHASES):
        drum = machine(rotation=rotation, angle_sense=angle_sense, phase_sense=phase_sense)
        compass = compass_of(drum, (0.0, 0.0))
        agree = (angle_sense == "against_rotation") == (phase_sense == "lag")
        mass = paper_angle((0.0, 0.0), compass.at(1.0, 30.0, angle_sense))
        effect = paper_angle((0.0, 0.0), compass.at(1.0, 30.0 if agree else -30.0, phase_sense))
        assert apart(mass, effect) < 1e-9


def test_a_mass_beside_the_holes_is_drawn_at_its_angle() -> None:
    trial = end_view.Piece("L", 123.0, 200.0, "add")
    view = end_view.end_view(machine(rotation="cw"), "L", Reader(), pieces=[trial])
    drawn = [i for i in items(view) if isinstance(i, Circle) and i.cls == "pic-add" and i.radius < 20]
    assert apart(paper_angle(end_view.CENTRE, drawn[0].centre), -123.0) < 1e-6
    assert len(hole_centres(view)) == len(HOLES) + 1
