"""Vibration of a sensor on polar paper: each run's vector, what the change of masses did, prediction and limit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from service.balancing.rotor.phasors import phasor
from service.engine import mapping
from service.model.correction import SensorVector
from service.model.machine import Machine, Sensor
from service.model.run import Run, RunOut
from service.web.pictures.angle_axis import arrow_head, compass_of
from service.web.pictures.drawing import Circle, Item, Line, Picture, Point, Words, group
from service.web.pictures.polar_axes import Paper, key_mark, sense_arrows
from service.web.pictures.reader import Reader
from service.web.pictures.words import mass_words, short
from service.web.units import Unit

WIDTH, RADIUS = 560.0, 200.0
CENTRE: Point = (WIDTH / 2, 262.0)
ROW = 22.0
MAX_RUNS = 24
"""Runs that are drawn: more hide each other."""
_BADGE = 11.0


@dataclass(frozen=True)
class Seen:
    """A run as one sensor saw it: internal vector and amplitude in the unit shown; no vector without phase."""

    run: Run
    vector: complex | None
    amplitude: float
    masses: tuple[complex, ...]


def polar_plot(
    machine: Machine,
    sensor: str,
    runs: Sequence[Run],
    reader: Reader,
    *,
    speed_rpm: float | None = None,
    run_out: Sequence[RunOut] = (),
    predicted: SensorVector | None = None,
    close_up: bool = False,
    legend: bool = True,
) -> Picture:
    """Draw the vectors of a sensor at one nominal speed (default: the service speed).

    Excluded runs are left out, run-out is subtracted; of more than `MAX_RUNS` the first and the latest are drawn.
    predicted: what a plan or correction leads one to expect, with the circle that its interval spans. close_up: only as
    far as prediction and limit reach, for what is near the centre; longer vectors are left out. legend: say every run
    as text below. Angles as in `compass`.
    """
    _ = reader.gettext
    spec = next(s for s in machine.sensors if s.name == sensor)
    speed = machine.service_speed_rpm if speed_rpm is None else speed_rpm
    shown = reader.amplitude_unit(spec)
    seen = _latest([s for run in runs if (s := _seen(machine, spec, run, run_out, speed, shown)) is not None])
    limit = mapping.limit_of(machine, mapping.Channel(spec, speed))
    marks = _Marks(machine, shown, predicted, None if limit is None else shown.show(limit))
    paper = Paper(compass_of(machine, CENTRE), RADIUS, marks.highest(seen, close_up))
    seen = [s for s in seen if s.amplitude <= paper.rings[-1] * 1.0001]
    items: list[Item] = [*marks.area(paper), *paper.grid(reader, machine.phase_sense), *marks.edge(paper)]
    items += _arrows(paper, seen) + _vectors(paper, seen) + marks.prediction(paper)
    items.append(key_mark((CENTRE[0], CENTRE[1] - RADIUS + 14.0)))
    counted = _("phase (lag)") if machine.phase_sense == "lag" else _("phase (lead)")
    items += sense_arrows(paper.compass, RADIUS + 32.0, machine.phase_sense, counted, _("rotation"))
    rows = _legend(seen, marks, reader, spec)
    if legend:
        items += [item for index, row in enumerate(rows) for item in _legend_row(index, row)]
    title = _("%(sensor)s at %(speed)s, %(unit)s") % {
        "sensor": sensor,
        "speed": reader.show.speed(speed),
        "unit": reader.gettext(shown.sign),
    }
    items.append(Words((WIDTH / 2, 20.0), title, "pic-title", size=17.0))
    height = CENTRE[1] + RADIUS + (44.0 + ROW * len(rows) if legend else 30.0)
    return Picture(WIDTH, height, title, "; ".join(text for _cls, text in rows), tuple(items))


def _latest(seen: list[Seen]) -> list[Seen]:
    """The first run, which all others are compared with, and the latest."""
    return seen if len(seen) <= MAX_RUNS else [seen[0], *seen[1 - MAX_RUNS :]]


@dataclass(frozen=True)
class _Marks:
    """What is marked beside the runs: the predicted vector with its circle, and the limit (as shown)."""

    machine: Machine
    shown: Unit
    predicted: SensorVector | None
    limit: float | None

    @property
    def vector(self) -> complex | None:
        """The predicted vector as shown."""
        if self.predicted is None:
            return None
        return phasor(self.shown.show(self.predicted.amplitude), self.predicted.phase_deg, self.machine.phase_sense)

    @property
    def spread(self) -> float:
        """Radius, as shown, of the circle about the predicted vector; 0 where it cannot be known."""
        if self.predicted is None or self.predicted.interval is None:
            return 0.0
        return self.shown.show(max(0.0, self.predicted.interval.high - self.predicted.amplitude))

    def highest(self, seen: Sequence[Seen], close_up: bool) -> float:
        """The value that has to fit on the paper."""
        near = [self.limit or 0.0, abs(self.vector or 0.0) + self.spread]
        if close_up and max(near) > 0.0:
            return 1.5 * max(near)
        return max([*near, *(s.amplitude for s in seen)], default=1.0)

    def area(self, paper: Paper) -> list[Item]:
        """The area within the limit."""
        return [Circle(CENTRE, self.limit * paper.scale, "pic-within")] if self.limit else []

    def edge(self, paper: Paper) -> list[Item]:
        """The limit itself."""
        return [Circle(CENTRE, self.limit * paper.scale, "pic-limit")] if self.limit else []

    def prediction(self, paper: Paper) -> list[Item]:
        """The predicted vector, dashed, a diamond at its tip, in the circle that holds the true one."""
        if self.vector is None or abs(self.vector) * paper.scale > RADIUS * 1.001:
            return []
        x, y = paper.tip(self.vector)
        diamond = ((x, y - 7.0), (x + 7.0, y), (x, y + 7.0), (x - 7.0, y))
        region: list[Item] = [Circle((x, y), self.spread * paper.scale, "pic-region")] if self.spread else []
        return [*region, Line((CENTRE, (x, y)), "pic-predicted"), Line(diamond, "pic-predicted-tip", True)]


def _seen(
    machine: Machine, sensor: Sensor, run: Run, run_out: Sequence[RunOut], speed: float, shown: Unit
) -> Seen | None:
    """The run as the sensor saw it; None where it is excluded, at another speed, or has no reading of it."""
    amplitude = mapping.amplitudes_of(machine, run, run_out).get(sensor.name)
    if run.excluded or run.nominal_speed_rpm != speed or amplitude is None:
        return None
    vector = mapping.vectors_with_phase(machine, run, run_out).get(sensor.name)
    masses = tuple(complex(m) for m in mapping.mass_vectors(machine, run.masses))
    return Seen(run, None if vector is None else vector / shown.size, shown.show(amplitude), masses)


def _reference(seen: Sequence[Seen], index: int) -> Seen | None:
    """The earlier run that differs from this one by masses in the fewest planes, the first of equals; None for none."""

    def planes(other: Seen) -> int:
        return sum(abs(a - b) > 1e-9 for a, b in zip(seen[index].masses, other.masses, strict=True))

    earlier = [s for s in seen[:index] if s.vector is not None and planes(s) > 0]
    return min(earlier, key=planes, default=None)


def _arrows(paper: Paper, seen: Sequence[Seen]) -> list[Item]:
    """From run to run: what the change of masses did."""
    out: list[Item] = []
    for index, one in enumerate(seen):
        reference = _reference(seen, index)
        if one.vector is None or reference is None or reference.vector is None:
            continue
        begin, end = paper.tip(reference.vector), paper.tip(one.vector)
        if math.dist(begin, end) > 6.0:
            out += [Line((begin, end), "pic-influence"), arrow_head(begin, end, "pic-influence-head", 11.0)]
    return out


def _vectors(paper: Paper, seen: Sequence[Seen]) -> list[Item]:
    """Each run's vector with its number; a circle where there is no phase."""
    out: list[Item] = []
    taken: list[Point] = []
    for one in seen:
        kind = one.run.kind
        if one.vector is None:
            out.append(Circle(CENTRE, one.amplitude * paper.scale, f"pic-amplitude pic-{kind}"))
            tip = (CENTRE[0] + one.amplitude * paper.scale * 0.5, CENTRE[1] + one.amplitude * paper.scale * 0.866)
        else:
            tip = paper.tip(one.vector)
            out += [Line((CENTRE, tip), f"pic-vector pic-{kind}"), Circle(tip, 4.0, f"pic-{kind}-fill")]
        where = _free_place(tip, taken)
        taken.append(where)
        out.append(_badge(where, one))
    return out


