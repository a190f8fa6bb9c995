"""A certificate as PDF on A4: the same bytes for the same session, every time.

fpdf2 and the fonts are loaded with the first certificate, not when the service starts.
"""

from __future__ import annotations

import logging
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from service.web.certificate.document import Facts, Lines, Part, Pictures, Section, Sheet, Table
from service.web.certificate.fallback_fonts import needed
from service.web.certificate.picture_to_pdf import draw

if TYPE_CHECKING:
    from fpdf import FPDF

MARGIN, WIDTH, HEIGHT = 14.0, 210.0, 297.0
BODY = WIDTH - 2.0 * MARGIN
FOOT = 13.0
FONTS = Path(__file__).parent / "fonts"
"""DejaVu Sans, kept here under its own free licence."""
FONT = "DejaVu"
_SMALL, _LINE = 7.6, 3.7
_INK, _SOFT, _RULE, _GROUND = (17, 24, 32), (80, 92, 104), (150, 160, 170), (238, 241, 244)
_MOODS = {"good": (0, 107, 60), "bad": (179, 38, 30), "open": (122, 74, 0)}
MAX_SIGNS = 20
"""Signs that cannot be printed and are named."""
_MAX_LINES = 40
"""Lines of a cell: a taller row is continued in the next, no row may be taller than a page."""
_WIDE_SIGN = 3.2
"""Width in mm of the widest sign: a text that fits with such ones is not measured."""
_MISSING = "\N{WHITE SQUARE}"
_WIDEST = {1: 118.0, 2: 88.0, 3: 60.0, 4: 45.0}
"""Width in mm of pictures, by how many stand side by side."""
_UNBROKEN = 120.0
"""Height in mm up to which a table is kept on one page."""
_WITH_HEADING = 28.0
"""Height in mm that has to be left for a heading with the first rows below it."""


def to_pdf(sheet: Sheet) -> bytes:
    """The PDF of a certificate, A4."""
    from fpdf import FPDF

    logging.getLogger("fpdf").setLevel(logging.ERROR)

    class _Document(FPDF):
        unprinted: dict[str, int]

        def footer(self) -> None:
            self.set_y(-FOOT + 3.0)
            self.set_font(FONT, "", 7.0)
            self.set_text_color(*_SOFT)
            self.cell(BODY - 30.0, 4.0, _shown(self, sheet.foot))
            words = sheet.page_of % {"page": self.page_no(), "pages": "{nb}"}
            self.cell(30.0, 4.0, words, align="R")

    pdf = _Document(format="A4")
    pdf.unprinted = {}
    pdf.set_creation_date(sheet.dated)
    pdf.set_lang(sheet.language)
    pdf.set_title(f"{sheet.title}: {sheet.subject}")
    pdf.set_producer("Drumtrue")
    for style, name in (("", "DejaVuSans.ttf"), ("B", "DejaVuSans-Bold.ttf")):
        pdf.add_font(FONT, style, str(FONTS / name))
    _add_fallbacks(pdf, sheet)
    pdf.set_margin(MARGIN)
    pdf.set_auto_page_break(True, FOOT + 1.0)
    pdf.add_page()
    _head(pdf, sheet)
    for index, section in enumerate(sheet.sections):
        _section(pdf, section)
        if index == sheet.signed % len(sheet.sections):
            _signatures(pdf, sheet)
    _unprinted(pdf, sheet)
    return bytes(pdf.output())


def _add_fallbacks(pdf: FPDF, sheet: Sheet) -> None:
    """Let installed fonts stand in for signs that the certificate's own font has not."""
    known = set(pdf.fonts[FONT.lower()].cmap)  # type: ignore[union-attr]
    names = []
    for index, path in enumerate(needed(sheet.texts(), known)):
        names.append(f"fallback{index}")
        pdf.add_font(names[-1], "", str(path))
    if names:
        pdf.set_fallback_fonts(names, exact_match=False)


def _unprinted(pdf: FPDF, sheet: Sheet) -> None:
    """Say which signs no font has."""
    missing: dict[str, int] = pdf.unprinted  # type: ignore[attr-defined]
    if not missing:
        return
    named = [f"U+{ord(sign):04X}" for sign in sorted(missing)]
    listed = ", ".join(named[:MAX_SIGNS]) + (" ..." if len(named) > MAX_SIGNS else "")
    _font(pdf, _SMALL)
    pdf.ln(2.0)
    said = sheet.unprinted % {"count": sum(missing.values()), "signs": listed}
    pdf.multi_cell(BODY, _LINE, said, new_x="LMARGIN", new_y="NEXT", align="L")


