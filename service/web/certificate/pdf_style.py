"""What the classes of a picture look like on paper: read from the pages' style sheet, light colours."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

from service.web import assets

Colour = tuple[int, int, int]
_VARIABLE = re.compile(r"--([\w-]+):\s*(#[0-9a-fA-F]{6})")
_RULE = re.compile(r"^\.(pic-[\w-]+) \{([^}]*)\}", re.MULTILINE)
_PROPERTY = re.compile(r"([\w-]+):\s*([^;]+)")


@dataclass(frozen=True)
class Paint:
    """Fill and line of a shape; widths and dashes in units of the picture."""

    fill: Colour | None = None
    fill_opacity: float = 1.0
    stroke: Colour | None = None
    width: float = 1.0
    dashes: tuple[float, float] | None = None
    bold: bool = False


@cache
def paint_of(classes: str) -> Paint:
    """The paint of a shape with these classes; later rules of the style sheet go before earlier ones."""
    names, found = set(classes.split()), dict[str, str]()
    for name, properties in _rules():
        if name in names:
            found |= properties
    dashes = found.get("stroke-dasharray", "").split()
    return Paint(
        fill=_colour(found.get("fill")),
        fill_opacity=float(found.get("fill-opacity", 1.0)),
        stroke=_colour(found.get("stroke")),
        width=float(found.get("stroke-width", 1.0)),
        dashes=(float(dashes[0]), float(dashes[1])) if len(dashes) == 2 else None,
        bold=found.get("font-weight") == "700",
    )


@cache
def _rules() -> tuple[tuple[str, dict[str, str]], ...]:
    """Rules of the style sheet in order: class and properties; those within @media are indented and passed over."""
    return tuple((name, dict(_PROPERTY.findall(body))) for name, body in _RULE.findall(_style_sheet()))


@cache
def _variables() -> dict[str, str]:
    """Colours of the first :root, the light ones."""
    return dict(_VARIABLE.findall(_style_sheet().partition("}")[0]))


def _style_sheet() -> str:
    return assets.files()["pictures.css"].decode()


def _colour(value: str | None) -> Colour | None:
    if value is None or value.strip() == "none":
        return None
    text = _variables()[value.strip().removeprefix("var(--").removesuffix(")")]
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)
