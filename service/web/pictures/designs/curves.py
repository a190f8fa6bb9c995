"""Curves over a turn or a radius, and the hodograph of a force."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from service.web.pictures.designs.axes import CURVES, HEIGHT, WIDTH, Axes, figure, legend, span
from service.web.pictures.drawing import Circle, Item, Picture
from service.web.pictures.reader import Reader

SQUARE = (84.0, 64.0, 404.0, 384.0)


@dataclass(frozen=True)
class Named:
    """A curve with the name it is shown under."""

    name: str
    x: tuple[float, ...]
    y: tuple[float, ...]


def chart(
    curves: Sequence[Named],
    reader: Reader,
    title: str,
    units: tuple[str, str],
    *,
    turn: bool = False,
    limit: tuple[str, float] | None = None,
) -> Picture:
    """Draw curves of one unit in one chart. units: of x and y; turn: x is a crank angle; limit: its name and value."""
    values = [one for curve in curves for one in curve.y] + ([limit[1]] if limit else [])
    axes = Axes.over(span(one for c in curves for one in c.x), span(values, zero=True), fixed=turn)
    items: list[Item] = axes.frame(reader, title, units[1], units[0])
    classes = [CURVES[k % len(CURVES)] for k in range(len(curves))]
    items += [axes.line(curve.x, curve.y, cls) for curve, cls in zip(curves, classes, strict=True)]
    names = [(curve.name, cls) for curve, cls in zip(curves, classes, strict=True)]
    if limit is not None:
        items.append(axes.line((axes.along[0], axes.along[-1]), (limit[1], limit[1]), "pic-limit"))
        names.append((limit[0], "pic-limit"))
    items += legend(names, HEIGHT - 8.0)
    described = "; ".join(
        f"{curve.name}: {figure(min(curve.y), reader)} … {figure(max(curve.y), reader)} {units[1]}" for curve in curves
    )
    return Picture(WIDTH, HEIGHT, title, described, tuple(items))


def hodograph(curves: Sequence[Named], reader: Reader, title: str, unit: str) -> Picture:
    """Draw vectors over a turn as the path of their tips, x and y on one scale; the first one is the present."""
    low, high = span((one for c in curves for part in (c.x, c.y) for one in part), zero=True)
    axes = Axes.over((low, high), (low, high), SQUARE)
    items: list[Item] = axes.frame(reader, title, unit, unit)
    classes = ("pic-curve",) if len(curves) == 1 else ("pic-curve-before", "pic-curve")
    for curve, cls in zip(curves, classes, strict=True):
        items.append(axes.line((*curve.x, curve.x[0]), (*curve.y, curve.y[0]), cls))
        items.append(Circle(axes.at(curve.x[0], curve.y[0]), 5.0, "pic-dot"))
    items += legend([(curve.name, cls) for curve, cls in zip(curves, classes, strict=True)], 446.0)
    sizes = [max((a * a + b * b) ** 0.5 for a, b in zip(c.x, c.y, strict=True)) for c in curves]
    described = "; ".join(f"{c.name}: ≤ {figure(s, reader)} {unit}" for c, s in zip(curves, sizes, strict=True))
    return Picture(440.0, 456.0, title, described, tuple(items))
