"""A drum with its parts: from the end, and unrolled from the side, every part in its place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from service.balancing.rotor.phasors import normal_degrees
from service.model.machine import AngleSense, Machine
from service.web.pictures.angle_axis import Compass, compass_of
from service.web.pictures.drawing import Anchor, Box, Circle, Group, Item, Line, Picture, Words, group, overlap
from service.web.pictures.end_view import sign
from service.web.pictures.polar_axes import key_mark
from service.web.pictures.reader import Reader
from service.web.pictures.words import short

State = Literal["comes", "stays", "empty"]
STATES: tuple[State, ...] = ("comes", "stays", "empty")
WIDTH = 600.0
CENTRE = (WIDTH / 2, 268.0)
RIM, OUTER, WORDS = 186.0, 164.0, 208.0
"""Radii on paper of the drum, of the outermost places, and of the words outside."""
APART = 25.0
"""Between two places at one angle, one behind the other along the shaft."""
MAX_NAMED = 24
"""Places up to which every one has its words in the end view."""
LEFT, RIGHT, TOP = 96.0, WIDTH - 60.0, 84.0
ROW, MARGIN = 25.0, 24.0
"""Height of a row of the unrolled drum, and room above the first one for its words."""
LEAST_HEIGHT, GREATEST_HEIGHT = 300.0, 1100.0


@dataclass(frozen=True)
class PlacedPart:
    """A place with the part that is, or is to be, in it; angle in the machine's sense, axial positions in mm."""

    label: str
    degrees: float
    axial_mm: tuple[float, ...]
    part: str | None
    state: State


def from_the_end(
    machine: Machine | None, sense: AngleSense, places: Sequence[PlacedPart], reader: Reader, *, done: bool = False
) -> Picture:
    """Draw the places as seen from the end, the mark up; those behind each other from the rim inwards.

    done: the parts are mounted already, so that nothing is said of what is to be done. Without a machine the way it
    turns is not known, and angles count clockwise on paper.
    """
    compass = Compass(True, CENTRE) if machine is None else compass_of(machine, CENTRE)
    title = reader.gettext("The drum from the end")
    items: list[Item] = [
        Words((WIDTH / 2, 22.0), title, "pic-title", size=19.0),
        Words((WIDTH / 2, 42.0), short(_side(machine, reader), 64), "pic-small", size=14.0),
        Circle(CENTRE, RIM, "pic-drum"),
        Circle(CENTRE, 30.0, "pic-hub"),
        key_mark((CENTRE[0], CENTRE[1] - 16.0), size=14.0),
        Words((CENTRE[0] + 9.0, CENTRE[1] - 36.0), reader.gettext("mark, 0°"), "pic-strong", "start", 13.0),
    ]
    if machine is not None:
        turn = math.radians(130.0)
        items += compass.arrow(48.0, math.pi + 0.5 * turn, math.pi - 0.5 * turn, "pic-turning", 14.0)
        items.append(Words((CENTRE[0], CENTRE[1] + 72.0), reader.gettext("rotation"), "pic-turning-words", size=13.0))
    taken: list[Box] = []
    for depth, place in _behind_each_other(places):
        items.append(_from_end(compass, sense, place, depth, named=len(places) <= MAX_NAMED, taken=taken))
    legend = _legend(places, reader, CENTRE[1] + RIM + 62.0, done=done)
    height = CENTRE[1] + RIM + 62.0 + (26.0 if legend else 0.0)
    return Picture(WIDTH, height, title, described(places, reader), (*items, *legend))


def unrolled(
    planes: Sequence[tuple[str, float]], places: Sequence[PlacedPart], reader: Reader, *, done: bool = False
) -> Picture:
    """Draw the drum cut open along the mark and laid flat: across along the shaft, downwards the angle.

    planes: name and axial position in mm of the correction planes.
    """
    _ = reader.gettext
    title = _("The drum unrolled from the side")
    along = [at for place in places for at in place.axial_mm] + [at for _name, at in planes]
    low, high = min(along), max(along)
    span = (high - low) or 1.0
    rows = len({round(normal_degrees(place.degrees), 1) for place in places})
    height = min(max(ROW * rows, LEAST_HEIGHT), GREATEST_HEIGHT)

    def x_of(axial: float) -> float:
        return LEFT + 34.0 + (RIGHT - LEFT - 68.0) * ((axial - low) / span if high > low else 0.5)

    def y_of(degrees: float) -> float:
        return TOP + MARGIN + (height - 2.0 * MARGIN) * normal_degrees(degrees) / 360.0

    items: list[Item] = [
        Words((WIDTH / 2, 22.0), title, "pic-title", size=19.0),
        Words(
            (WIDTH / 2, 42.0),
            _("across: along the shaft; down: angle from the mark; place: part"),
            "pic-small",
            size=14.0,
        ),
        Line(((LEFT, TOP), (RIGHT, TOP), (RIGHT, TOP + height), (LEFT, TOP + height)), "pic-drum", True),
    ]
    for degrees in range(0, 361, 45):
        y = TOP + MARGIN + (height - 2.0 * MARGIN) * degrees / 360.0
        items.append(Line(((LEFT, y), (RIGHT, y)), "pic-grid"))
        items.append(Words((LEFT - 10.0, y + 5.0), f"{degrees}°", "pic-small", "end", 13.0))
    for name, at in planes:
        items.append(Line(((x_of(at), TOP), (x_of(at), TOP + height)), "pic-limit"))
        words = short(_("Plane %(plane)s") % {"plane": name}, 14)
        items.append(Words((x_of(at), TOP - 9.0), words, "pic-limit-words", size=13.0))
    taken: list[Box] = []
    for place in sorted(places, key=lambda one: STATES.index(one.state)):
        ends = [(x_of(at), y_of(place.degrees)) for at in place.axial_mm]
        items.append(_from_side(place, ends, taken))
    legend = _legend(places, reader, TOP + height + 26.0, done=done)
    return Picture(WIDTH, TOP + height + 44.0, title, described(places, reader), (*items, *legend))


