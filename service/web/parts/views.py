"""An arrangement as a page and paper show it: places with their parts, pictures, figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from service.model.arrangement import Arrangement, Mounted
from service.model.machine import AngleSense, Machine
from service.model.parts import Mass, PartRecord, Place
from service.web.display import Display
from service.web.pictures.drawing import Picture
from service.web.pictures.part_places import PlacedPart, State, from_the_end, unrolled
from service.web.pictures.reader import Reader


@dataclass(frozen=True)
class Figures:
    """What an order leaves, each in two parts as `parted` tells it; none of them where it is not known."""

    best: tuple[str, str]
    now: tuple[str, str] | None
    rule: tuple[str, str] | None
    times: float | None
    """How many times as much the maker's rule leaves."""
    scale: str | None
    """What the scale makes of it, one standard deviation."""


def placed(made: Arrangement) -> list[PlacedPart]:
    """Every place with its part, as mounted or as proposed."""
    inside = {one.place: one.part for one in made.mounted or made.arrangement}
    before = {part.present: part.id for part in made.request.parts if part.present is not None and part.may != "gone"}
    return [_one(place, inside.get(place.label), before.get(place.label)) for place in made.places]


def present(places: Sequence[Place], records: Sequence[PartRecord]) -> list[PlacedPart]:
    """Every place of a set with what is in it now."""
    inside = {one.place: one.part for one in records if one.place is not None}
    return [_one(place, inside.get(place.label), inside.get(place.label)) for place in places]


def pictures(
    machine: Machine | None, places: Sequence[PlacedPart], reader: Reader, made: Arrangement | None = None
) -> tuple[Picture, Picture]:
    """The drum from the end, and unrolled."""
    sense: AngleSense = "against_rotation"
    planes: list[tuple[str, float]] = []
    if machine is not None:
        sense = machine.angle_sense
        planes = [(plane.name, plane.axial_mm) for plane in machine.planes if plane.axial_mm is not None]
    elif made is not None:
        sense = made.request.angle_sense or sense
        planes = [(str(n), at) for n, at in enumerate(made.request.planes_axial_mm or (), 1)]
    done = made is not None and made.state == "mounted"
    return from_the_end(machine, sense, places, reader, done=done), unrolled(planes, places, reader, done=done)


def figures(made: Arrangement, reader: Reader) -> Figures:
    """The objective of the order, of the present one, and of the maker's rule."""
    rule = made.makers_rule
    times = None
    if rule is not None and made.objective_value:
        times = rule.objective_value / made.objective_value
    return Figures(
        best=parted(made, made.objective_value, reader),
        now=None if made.objective_now is None else parted(made, made.objective_now, reader),
        rule=None if rule is None else parted(made, rule.objective_value, reader),
        times=times,
        scale=None if made.objective_scatter is None else objective(made, made.objective_scatter, reader),
    )


def objective(made: Arrangement, value: float | None, reader: Reader) -> str:
    """An objective with its unit, in a sentence."""
    figure, means = parted(made, value, reader)
    return f"{figure} ({means})" if made.objective_unit == "g.mm" and means else f"{figure} {means}".strip()


def parted(made: Arrangement, value: float | None, reader: Reader) -> tuple[str, str]:
    """An objective and what it is: the mass at the parts' radius, and its unbalance; or a share, and of what."""
    show, _ = reader.show, reader.gettext
    if value is None:
        return "\N{EM DASH}", ""
    if made.objective_unit == "g.mm":
        grams = value / made.places[0].radius_mm
        # What is less than a milligram is nothing on any scale for such parts.
        return show.mass(0.0 if grams < 1e-3 else grams), _("at the parts: %(unbalance)s") % {
            "unbalance": show.unbalance(value)
        }
    share = show.percent(value) if value >= 0.1 else f"{reader.number(100.0 * value)} %"
    if made.request.objective == "residual_vibration":
        return share, _("of the vibration limit")
    return share, _("of the forces now")


def mass(show: Display, reading: Mass) -> str:
    """A mass as it was weighed: one, or both ends."""
    if isinstance(reading, tuple):
        return " + ".join(show.mass(one) for one in reading)
    return show.mass(reading)


def masses_by_part(made: Arrangement) -> Mapping[str, Mass]:
    """What each part was weighed with."""
    return {part.id: part.mass_g for part in made.request.parts}


def differing(made: Arrangement) -> tuple[Mounted, ...]:
    """Places whose part an arrangement changes, as it is to be."""
    moved = {move.to for move in made.moves} | {move.leaves for move in made.moves}
    return tuple(one for one in made.arrangement if one.place in moved or not made.moves)


def _one(place: Place, part: str | None, before: str | None) -> PlacedPart:
    state: State = "empty" if part is None else "stays" if part == before else "comes"
    return PlacedPart(place.label, place.angle_deg, place.axial_mm, part, state)
