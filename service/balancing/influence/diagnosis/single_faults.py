"""Single faults that a session may hold, each as the runs would have been recorded without it.

A fault is undone: the runs are written as they would have been had the mass not been lost, the angle not been mirrored,
the reading not been typed wrong. A fault that really happened leaves runs that follow one linear model.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import numpy as np

from service.balancing.influence.fit import RunSet
from service.balancing.rotor.phasors import ComplexArray, FloatArray

Kind = Literal[
    "amplitude_factor",
    "angle",
    "angle_mirrored",
    "angle_opposite",
    "gain",
    "left_in",
    "lost",
    "mass",
    "mass_factor",
    "phase_mirrored",
    "phase_offset",
    "phase_opposite",
    "piece",
    "planes_swapped",
    "reading",
    "run",
    "sensors_swapped",
    "sensors_swapped_from",
]
"""Every kind of single fault that is looked for."""
FACTORS = (2.0, 0.5, 10.0, 0.1)
"""By which a mass or an amplitude is typed wrong: half and whole, a decimal place."""
MAX_PAIRS_OF_SENSORS = 28
"""Pairs of sensors that may have changed places, of eight sensors all."""


@dataclass(frozen=True)
class Fault:
    """What went wrong, with the indices that it is about. turn: radians, factor: what was off, where it is known."""

    kind: Kind
    runs: tuple[int, ...]
    planes: tuple[int, ...] = ()
    sensors: tuple[int, ...] = ()
    factor: float = 1.0
    turn: float = 0.0


@dataclass(frozen=True)
class Undone:
    """Runs without a fault: masses (K, P), vibration (K, S), and by what the weight of each reading (K, S) grows.

    weight: 0 for a reading that does not count; the factor by which a reading was made smaller, its error with it.
    """

    fault: Fault
    masses: ComplexArray
    vibration: ComplexArray
    weight: FloatArray


def discrete(runs: RunSet, nominal_rpm: FloatArray | None, about: tuple[int, ...]) -> Iterator[Undone]:
    """Yield every slip of the usual kinds in the runs `about`, undone. nominal_rpm: (S,) of the rows, None for one."""
    plain = Undone(Fault("run", ()), runs.masses, runs.vibration, np.where(np.isfinite(runs.vibration), 1.0, 0.0))
    yield from _swapped_sensors(plain, nominal_rpm, about)
    for k in about:
        yield from _mass_slips(plain, k)
        yield from _reading_slips(plain, k)


def left_out(runs: RunSet, about: tuple[int, ...]) -> Iterator[Undone]:
    """Yield the runs without one reading, and without one run, of those `about`."""
    present = np.isfinite(runs.vibration)
    for k in about:
        for s in np.flatnonzero(present[k]):
            weight = np.where(present, 1.0, 0.0)
            weight[k, s] = 0.0
            yield Undone(Fault("reading", (k,), sensors=(int(s),)), runs.masses, runs.vibration, weight)
        if present[k].sum() > 1:
            weight = np.where(present, 1.0, 0.0)
            weight[k] = 0.0
            yield Undone(Fault("run", (k,)), runs.masses, runs.vibration, weight)


def turned_masses(runs: RunSet, about: tuple[int, ...]) -> Iterator[Fault]:
    """Yield each mass of a plane in one run, or in all runs that state it alike, as one that may be off."""
    for p in range(runs.masses.shape[1]):
        seen: dict[complex, list[int]] = {}
        for k in np.flatnonzero(runs.masses[:, p]):
            seen.setdefault(complex(runs.masses[k, p]), []).append(int(k))
        for alike in seen.values():
            for run in sorted(set(alike) & set(about)):
                yield Fault("piece", (run,), planes=(p,))
            if 1 < len(alike) <= len(about):
                yield Fault("piece", tuple(alike), planes=(p,))


def undo_masses(runs: RunSet, fault: Fault, values: ComplexArray) -> ComplexArray:
    """Masses (N, K, P) with those of a fault times each of `values` (N,)."""
    masses = np.repeat(runs.masses[None], len(values), axis=0)
    for k in fault.runs:
        masses[:, k, list(fault.planes)] *= values[:, None]
    return masses


def undo_readings(runs: RunSet, fault: Fault, values: ComplexArray) -> ComplexArray:
    """Readings (N, K, S) with those of the fault's runs divided by each of `values` (N,)."""
    vibration = np.repeat(runs.vibration[None], len(values), axis=0)
    for k in fault.runs:
        vibration[:, k] /= values[:, None]
    return vibration


