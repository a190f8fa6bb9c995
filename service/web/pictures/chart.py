"""Axes of a chart: values upwards from 0, places or times along."""

from __future__ import annotations

from dataclasses import dataclass

from service.web.pictures.drawing import Item, Line, Point, Words
from service.web.pictures.reader import Reader
from service.web.pictures.scales import ticks

WIDTH, HEIGHT = 640.0, 360.0
LEFT, RIGHT, TOP, BOTTOM = 76.0, 620.0, 64.0, 304.0


@dataclass(frozen=True)
class Chart:
    """A chart for x between `low` and `high` and y between 0 and about `top`."""

    low: float
    high: float
    top: float

    @property
    def ticks(self) -> tuple[float, ...]:
        """Values that have a line of their own."""
        return ticks(self.top, 5)

    def at(self, x: float, y: float) -> Point:
        """Where a value lies on paper."""
        along = (x - self.low) / ((self.high - self.low) or 1.0)
        return LEFT + 24.0 + along * (RIGHT - LEFT - 48.0), BOTTOM - y / self.ticks[-1] * (BOTTOM - TOP)

    def frame(self, reader: Reader, title: str, upwards: str, along: str) -> list[Item]:
        """Title, axes, lines at round values with their numbers, what is shown upwards and along."""
        out: list[Item] = [Words((20.0, 20.0), title, "pic-title", "start", 17.0)]
        out.append(Words((20.0, 44.0), upwards, "pic-small", "start", 14.0))
        out.append(Words((RIGHT, BOTTOM + 46.0), along, "pic-small", "end", 14.0))
        for value in (0.0, *self.ticks):
            y = self.at(self.low, value)[1]
            out.append(Line(((LEFT, y), (RIGHT, y)), "pic-axis" if value == 0.0 else "pic-grid"))
            out.append(Words((LEFT - 8.0, y + 5.0), reader.number(value), "pic-small", "end", 14.0))
        return out

    def line_at(self, value: float, words: str) -> list[Item]:
        """A limit across the chart, named above it; nothing where it lies above the chart."""
        if value > self.ticks[-1]:
            return []
        y = self.at(self.low, value)[1]
        return [
            Line(((LEFT, y), (RIGHT, y)), "pic-limit"),
            Words((RIGHT, 44.0), words, "pic-limit-words", "end", 14.0),
        ]
