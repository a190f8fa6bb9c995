"""Before and after: two bars a sensor and the limit, as text too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from service.model.machine import Machine
from service.model.report import BeforeAfter
from service.web.pictures.drawing import Item, Line, Picture, Point, Words
from service.web.pictures.reader import Reader
from service.web.pictures.words import short
from service.web.units import Unit

WIDTH = 640.0
LEFT, RIGHT = 20.0, 490.0
_ROW, _BAR = 100.0, 26.0
_TOP = 40.0
_HATCH = 9.0


def before_after(machine: Machine, lines: Sequence[BeforeAfter], reader: Reader) -> Picture:
    """Draw each sensor as found (hatched) and in the latest check run (full), with its limit.

    Sensors of one unit share one scale; else the bars of each sensor are drawn to their own.
    """
    _ = reader.gettext
    title = _("Vibration before and after balancing")
    sensors = {sensor.name: sensor for sensor in machine.sensors}
    units = [reader.amplitude_unit(sensors[line.sensor]) for line in lines]
    tops = [unit.show(_highest(line)) for line, unit in zip(lines, units, strict=True)]
    shared = len({unit.sign for unit in units}) == 1
    speeds = len({line.speed_rpm for line in lines}) > 1
    items: list[Item] = [Words((LEFT, 20.0), title, "pic-title", "start", 17.0)]
    described = []
    for index, (line, unit, own) in enumerate(zip(lines, units, tops, strict=True)):
        name = short(line.sensor, 40) + (f", {reader.show.speed(line.speed_rpm)}" if speeds else "")
        bars = _Bars(_TOP + _ROW * index, (RIGHT - LEFT) / ((max(tops) if shared else own) or 1.0), unit, reader)
        items += bars.drawn(line, name)
        described.append(bars.described(line, name))
    if not lines:
        described.append(_("no run as found yet"))
        items.append(Words((LEFT, _TOP + 30.0), described[0], "pic-words", "start", 15.0))
    return Picture(WIDTH, _TOP + _ROW * max(len(lines), 1), title, "; ".join(described), tuple(items))


def _highest(line: BeforeAfter) -> float:
    return max(line.before, line.after or 0.0, line.limit or 0.0)


@dataclass(frozen=True)
class _Bars:
    """The line of one sensor: where it begins, units of paper for 1 of the unit shown, the unit."""

    top: float
    scale: float
    unit: Unit
    reader: Reader

    def drawn(self, line: BeforeAfter, name: str) -> list[Item]:
        """Name, bars with their values, limit."""
        out: list[Item] = [Words((LEFT, self.top + 16.0), name, "pic-strong", "start", 16.0)]
        out += self._hatched(self.top + 24.0, self._width(line.before))
        out.append(self._value(self.top + 24.0, line.before, "pic-words", line.limit))
        if line.after is not None:
            cls = "pic-over" if line.within_limit is False else "pic-after"
            y, x = self.top + 24.0 + _BAR + 4.0, LEFT + max(self._width(line.after), 2.0)
            out.append(Line(((LEFT, y), (x, y), (x, y + _BAR), (LEFT, y + _BAR)), cls, closed=True))
            out.append(self._value(y, line.after, f"{cls}-words", line.limit, line.reduction))
        if line.limit is not None:
            x = LEFT + self._width(line.limit)
            out.append(Line(((x, self.top + 19.0), (x, self.top + 24.0 + 2 * _BAR + 9.0)), "pic-limit"))
            words = self.reader.gettext("limit: %(value)s") % {"value": self._text(line.limit)}
            out.append(Words((WIDTH - 12.0, self.top + 16.0), words, "pic-limit-words", "end", 14.0))
        return out

    def described(self, line: BeforeAfter, name: str) -> str:
        """The same as text."""
        _ = self.reader.gettext
        parts = [name, _("before: %(value)s") % {"value": self._text(line.before)}]
        if line.after is not None:
            parts.append(_("after: %(value)s") % {"value": self._text(line.after)})
        if line.limit is not None:
            parts.append(_("limit: %(value)s") % {"value": self._text(line.limit)})
        return ", ".join(parts)

    def _width(self, stored: float) -> float:
        return self.unit.show(stored) * self.scale

    def _text(self, stored: float) -> str:
        return f"{self.reader.number(self.unit.show(stored))} {self.reader.gettext(self.unit.sign)}"

    def _value(self, y: float, stored: float, cls: str, limit: float | None, reduction: float | None = None) -> Words:
        text = self._text(stored)
        if reduction is not None:
            text += f"  ({self.reader.signed(-100.0 * reduction, 3)} %)"
        # Right of the bar, and of the limit too, so that no line runs through it.
        return Words(
            (LEFT + max(self._width(stored), self._width(limit or 0.0)) + 10.0, y + 19.0), text, cls, "start", 15.0
        )

    def _hatched(self, y: float, width: float) -> list[Item]:
        """A bar with slanted lines in it."""
        width = max(width, 2.0)
        corners: tuple[Point, ...] = ((LEFT, y), (LEFT + width, y), (LEFT + width, y + _BAR), (LEFT, y + _BAR))
        out: list[Item] = [Line(corners, "pic-before", closed=True)]
        start = _HATCH
        while start < width + _BAR:
            begin, end = max(0.0, start - width), min(_BAR, start)
            out.append(Line(((LEFT + start - begin, y + begin), (LEFT + start - end, y + end)), "pic-hatch"))
            start += _HATCH
        return out
