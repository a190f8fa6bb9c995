"""What the pictures show: every run, limit and piece, in words and shapes, in the reader's language and units."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.model.correction import Ellipse, Interval, PlaneMass, SensorVector
from service.model.machine import Plane
from service.model.plan import BlockedPosition, FrontPoint, Offer
from service.model.report import BeforeAfter
from service.model.run import MassOnRotor
from service.model.session import AsFoundPiece
from service.usecases.sessions.live import SensorNow
from service.web.pictures import bars, dials, end_view, front, masses, polar, trend
from service.web.pictures.angle_axis import compass_of
from service.web.pictures.drawing import Circle, Group, Line, Picture, Words, overlap
from service.web.pictures.reader import Reader
from service.web.pictures.scales import ticks
from service.web.pictures.svg import to_svg
from service.web.preferences import Preferences
from tests.web.pictures.samples import HOLES, WHEN, items, machine, run, words_of

GERMAN = Reader(Preferences(language="de", mass="oz", velocity="in/s"))
TRIAL = MassOnRotor(plane="L", mass_g=200.0, angle_deg=55.0)
RUNS = [
    run(1, "initial", {"P": (3.1, 40.0), "Q": (20.0, 90.0)}),
    run(2, "trial", {"P": (4.2, 80.0), "Q": (25.0, 95.0)}, TRIAL),
    run(3, "check", {"P": (0.3, 200.0), "Q": (2.0, 9.0)}, replace(TRIAL, mass_g=-50.0)),
]
EXPECTED = SensorVector(
    sensor="P", speed_rpm=460.0, amplitude=0.4, phase_deg=190.0, interval=Interval(low=0.2, high=0.6, confidence=0.95)
)


def circles(picture: Picture, cls: str) -> list[Circle]:
    return [item for item in items(picture) if isinstance(item, Circle) and item.cls == cls]


def lines(picture: Picture, cls: str) -> list[Line]:
    return [item for item in items(picture) if isinstance(item, Line) and item.cls == cls]


def test_a_polar_plot_has_every_run_the_limit_and_what_is_expected() -> None:
    picture = polar.polar_plot(machine(), "P", RUNS, Reader(), predicted=EXPECTED)
    said = " ".join(words_of(picture))
    for part in (
        "as found: 3.1 @ 40°",
        "trial: 4.2 @ 80° (L: 200\u202fg @ 55°)",
        "predicted: 0.4 @ 190°",
        "limit: 0.7",
    ):
        assert part in said, said
    scale = circles(picture, "pic-limit")[0].radius / 0.7
    assert circles(picture, "pic-region")[0].radius == pytest.approx(0.2 * scale)
    assert len(lines(picture, "pic-influence")) == 2
    assert "as found" in picture.description


def test_influence_arrows_go_from_the_run_with_the_fewest_other_masses() -> None:
    both = run(3, "trial", {"P": (2.0, 0.0)}, TRIAL, replace(TRIAL, plane="R"))
    picture = polar.polar_plot(machine(), "P", [*RUNS[:2], both], Reader())
    first, second, third = (
        line.points[1] for line in items(picture) if isinstance(line, Line) and "pic-vector" in line.cls
    )
    assert [line.points for line in lines(picture, "pic-influence")] == [(first, second), (second, third)]


def test_excluded_runs_other_speeds_and_run_out_are_minded() -> None:
    drum = machine()
    left_out = [replace(RUNS[1], excluded=True), replace(RUNS[2], nominal_speed_rpm=700.0)]
    assert "trial" not in " ".join(words_of(polar.polar_plot(drum, "P", [RUNS[0], *left_out], Reader())))
    there = polar.polar_plot(drum, "P", left_out, Reader(), speed_rpm=700.0)
    assert "700" in there.title
    assert any("check" in word for word in words_of(there))


def test_a_run_without_phase_is_a_circle() -> None:
    picture = polar.polar_plot(machine(), "P", [run(1, "initial", {"P": (2.0, None)})], Reader())
    assert len(circles(picture, "pic-amplitude pic-initial")) == 1
    assert "as found: 2" in words_of(picture)


def test_a_close_up_leaves_out_what_is_far_away() -> None:
    near = polar.polar_plot(machine(), "P", RUNS, Reader(), predicted=EXPECTED, close_up=True)
    assert not any("as found" in word for word in words_of(near))
    assert any("check" in word for word in words_of(near))


def test_units_and_language_of_the_reader_are_everywhere_and_the_picture_stays_the_same() -> None:
    plain, german = (polar.polar_plot(machine(), "P", RUNS, r, predicted=EXPECTED) for r in (Reader(), GERMAN))
    said = " ".join(words_of(german))
    assert "wie vorgefunden: 0,122 @ 40°" in said
    assert "7,055\u202foz" in said
    assert "in/s" in said
    for one, other in zip(lines(plain, "pic-vector pic-trial"), lines(german, "pic-vector pic-trial"), strict=True):
        across, up = (one.points[1][axis] - polar.CENTRE[axis] for axis in (0, 1))
        there = (other.points[1][0] - polar.CENTRE[0]) / across
        assert there > 0.0
        assert (other.points[1][1] - polar.CENTRE[1]) / up == pytest.approx(there)


def pieces() -> list[end_view.Piece]:
    return [
        end_view.Piece("L", 10.0, 20.0, "add"),
        end_view.Piece("L", 10.0, 50.0, "add"),
        end_view.Piece("L", 55.0, 10.0, "remove"),
        end_view.Piece("L", 55.0, 30.0, "add"),
        end_view.Piece("L", 90.0, 100.0, "keep"),
        end_view.Piece("R", 200.0, 300.0, "add"),
    ]


def test_the_end_view_says_what_goes_where_by_shape_and_words() -> None:
    fixed = end_view.pieces_of((), [AsFoundPiece(plane="L", position_deg=200.0, mass_g=5.0, may="stay")])
    shut = [BlockedPosition(plane="L", position_deg=333.0), BlockedPosition(plane="R", position_deg=10.0)]
    picture = end_view.end_view(machine(seen_from="gear side"), "L", Reader(), pieces=[*pieces(), *fixed], blocked=shut)
    said = words_of(picture)
    for word in (
        "+20\u202fg + 50\u202fg",
        "+30\u202fg",
        "2: \N{MINUS SIGN}10\u202fg",
        "100\u202fg",
        "5\u202fg",
        "seen from: gear side",
    ):
        assert word in said, said
    assert "300\u202fg" not in " ".join(said)
    assert {"bolt in", "take off", "stays", "as found, stays", "takes nothing"} <= set(said)
    # A plus, a ring with a cross, a dot, a square, a bar: told apart without colour, each once more in the legend.
    holes = [item for item in items(picture) if isinstance(item, Group) and item.cls == "pic-place"]
    shapes = [tuple(type(part).__name__ + getattr(part, "cls", "") for part in hole.items[1:-1]) for hole in holes]
    assert len(set(shapes)) == 4
    assert "bolt in: 20\u202fg at 1" in picture.description


def test_words_beside_the_drum_do_not_run_into_each_other() -> None:
    angles = tuple(float(angle) for angle in range(0, 360, 10))
    plane = Plane(name="L", radius_mm=100.0, positions_deg=angles, max_masses=20)
    crowd = [
        end_view.Piece("L", angle, 1234.5, "add")
        for angle in (0.0, 10.0, 20.0, 350.0, 90.0, 100.0, 180.0, 190.0, 200.0)
    ]
    picture = end_view.end_view(machine(planes=(plane,)), "L", Reader(), pieces=crowd)
    boxes = [item.box() for item in items(picture) if isinstance(item, Words) and item.cls == "pic-add-words"]
    assert len(boxes) == len(crowd)
    assert not any(overlap(a, b) for n, a in enumerate(boxes) for b in boxes[:n])
    heads = [
        item.box() for item in items(picture) if isinstance(item, Words) and item.cls in ("pic-title", "pic-small")
    ]
    legend = [item.box() for item in items(picture) if isinstance(item, Words) and item.cls == "pic-words"]
    assert not any(overlap(a, b) for a in boxes for b in [*heads, *legend])
    assert all(left >= 0.0 and right <= picture.width and bottom <= picture.height for left, _, right, bottom in boxes)


@given(st.lists(st.floats(0.0, 359.0), min_size=1, max_size=360, unique_by=lambda a: round(a, 3)))
def test_holes_do_not_touch_and_lie_on_the_drum(angles: list[float]) -> None:
    plane = Plane(name="L", radius_mm=100.0, positions_deg=tuple(angles), max_masses=1)
    picture = end_view.end_view(machine(planes=(plane,)), "L", Reader())
    drawn = circles(picture, "pic-hole")
    assert len(drawn) == len(angles)
    assert all(0.0 < hole.radius <= 17.0 for hole in drawn)


def test_labels_on_the_drum_are_used_and_escaped() -> None:
    plane = Plane(
        name="<b>&", radius_mm=1.0, positions_deg=HOLES, hole_labels=("A<", "B&", "C", "D", "E"), max_masses=1
    )
    picture = end_view.end_view(machine(planes=(plane,), seen_from='"x" <script>'), "<b>&", Reader())
    assert {"A<", "B&", "C", "D", "E", "Plane <b>&"} <= set(words_of(picture))
    assert "<script" not in to_svg(picture)


def needed() -> PlaneMass:
    region = Ellipse(major_g=30.0, minor_g=10.0, angle_deg=20.0, confidence=0.95)
    return PlaneMass(plane="L", mass_g=150.0, angle_deg=55.0, unbalance_gmm=1.0, ellipse=region)


@pytest.mark.parametrize("sense", ["against_rotation", "with_rotation"])
def test_the_region_of_a_correction_has_its_axes_where_they_are_stated(sense: Any) -> None:
    drum = machine(angle_sense=sense)
    picture = masses.mass_plot(drum, needed(), Reader())
    outline = lines(picture, "pic-region")[0].points
    tip = lines(picture, "pic-predicted")[0].points[1]
    reach = [((x - tip[0]) ** 2 + (y - tip[1]) ** 2) ** 0.5 for x, y in outline]
    assert max(reach) / min(reach) == pytest.approx(3.0, rel=0.01)
    # The longer axis points to 20 degrees as the machine counts them: from the tip as from the centre.
    far = outline[max(range(len(reach)), key=reach.__getitem__)]
    compass = compass_of(drum, tip)
    assert compass.stated(far, sense) % 180.0 == pytest.approx(20.0, abs=0.1)
    assert "needed: 150\u202fg @ 55°" in picture.description


def line(**changes: Any) -> BeforeAfter:
    usual = {"sensor": "P", "unit": "mm/s rms", "speed_rpm": 460.0, "before": 4.0, "after": 0.5, "reduction": 0.875}
    return BeforeAfter(**{**usual, "limit": 0.7, "within_limit": True, **changes})


def test_bars_are_as_long_as_their_values_and_red_above_the_limit() -> None:
    picture = bars.before_after(machine(), [line(), line(after=1.0, within_limit=False)], Reader())
    wide = [
        max(x for x, _y in bar.points) - bars.LEFT
        for cls in ("pic-before", "pic-after", "pic-over")
        for bar in lines(picture, cls)
    ]
    assert wide == pytest.approx([w * (bars.RIGHT - bars.LEFT) / 4.0 for w in (4.0, 4.0, 0.5, 1.0)])
    assert any(
        word.startswith("0.5 mm/s rms") and word.endswith("(\N{MINUS SIGN}87.5 %)") for word in words_of(picture)
    )
    assert "limit: 0.7 mm/s rms" in picture.description


def test_bars_of_sensors_in_other_units_each_have_their_own_scale() -> None:
    picture = bars.before_after(machine(), [line(), line(sensor="Q", before=4000.0, after=None, limit=None)], Reader())
    assert [max(x for x, _y in bar.points) for bar in lines(picture, "pic-before")] == [bars.RIGHT, bars.RIGHT]
    assert to_svg(bars.before_after(machine(), [], Reader())).count("no run as found yet") == 2


def offer(value: float | None, status: Any = "optimal") -> Offer:
    blank: dict[str, Any] = {"message": "", "reason": None, "placements": (), "taken_off": (), "lower_bound": None}
    return Offer(status=status, objective_value=value, gap=None, **blank)


def test_the_front_has_a_point_for_each_number_of_pieces_and_rings_the_plan() -> None:
    values = (42.0, 5.0, 0.85)
    points = [FrontPoint(pieces=n, offer=offer(v, "optimal" if n else "heuristic")) for n, v in enumerate(values)]
    picture = front.front_chart([*points, FrontPoint(pieces=9, offer=offer(None))], "1", Reader(), chosen=2, limit=1.0)
    heights = [y for _x, y in lines(picture, "pic-curve")[0].points]
    assert heights == sorted(heights)
    assert len(circles(picture, "pic-dot")) == 2
    assert len(circles(picture, "pic-dot-before")) == 1
    assert circles(picture, "pic-chosen")[0].centre == circles(picture, "pic-dot")[-1].centre
    assert "there is no selection" in front.front_chart([], "1", Reader()).description


def test_the_trend_is_in_order_of_time_and_says_every_value() -> None:
    points = [trend.TrendPoint(WHEN + timedelta(days=30 * n), 3.0 - n, None if n == 1 else 0.5) for n in (2, 0, 1)]
    picture = trend.trend_chart(points, "P", "mm/s rms", GERMAN, limit=0.7)
    along = [x for x, _y in lines(picture, "pic-curve-before")[0].points]
    assert along == sorted(along)
    assert picture.description.startswith("2026-03-14: 3 → 0,5; ")
    assert trend.trend_chart(points[:1], "P", "mm/s", Reader()).height > 0
    assert trend.trend_chart([], "P", "mm/s", Reader()).items == ()


def needle(picture: Picture) -> Group:
    return next(item for item in items(picture) if isinstance(item, Group) and item.cls.startswith("pic-needle"))


def test_needles_stand_at_their_values_and_say_how_a_script_may_turn_them() -> None:
    drum = machine(rotation="cw", phase_sense="lag")
    hand = needle(dials.amplitude_dial(drum.sensors[0], 0.35, Reader(), limit=0.7))
    data = dict(hand.data)
    assert hand.turn_deg == pytest.approx(-120.0 + 240.0 * 0.35 / float(data["top"]))
    assert needle(dials.phase_dial(drum, drum.sensors[0], 90.0, Reader())).turn_deg == -90.0
    for picture in (
        dials.amplitude_dial(drum.sensors[0], None, Reader()),
        dials.phase_dial(drum, drum.sensors[0], None, Reader()),
    ):
        assert "pic-absent" in needle(picture).cls
        assert "\N{EM DASH}" in [item.text for item in items(picture) if isinstance(item, Words)]
        assert picture.description == "no value yet"


def test_steadiness_is_told_by_shape_too() -> None:
    now = SensorNow(
        sensor="P",
        readings=9,
        amplitude=1.0,
        phase_deg=None,
        speed_rpm=None,
        amplitude_spread=0.0,
        phase_spread_deg=None,
        drift=0.0,
        steady=True,
        why_not=None,
    )
    said = [dials.steady_light(state, Reader()).title for state in (None, now, replace(now, steady=False))]
    assert said == ["no reading", "steady", "not steady yet"]


@given(st.floats(1e-9, 1e9), st.integers(2, 8))
def test_ticks_are_round_few_and_reach_the_value(highest: float, most: int) -> None:
    values = ticks(highest, most)
    assert 1 <= len(values) <= most
    assert highest * (1.0 - 1e-6) <= values[-1] <= highest * 2.51
    assert values[0] == pytest.approx(values[-1] / len(values))


def test_a_picture_is_small() -> None:
    for picture in (
        polar.polar_plot(machine(), "P", RUNS, Reader()),
        end_view.end_view(machine(), "L", Reader(), pieces=pieces()),
    ):
        assert len(to_svg(picture)) < 12_000