def described(places: Sequence[PlacedPart], reader: Reader) -> str:
    """Which part is in which place, as text."""
    _ = reader.gettext
    return "; ".join(
        _("place %(place)s: %(part)s") % {"place": one.label, "part": one.part or _("empty")} for one in places
    )


def _side(machine: Machine | None, reader: Reader) -> str:
    if machine is None or machine.seen_from is None:
        return reader.gettext("seen from the end where the rotation is meant")
    return reader.gettext("seen from: %(side)s") % {"side": machine.seen_from}


def _behind_each_other(places: Sequence[PlacedPart]) -> list[tuple[int, PlacedPart]]:
    """Each place with the number of those at its angle that stand before it."""
    seen: dict[float, int] = {}
    out = []
    for place in places:
        angle = round(normal_degrees(place.degrees), 1)
        out.append((seen.get(angle, 0), place))
        seen[angle] = seen.get(angle, 0) + 1
    return out


def _marker(place: PlacedPart, where: tuple[float, float], size: float) -> list[Item]:
    if place.state == "empty":
        return [Circle(where, size, "pic-hole")]
    return sign("add" if place.state == "comes" else "keep", where, size)


def _words_class(place: PlacedPart) -> str:
    return {"comes": "pic-add-words", "stays": "pic-keep-words", "empty": "pic-small"}[place.state]


def _from_end(
    compass: Compass, sense: AngleSense, place: PlacedPart, depth: int, *, named: bool, taken: list[Box]
) -> Group:
    radius = max(OUTER - APART * depth, 60.0)
    items = _marker(place, compass.at(radius, place.degrees, sense), 11.0 if named else 7.0)
    if named and depth == 0:
        inner = compass.at(radius - 24.0, place.degrees, sense)
        items.append(Words((inner[0], inner[1] + 5.0), place.label[:5], "pic-hole-words", size=13.0))
        x, y = compass.at(WORDS, place.degrees, sense)
        aside = x - compass.centre[0]
        anchor: Anchor = "middle" if abs(aside) < 50.0 else "start" if aside > 0.0 else "end"
        words = Words((x, y + 6.0), short(place.part or "–", 8), _words_class(place), anchor, 17.0)
        if not any(overlap(words.box(), box) for box in taken):
            taken.append(words.box())
            items.append(words)
    return group(items, "pic-place", title=f"{place.label}: {place.part or '–'}")


def _from_side(place: PlacedPart, ends: list[tuple[float, float]], taken: list[Box]) -> Group:
    items: list[Item] = []
    if len(ends) == 2:
        (x1, y), (x2, _) = ends
        items += [Line(((x1, y), (x2, y)), "pic-axis"), *_marker(place, (x1, y), 6.0), *_marker(place, (x2, y), 6.0)]
        at, text = (0.5 * (x1 + x2), y - 4.0), f"{place.label}: {short(place.part or '–', 12)}"
        words = Words(at, text, _words_class(place), "middle", 14.0)
    else:
        (x, y), small = ends[0], 6.0
        items += _marker(place, (x, y), small)
        words = Words((x + 9.0, y + 4.5), short(place.part or "–", 6), _words_class(place), "start", 12.0)
    if not any(overlap(words.box(), box) for box in taken):
        taken.append(words.box())
        items.append(words)
    return group(items, "pic-place", title=f"{place.label}: {place.part or '–'}")


def _legend(places: Sequence[PlacedPart], reader: Reader, top: float, *, done: bool) -> list[Item]:
    _ = reader.gettext
    words: dict[State, str] = {
        "comes": _("was moved here") if done else _("comes here"),
        "stays": _("stays"),
        "empty": _("empty"),
    }
    found = [state for state in STATES if any(place.state == state for place in places)]
    out: list[Item] = []
    for index, state in enumerate(found):
        x = WIDTH / 2 + 180.0 * (index - 0.5 * (len(found) - 1)) - 50.0
        out.append(group(_marker(PlacedPart("", 0.0, (0.0,), "", state), (x, top), 9.0)))
        out.append(Words((x + 18.0, top + 5.5), words[state], "pic-words", "start", 15.0))
    return out
