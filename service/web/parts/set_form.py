"""The form of a set of places: rings round the drum, one behind the other along the shaft."""

from __future__ import annotations

import numpy as np

from service.model.parts import MAX_PLACES, Place
from service.web.forms import Form
from service.web.language import N_
from service.web.rendering import Page

KINDS = {"alike": N_("all alike"), "alternating": N_("left and right in turn")}
SIDES = (N_("left"), N_("right"))
NAME = N_("rasp bars")


def blank(page: Page) -> Form:
    """An empty form, of eight bars."""
    values = {"around": "8", "along": "1", "first_deg": "0", "stagger_deg": "0", "kinds": "alike"}
    return Form(values | {"name": page.text(NAME)}, page.preferences)


def read(page: Page, form: Form) -> tuple[str, tuple[Place, ...]] | None:
    """Name and places that were typed; None where a field is wrong."""
    length = page.display.length_unit()
    name = form.text("name", required=True)
    around = form.whole("around", low=1, high=MAX_PLACES)
    along = form.whole("along", low=1, high=MAX_PLACES, required=False) or 1
    first = form.angle("first_deg", required=False) or 0.0
    stagger = form.angle("stagger_deg", required=False) or 0.0
    radius = form.number("radius_mm", above=0.0, high=1e5, unit=length)
    axial = form.number("axial_mm", low=-1e5, high=1e5, unit=length)
    end = form.number("axial_end_mm", low=-1e5, high=1e5, unit=length, required=along > 1)
    kinds = form.choice("kinds", KINDS, required=False) or "alike"
    if name is not None and "/" in name:
        form.wrong("name", N_("This name must have no “/” in it."))
    if around is not None and around * along > MAX_PLACES:
        form.wrong("around", N_("At most %(most)s places."), most=MAX_PLACES)
    if not form.ok or name is None or around is None or radius is None or axial is None:
        return None
    rings = [(axial,) if end is None else (axial, end)] if along == 1 else _rings(axial, end or 0.0, along)
    places = tuple(
        Place(
            label=str(ring * around + n + 1),
            angle_deg=round((first + ring * stagger + 360.0 * n / around) % 360.0, 6),
            radius_mm=radius,
            axial_mm=at,
            kind=None if kinds == "alike" else page.text(SIDES[n % 2]),
        )
        for ring, at in enumerate(rings)
        for n in range(around)
    )
    return name, places


def _rings(first: float, last: float, count: int) -> list[tuple[float, ...]]:
    return [(float(at),) for at in np.linspace(first, last, count)]
