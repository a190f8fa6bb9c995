"""A picture drawn into a PDF: the same shapes as on a page, at any size."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from service.web.certificate.pdf_style import Paint, paint_of
from service.web.pictures.drawing import Circle, Group, Item, Line, Picture, Point, Words

if TYPE_CHECKING:
    from fpdf import FPDF

FontOf = Callable[[str], tuple[str, str]]
"""A text as it can be set, and the font of the PDF that has its signs."""
MM_PER_POINT = 25.4 / 72.0


def draw(pdf: FPDF, picture: Picture, left: float, top: float, width: float, font_of: FontOf) -> float:
    """Draw a picture `width` mm wide at (left, top) mm; returns its height in mm."""
    scale = width / picture.width
    for item in picture.items:
        _Ink(pdf, left, top, scale, font_of).draw(item)
    pdf.set_dash_pattern()
    pdf.set_text_color(0, 0, 0)
    return picture.height * scale


class _Ink:
    def __init__(self, pdf: FPDF, left: float, top: float, scale: float, font_of: FontOf) -> None:
        self.pdf, self.left, self.top, self.scale, self.font_of = pdf, left, top, scale, font_of

    def draw(self, item: Item) -> None:
        match item:
            case Group():
                x, y = self._at(item.about)
                with self.pdf.rotation(-item.turn_deg, x, y):
                    for part in item.items:
                        self.draw(part)
            case Words():
                self._write(item)
            case Line(points, cls, closed):
                self._shape([self._at(point) for point in points], paint_of(cls), closed)
            case Circle((x, y), radius, cls):
                self._circle(self._at((x, y)), radius * self.scale, paint_of(cls))

    def _at(self, point: Point) -> Point:
        return self.left + point[0] * self.scale, self.top + point[1] * self.scale

    def _style(self, paint: Paint) -> str:
        """Set the colours; returns which of drawing and filling is asked for."""
        style = ""
        if paint.stroke is not None:
            self.pdf.set_draw_color(*paint.stroke)
            self.pdf.set_line_width(max(paint.width * self.scale, 0.05))
            dash, gap = paint.dashes or (0.0, 0.0)
            self.pdf.set_dash_pattern(dash * self.scale, gap * self.scale)
            style += "D"
        if paint.fill is not None:
            self.pdf.set_fill_color(*paint.fill)
            style += "F"
        return style

    def _shape(self, points: list[Point], paint: Paint, closed: bool) -> None:
        style = self._style(paint)
        if not style or len(points) < 2:
            return
        with self.pdf.local_context(fill_opacity=paint.fill_opacity):
            if closed:
                self.pdf.polygon(points, style=style)
            else:
                self.pdf.polyline(points, style="D")

    def _circle(self, centre: Point, radius: float, paint: Paint) -> None:
        style = self._style(paint)
        if not style or radius <= 0.0 or not math.isfinite(radius):
            return
        with self.pdf.local_context(fill_opacity=paint.fill_opacity):
            self.pdf.circle(*centre, radius, style=style)

    def _write(self, words: Words) -> None:
        paint = paint_of(words.cls)
        text, font = self.font_of(words.text)
        bold = paint.bold and (font.lower() + "B") in self.pdf.fonts
        self.pdf.set_font(font, "B" if bold else "", words.size * self.scale / MM_PER_POINT)
        self.pdf.set_text_color(*(paint.fill or (0, 0, 0)))
        x, y = self._at(words.at)
        share = {"start": 0.0, "middle": 0.5, "end": 1.0}[words.anchor]
        self.pdf.text(x - share * self.pdf.get_string_width(text), y, text)