def _head(pdf: FPDF, sheet: Sheet) -> None:
    _font(pdf, 17.0, bold=True)
    pdf.cell(BODY, 8.0, _shown(pdf, sheet.title), new_x="LMARGIN", new_y="NEXT")
    _font(pdf, 12.0)
    pdf.multi_cell(BODY, 5.6, _shown(pdf, sheet.subject), new_x="LMARGIN", new_y="NEXT", align="L")
    pdf.ln(1.5)
    colour = _MOODS[sheet.mood]
    pdf.set_draw_color(*colour)
    pdf.set_line_width(0.9)
    pdf.set_text_color(*colour)
    pdf.set_font(FONT, "B", 11.0)
    pdf.multi_cell(BODY, 8.0, _shown(pdf, sheet.verdict), border=1, new_x="LMARGIN", new_y="NEXT", align="C")


def _section(pdf: FPDF, section: Section) -> None:
    _keep(pdf, _WITH_HEADING)
    pdf.ln(2.6)
    _font(pdf, 10.0, bold=True)
    pdf.cell(BODY, 5.4, _shown(pdf, section.heading), new_x="LMARGIN", new_y="NEXT")
    pdf.set_draw_color(*_RULE)
    pdf.set_line_width(0.3)
    pdf.line(MARGIN, pdf.get_y(), MARGIN + BODY, pdf.get_y())
    pdf.ln(1.0)
    for part in section.parts:
        _part(pdf, part)


def _part(pdf: FPDF, part: Part) -> None:
    match part:
        case Facts(pairs):
            _facts(pdf, pairs)
        case Table():
            _table(pdf, part)
        case Pictures():
            _pictures(pdf, part)
        case Lines(lines):
            _font(pdf, _SMALL)
            for line in lines:
                pdf.multi_cell(BODY, _LINE, _shown(pdf, line), new_x="LMARGIN", new_y="NEXT", align="L")


def _facts(pdf: FPDF, pairs: tuple[tuple[str, str], ...]) -> None:
    """Pairs in two columns."""
    rows = [(*pairs[i], *(pairs[i + 1] if i + 1 < len(pairs) else ("", ""))) for i in range(0, len(pairs), 2)]
    _grid(pdf, rows, (21, 29, 21, 29), heads=False, figures=frozenset())


def _table(pdf: FPDF, table: Table) -> None:
    """A table; one that fits on a page is not broken."""
    _font(pdf, _SMALL)
    height = sum(_row_height(pdf, row, table.widths) for row in (table.heads, *table.rows))
    if height < _UNBROKEN:
        _keep(pdf, height)
    _grid(pdf, [table.heads, *table.rows], table.widths, heads=True, figures=table.figures)
    pdf.ln(1.2)


def _grid(pdf: FPDF, rows: list[Any], widths: tuple[float, ...], *, heads: bool, figures: frozenset[int]) -> None:
    from fpdf.fonts import FontFace

    _font(pdf, _SMALL)
    pdf.set_draw_color(*_RULE)
    pdf.set_fill_color(255, 255, 255)
    pdf.set_line_width(0.15)
    headings = FontFace(emphasis="BOLD", color=_SOFT, fill_color=_GROUND)
    with pdf.table(
        width=BODY,
        col_widths=widths,
        line_height=_LINE,
        first_row_as_headings=heads,
        headings_style=headings,
        borders_layout="HORIZONTAL_LINES" if heads else "NONE",
        padding=(0.45, 1.2),
        v_align="TOP",
        text_align=tuple("RIGHT" if column in figures else "LEFT" for column in range(len(widths))),
    ) as table:
        soft = FontFace(color=_SOFT)
        for whole in rows:
            for row in _pieces(pdf, [_shown(pdf, text) for text in whole], widths):
                line = table.row()
                for column, text in enumerate(row):
                    line.cell(text, style=soft if not heads and column % 2 == 0 else None)


def _row_height(pdf: FPDF, row: tuple[str, ...], widths: tuple[float, ...]) -> float:
    """Height of a row in mm, from the widths of its texts; a little more where words do not fill their lines."""
    lines = [
        math.ceil(1.1 * pdf.get_string_width(text) / (BODY * width / sum(widths) - 2.6))
        for text, width in zip(row, widths, strict=True)
    ]
    return max(1, *lines) * _LINE + 0.9


