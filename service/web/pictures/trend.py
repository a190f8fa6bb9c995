"""A machine over its sessions: vibration as found and as left, beside the limit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from service.web.pictures.chart import BOTTOM, HEIGHT, LEFT, RIGHT, WIDTH, Chart
from service.web.pictures.drawing import Circle, Item, Line, Picture, Words
from service.web.pictures.reader import Reader

MAX_DATES = 6


@dataclass(frozen=True)
class TrendPoint:
    """A session of one sensor: amplitudes in the unit shown; `after` None where no check run was taken."""

    when: datetime
    before: float
    after: float | None


def trend_chart(
    points: Sequence[TrendPoint], sensor: str, unit: str, reader: Reader, *, limit: float | None = None
) -> Picture:
    """Draw a sensor over the sessions of its machine, in order of time; limit in the unit shown."""
    _ = reader.gettext
    title = _("%(sensor)s over the sessions") % {"sensor": sensor}
    if not points:
        return Picture(WIDTH, 40.0, title, _("no session yet"), ())
    points = sorted(points, key=lambda point: point.when)
    highest = max([limit or 0.0, *(p.before for p in points), *(p.after or 0.0 for p in points)])
    chart = Chart(points[0].when.timestamp(), points[-1].when.timestamp(), highest)
    items: list[Item] = chart.frame(reader, title, unit, "")
    if limit is not None:
        items += chart.line_at(limit, _("limit: %(value)s") % {"value": reader.number(limit)})
    before = [chart.at(p.when.timestamp(), p.before) for p in points]
    after = [chart.at(p.when.timestamp(), p.after) for p in points if p.after is not None]
    for places, line, dot in ((before, "pic-curve-before", "pic-dot-before"), (after, "pic-curve", "pic-dot")):
        if len(places) > 1:
            items.append(Line(tuple(places), line))
        items += [Circle(place, 7.0, dot) for place in places]
    items += _dates(points, before, reader)
    items += [Circle((84.0, HEIGHT - 16.0), 7.0, "pic-dot-before"), _words(98.0, _("as found"))]
    items += [Circle((244.0, HEIGHT - 16.0), 7.0, "pic-dot"), _words(258.0, _("after balancing"))]
    described = "; ".join(
        f"{reader.date(p.when)}: {reader.number(p.before)}"
        + (f" → {reader.number(p.after)}" if p.after is not None else "")
        for p in points
    )
    return Picture(WIDTH, HEIGHT, title, described, tuple(items))


def _words(x: float, text: str) -> Words:
    return Words((x, HEIGHT - 11.0), text, "pic-words", "start", 14.0)


def _dates(points: Sequence[TrendPoint], places: Sequence[tuple[float, float]], reader: Reader) -> list[Item]:
    """Days below the axis, as many as have room."""
    out: list[Item] = []
    last = float("-inf")
    for point, (x, _y) in zip(points, places, strict=True):
        if x - last > (RIGHT - LEFT) / MAX_DATES:
            out.append(Words((x, BOTTOM + 22.0), reader.date(point.when), "pic-words", size=14.0))
            last = x
    return out
