"""What a picture is made of: shapes and words with classes; what is painted how stands in pictures.css."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

Point: TypeAlias = tuple[float, float]
Box: TypeAlias = tuple[float, float, float, float]
"""Left, top, right, bottom."""
Anchor = Literal["start", "middle", "end"]

WORD_WIDTH = 0.64
"""Width of a sign, as a share of the size of the letters, that bold words hardly exceed: it keeps words apart."""


@dataclass(frozen=True)
class Line:
    """Points joined by straight lines; `closed` makes it a shape."""

    points: tuple[Point, ...]
    cls: str
    closed: bool = False


@dataclass(frozen=True)
class Circle:
    """A circle."""

    centre: Point
    radius: float
    cls: str


@dataclass(frozen=True)
class Words:
    """A line of text; its baseline starts, has its middle or ends at `at`."""

    at: Point
    text: str
    cls: str
    anchor: Anchor = "middle"
    size: float = 14.0

    def box(self) -> Box:
        """Where it stands; the width is an estimate."""
        width = WORD_WIDTH * self.size * len(self.text)
        left = self.at[0] - {"start": 0.0, "middle": 0.5, "end": 1.0}[self.anchor] * width
        return left, self.at[1] - 0.8 * self.size, left + width, self.at[1] + 0.25 * self.size


@dataclass(frozen=True)
class Group:
    """Parts that belong together: turned by `turn_deg` clockwise about `about`, with `data` for scripts."""

    items: tuple[Item, ...]
    cls: str = ""
    turn_deg: float = 0.0
    about: Point = (0.0, 0.0)
    data: tuple[tuple[str, str], ...] = ()
    title: str | None = None


Item: TypeAlias = Line | Circle | Words | Group


@dataclass(frozen=True)
class Picture:
    """A picture of `width` by `height`; `title` and `description` are for those who do not see it."""

    width: float
    height: float
    title: str
    description: str
    items: tuple[Item, ...] = field(default=())


def group(items: Iterable[Item], cls: str = "", title: str | None = None) -> Group:
    """Parts that belong together."""
    return Group(tuple(items), cls, title=title)


def overlap(a: Box, b: Box) -> bool:
    """Whether two boxes share more than an edge."""
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
