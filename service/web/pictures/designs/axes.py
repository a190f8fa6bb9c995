"""Axes of a chart whose values may lie on both sides of 0."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from service.web.pictures.drawing import Box, Item, Line, Point, Words
from service.web.pictures.reader import Reader
from service.web.pictures.scales import ticks

WIDTH, HEIGHT = 640.0, 380.0
PAPER: Box = (84.0, 64.0, 620.0, 316.0)
CURVES = ("pic-curve", "pic-curve-second", "pic-curve-third", "pic-curve-fourth")
"""Classes of the lines of one chart, told apart by their dashes too."""


def span(values: Iterable[float], *, zero: bool = False) -> tuple[float, float]:
    """Least and greatest of the values, some room apart; zero: 0 is among them."""
    found = [one for one in values if math.isfinite(one)] + ([0.0] if zero else [])
    low, high = (min(found), max(found)) if found else (0.0, 1.0)
    return (low, high) if high > low else (low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0))


def grid(low: float, high: float, most: int = 5) -> tuple[float, ...]:
    """Round values from about `low` to about `high`, the outer ones beyond both."""
    step = ticks(high - low, most)[0]
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return tuple(step * k for k in range(first, last + 1))


@dataclass(frozen=True)
class Axes:
    """A chart between round values of both axes, drawn within a box."""

    along: tuple[float, ...]
    upwards: tuple[float, ...]
    box: Box = PAPER

    @classmethod
    def over(cls, x: tuple[float, float], y: tuple[float, float], box: Box = PAPER, *, fixed: bool = False) -> Axes:
        """Axes over these spans; fixed: x ends where it is stated, as a turn does."""
        along = tuple(x[0] + (x[1] - x[0]) * k / 4.0 for k in range(5)) if fixed else grid(*x)
        return cls(along, grid(*y), box)

    def at(self, x: float, y: float) -> Point:
        """Where a value lies on paper."""
        left, top, right, bottom = self.box
        return (
            left + (x - self.along[0]) / (self.along[-1] - self.along[0]) * (right - left),
            bottom - (y - self.upwards[0]) / (self.upwards[-1] - self.upwards[0]) * (bottom - top),
        )

    def line(self, x: Sequence[float], y: Sequence[float], cls: str) -> Line:
        """A curve."""
        return Line(tuple(self.at(a, b) for a, b in zip(x, y, strict=True)), cls)

    def frame(self, reader: Reader, title: str, upwards: str, along: str) -> list[Item]:
        """Title, lines at round values with their numbers, what is shown upwards and along."""
        left, top, right, bottom = self.box
        out: list[Item] = [Words((20.0, 22.0), title, "pic-title", "start", 17.0)]
        out.append(Words((20.0, 46.0), upwards, "pic-small", "start", 14.0))
        out.append(Words((right, bottom + 42.0), along, "pic-small", "end", 14.0))
        for y in self.upwards:
            at = self.at(self.along[0], y)[1]
            out.append(Line(((left, at), (right, at)), "pic-axis" if y == 0.0 else "pic-grid"))
            out.append(Words((left - 8.0, at + 5.0), figure(y, reader), "pic-small", "end", 14.0))
        for x in self.along:
            at = self.at(x, self.upwards[0])[0]
            out.append(Line(((at, top), (at, bottom)), "pic-axis" if x == 0.0 else "pic-grid"))
            out.append(Words((at, bottom + 20.0), figure(x, reader), "pic-small", size=14.0))
        return out


def figure(value: float, reader: Reader) -> str:
    """A round value, noughts cut off."""
    if value != 0.0 and not 1e-3 <= abs(value) < 1e5:
        return reader.show.figure(f"{value:.3g}")
    return reader.number(value, 4)


def legend(names: Sequence[tuple[str, str]], y: float) -> list[Item]:
    """A sample of each line with its name, side by side."""
    out: list[Item] = []
    for k, (name, cls) in enumerate(names):
        x = 20.0 + 155.0 * k
        out.append(Line(((x, y - 4.0), (x + 30.0, y - 4.0)), cls))
        out.append(Words((x + 36.0, y), name, "pic-words", "start", 14.0))
    return out
