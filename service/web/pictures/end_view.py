"""End view of the drum: numbered holes, the key-phasor mark, the way it turns, which mass goes where and comes off."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from service.balancing.rotor.phasors import normal_degrees
from service.engine.validation import hole_label, same_angle
from service.model.machine import Machine, Plane
from service.model.plan import BlockedPosition, Change
from service.model.session import AsFoundPiece
from service.web.numbers import MINUS
from service.web.pictures.angle_axis import Compass, compass_of
from service.web.pictures.drawing import Anchor, Box, Circle, Group, Item, Line, Picture, Point, Words, group, overlap
from service.web.pictures.polar_axes import key_mark
from service.web.pictures.reader import Reader
from service.web.pictures.words import short

Part = Literal["add", "remove", "keep", "fixed", "blocked"]
PARTS: tuple[Part, ...] = ("add", "remove", "keep", "fixed", "blocked")
"""What can be at a hole; where there are several, the first of these gives the hole its sign."""

WIDTH = 600.0
CENTRE: Point = (WIDTH / 2, 276.0)
HOLES, RIM, WORDS = 150.0, 182.0, 204.0
"""Radii on paper of the holes, of the drum, and of the words beside it."""
MAX_NUMBERS = 40
"""Above this many holes only those that matter, and every fifth, have their number."""
_QUARTER = 92.0
"""Radius on paper of the word that tells which way angles count."""
_HEAD = 52.0
"""Room for title and side, in which no other word stands."""
MAX_MOVES = 20


@dataclass(frozen=True)
class Piece:
    """A mass in a plane: added, removed, kept, or fixed (as found, and to stay); angle in the machine's sense."""

    plane: str
    position_deg: float
    mass_g: float
    part: Part


def pieces_of(changes: Iterable[Change], as_found: Iterable[AsFoundPiece] = ()) -> tuple[Piece, ...]:
    """The pieces of a plan's changes, and the as-found pieces that must stay."""
    moved = tuple(Piece(c.placement.plane, c.placement.position_deg, c.placement.mass_g, c.action) for c in changes)
    stay = tuple(Piece(p.plane, p.position_deg, p.mass_g, "fixed") for p in as_found if p.may == "stay")
    return moved + stay


def end_view(
    machine: Machine,
    plane_name: str,
    reader: Reader,
    *,
    pieces: Sequence[Piece] = (),
    blocked: Sequence[BlockedPosition] = (),
    from_other_end: bool = False,
    done: bool = False,
) -> Picture:
    """Draw a correction plane as seen from `seen_from`, mark up: the far plane too, as if the drum were of glass.

    from_other_end: as seen by somebody who stands at the other end; it turns the other way there. A piece that is in
    no hole (a trial mass at any angle) is drawn at its angle. done: say what was done instead of what to do.
    Angles as in `compass`.
    """
    plane = next(p for p in machine.planes if p.name == plane_name)
    holes = _holes(plane, pieces, blocked)
    compass = compass_of(machine, CENTRE, mirrored=from_other_end)
    words = _piece_words(machine, compass, holes, reader)
    lowered = max([0.0, *(_HEAD - item.box()[1] for item in words)])
    if lowered:
        compass = replace(compass, centre=(CENTRE[0], CENTRE[1] + lowered))
        words = _piece_words(machine, compass, holes, reader)
    size = _hole_size(holes)
    title = reader.gettext("Plane %(plane)s") % {"plane": plane.name}
    side = _side(machine, reader, from_other_end)
    items: list[Item] = [
        Words((WIDTH / 2, 22.0), short(title, 44), "pic-title", size=19.0),
        Words((WIDTH / 2, 42.0), short(side, 64), "pic-small", size=14.0),
        Circle(compass.centre, RIM, "pic-drum"),
        *_hub(compass, reader),
        Words(compass.at(_QUARTER, 90.0, machine.angle_sense), "90°", "pic-small", size=14.0),
        *(_drawn_hole(machine, compass, hole, size, (plane, len(holes))) for hole in holes),
        *words,
    ]
    legend = _legend(holes, reader, done)
    bottom = max([compass.centre[1] + RIM + 24.0, *(item.box()[3] for item in words)])
    items += [item for index, cell in enumerate(legend) for item in _legend_cell(bottom + 22.0, index, *cell)]
    height = bottom + 14.0 + 28.0 * math.ceil(len(legend) / 2)
    return Picture(WIDTH, height, f"{title}: {side}", _described(holes, dict(legend), reader), tuple(items))


