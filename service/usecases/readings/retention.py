"""Retention: raw readings are kept for some days, then rolled up to one row a minute."""

from __future__ import annotations

import cmath
import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from typing import Any

import numpy as np

from db.rows import ReadingRow
from service.balancing.influence.resolution import known_scatter
from service.errors import InvalidInput
from service.messages import Message
from service.model.base import document
from service.runtime.context import AppContext

STEP = timedelta(hours=1)
"""Readings of a source in one unit of work: writers wait no longer than for one hour's readings."""


@document
class Retained:
    """What became of old raw readings."""

    before: datetime
    """Readings from before this moment, UTC, a whole minute."""
    readings: int
    """Raw readings that were removed."""
    minutes: int
    """Rows that hold what is left of them."""


def retain(work: AppContext, days: int, stopped: Callable[[], bool] = lambda: False) -> Retained:
    """Roll up raw readings taken more than `days` days ago: per source, machine, sensor and minute one row.

    Each row holds their count, mean vector, scatter, speed and broadband value. stopped: asked after each hour of
    readings whether to leave the rest for the next time. Raises InvalidInput for no days.
    """
    if days < 1:
        raise InvalidInput(Message("invalid_input.retention", days=days), field="days", value=days)
    before = (work.now() - timedelta(days=days)).replace(second=0, microsecond=0)
    with work.read() as store:
        sources = store.sources_of_readings()
    removed = minutes = 0
    for source in sources:
        while not stopped():
            with work.write() as store:
                store.roll_up_alone()
                first = store.oldest_reading(source)
                if first is None or first >= before:
                    break
                until = min(first.replace(minute=0, second=0, microsecond=0) + STEP, before)
                rows = store.readings_before(source, until)
                rolled = rolled_up(rows)
                store.roll_up(source, until, len(rows), rolled, forget=before)
            removed, minutes = removed + len(rows), minutes + len(rolled)
    return Retained(before=before, readings=removed, minutes=minutes)


def rolled_up(rows: Sequence[ReadingRow]) -> list[dict[str, Any]]:
    """Rows of the table of minutes, one for each machine, sensor and minute of readings of one source."""
    groups: dict[tuple[str, str, datetime], list[ReadingRow]] = defaultdict(list)
    for row in rows:
        groups[row.machine_id, row.sensor, row.taken_at.replace(second=0, microsecond=0)].append(row)
    return [
        {
            "source": group[0].source,
            "machine_id": machine_id,
            "sensor": sensor,
            "minute": minute,
            "readings": len(group),
            "last_sequence": max(row.sequence for row in group),
            "speed_rpm": _mean([row.speed_rpm for row in group]),
            "overall_rms": _mean([row.overall_rms for row in group]),
            **_vector(group),
        }
        for (machine_id, sensor, minute), group in groups.items()
    ]


def _vector(group: Sequence[ReadingRow]) -> dict[str, float | None]:
    """Mean vector and scatter of one reading; phases of one machine have one sense, so that either gives the same."""
    if any(row.phase_deg is None for row in group):
        amplitudes = np.array([row.amplitude for row in group])
        scatter = float(amplitudes.std(ddof=1)) if len(group) > 1 else group[0].scatter
        amplitude = float(amplitudes.mean())
        return {"amplitude": amplitude, "phase_deg": None, "scatter": known_scatter(scatter, amplitude)}
    vectors = np.array([cmath.rect(row.amplitude, math.radians(row.phase_deg or 0.0)) for row in group])
    mean = complex(vectors.mean())
    spread = float((np.abs(vectors - mean) ** 2).sum())
    scatter = math.sqrt(spread / (2 * (len(group) - 1))) if len(group) > 1 else group[0].scatter
    phase = math.degrees(cmath.phase(mean)) % 360.0
    return {"amplitude": abs(mean), "phase_deg": phase, "scatter": known_scatter(scatter, abs(mean))}


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None
