"""What a further mass would bring: the best objective for each number of pieces."""

from __future__ import annotations

from collections.abc import Sequence

from service.model.plan import FrontPoint
from service.web.pictures.chart import BOTTOM, HEIGHT, WIDTH, Chart
from service.web.pictures.drawing import Circle, Item, Line, Picture, Words
from service.web.pictures.reader import Reader


def front_chart(
    points: Sequence[FrontPoint], unit: str, reader: Reader, *, chosen: int | None = None, limit: float | None = None
) -> Picture:
    """Draw the best objective against the number of pieces; points without a selection are left out.

    unit: the plan's `objective_unit`, or words for it, for the axis. chosen: the number of pieces of the plan, ringed.
    A point that is proved is full, one that is not is hollow.
    """
    _ = reader.gettext
    title = _("What each further mass brings")
    known = [(p.pieces, p.offer.objective_value, p.offer) for p in points if p.offer.objective_value is not None]
    if not known:
        words = _("there is no selection")
        items: tuple[Item, ...] = (Words((20.0, 20.0), title, "pic-title", "start", 17.0),)
        return Picture(WIDTH, 60.0, title, words, (*items, Words((20.0, 46.0), words, "pic-words", "start", 15.0)))
    chart = Chart(min(p[0] for p in known), max(p[0] for p in known), max(max(p[1] for p in known), limit or 0.0))
    upwards = _("left over") + ("" if unit == "1" else f", {unit}")
    drawn = chart.frame(reader, title, upwards, _("masses in the drum"))
    if limit is not None:
        drawn += chart.line_at(limit, _("limit: %(value)s") % {"value": reader.number(limit)})
    drawn.append(Line(tuple(chart.at(pieces, value) for pieces, value, _offer in known), "pic-curve"))
    for pieces, value, offer in known:
        where = chart.at(pieces, value)
        proved = offer.status in ("optimal", "within_uncertainty")
        drawn.append(Circle(where, 7.0, "pic-dot" if proved else "pic-dot-before"))
        if pieces == chosen:
            drawn.append(Circle(where, 13.0, "pic-chosen"))
        drawn.append(Words((where[0], where[1] - 17.0), reader.number(value), "pic-words", size=14.0))
        drawn.append(Words((where[0], BOTTOM + 22.0), str(pieces), "pic-words", size=15.0))
    described = "; ".join(
        _("%(count)s masses: %(value)s") % {"count": pieces, "value": reader.number(value)}
        for pieces, value, _o in known
    )
    return Picture(WIDTH, HEIGHT, title, described, tuple(drawn))