def _pieces(pdf: FPDF, row: list[str], widths: tuple[float, ...]) -> list[list[str]]:
    """A row as rows that each fit on a page: cells of many lines are continued."""
    cells = [_cut(pdf, text, BODY * width / sum(widths) - 2.6) for text, width in zip(row, widths, strict=True)]
    count = max(len(cell) for cell in cells)
    return [[cell[index] if index < len(cell) else "" for cell in cells] for index in range(count)]


def _cut(pdf: FPDF, text: str, width: float) -> list[str]:
    """A text in parts of no more than this many lines of a column, `width` mm wide."""
    if len(text) * _WIDE_SIGN < width * _MAX_LINES and text.count("\n") < _MAX_LINES:
        return [text]
    lines: Any = pdf.multi_cell(width, _LINE, text, dry_run=True, output="LINES")
    return ["\n".join(lines[start : start + _MAX_LINES]) for start in range(0, len(lines), _MAX_LINES)] or [text]


def _pictures(pdf: FPDF, part: Pictures) -> None:
    """Rows of pictures, each row whole on one page."""
    width, gap = _WIDEST[part.across], 3.0
    for start in range(0, len(part.pictures), part.across):
        row = part.pictures[start : start + part.across]
        height = max(picture.height * width / picture.width for picture in row)
        _keep(pdf, height)
        total = len(row) * width + (len(row) - 1) * gap
        left, top = MARGIN + (BODY - total) / 2.0, pdf.get_y()
        for index, picture in enumerate(row):
            draw(pdf, picture, left + index * (width + gap), top, width, lambda text: _run_of(pdf, text))
        pdf.set_xy(MARGIN, top + height + 1.5)


def _signatures(pdf: FPDF, sheet: Sheet) -> None:
    """Lines to sign on, below the result that is signed: never alone on a page."""
    _keep(pdf, 22.0)
    pdf.ln(12.0)
    width = BODY / len(sheet.signatures)
    pdf.set_draw_color(*_INK)
    pdf.set_line_width(0.3)
    pdf.set_dash_pattern()
    y = pdf.get_y()
    _font(pdf, _SMALL)
    for index, (words, name) in enumerate(sheet.signatures):
        x = MARGIN + index * width
        pdf.line(x, y, x + width - 8.0, y)
        pdf.set_xy(x, y + 0.8)
        told = f"{words}: {name}" if name else words
        pdf.multi_cell(width - 8.0, 4.0, _shown(pdf, told), align="L", max_line_height=4.0)
    pdf.set_xy(MARGIN, y + 9.0)


def _font(pdf: FPDF, size: float, *, bold: bool = False) -> None:
    pdf.set_font(FONT, "B" if bold else "", size)
    pdf.set_text_color(*_INK)


def _keep(pdf: FPDF, height: float) -> None:
    """Begin a new page where this many mm are not left on this one."""
    if pdf.get_y() + height > HEIGHT - FOOT - 1.0 and pdf.get_y() > MARGIN + 1.0:
        pdf.add_page()


def _shown(pdf: FPDF, text: str) -> str:
    """The text with a box for every sign that no font has; these are counted."""
    out = []
    for sign in text:
        has = sign == "\n" or any(ord(sign) in pdf.fonts[name].cmap for name in _fonts(pdf))  # type: ignore[union-attr]
        if not has:
            pdf.unprinted[sign] = pdf.unprinted.get(sign, 0) + 1  # type: ignore[attr-defined]
        out.append(sign if has else _MISSING)
    return "".join(out)


def _fonts(pdf: FPDF) -> tuple[str, ...]:
    """Keys of the fonts a text may be set in, the certificate's own first."""
    return (FONT.lower(), *(name for name in pdf.fonts if name.startswith("fallback")))


def _run_of(pdf: FPDF, text: str) -> tuple[str, str]:
    """A text of a picture, and the font that has most of its signs: a picture's text is set in one font."""
    shown = _shown(pdf, text)
    best = max(_fonts(pdf), key=lambda name: sum(ord(sign) in pdf.fonts[name].cmap for sign in shown))  # type: ignore[union-attr]
    return shown, FONT if best == FONT.lower() else best
