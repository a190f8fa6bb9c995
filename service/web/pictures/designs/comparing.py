"""Bars before and after, and a front of designs that trade two responses off."""

from __future__ import annotations

from collections.abc import Sequence

from service.web.pictures.designs.axes import HEIGHT, WIDTH, Axes, figure, span
from service.web.pictures.drawing import Circle, Item, Line, Picture, Words
from service.web.pictures.reader import Reader

_LEFT, _RIGHT, _ROW = 130.0, 520.0, 44.0


def bars(
    rows: Sequence[tuple[str, float, float]], reader: Reader, title: str, unit: str, names: tuple[str, str]
) -> Picture:
    """Draw two bars for each row: before (outline) and after (full). names: what the two are."""
    top = max([abs(one) for _, *pair in rows for one in pair] or [1.0]) or 1.0
    scale = (_RIGHT - _LEFT) / top
    items: list[Item] = [Words((20.0, 22.0), title, "pic-title", "start", 17.0)]
    items.append(Words((20.0, 46.0), unit, "pic-small", "start", 14.0))
    for k, (name, before, after) in enumerate(rows):
        y = 60.0 + _ROW * k
        items.append(Words((_LEFT - 10.0, y + 22.0), name[:14], "pic-strong", "end", 14.0))
        for offset, value, cls in ((0.0, before, "pic-before"), (18.0, after, "pic-after")):
            right = _LEFT + max(scale * abs(value), 2.0)
            corners = ((_LEFT, y + offset), (right, y + offset), (right, y + offset + 15.0), (_LEFT, y + offset + 15.0))
            items.append(Line(corners, cls, closed=True))
            items.append(Words((right + 8.0, y + offset + 13.0), figure(value, reader), "pic-words", "start", 13.0))
    y = 60.0 + _ROW * len(rows) + 22.0
    for k, (name, cls) in enumerate(zip(names, ("pic-before", "pic-after"), strict=True)):
        x = 20.0 + 180.0 * k
        corners = ((x, y - 12.0), (x + 26.0, y - 12.0), (x + 26.0, y), (x, y))
        items += [Line(corners, cls, closed=True), Words((x + 34.0, y), name, "pic-words", "start", 14.0)]
    described = "; ".join(f"{name}: {figure(before, reader)} → {figure(after, reader)}" for name, before, after in rows)
    return Picture(WIDTH, y + 14.0, title, described, tuple(items))


def front(
    points: Sequence[tuple[float, float]], reader: Reader, title: str, names: tuple[str, str], chosen: int | None = None
) -> Picture:
    """Draw a front; chosen: the point that is ringed."""
    axes = Axes.over(span(x for x, _ in points), span(y for _, y in points))
    items: list[Item] = axes.frame(reader, title, names[1], names[0])
    places = [axes.at(x, y) for x, y in points]
    if len(places) > 1:
        items.append(Line(tuple(places), "pic-curve"))
    items += [Circle(place, 5.0, "pic-dot") for place in places]
    if chosen is not None and 0 <= chosen < len(places):
        items.append(Circle(places[chosen], 13.0, "pic-chosen"))
    described = "; ".join(f"{figure(x, reader)}, {figure(y, reader)}" for x, y in points)
    return Picture(WIDTH, HEIGHT, title, described, tuple(items))
