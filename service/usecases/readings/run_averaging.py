"""Average stored readings of a source into a run: vectors with their scatter.

The scatter of readings that a source rounds is at least what its steps leave unknown
(`service.balancing.influence.resolution`); the steps are found in the readings of the run and in those before it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from datetime import datetime

import numpy as np

from db.rows import ReadingRow, SessionRow, SourceRow
from db.store import Store
from service.balancing.influence.resolution import known_scatter, quantisation_step, scatter_floor
from service.balancing.rotor.phasors import PhaseSense, phasor, polar
from service.errors import Conflict, InvalidInput
from service.messages import Message
from service.model.findings import Findings, OrderComponent
from service.model.machine import Machine
from service.model.run import RunReading, Take
from service.runtime.context import require

EARLIER_READINGS = 400
"""Readings of the source from before the run that help to find its steps."""
MIN_SPEED_RPM = 1e-9
"""A run states no lower speed."""


def taken_readings(
    store: Store, session: SessionRow, take: Take, released_at: datetime | None = None
) -> tuple[RunReading, ...]:
    """One averaged reading per sensor.

    released_at: when the machine was released with the masses of the run on; what was received before is of others.

    Raises NotFound for an unknown source, Conflict for one of another machine or readings from before the release,
    InvalidInput where it has no reading.
    """
    source = require(store, SourceRow, take.source)
    if source.machine_id != session.machine_id:
        raise Conflict(
            Message("source_of_other_machine.taking", source=take.source), field="take.source", value=take.source
        )
    if take.since > take.until:
        raise InvalidInput(Message("invalid_input.take_reversed"), field="take.from", value=str(take.since))
    gone = store.rolled_up_between(take.source, take.since, take.until)
    if gone is not None:
        raise Conflict(
            Message("readings_rolled_up", source=take.source, time=gone.isoformat()),
            field="take.from",
            value=take.since.isoformat(),
        )
    rows = [
        row
        for row in store.readings_between(take.source, session.machine_id, take.since, take.until)
        if row.session_id in (None, session.id) and _received_from(row, take.received_from)
    ]
    _require_released(take, rows, released_at)
    by_sensor: dict[str, list[ReadingRow]] = defaultdict(list)
    for row in rows:
        by_sensor[row.sensor].append(row)
    found = store.findings_between(take.source, take.since, take.until)
    earlier: dict[str, list[ReadingRow]] = defaultdict(list)
    for row in store.readings_of(take.source, None, take.since, EARLIER_READINGS, 0):
        earlier[row.sensor].append(row)
    readings = tuple(
        _averaged(session.machine, sensor.name, by_sensor[sensor.name], earlier[sensor.name], found)
        for sensor in session.machine.sensors
        if by_sensor[sensor.name]
    )
    if not readings:
        raise InvalidInput(
            Message("nothing_to_take", source=take.source, since=take.since.isoformat(), until=take.until.isoformat()),
            field="take",
            value=take.source,
        )
    return readings


def _received_from(row: ReadingRow, first: datetime | None) -> bool:
    return first is None or (row.received_at is not None and row.received_at >= first)


def _require_released(take: Take, rows: Sequence[ReadingRow], released_at: datetime | None) -> None:
    """Refuse readings that were here before the machine turned with these masses: whatever their time says."""
    if released_at is None:
        return
    early = [row for row in rows if row.received_at is not None and row.received_at < released_at]
    if early:
        raise Conflict(
            Message("readings_before_release", count=len(early)), field="take.from", value=take.since.isoformat()
        )


def _averaged(
    machine: Machine,
    sensor: str,
    rows: Sequence[ReadingRow],
    earlier: Sequence[ReadingRow],
    found: Mapping[int, Findings],
) -> RunReading:
    """Vector mean; scatter of the mean from the spread, or from the readings' own scatter where there is only one.

    Without a phase in all of them the amplitudes are averaged and the phase is None. Readings that are all the same, of
    a source whose steps do not show, have an unknown scatter.
    """
    n = len(rows)
    speeds = [row.speed_rpm for row in rows if row.speed_rpm is not None]
    overall = [row.overall_rms for row in rows if row.overall_rms is not None]
    phase: float | None = None
    if any(row.phase_deg is None for row in rows):
        amplitudes = np.array([row.amplitude for row in rows])
        amplitude = float(amplitudes.mean())
        scatter = float(amplitudes.std(ddof=1) / math.sqrt(n)) if n > 1 else rows[0].scatter
    else:
        vectors = np.array([phasor(r.amplitude, r.phase_deg or 0.0, machine.phase_sense) for r in rows])
        mean = complex(vectors.mean())
        amplitude, phase = polar(mean, machine.phase_sense)
        scatter = _scatter_of_mean(vectors, mean) if n > 1 else rows[0].scatter
    floor = _floor(amplitude, phase, [*rows, *earlier]) if n > 1 else 0.0
    return RunReading(
        sensor=sensor,
        amplitude=amplitude,
        phase_deg=phase,
        speed_rpm=float(np.mean(speeds)) if speeds and np.mean(speeds) >= MIN_SPEED_RPM else None,
        scatter=known_scatter(scatter, amplitude, floor),
        overall_rms=float(np.mean(overall)) if overall else None,
        findings=together([found[row.sequence] for row in rows if row.sequence in found], machine.phase_sense),
    )


def _floor(amplitude: float, phase: float | None, rows: Sequence[ReadingRow]) -> float:
    """What the steps of a source leave unknown of a vector, in the sensor's unit."""
    amplitude_step = quantisation_step(np.array([row.amplitude for row in rows]))
    phases = [row.phase_deg for row in rows if row.phase_deg is not None]
    phase_step = quantisation_step(np.array(phases)) if phase is not None else None
    return scatter_floor(amplitude, amplitude_step, phase_step)


def together(found: Sequence[Findings], sense: PhaseSense) -> Findings | None:
    """Findings of several blocks of one sensor, oldest first, as those of one; None of none.

    Amplitudes in the sensor's unit and detection, phases in degrees in `sense`.
    """
    if not found:
        return None
    orders = min(len(one.components) for one in found)
    tones = [one.neighbour for one in found if one.neighbour is not None]
    return Findings(
        turns=sum(one.turns for one in found),
        components=tuple(_mean_component([one.components[k] for one in found], sense) for k in range(orders)),
        neighbour=max(tones, key=lambda tone: tone.amplitude, default=None),
        flags=tuple(dict.fromkeys(flag for one in found for flag in one.flags)),
        directions=found[-1].directions,
    )


def _mean_component(parts: Sequence[OrderComponent], sense: PhaseSense) -> OrderComponent:
    mean = complex(np.mean([phasor(part.amplitude, part.phase_deg, sense) for part in parts]))
    amplitude, phase_deg = polar(mean, sense)
    return OrderComponent(order=parts[0].order, amplitude=amplitude, phase_deg=phase_deg)


def _scatter_of_mean(vectors: np.ndarray[tuple[int], np.dtype[np.complex128]], mean: complex) -> float:
    """Standard deviation of the mean per real component: two components, n - 1 degrees of freedom each."""
    n = len(vectors)
    return math.sqrt(float((np.abs(vectors - mean) ** 2).sum()) / (2 * (n - 1)) / n)
