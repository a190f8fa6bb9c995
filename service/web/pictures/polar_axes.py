"""Polar paper: rings at round values, spokes at angles, the key-phasor mark, the sense of angles and of rotation."""

from __future__ import annotations

import math
from dataclasses import dataclass

from service.model.machine import AngleSense, PhaseSense
from service.web.pictures.angle_axis import Compass
from service.web.pictures.drawing import Circle, Item, Line, Point, Words
from service.web.pictures.reader import Reader
from service.web.pictures.scales import ticks


@dataclass(frozen=True)
class Paper:
    """Polar paper of `radius` units about the compass's centre, for values up to about `highest` (as shown)."""

    compass: Compass
    radius: float
    highest: float

    @property
    def rings(self) -> tuple[float, ...]:
        """Values of the rings; the last is the outermost."""
        return ticks(self.highest, 4)

    @property
    def scale(self) -> float:
        """Units of paper for a value of 1, as shown."""
        return self.radius / self.rings[-1]

    def tip(self, vector: complex) -> Point:
        """Where an internal vector, in the unit shown, ends."""
        return self.compass.tip(vector, self.scale)

    def grid(self, reader: Reader, sense: AngleSense | PhaseSense) -> list[Item]:
        """Rings with their values, spokes with their angles in `sense`, the mark at 0."""
        centre, out = self.compass.centre, list[Item]()
        for degrees in range(0, 360, 30):
            outer = self.compass.at(self.radius, degrees, sense)
            inner = self.compass.at(self.radius * (0.0 if degrees % 90 == 0 else 0.12), degrees, sense)
            out.append(Line((inner, outer), "pic-grid"))
            x, y = self.compass.at(self.radius + 17.0, degrees, sense)
            out.append(Words((x, y + 5.0), f"{degrees}°", "pic-small", size=13.0))
        for value in self.rings:
            last = value == self.rings[-1]
            out.append(Circle(centre, value * self.scale, "pic-rim" if last else "pic-grid"))
        for value in self.rings:
            x, y = self.compass.point(value * self.scale, math.radians(45.0) * (1 if self.compass.clockwise else -1))
            out.append(Words((x + 3.0, y - 2.0), reader.number(value), "pic-small pic-halo", "start", 12.0))
        return out


def key_mark(tip: Point, cls: str = "pic-mark", size: float = 12.0) -> Line:
    """The key-phasor mark: a triangle whose tip points down at `tip`."""
    x, y = tip
    return Line(((x, y), (x - 0.6 * size, y - size), (x + 0.6 * size, y - size)), cls, True)


def sense_arrows(
    compass: Compass, radius: float, sense: AngleSense | PhaseSense, angles: str, rotation: str
) -> list[Item]:
    """Two arcs outside the rim: which way angles in `sense` count, and which way the drum turns."""
    counts = -1.0 if sense in ("with_rotation", "lead") else 1.0
    out: list[Item] = []
    # Internal angles count against the rotation: the drum turns towards negative ones.
    for way, words, cls in ((counts, angles, "pic-sense"), (-1.0, rotation, "pic-turning")):
        side = 1.0 if compass.clockwise else -1.0
        about = math.radians(45.0) if cls == "pic-sense" else math.radians(-45.0)
        begin, end = about * side - way * math.radians(14.0), about * side + way * math.radians(14.0)
        out += compass.arrow(radius, begin, end, cls)
        x = compass.centre[0] + (1 if about > 0 else -1) * (radius * math.sin(math.radians(45.0)) + 14.0)
        y = compass.centre[1] - radius * math.cos(math.radians(45.0)) - 12.0
        out.append(Words((x, y), words, cls + "-words", "start" if about > 0 else "end", 13.0))
    return out
