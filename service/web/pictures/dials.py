"""Dials of a live reading: amplitude, phase, steadiness. Drawn still; a script may turn the needles.

Without a reading the needle is drawn hidden, for a script to show: no dial points at what no one measured.
A needle is a group with `data-dial`. Amplitude: it stands at `data-from` degrees for 0 and at `data-to` for `data-top`
(stored unit). Phase: it stands at `data-sign` times the stated phase in degrees. 0 degrees is up, clockwise.
"""

from __future__ import annotations

import math

from service.model.machine import Machine, Sensor
from service.usecases.sessions.live import SensorNow
from service.web.pictures.angle_axis import Compass, compass_of
from service.web.pictures.drawing import Circle, Group, Item, Line, Picture, Point, Words
from service.web.pictures.polar_axes import key_mark
from service.web.pictures.reader import Reader
from service.web.pictures.scales import ticks

SIZE, HEIGHT = 220.0, 236.0
CENTRE: Point = (SIZE / 2, 100.0)
RADIUS = 84.0
NOTHING = "\N{EM DASH}"
BEGIN_DEG, END_DEG = -120.0, 120.0
_UP = Compass(clockwise=True, centre=CENTRE)


def amplitude_dial(
    sensor: Sensor, amplitude: float | None, reader: Reader, *, limit: float | None = None, top: float | None = None
) -> Picture:
    """Draw an amplitude (stored unit; None: no reading) on a scale that is green up to the limit and red above.

    top: value of the full scale in the stored unit; default: round and above both amplitude and limit.
    """
    unit = reader.amplitude_unit(sensor)
    marks = ticks(unit.show(top or max(1.25 * (amplitude or 0.0), 2.0 * (limit or 0.0)) or 1.0), 4)
    full = unit.store(marks[-1])
    items: list[Item] = [Line(_arc(0.0, 1.0), "pic-scale")]
    if limit is not None:
        share = min(limit / full, 1.0)
        items += [Line(_arc(0.0, share), "pic-scale-within"), Line(_arc(share, 1.0), "pic-scale-over")]
    for value in (0.0, *marks):
        angle = math.radians(_turn(value / marks[-1]))
        x, y = _UP.point(RADIUS - 22.0, angle)
        items.append(Line((_UP.point(RADIUS - 8.0, angle), _UP.point(RADIUS + 8.0, angle)), "pic-axis"))
        items.append(Words((x, y + 5.0), reader.number(value), "pic-small", size=16.0))
    data = (("dial", "amplitude"), ("top", f"{full:.9g}"), ("from", f"{BEGIN_DEG:g}"), ("to", f"{END_DEG:g}"))
    items.append(_needle(None if amplitude is None else _turn(min(amplitude / full, 1.05)), data))
    text = NOTHING if amplitude is None else reader.number(unit.show(amplitude))
    items.append(Words((CENTRE[0], HEIGHT - 36.0), text, "pic-strong", size=30.0))
    items.append(Words((CENTRE[0], HEIGHT - 12.0), reader.gettext(unit.sign), "pic-small", size=18.0))
    title = reader.gettext("amplitude of %(sensor)s") % {"sensor": sensor.name}
    said = reader.gettext("no value yet") if amplitude is None else f"{text} {reader.gettext(unit.sign)}"
    return Picture(SIZE, HEIGHT, title, said, tuple(items))


def phase_dial(machine: Machine, sensor: Sensor, phase_deg: float | None, reader: Reader) -> Picture:
    """Draw a phase as on the polar plot: same mark, same sense; None: there is no key-phasor."""
    compass = compass_of(machine, CENTRE)
    items: list[Item] = [Circle(CENTRE, RADIUS, "pic-rim"), key_mark((CENTRE[0], CENTRE[1] - RADIUS + 12.0))]
    for degrees in range(0, 360, 30):
        outer = compass.at(RADIUS, degrees, machine.phase_sense)
        inner = compass.at(RADIUS - 8.0, degrees, machine.phase_sense)
        items.append(Line((inner, outer), "pic-axis"))
        if degrees % 90 == 0 and degrees:
            x, y = compass.at(RADIUS - 24.0, degrees, machine.phase_sense)
            items.append(Words((x, y + 5.0), f"{degrees}", "pic-small", size=16.0))
    way = 1 if compass.clockwise == (machine.phase_sense == "lag") else -1
    items.append(_needle(None if phase_deg is None else way * phase_deg, (("dial", "phase"), ("sign", str(way)))))
    text = NOTHING if phase_deg is None else reader.angle(phase_deg)
    items.append(Words((CENTRE[0], HEIGHT - 12.0), text, "pic-strong", size=30.0))
    title = reader.gettext("phase of %(sensor)s") % {"sensor": sensor.name}
    return Picture(SIZE, HEIGHT, title, reader.gettext("no value yet") if phase_deg is None else text, tuple(items))


def steady_light(now: SensorNow | None, reader: Reader) -> Picture:
    """Draw whether a sensor is steady: a tick in green, waves in red, a bar where nothing comes; shape says it too."""
    x, y = CENTRE
    if now is None:
        items: tuple[Item, ...] = (Circle(CENTRE, RADIUS, "pic-silent"), _bar("pic-silent-sign"))
        words = reader.gettext("no reading")
    elif now.steady:
        tick = Line(((x - 40.0, y + 2.0), (x - 12.0, y + 32.0), (x + 42.0, y - 32.0)), "pic-steady-sign")
        items = (Circle(CENTRE, RADIUS, "pic-steady"), tick)
        words = reader.gettext("steady")
    else:
        waves = (Line(_wave(y + 24.0 * row), "pic-unsteady-sign") for row in (-1, 0, 1))
        items = (Circle(CENTRE, RADIUS, "pic-unsteady"), *waves)
        words = reader.gettext("not steady yet")
    items = (*items, Words((x, HEIGHT - 14.0), words, "pic-strong", size=20.0))
    return Picture(SIZE, HEIGHT, words, words, items)


def _turn(share: float) -> float:
    return BEGIN_DEG + share * (END_DEG - BEGIN_DEG)


def _arc(begin: float, end: float) -> tuple[Point, ...]:
    steps = max(2, int(60 * (end - begin)))
    return tuple(_UP.point(RADIUS, math.radians(_turn(begin + (end - begin) * i / steps))) for i in range(steps + 1))


def _needle(turn_deg: float | None, data: tuple[tuple[str, str], ...]) -> Group:
    """The hand, turned; of no value it is there for a script to turn, and hidden."""
    x, y = CENTRE
    hand = Line(((x - 5.0, y + 12.0), (x, y - RADIUS + 14.0), (x + 5.0, y + 12.0)), "pic-needle-hub", closed=True)
    cls = "pic-needle pic-absent" if turn_deg is None else "pic-needle"
    return Group((hand, Circle(CENTRE, 8.0, "pic-needle-hub")), cls, turn_deg or 0.0, CENTRE, data)


def _bar(cls: str) -> Line:
    return Line(((CENTRE[0] - 36.0, CENTRE[1]), (CENTRE[0] + 36.0, CENTRE[1])), cls)


def _wave(y: float) -> tuple[Point, ...]:
    return tuple((CENTRE[0] - 44.0 + 4.0 * i, y + 7.0 * math.sin(i * 4.0 * math.pi / 22.0)) for i in range(23))