@dataclass(frozen=True)
class Hole:
    """A place in the plane with what is there; `label` None: no hole, a mass at any angle."""

    degrees: float
    label: str | None
    pieces: tuple[Piece, ...]
    blocked: bool

    @property
    def part(self) -> Part | None:
        """What gives the hole its sign; None for an empty one."""
        found = {piece.part for piece in self.pieces} | ({"blocked"} if self.blocked else set())
        return next((part for part in PARTS if part in found), None)


def _holes(plane: Plane, pieces: Sequence[Piece], blocked: Sequence[BlockedPosition]) -> tuple[Hole, ...]:
    here = [p for p in pieces if p.plane == plane.name]
    shut = [b.position_deg for b in blocked if b.plane == plane.name]
    out = [
        Hole(
            degrees=degrees,
            label=hole_label(plane, index),
            pieces=tuple(p for p in here if same_angle(p.position_deg, degrees)),
            blocked=any(same_angle(angle, degrees) for angle in shut),
        )
        for index, degrees in enumerate(plane.positions_deg)
    ]
    elsewhere = [p for p in here if not any(same_angle(p.position_deg, hole.degrees) for hole in out)]
    return (*out, *(Hole(p.position_deg, None, (p,), blocked=False) for p in elsewhere))


def _hole_size(holes: Sequence[Hole]) -> float:
    """Radius of a hole: a third of the way to the next one, never so small that it is no hole."""
    angles = sorted(normal_degrees(hole.degrees) for hole in holes if hole.label is not None)
    gaps = [b - a for a, b in zip(angles, [*angles[1:], angles[0] + 360.0], strict=True)]
    return min(17.0, max(2.5, 0.4 * HOLES * math.radians(min(gaps))))


def _side(machine: Machine, reader: Reader, from_other_end: bool) -> str:
    _ = reader.gettext
    if machine.seen_from is None:
        return _("seen from the opposite end") if from_other_end else _("seen from the end where the rotation is meant")
    text = _("seen from the end opposite to: %(side)s") if from_other_end else _("seen from: %(side)s")
    return text % {"side": machine.seen_from}


def _hub(compass: Compass, reader: Reader) -> list[Item]:
    """The shaft with its key-phasor mark, and how the drum turns."""
    x, y = compass.centre
    out: list[Item] = [Circle(compass.centre, 34.0, "pic-hub")]
    out += [Line(((x, y - 34.0), (x, y - HOLES + 22.0)), "pic-grid"), key_mark((x, y - 20.0), size=16.0)]
    out.append(Words((x + 8.0, y - 44.0), _zero(reader), "pic-strong", "start", 14.0))
    # The drum turns towards negative internal angles; the arrow runs below the shaft, where no number stands.
    turn = math.radians(130.0)
    out += compass.arrow(64.0, math.pi + 0.5 * turn, math.pi - 0.5 * turn, "pic-turning", 18.0)
    out.append(Words((x, y + 90.0), reader.gettext("rotation"), "pic-turning-words", size=14.0))
    return out


def _zero(reader: Reader) -> str:
    return reader.gettext("mark, 0°")


def _drawn_hole(machine: Machine, compass: Compass, hole: Hole, size: float, among: tuple[Plane, int]) -> Group:
    """A hole with what is there; a script finds it by its plane and angle, where it is touched."""
    plane, count = among
    where = compass.at(HOLES, hole.degrees, machine.angle_sense)
    sign_size = max(size, 10.0)
    items: list[Item] = []
    if hole.label is not None:
        items.append(Circle(where, size, "pic-hole"))
    if hole.part is not None:
        items += sign(hole.part, where, sign_size)
    if hole.label is not None and _numbered(hole, count):
        x, y = compass.at(HOLES - max(size, 10.0) - 13.0, hole.degrees, machine.angle_sense)
        cls = "pic-strong" if hole.pieces else "pic-hole-words"
        items.append(Words((x, y + 5.0), hole.label[:5], cls, size=14.0 if count <= 24 else 11.0))
    data = (("plane", plane.name), ("at", f"{hole.degrees:.10g}")) if hole.label is not None else ()
    return Group(tuple(items), "pic-place", data=data, title=hole.label)


def _numbered(hole: Hole, count: int) -> bool:
    if count <= MAX_NUMBERS or hole.pieces:
        return True
    return hole.label is not None and hole.label.isdecimal() and int(hole.label) % 5 == 0


