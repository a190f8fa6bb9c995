"""Saved influence coefficients: documents to arrays and back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from service.balancing.influence.saved import SavedInfluence as Arrays
from service.balancing.rotor.phasors import ComplexArray, polar
from service.engine.learned_on import learned_on
from service.engine.mapping import Channel, known
from service.model.influence import Coefficient, InfluenceRow, SavedInfluence, Vector
from service.model.machine import Machine


def as_arrays(machine: Machine, saved: SavedInfluence, rows: Sequence[Channel]) -> Arrays:
    """Saved coefficients (S, P) for these rows, planes by name; nan where nothing was saved."""
    count = len(machine.planes)
    influence = np.full((len(rows), count), complex(np.nan, np.nan))
    covariance = np.full((len(rows), count, count), complex(np.nan, np.nan))
    names = [plane.name for plane in machine.planes]
    if set(names) <= set(saved.planes):
        order = [saved.planes.index(name) for name in names]
        found = {(row.sensor, row.speed_rpm): row for row in saved.rows}
        for s, row in enumerate(rows):
            kept = found.get((row.sensor.name, row.speed_rpm))
            if kept is not None:
                influence[s] = _complex(kept.influence)[order]
            if kept is not None and kept.covariance is not None:
                covariance[s] = np.array([_complex(line) for line in kept.covariance])[np.ix_(order, order)]
    return Arrays(influence, covariance, saved.sessions)


def as_document(machine: Machine, rows: Sequence[Channel], arrays: Arrays) -> SavedInfluence:
    """Arrays as they are kept; rows without coefficients are left out."""
    out = []
    for s, row in enumerate(rows):
        if not np.isfinite(arrays.influence[s]).all():
            continue
        spread = arrays.covariance[s]
        out.append(
            InfluenceRow(
                sensor=row.sensor.name,
                speed_rpm=row.speed_rpm,
                influence=_vectors(arrays.influence[s]),
                covariance=tuple(_vectors(line) for line in spread) if np.isfinite(spread).all() else None,
            )
        )
    return SavedInfluence(
        planes=tuple(p.name for p in machine.planes),
        rows=tuple(out),
        sessions=arrays.sessions,
        learned_on=learned_on(machine),
    )


def merged(old: SavedInfluence | None, new: SavedInfluence) -> SavedInfluence:
    """New rows in place of old ones of the same sensor and speed; old rows of other speeds are kept."""
    if old is None or old.planes != new.planes:
        return new
    fresh = {(row.sensor, row.speed_rpm) for row in new.rows}
    kept = tuple(row for row in old.rows if (row.sensor, row.speed_rpm) not in fresh)
    return replace(new, rows=(*new.rows, *kept))


def shown(machine: Machine, saved: SavedInfluence) -> tuple[tuple[Coefficient, ...], ...]:
    """Saved coefficients as amplitude per gram and phase in the machine's senses."""
    out = []
    for row in saved.rows:
        line = []
        for p, (plane, (real, imaginary)) in enumerate(zip(saved.planes, row.influence, strict=True)):
            amplitude, phase = polar(complex(real, imaginary), machine.phase_sense)
            variance = np.nan if row.covariance is None else row.covariance[p][p][0]
            line.append(
                Coefficient(
                    sensor=row.sensor,
                    plane=plane,
                    speed_rpm=row.speed_rpm,
                    amplitude_per_g=amplitude,
                    phase_deg=phase,
                    scatter_per_g=known(float(np.sqrt(variance))),
                )
            )
        out.append(tuple(line))
    return tuple(out)


def _complex(vectors: Sequence[Vector]) -> ComplexArray:
    return np.array([complex(real, imaginary) for real, imaginary in vectors])


def _vectors(values: ComplexArray) -> tuple[Vector, ...]:
    return tuple((float(v.real), float(v.imag)) for v in values)
