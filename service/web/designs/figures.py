"""The pictures that a design offers, by kind: the same on pages, in reports and at the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from service.model.design import DesignCurve, DesignEvaluation, DesignFront
from service.web.designs.names import CURVES, RESPONSES, name_of
from service.web.pictures.designs.comparing import bars, front
from service.web.pictures.designs.curves import Named, chart, hodograph
from service.web.pictures.designs.linkage import Scene, linkage_picture
from service.web.pictures.designs.shapes import Outline, gears, section
from service.web.pictures.drawing import Picture
from service.web.pictures.reader import Reader

KINDS = ("linkage", "hodograph", "force", "moment", "section", "stress", "gears", "bars")
"""Kinds of picture of a design; a front is one more, of a run."""


@dataclass(frozen=True)
class Figures:
    """Pictures of a design, next to another one where that is given. names: of the two."""

    shown: DesignEvaluation
    before: DesignEvaluation | None
    reader: Reader

    @property
    def names(self) -> tuple[str, str]:
        """What the two designs are called."""
        _ = self.reader.gettext
        return _("present"), _("optimum") if self.before is not None else _("this design")

    def all(self) -> dict[str, Picture]:
        """Every picture that the design offers, by kind."""
        made = {kind: _MAKERS[kind](self) for kind in KINDS if kind in self.kinds()}
        return {kind: picture for kind, picture in made.items() if picture is not None}

    def kinds(self) -> tuple[str, ...]:
        """Kinds that the design offers."""
        drawn = str(self.shown.drawing.get("kind"))
        return _OFFERED.get(drawn, ())

    def scene(self) -> Scene | None:
        """What the animation moves, of a linkage."""
        return Scene.of(self.shown.drawing) if self.shown.drawing.get("kind") == "linkage" else None

    # ------------------------------------------------------------ kinds
    def linkage(self) -> Picture | None:
        """The linkage over a turn."""
        _ = self.reader.gettext
        scene = self.scene()
        if scene is None:
            return None
        words = _("%(links)s links with their joints and mass centres; thin lines: twelve positions of a turn")
        return linkage_picture(scene, _("The linkage over a turn"), words % {"links": len(scene.links)})

    def hodograph(self) -> Picture:
        """The shaking force as the path of its tip."""
        designs = [one for one in (self.before, self.shown) if one is not None]
        names = self.names if self.before is not None else (self.names[1],)
        paths = []
        for name, design in zip(names, designs, strict=True):
            x, y = (_curve(design, part) for part in ("force_x", "force_y"))
            paths.append(Named(name, x.y, y.y))
        unit = _curve(self.shown, "force_x").y_unit
        return hodograph(paths, self.reader, self.reader.gettext("Shaking force on the frame, hodograph"), unit)

    def force(self) -> Picture:
        """The shaking force over the turn."""
        return self._over_turn(self.reader.gettext("Shaking force on the frame over a turn"), ("force_x", "force_y"))

    def moment(self) -> Picture:
        """Shaking moment and driving torque over the turn."""
        return self._over_turn(
            self.reader.gettext("Moment on the frame and driving torque over a turn"), ("moment", "torque")
        )

    def section(self) -> Picture:
        """The section of the disc."""
        designs = [one for one in (self.before, self.shown) if one is not None]
        names = self.names if self.before is not None else (self.names[1],)
        thickness = _curve(self.shown, "thickness")
        outlines = [_outline(name, design) for name, design in zip(names, designs, strict=True)]
        title = self.reader.gettext("Section of the disc: thickness over the radius")
        return section(outlines, self.reader, title, thickness.y_unit)

    def stress(self) -> Picture:
        """Stresses over the radius, with the limit."""
        _ = self.reader.gettext
        curves = [_curve(self.shown, name) for name in ("stress_radial", "stress_hoop", "stress_equivalent")]
        named = [Named(name_of(CURVES, one.name, _), one.x, one.y) for one in curves]
        held = next((one for one in self.shown.responses.limits if one.code == "stress"), None)
        limit = None if held is None else (_("limit"), held.limit)
        units = (f"{_('radius')}, {curves[0].x_unit}", curves[0].y_unit)
        return chart(named, self.reader, _("Stresses over the radius"), units, limit=limit)

    def gears(self) -> Picture:
        """The pair's pitch circles."""
        drawing = self.shown.drawing
        title = self.reader.gettext("Pitch circles to scale")
        return gears(tuple(drawing["diameters"]), tuple(drawing["teeth"]), self.reader, title, "mm")

    def bars(self) -> Picture:
        """Vibration at each sensor without and with the masses."""
        _ = self.reader.gettext
        drawing = self.shown.drawing
        unit = next(one.unit for one in self.shown.responses.scalars if one.name == "largest").replace("um", "µm")
        rows = list(zip(drawing["sensors"], drawing["before"], drawing["after"], strict=True))
        names = (_("without masses"), _("with these masses"))
        return bars(rows, self.reader, _("Vibration at each sensor"), unit, names)

    def _over_turn(self, title: str, names: tuple[str, str]) -> Picture:
        _ = self.reader.gettext
        curves = [_curve(self.shown, name) for name in names]
        named = [Named(name_of(CURVES, one.name, _), one.x, one.y) for one in curves]
        return chart(
            named, self.reader, title, (f"{_('crank angle')}, {curves[0].x_unit}", curves[0].y_unit), turn=True
        )


_MAKERS: Mapping[str, Callable[[Figures], Picture | None]] = {
    "linkage": Figures.linkage,
    "hodograph": Figures.hodograph,
    "force": Figures.force,
    "moment": Figures.moment,
    "section": Figures.section,
    "stress": Figures.stress,
    "gears": Figures.gears,
    "bars": Figures.bars,
}
_OFFERED = {
    "linkage": ("linkage", "hodograph", "force", "moment"),
    "profile": ("section", "stress"),
    "gear_pair": ("gears",),
    "shaft_set": ("bars",),
}


def front_picture(found: DesignFront, reader: Reader, chosen: int | None = None) -> Picture:
    """The front of two responses."""
    points = [(one.first, one.second) for one in found.points]
    names = tuple(name_of(RESPONSES, name, reader.gettext) for name in found.names)
    return front(points, reader, reader.gettext("Designs that no other beats in both"), names, chosen)  # type: ignore[arg-type]


def _curve(design: DesignEvaluation, name: str) -> DesignCurve:
    return next(one for one in design.curves if one.name == name)


def _outline(name: str, design: DesignEvaluation) -> Outline:
    """The section in the document's unit; the drawing's control points are in m."""
    thickness = _curve(design, "thickness")
    size = thickness.x[-1] / design.drawing["radius"][-1]
    radii, heights = design.drawing["controls"]
    controls = tuple(size * one for one in radii), tuple(size * one for one in heights)
    return Outline(name, thickness.x, thickness.y, controls)
