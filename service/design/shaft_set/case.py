"""A shaft set's document, read: vibration, influence, limits of mass, weights of the aims and the present masses."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from service.design.findings import of_error
from service.design.heading import Heading, begin
from service.design.reading import LARGEST, Problems, Table, refused, told
from service.design.study import Document
from service.errors import NumericsError
from service.mechanics.bodies import ComplexArray, FloatArray
from service.mechanics.shaft_set import FuzzyGoals, ShaftSet
from service.messages import Message

MAX_SENSORS, MAX_PLANES = 400, 20
AIMS = ("energy", "largest", "spread")
"""Names of F1, F2 and F3."""


@dataclass(frozen=True)
class ShaftCase:
    """A document that was read without a refusal. present: masses (planes,), g; most: limit of each, g."""

    heading: Heading
    sensors: tuple[str, ...]
    planes: tuple[str, ...]
    shaft: ShaftSet
    goals: FuzzyGoals
    present: ComplexArray
    most: float


def read_shaft(document: Document) -> tuple[ShaftCase | None, Problems]:
    """The case of a document, or None, and what was noted while it was read."""
    root, problems, heading = begin(document)
    table, design, aim = root.table("shaft_set"), root.table("design"), root.table("aim", optional=True)
    weights, best, worst = _aim(aim)
    root.close()
    if table is None or design is None:
        return None, problems
    sensors, planes = _names(table, "sensors", MAX_SENSORS), _names(table, "planes", MAX_PLANES)
    form = table.text("form", default="complex", choices=("complex", "polar"))
    unit = problems.factor("vibration", table.at("initial"))
    per_mass = problems.factor("trial_mass", table.at("influence"))
    initial = _vectors(table, "initial", (len(sensors),), form) * unit
    influence = _vectors(table, "influence", (len(sensors), len(planes)), form) * unit / per_mass
    table.close()
    most = design.number("most_mass", "trial_mass", above=0.0)
    masses = design.numbers("masses", "trial_mass", count=len(planes), default=(0.0,) * len(planes))
    angles = design.numbers("angles", "angle", count=len(planes), default=(0.0,) * len(planes))
    design.close()
    if refused(problems):
        return None, problems
    try:
        shaft = ShaftSet(initial, influence)
    except NumericsError as error:
        problems.found.append(of_error(error, "shaft_set"))
        return None, problems
    present = np.array([cmath.rect(mass, angle) for mass, angle in zip(masses, angles, strict=True)])
    goals = FuzzyGoals.of(shaft, weights, best, worst)
    return ShaftCase(heading, sensors, planes, shaft, goals, present, most), problems


def _aim(table: Table | None) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weights, and the user's own best and worst values (NaN where they are to be computed)."""
    unstated = np.full(3, math.nan)
    if table is None:
        return np.array([0.7, 0.2, 0.1]), unstated, unstated
    weights = np.array(table.numbers("weights", count=3, default=(0.7, 0.2, 0.1)))
    if not np.isnan(weights).any() and (weights.min() < 0.0 or weights.sum() <= 0.0):
        stated = ", ".join(f"{value:g}" for value in weights)
        table.problems.add(Message("design_weights", field=table.at("weights"), value=stated))
        weights = np.ones(3)
    limits = []
    for name in ("best", "worst"):
        one, held = table.table(name, optional=True), unstated.copy()
        if one is not None:
            for k, aim in enumerate(AIMS):
                if aim in one:
                    held[k] = one.number(aim, least=0.0)
            one.close()
        limits.append(held)
    if (limits[1] <= limits[0]).any():
        k = int((limits[1] <= limits[0]).argmax())
        table.problems.add(
            Message("design_bounds_crossed", field=table.at(f"worst.{AIMS[k]}"), lower=limits[0][k], upper=limits[1][k])
        )
    table.close()
    return weights, limits[0], limits[1]


def _names(table: Table, name: str, most: int) -> tuple[str, ...]:
    stated = table.values.get(name)
    count = len(stated) if isinstance(stated, list) else 1
    if not 1 <= count <= most:
        table.problems.add(Message("design_count_out_of_range", field=table.at(name), value=count, least=1, most=most))
    return table.texts(name, count=count)


def _vectors(table: Table, name: str, shape: tuple[int, ...], form: str) -> ComplexArray:
    """Vectors as [real, imaginary] or [amplitude, degrees], in nested lists of a shape."""
    stated = table.ask(name)
    if stated is None:
        return np.full(shape, complex(math.nan))
    try:
        pairs = np.array(stated, dtype=np.float64)
    except (ValueError, TypeError, OverflowError):
        pairs = np.zeros(0)
    wanted = " x ".join(str(size) for size in (*shape, 2))
    if pairs.shape != (*shape, 2):
        table.problems.add(Message("design_not_a_list.shape", field=table.at(name), value=told(stated), shape=wanted))
        return np.full(shape, complex(math.nan))
    if not (np.abs(pairs) <= LARGEST).all():
        table.problems.add(Message("design_not_finite", field=table.at(name), value=told(stated)))
    if form == "polar":
        return np.asarray(pairs[..., 0] * np.exp(1j * np.radians(pairs[..., 1])))
    return np.asarray(pairs[..., 0] + 1j * pairs[..., 1])
