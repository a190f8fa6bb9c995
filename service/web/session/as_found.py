"""What is known of a drum before its first run: pieces bolted on already, and the run-out of its shaft."""

from __future__ import annotations

from collections.abc import Iterator

from service.model.machine import Machine
from service.model.run import RunOut
from service.model.session import AsFoundPiece
from service.web.forms import Form
from service.web.language import N_
from service.web.rendering import Page
from service.web.session.guide import holes

PIECES = 6
"""Rows of the form; what is on a drum beyond them stays, and is part of it."""
MAY = {"stay": N_("stays"), "move": N_("may be moved"), "remove": N_("may be taken off")}
MAX_G, MAX_AMPLITUDE = 1e5, 1e6


def places(page: Page, machine: Machine) -> list[tuple[str, str]]:
    """Every hole of every plane, for a list: what is sent, and what is read."""
    out = []
    for index, plane in enumerate(machine.planes):
        for label, at in holes(plane):
            words = page.text(N_("plane %(plane)s, hole %(hole)s"), plane=plane.name, hole=label)
            out.append((f"{index} {at:g}", f"{words} · {page.display.angle(at)}"))
    return out


def read_pieces(page: Page, form: Form, machine: Machine) -> tuple[AsFoundPiece, ...]:
    """The pieces that were stated; a row without a hole and a mass is none."""
    return tuple(_pieces(page, form, machine))


def _pieces(page: Page, form: Form, machine: Machine) -> Iterator[AsFoundPiece]:
    known = {place for place, _ in places(page, machine)}
    for index in range(PIECES):
        where = f"on_rotor[{index}]"
        if not form.value(f"{where}.place") and not form.value(f"{where}.mass_g").strip():
            continue
        place = form.choice(f"{where}.place", known)
        grams = form.number(f"{where}.mass_g", above=0.0, high=MAX_G, unit=page.display.mass_unit())
        may = form.choice(f"{where}.may", MAY, required=False) or "stay"
        if form.ok and place is not None and grams is not None:
            plane, at = place.split()
            name = machine.planes[int(plane)].name
            yield AsFoundPiece(plane=name, position_deg=float(at), mass_g=grams, may=may)  # type: ignore[arg-type]


def read_run_out(page: Page, form: Form, machine: Machine) -> tuple[RunOut, ...]:
    """The run-out of each sensor for which one was stated."""
    out = []
    for index, sensor in enumerate(machine.sensors):
        where = f"run_out[{index}]"
        if not form.value(f"{where}.amplitude").strip() and not form.value(f"{where}.phase_deg").strip():
            continue
        unit = page.display.amplitude_unit(sensor)
        amplitude = form.number(f"{where}.amplitude", low=0.0, high=MAX_AMPLITUDE, unit=unit)
        phase = form.angle(f"{where}.phase_deg")
        if form.ok and amplitude is not None and phase is not None:
            out.append(RunOut(sensor=sensor.name, amplitude=amplitude, phase_deg=phase))
    return tuple(out)
