"""A picture as SVG text: no colours, only classes, so that a page can be light, dark or printed."""

from __future__ import annotations

from html import escape

from markupsafe import Markup

from service.web.pictures.drawing import Circle, Group, Item, Line, Picture, Words
from service.web.pictures.palette import css


def to_svg(picture: Picture, *, standalone: bool = False) -> Markup:
    """Inline SVG text of a picture, as wide as its place; standalone: with the name space that a file needs."""
    space = ' xmlns="http://www.w3.org/2000/svg"' if standalone else ""
    head = (
        f'<svg{space} class="pic" role="img" viewBox="0 0 {_n(picture.width)} {_n(picture.height)}"'
        f' aria-label="{escape(picture.title)}">'
        f"<title>{escape(picture.title)}</title><desc>{escape(picture.description)}</desc>"
    )
    return Markup(head + "".join(map(_item, picture.items)) + "</svg>")  # noqa: S704 every text is escaped below


def to_file(picture: Picture) -> str:
    """SVG text of a picture as a file that stands alone: light, with its own colours, at the picture's size."""
    size = f' width="{_n(picture.width)}" height="{_n(picture.height)}"'
    style = f"<style>text{{font-family:sans-serif}}\n{css(plain=True)}</style>"
    text = str(to_svg(picture, standalone=True)).replace("<svg", f"<svg{size}", 1)
    ground = '<rect width="100%" height="100%" fill="#ffffff"/>'
    return text.replace("</desc>", f"</desc>{style}{ground}", 1)


def _item(item: Item) -> str:
    match item:
        case Line(points, cls, closed):
            tag = "polygon" if closed else "polyline"
            if len(points) == 2:
                (x1, y1), (x2, y2) = points
                return f'<line class="{cls}" x1="{_n(x1)}" y1="{_n(y1)}" x2="{_n(x2)}" y2="{_n(y2)}"/>'
            corners = " ".join(f"{_n(x)},{_n(y)}" for x, y in points)
            return f'<{tag} class="{cls}" points="{corners}"/>'
        case Circle((x, y), radius, cls):
            return f'<circle class="{cls}" cx="{_n(x)}" cy="{_n(y)}" r="{_n(radius)}"/>'
        case Words((x, y), text, cls, anchor, size):
            return (
                f'<text class="{cls}" x="{_n(x)}" y="{_n(y)}" text-anchor="{anchor}" font-size="{_n(size)}">'
                f"{escape(text)}</text>"
            )
        case Group():
            return _group(item)


def _group(item: Group) -> str:
    attributes = f' class="{item.cls}"' if item.cls else ""
    if item.turn_deg or item.about != (0.0, 0.0):
        x, y = item.about
        attributes += f' transform="rotate({_n(item.turn_deg)} {_n(x)} {_n(y)})"'
    attributes += "".join(f' data-{name}="{escape(value)}"' for name, value in item.data)
    title = f"<title>{escape(item.title)}</title>" if item.title else ""
    return f"<g{attributes}>{title}{''.join(map(_item, item.items))}</g>"


def _n(value: float) -> str:
    """A coordinate to a tenth of a unit, as short as it goes."""
    return f"{round(value, 1) + 0.0:g}" if abs(value) < 1e5 else f"{value:.1f}"
