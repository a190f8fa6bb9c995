"""What the classes of a picture look like on paper: the rules of the palette, light colours."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from service.web.pictures.palette import LIGHT, RULES

Colour = tuple[int, int, int]


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
    for name, properties in RULES:
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


def _colour(name: str | None) -> Colour | None:
    if name is None or name == "none":
        return None
    text = LIGHT[name]
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)