def _mass_slips(plain: Undone, k: int) -> Iterator[Undone]:
    row = plain.masses[k]
    on = [int(p) for p in np.flatnonzero(row)]
    for planes in [(p,) for p in on] + ([tuple(on)] if len(on) > 1 else []):
        at = list(planes)
        yield from _changed(plain, Fault("angle_mirrored", (k,), planes), at, row[at].conj())
        yield from _changed(plain, Fault("angle_opposite", (k,), planes), at, -row[at])
        yield from _changed(plain, Fault("lost", (k,), planes), at, 0.0 * row[at])
        for factor in FACTORS:
            yield from _changed(plain, Fault("mass_factor", (k,), planes, factor=1.0 / factor), at, factor * row[at])
    for p, q in combinations(range(len(row)), 2):
        yield from _changed(plain, Fault("planes_swapped", (k,), (p, q)), [p, q], row[[q, p]])
    if k and plain.masses[k - 1].any():
        every = list(range(len(row)))
        yield from _changed(plain, Fault("left_in", (k,), tuple(every)), every, row + plain.masses[k - 1])


def _changed(plain: Undone, fault: Fault, at: list[int], values: ComplexArray) -> Iterator[Undone]:
    masses = plain.masses.copy()
    masses[fault.runs[0], at] = values
    if np.abs(masses - plain.masses).max() > 1e-6 * np.abs(plain.masses).max():
        yield replace(plain, fault=fault, masses=masses)


def _reading_slips(plain: Undone, k: int) -> Iterator[Undone]:
    seen = [int(s) for s in np.flatnonzero((plain.weight[k] > 0.0) & (plain.vibration[k] != 0.0))]
    for s in seen:
        yield _read(plain, Fault("phase_opposite", (k,), sensors=(s,)), s, -plain.vibration[k, s])
        for factor in FACTORS:
            fault = Fault("amplitude_factor", (k,), sensors=(s,), factor=factor)
            weight = plain.weight.copy()
            weight[k, s] = factor
            yield replace(_read(plain, fault, s, plain.vibration[k, s] / factor), weight=weight)
    if len(seen) > 1:
        yield _read(plain, Fault("phase_opposite", (k,), sensors=tuple(seen)), seen, -plain.vibration[k, seen])
        yield _read(plain, Fault("phase_mirrored", (k,), sensors=tuple(seen)), seen, plain.vibration[k, seen].conj())


def _read(plain: Undone, fault: Fault, at: int | list[int], values: complex | ComplexArray) -> Undone:
    vibration = plain.vibration.copy()
    vibration[fault.runs[0], at] = values
    return replace(plain, fault=fault, vibration=vibration)


def _swapped_sensors(plain: Undone, nominal_rpm: FloatArray | None, about: tuple[int, ...]) -> Iterator[Undone]:
    count, sensors = plain.vibration.shape
    speed = np.zeros(sensors) if nominal_rpm is None else nominal_rpm
    pairs = [(a, b) for a, b in combinations(range(sensors), 2) if speed[a] == speed[b]]
    for a, b in pairs[:MAX_PAIRS_OF_SENSORS]:
        for k in about:
            if plain.weight[k, [a, b]].all():
                yield _swapped(plain, Fault("sensors_swapped", (k,), sensors=(a, b)), a, b)
        for k in [k for k in about if 2 <= k < count - 1]:
            runs = tuple(int(j) for j in range(k, count) if plain.weight[j, [a, b]].all())
            if len(runs) > 1:
                yield _swapped(plain, Fault("sensors_swapped_from", runs, sensors=(a, b)), a, b)


def _swapped(plain: Undone, fault: Fault, a: int, b: int) -> Undone:
    vibration = plain.vibration.copy()
    for k in fault.runs:
        vibration[k, [a, b]] = plain.vibration[k, [b, a]]
    return replace(plain, fault=fault, vibration=vibration)