def _badge(where: Point, one: Seen) -> Item:
    number = Words((where[0], where[1] + 4.5), str(one.run.number), "pic-badge-words", size=13.0)
    return group((Circle(where, _BADGE, f"pic-badge pic-{one.run.kind}-fill"), number))


def _free_place(tip: Point, taken: Sequence[Point]) -> Point:
    """A place beside a tip where no number stands yet; outwards first."""
    out = math.atan2(tip[1] - CENTRE[1], tip[0] - CENTRE[0]) if math.dist(tip, CENTRE) > 1.0 else -math.pi / 2
    for reach in (18.0, 30.0, 44.0, 60.0):
        for turn in (0.0, 0.8, -0.8, 1.6, -1.6, 2.4, -2.4, math.pi):
            place = (tip[0] + reach * math.cos(out + turn), tip[1] + reach * math.sin(out + turn))
            if all(math.dist(place, other) > 2.0 * _BADGE for other in taken):
                return place
    return tip[0], tip[1] - 18.0


def _legend(seen: Sequence[Seen], marks: _Marks, reader: Reader, sensor: Sensor) -> list[tuple[str, str]]:
    """Class and words of each line below the plot."""
    _ = reader.gettext
    names = {
        "initial": _("as found"),
        "trial": _("trial"),
        "check": _("check"),
        "correction": _("with corrections"),
    }
    out: list[tuple[str, str]] = []
    for one in seen:
        reading = reader.number(one.amplitude)
        if one.vector is not None:
            stated = next(r for r in one.run.readings if r.sensor == sensor.name)
            reading += f" @ {reader.angle(stated.phase_deg or 0.0)}"
        fitted = mass_words(one.run.masses, reader, most=2)
        words = f"{names[one.run.kind]}: {reading}" + (f" ({fitted})" if fitted else "")
        out.append((f"{one.run.kind} {one.run.number}", words))
    if marks.predicted is not None:
        value = reader.number(marks.shown.show(marks.predicted.amplitude))
        words = f"{value} @ {reader.angle(marks.predicted.phase_deg)}"
        out.append(("predicted", _("predicted: %(value)s") % {"value": words}))
    if marks.limit is not None:
        out.append(("limit", _("limit: %(value)s") % {"value": reader.number(marks.limit)}))
    return out


def _legend_row(index: int, row: tuple[str, str]) -> list[Item]:
    kind, text = row
    x, y = 60.0, CENTRE[1] + RADIUS + 50.0 + ROW * index
    sample: list[Item]
    if kind == "limit":
        sample = [Line(((x - 14.0, y), (x + 14.0, y)), "pic-limit")]
    elif kind == "predicted":
        diamond = ((x + 7.0, y - 7.0), (x + 14.0, y), (x + 7.0, y + 7.0), (x, y))
        sample = [Line(((x - 14.0, y), (x + 7.0, y)), "pic-predicted"), Line(diamond, "pic-predicted-tip", True)]
    else:
        name, number = kind.split()
        badge = Words((x, y + 4.5), number, "pic-badge-words", size=13.0)
        sample = [Circle((x, y), _BADGE - 1.0, f"pic-badge pic-{name}-fill"), badge]
    return [*sample, Words((x + 24.0, y + 5.0), short(text, 64), "pic-words", "start", 14.0)]
