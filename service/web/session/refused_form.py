"""Show what a refused form held next to the newer state, so that nothing typed is lost."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from service.errors import NotFound
from service.model.machine import Machine
from service.usecases.stock import catalogues
from service.web.language import N_
from service.web.rendering import Page
from service.web.session.guide import Guide

TICKED = "\N{CHECK MARK}"
LONGEST = 100
"""Of a field, in signs: more is no figure and no name."""
_INDEXED = re.compile(r"(readings|masses|actual)\[(\d{1,3})\]\.(\w+)")
_ASKED = (
    (r"runs/take", N_("Take this run")),
    (r"runs", N_("Store this run")),
    (r"stops/\d+/lock", N_("Locked, go on")),
    (r"stops/\d+/trial", N_("The mass is bolted on")),
    (r"stops/\d+/bare", N_("All of them are off")),
    (r"stops/\d+/release", N_("Ready to run")),
    (r"stops/\d+/cancel", N_("Back, nothing was changed")),
    (r"plans", N_("Find the best")),
    (r"box", N_("Use this box")),
    (r"teach", N_("Teach the machine")),
    (r"close", N_("Close the session")),
)
_BY_FIELD = (
    (r"runs/.+/exclude", "excluded", {"yes": N_("Leave out"), "no": N_("Take in again")}, N_("Leave out")),
    (
        r"corrections",
        "source",
        {"balancer": N_("Use these masses"), "saved_influence": N_("Use what the machine taught")},
        N_("Compute"),
    ),
    (r"stops", "purpose", {"trial": N_("Stop the machine to bolt it on"), "plan": N_("Fit this")}, N_("Fit this")),
    (r"stops/\d+/plan", "differs", {"yes": N_("This is bolted on")}, N_("All is bolted on as shown")),
)
_TICKS = {
    "standstill": N_("The drum stands still"),
    "key_out": N_("The key is out, and in my pocket"),
    "blocked": N_("The drum is blocked so that it cannot turn"),
    "torqued": N_("Every bolt is torqued"),
    "tools_out": N_("Tools are out, the block is off the drum"),
    "guards_on": N_("Guards are on, nobody is in reach"),
    "keep": N_("No, the earlier trial mass stays on"),
    "anyway": N_("Take it although it is not steady"),
}
_MODES = {"best": N_("the best of all"), "fewest": N_("fewest pieces within the limits")}
_AIMS = {
    "residual_vibration": N_("least vibration"),
    "components": N_("nearest to the masses needed"),
    "bearing_force": N_("least force on the bearings"),
    "robust": N_("least vibration in spite of the scatter"),
}


@dataclass(frozen=True)
class KeptField:
    """One field as it was typed: what it is called, what stands in it, its unit."""

    label: str
    text: str
    unit: str = ""


@dataclass(frozen=True)
class Kept:
    """A form that was refused: the words of its button, and its fields."""

    asked: str
    fields: tuple[KeptField, ...]


def kept(page: Page, guide: Guide, typed: dict[str, str]) -> Kept:
    """The refused form that `page` was sent, as its own page named it."""
    return Kept(page.text(_asked(page, typed)), tuple(_fields(page, guide, typed)))


def _asked(page: Page, typed: dict[str, str]) -> str:
    path = page.request.url.path.split("/", 3)[-1]
    for pattern, field, words, otherwise in _BY_FIELD:
        if re.fullmatch(pattern, path):
            return words.get(typed.get(field, ""), otherwise)
    if path.endswith("/again"):
        struck = N_("Piece is not in the box") if typed.get("missing_g") else N_("Hole cannot be used")
        return N_("Use all holes again") if typed.get("clear") else struck
    return next((words for pattern, words in _ASKED if re.fullmatch(pattern, path)), N_("Store"))


def _fields(page: Page, guide: Guide, typed: dict[str, str]) -> Iterator[KeptField]:
    for name, value in typed.items():
        text = value.strip()[:LONGEST]
        found = _field(page, guide, name, text) if text else None
        if found is not None:
            yield found


def _field(page: Page, guide: Guide, name: str, text: str) -> KeptField | None:
    indexed = _INDEXED.fullmatch(name)
    if indexed is not None:
        return _of_row(page, guide.session.machine, indexed[1], int(indexed[2]), indexed[3], text)
    if name in _TICKS:
        return KeptField(page.text(_TICKS[name]), TICKED)
    grams = page.display.mass_unit().sign
    simple = {
        "speed_rpm": (N_("Speed"), page.text(N_("r/min"))),
        "masses.mass_g": (N_("Mass, with its bolt"), grams),
        "masses.angle_deg": (N_("Hole"), "°"),
        "max_masses_per_plane": (N_("Pieces in a plane, at most"), ""),
        "blocked_deg": (N_("Hole"), "°"),
        "missing_g": (N_("Mass"), "g"),
        "reason": (N_("Reason"), ""),
    }
    if name in simple:
        label, unit = simple[name]
        return KeptField(page.text(label), text, unit)
    if name in ("plane", "blocked_plane"):
        return KeptField(page.text(N_("Plane")), text)
    if name == "mode":
        return KeptField(page.text(N_("How many pieces")), page.text(_MODES.get(text, text)))
    if name == "objective":
        return KeptField(page.text(N_("Aim")), page.text(_AIMS.get(text, text)))
    return KeptField(page.text(N_("Box")), _box(page, text)) if name == "catalogue_id" else None


def _of_row(page: Page, machine: Machine, rows: str, index: int, name: str, text: str) -> KeptField | None:
    """A field of a table: of a sensor, of a plane, of a piece."""
    grams = page.display.mass_unit().sign
    if rows == "readings" and index < len(machine.sensors):
        sensor = machine.sensors[index]
        units = {"amplitude": page.display.amplitude_unit(sensor).sign, "phase_deg": "°"}
        labels = {"amplitude": N_("Amplitude"), "phase_deg": N_("Phase")}
        whose = sensor.name
    elif rows == "masses" and index < len(machine.planes):
        labels, units = {"mass_g": N_("Mass"), "angle_deg": N_("Angle")}, {"mass_g": grams, "angle_deg": "°"}
        whose = page.text(N_("Plane %(plane)s"), plane=machine.planes[index].name)
    else:
        labels = {"position_deg": N_("Really in"), "mass_g": N_("Really the piece"), "weighed_g": N_("Weighed")}
        labels["left_out"] = N_("Not fitted")
        units = {"position_deg": "°", "mass_g": "g", "weighed_g": grams}
        whose = page.text(N_("Piece %(number)s"), number=index + 1)
    if name not in labels:
        return None
    return KeptField(f"{whose}: {page.text(labels[name])}", TICKED if name == "left_out" else text, units.get(name, ""))


def _box(page: Page, key: str) -> str:
    try:
        return catalogues.get(page.work, key).name
    except NotFound:
        return key
