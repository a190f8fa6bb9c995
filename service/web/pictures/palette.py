"""The paint of pictures: colours and one rule a class, for pages and paper alike.

`python -m service.web.pictures.palette` writes the rules into static/pictures.css; pages in dark light override the
colours there, paper takes those below.
"""

from __future__ import annotations

from pathlib import Path

LIGHT: dict[str, str] = {
    "pic-ink": "#111820",
    "pic-soft": "#5b6672",
    "pic-grid": "#c3cad2",
    "pic-ground": "#ffffff",
    "pic-body": "#eef1f4",
    "pic-add": "#0b57d0",
    "pic-remove": "#b3261e",
    "pic-keep": "#20262d",
    "pic-fixed": "#6b4f00",
    "pic-initial": "#20262d",
    "pic-trial": "#0b57d0",
    "pic-check": "#006b3c",
    "pic-correction": "#7a4a00",
    "pic-predicted": "#8a1c8c",
    "pic-limit": "#006b3c",
    "pic-within": "#d9f2e3",
    "pic-region": "#f2dcf3",
    "pic-badge": "#ffffff",
    "pic-over": "#b3261e",
}
"""Colours on a light ground and on paper."""

Properties = dict[str, str]
RULES: tuple[tuple[str, Properties], ...] = (
    ("pic-title", {"fill": "pic-ink", "font-weight": "700"}),
    ("pic-words", {"fill": "pic-ink"}),
    ("pic-strong", {"fill": "pic-ink", "font-weight": "700"}),
    ("pic-small", {"fill": "pic-soft"}),
    ("pic-halo", {"fill": "pic-soft", "paint-order": "stroke", "stroke": "pic-ground", "stroke-width": "4"}),
    ("pic-grid", {"fill": "none", "stroke": "pic-grid", "stroke-width": "1"}),
    ("pic-rim", {"fill": "none", "stroke": "pic-ink", "stroke-width": "1.5"}),
    ("pic-axis", {"fill": "none", "stroke": "pic-ink", "stroke-width": "1.5"}),
    ("pic-mark", {"fill": "pic-ink"}),
    ("pic-sense", {"fill": "none", "stroke": "pic-soft", "stroke-width": "2"}),
    ("pic-sense-head", {"fill": "pic-soft"}),
    ("pic-sense-words", {"fill": "pic-soft"}),
    ("pic-turning", {"fill": "none", "stroke": "pic-ink", "stroke-width": "4"}),
    ("pic-turning-head", {"fill": "pic-ink"}),
    ("pic-turning-words", {"fill": "pic-ink", "font-weight": "700"}),
    ("pic-within", {"fill": "pic-within"}),
    ("pic-limit", {"fill": "none", "stroke": "pic-limit", "stroke-width": "2.5", "stroke-dasharray": "8 4"}),
    ("pic-region", {"fill": "pic-region", "stroke": "pic-predicted", "stroke-width": "1", "fill-opacity": "0.6"}),
    ("pic-limit-words", {"fill": "pic-limit", "font-weight": "700"}),
    ("pic-predicted", {"fill": "none", "stroke": "pic-predicted", "stroke-width": "2.5", "stroke-dasharray": "5 4"}),
    ("pic-predicted-tip", {"fill": "pic-predicted"}),
    ("pic-vector", {"fill": "none", "stroke-width": "3"}),
    ("pic-amplitude", {"fill": "none", "stroke-width": "2", "stroke-dasharray": "2 5"}),
    ("pic-initial", {"stroke": "pic-initial"}),
    ("pic-trial", {"stroke": "pic-trial"}),
    ("pic-check", {"stroke": "pic-check"}),
    ("pic-correction", {"stroke": "pic-correction"}),
    ("pic-initial-fill", {"fill": "pic-initial"}),
    ("pic-trial-fill", {"fill": "pic-trial"}),
    ("pic-check-fill", {"fill": "pic-check"}),
    ("pic-correction-fill", {"fill": "pic-correction"}),
    ("pic-badge", {"stroke": "pic-ground", "stroke-width": "2"}),
    ("pic-badge-words", {"fill": "pic-badge", "font-weight": "700"}),
    ("pic-influence", {"fill": "none", "stroke": "pic-trial", "stroke-width": "1.5", "stroke-dasharray": "3 3"}),
    ("pic-influence-head", {"fill": "pic-trial"}),
    ("pic-drum", {"fill": "pic-body", "stroke": "pic-ink", "stroke-width": "3"}),
    ("pic-hub", {"fill": "pic-ground", "stroke": "pic-ink", "stroke-width": "2"}),
    ("pic-hole", {"fill": "pic-ground", "stroke": "pic-ink", "stroke-width": "1.5"}),
    ("pic-hole-words", {"fill": "pic-ink"}),
    ("pic-add", {"fill": "pic-add", "stroke": "pic-add", "stroke-width": "3"}),
    ("pic-remove", {"fill": "pic-ground", "stroke": "pic-remove", "stroke-width": "3"}),
    ("pic-keep", {"fill": "pic-keep", "stroke": "pic-keep", "stroke-width": "3"}),
    ("pic-fixed", {"fill": "pic-fixed", "stroke": "pic-fixed", "stroke-width": "3"}),
    ("pic-blocked", {"fill": "pic-grid", "stroke": "pic-soft", "stroke-width": "2"}),
    ("pic-blocked-sign", {"fill": "none", "stroke": "pic-soft", "stroke-width": "3"}),
    ("pic-add-sign", {"fill": "none", "stroke": "pic-badge", "stroke-width": "3.5"}),
    ("pic-remove-sign", {"fill": "none", "stroke": "pic-remove", "stroke-width": "3.5"}),
    ("pic-keep-sign", {"fill": "pic-badge"}),
    ("pic-add-words", {"fill": "pic-add", "font-weight": "700"}),
    ("pic-remove-words", {"fill": "pic-remove", "font-weight": "700"}),
    ("pic-keep-words", {"fill": "pic-keep", "font-weight": "700"}),
    ("pic-fixed-words", {"fill": "pic-fixed", "font-weight": "700"}),
    ("pic-before", {"fill": "pic-ground", "stroke": "pic-soft", "stroke-width": "1.5"}),
    ("pic-hatch", {"fill": "none", "stroke": "pic-soft", "stroke-width": "1.5"}),
    ("pic-after", {"fill": "pic-check", "stroke": "pic-check", "stroke-width": "1.5"}),
    ("pic-over", {"fill": "pic-over", "stroke": "pic-over", "stroke-width": "1.5"}),
    ("pic-over-words", {"fill": "pic-over", "font-weight": "700"}),
    ("pic-after-words", {"fill": "pic-check", "font-weight": "700"}),
    ("pic-curve", {"fill": "none", "stroke": "pic-trial", "stroke-width": "2.5"}),
    ("pic-curve-before", {"fill": "none", "stroke": "pic-soft", "stroke-width": "2", "stroke-dasharray": "6 4"}),
    (
        "pic-curve-second",
        {"fill": "none", "stroke": "pic-correction", "stroke-width": "2.5", "stroke-dasharray": "9 4"},
    ),
    ("pic-curve-third", {"fill": "none", "stroke": "pic-predicted", "stroke-width": "2.5", "stroke-dasharray": "3 3"}),
    (
        "pic-curve-fourth",
        {"fill": "none", "stroke": "pic-correction", "stroke-width": "2.5", "stroke-dasharray": "12 3"},
    ),
    ("pic-path", {"fill": "none", "stroke": "pic-grid", "stroke-width": "1.5", "stroke-dasharray": "2 4"}),
    ("pic-ghost", {"fill": "none", "stroke": "pic-grid", "stroke-width": "1"}),
    ("pic-link", {"fill": "pic-region", "stroke": "pic-ink", "stroke-width": "5", "fill-opacity": "0.5"}),
    ("pic-mass", {"fill": "pic-remove"}),
    ("pic-section", {"fill": "pic-region", "stroke": "pic-trial", "stroke-width": "2.5", "fill-opacity": "0.6"}),
    ("pic-section-before", {"fill": "none", "stroke": "pic-soft", "stroke-width": "2", "stroke-dasharray": "6 4"}),
    ("pic-dot", {"fill": "pic-trial", "stroke": "pic-ground", "stroke-width": "2"}),
    ("pic-dot-before", {"fill": "pic-ground", "stroke": "pic-soft", "stroke-width": "2"}),
    ("pic-chosen", {"fill": "none", "stroke": "pic-check", "stroke-width": "3"}),
    ("pic-absent", {"display": "none"}),
    ("pic-needle-hub", {"fill": "pic-ink"}),
    ("pic-scale", {"fill": "none", "stroke": "pic-grid", "stroke-width": "10"}),
    ("pic-scale-within", {"fill": "none", "stroke": "pic-limit", "stroke-width": "10"}),
    ("pic-scale-over", {"fill": "none", "stroke": "pic-over", "stroke-width": "10"}),
    ("pic-steady", {"fill": "pic-check", "stroke": "pic-check", "stroke-width": "3"}),
    ("pic-steady-sign", {"fill": "none", "stroke": "pic-badge", "stroke-width": "12"}),
    ("pic-unsteady", {"fill": "pic-ground", "stroke": "pic-remove", "stroke-width": "4"}),
    ("pic-unsteady-sign", {"fill": "none", "stroke": "pic-remove", "stroke-width": "4"}),
    ("pic-silent", {"fill": "pic-ground", "stroke": "pic-soft", "stroke-width": "4"}),
    ("pic-silent-sign", {"fill": "none", "stroke": "pic-soft", "stroke-width": "4"}),
)
"""Class and properties, in order: a later rule goes before an earlier one. A colour is named as in `LIGHT`."""

BEGIN, END = "/* rules of palette.py: */\n", "/* end of palette.py */\n"


def css(*, plain: bool = False) -> str:
    """The rules as CSS, a line each; plain: with the light colours themselves, for a file that stands alone."""

    def value(text: str) -> str:
        if text not in LIGHT:
            return text
        return LIGHT[text] if plain else f"var(--{text})"

    lines = (
        f".{name} {{ {' '.join(f'{key}: {value(text)};' for key, text in properties.items())} }}\n"
        for name, properties in RULES
    )
    return "".join(lines)


def written(sheet: str) -> str:
    """A style sheet with the rules of today between its two marks."""
    before, _, rest = sheet.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}{css()}{END}{after}"


if __name__ == "__main__":
    SHEET = Path(__file__).parents[1] / "static" / "pictures.css"
    SHEET.write_text(written(SHEET.read_text(encoding="utf-8")), encoding="utf-8")