def sign(part: Part, where: Point, size: float) -> list[Item]:
    """The sign of what is done: its shape tells as much as its colour."""
    x, y = where
    arm = 0.58 * size
    match part:
        case "add":
            cross = (
                Line(((x - arm, y), (x + arm, y)), "pic-add-sign"),
                Line(((x, y - arm), (x, y + arm)), "pic-add-sign"),
            )
            return [Circle(where, size, "pic-add"), *cross]
        case "remove":
            ring = Circle(where, size, "pic-remove")
            return [ring, *_crossed(where, arm, "pic-remove-sign")]
        case "keep":
            return [Circle(where, size, "pic-keep"), Circle(where, 0.38 * size, "pic-keep-sign")]
        case "fixed":
            corner = 0.86 * size
            square = (
                (x - corner, y - corner),
                (x + corner, y - corner),
                (x + corner, y + corner),
                (x - corner, y + corner),
            )
            return [Line(square, "pic-fixed", True), Circle(where, 0.38 * size, "pic-keep-sign")]
        case "blocked":
            bar = Line(((x - 0.7 * size, y + 0.7 * size), (x + 0.7 * size, y - 0.7 * size)), "pic-blocked-sign")
            return [Circle(where, size, "pic-blocked"), bar]


def _crossed(where: Point, arm: float, cls: str) -> tuple[Line, Line]:
    x, y = where
    return (
        Line(((x - arm, y - arm), (x + arm, y + arm)), cls),
        Line(((x - arm, y + arm), (x + arm, y - arm)), cls),
    )


def _piece_words(machine: Machine, compass: Compass, holes: Sequence[Hole], reader: Reader) -> list[Words]:
    """The masses as text outside the drum; moved outwards, and with the hole's name, where two would meet."""
    out: list[Words] = []
    for hole in holes:
        for part, text in _mass_lines(hole, reader):
            out.append(_placed(machine, compass, hole, (part, text), [words.box() for words in out]))
    return out


def _placed(machine: Machine, compass: Compass, hole: Hole, words: tuple[Part, str], taken: Sequence[Box]) -> Words:
    part, text = words
    size = 17.0 if len(text) <= 11 else 14.0
    for step in range(MAX_MOVES):
        shown = text if step == 0 or hole.label is None else f"{hole.label}: {text}"
        x, y = compass.at(WORDS + 9.0 * step, hole.degrees, machine.angle_sense)
        aside = x - compass.centre[0]
        anchor: Anchor = "middle" if abs(aside) < 60.0 else "start" if aside > 0.0 else "end"
        # Beside the drum the words begin where it ends; above and below it they stand over the hole.
        x -= 14.0 * (0 if anchor == "middle" else 1 if anchor == "start" else -1)
        placed = Words((x, y + 5.0), shown, f"pic-{part}-words", anchor, size)
        left, _top, right, _bottom = placed.box()
        placed = replace(placed, at=(x + max(0.0, 4.0 - left) - max(0.0, right - WIDTH + 4.0), y + 5.0))
        if not any(overlap(placed.box(), box) for box in taken):
            break
    return placed


def _mass_lines(hole: Hole, reader: Reader) -> list[tuple[Part, str]]:
    """One line for each thing that happens at a hole: +200 g, −20 g, 50 g."""
    signs: dict[Part, str] = {"add": "+", "remove": MINUS}
    out: list[tuple[Part, str]] = []
    for part in PARTS:
        masses = [piece.mass_g for piece in hole.pieces if piece.part == part]
        if masses:
            listed = f" {signs.get(part, '+')} ".join(reader.mass(abs(mass)) for mass in masses)
            out.append((part, signs.get(part, "") + listed))
    return out


def _legend(holes: Sequence[Hole], reader: Reader, done: bool) -> list[tuple[Part, str]]:
    _ = reader.gettext
    words: dict[Part, str] = {
        "add": _("bolted in") if done else _("bolt in"),
        "remove": _("taken off") if done else _("take off"),
        "keep": _("stays"),
        "fixed": _("as found, stays"),
        "blocked": _("takes nothing"),
    }
    found = {piece.part for hole in holes for piece in hole.pieces} | {"blocked" for hole in holes if hole.blocked}
    return [(part, words[part]) for part in PARTS if part in found]


def _legend_cell(top: float, index: int, part: Part, words: str) -> list[Item]:
    x, y = 120.0 + 240.0 * (index % 2), top + 28.0 * (index // 2)
    return [group(sign(part, (x, y), 11.0)), Words((x + 22.0, y + 5.5), words, "pic-words", "start", 16.0)]


def _described(holes: Sequence[Hole], legend: dict[Part, str], reader: Reader) -> str:
    """What is done at each hole, as text."""
    lines = []
    for hole in holes:
        for piece in hole.pieces:
            mass, place = reader.mass(piece.mass_g), hole.label or reader.angle(hole.degrees)
            lines.append(
                reader.gettext("%(action)s: %(mass)s at %(place)s")
                % {"action": legend[piece.part], "mass": mass, "place": place}
            )
    return "; ".join(lines) or reader.gettext("no mass in this plane")
