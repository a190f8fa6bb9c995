"""Shapes of machine parts to scale: section of a disc, gear pair."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from service.web.pictures.designs.axes import Axes, figure, legend, span
from service.web.pictures.drawing import Circle, Item, Line, Picture, Words
from service.web.pictures.reader import Reader

WIDTH = 640.0


@dataclass(frozen=True)
class Outline:
    """Half a section: thickness over the radius, both in one unit of length; controls: the points that shape it."""

    name: str
    radius: tuple[float, ...]
    thickness: tuple[float, ...]
    controls: tuple[tuple[float, ...], tuple[float, ...]]


def section(outlines: Sequence[Outline], reader: Reader, title: str, unit: str) -> Picture:
    """Draw sections of discs over each other, the thickness on both sides of the middle plane; the last one is filled.

    Radius along, thickness upwards on its own scale: a disc is far wider than it is thick.
    """
    thickest = max(max(one.thickness) for one in outlines)
    ends = span(one for outline in outlines for one in outline.radius)
    axes = Axes.over(ends, (-0.55 * thickest, 0.55 * thickest))
    items: list[Item] = axes.frame(reader, title, unit, unit)
    classes = ("pic-section",) if len(outlines) == 1 else ("pic-section-before", "pic-section")
    for outline, cls in zip(outlines, classes, strict=True):
        upper = [axes.at(r, t / 2.0) for r, t in zip(outline.radius, outline.thickness, strict=True)]
        lower = [axes.at(r, -t / 2.0) for r, t in zip(outline.radius, outline.thickness, strict=True)]
        items.append(Line((*upper, *reversed(lower)), cls, closed=True))
    last = outlines[-1]
    items += [Circle(axes.at(r, t / 2.0), 5.0, "pic-dot") for r, t in zip(*last.controls, strict=True)]
    items += legend([(one.name, cls) for one, cls in zip(outlines, classes, strict=True)], 372.0)
    described = "; ".join(
        f"{one.name}: {figure(min(one.thickness), reader)} … {figure(max(one.thickness), reader)} {unit}"
        for one in outlines
    )
    return Picture(WIDTH, 380.0, title, described, tuple(items))


def gears(diameters: tuple[float, float], teeth: tuple[int, int], reader: Reader, title: str, unit: str) -> Picture:
    """Draw the pitch circles of a pair to scale, each with its teeth and diameter."""
    total = sum(diameters)
    scale = 560.0 / total
    radii = [scale * one / 2.0 for one in diameters]
    height = 70.0 + 2.0 * max(radii) + 44.0
    middle = 60.0 + max(radii)
    items: list[Item] = [Words((20.0, 22.0), title, "pic-title", "start", 17.0)]
    x = 40.0
    for radius, diameter, count in zip(radii, diameters, teeth, strict=True):
        x += radius
        items.append(Circle((x, middle), radius, "pic-drum"))
        items.append(Circle((x, middle), 4.0, "pic-mark"))
        text = f"z = {count}, {figure(diameter, reader)} {unit}"
        items.append(Words((min(max(x, 110.0), 530.0), middle + radius + 24.0), text, "pic-words", size=14.0))
        x += radius
    described = "; ".join(
        f"z = {count}, {figure(one, reader)} {unit}" for count, one in zip(teeth, diameters, strict=True)
    )
    return Picture(WIDTH, height, title, described, tuple(items))
