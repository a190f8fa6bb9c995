"""The running session as it is seen now: the newest readings, and whether a run may be taken."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np

from db.rows import ReadingRow, SessionRow
from db.store import Store
from service.balancing.rotor.phasors import PhaseSense, phasor, polar
from service.model.base import document
from service.model.findings import Findings
from service.model.machine import Machine
from service.model.run import Take
from service.runtime.context import Work, require

WINDOW = timedelta(seconds=10)
MOST_READINGS = 400
LEAST = 5
"""Readings of a sensor, within the window, before anything is said of its steadiness."""
STEADY_AMPLITUDE = 0.05
STEADY_PHASE_DEG = 5.0
"""A sixth of the 30 % or 30 degrees by which a trial mass should change a reading: the change then stands clear."""


@document
class SensorNow:
    """One sensor over the newest readings of the window."""

    sensor: str
    """Sensor of the session's machine."""
    readings: int
    """Readings in the window."""
    amplitude: float
    """Mean 1x amplitude (of the mean vector where there are phases), in the sensor's unit and detection."""
    phase_deg: float | None
    """Mean phase, degrees, in the machine's phase sense; null without a key-phasor."""
    speed_rpm: float | None
    """Mean speed, r/min."""
    amplitude_spread: float
    """Standard deviation of the amplitude over the window, as a fraction of the mean."""
    phase_spread_deg: float | None
    """Standard deviation of the phase over the window, degrees."""
    drift: float
    """Change of the mean vector from the first to the second half of the window, as a fraction of the amplitude."""
    steady: bool
    """Both spreads and the drift are small, and there are enough readings."""
    why_not: str | None
    """What is not steady yet."""
    findings: Findings | None = None
    """What the signal chain found beside the newest reading, where that came from a block of waveforms."""


@document
class Live:
    """The newest readings of a session's machine."""

    session_id: str
    """Session."""
    newest_at: datetime | None
    """When the newest reading was taken, UTC; null where there is none."""
    since: datetime | None
    """When the oldest reading of the window was taken, UTC: a run may be taken from here."""
    sensors: tuple[SensorNow, ...]
    """Sensors of the machine that have readings."""
    steady: bool
    """A run may be taken: every sensor of the machine is steady."""


def look(work: Work, session_id: str, since: datetime | None = None) -> Live:
    """The window of the last 10 s before the newest reading, at most 400 readings. Raises NotFound.

    since: nothing from before it is seen, such as the moment the machine was released with other masses on.
    """
    with work.read() as store:
        session = require(store, SessionRow, session_id)
        sources = [row.name for row in store.sources() if row.machine_id == session.machine_id]
        rows = store.newest_readings(session.machine_id, session.id, sources, _first(session, since), MOST_READINGS)
        return _with_findings(store, _seen(session.id, session.machine, rows), rows)


def _with_findings(store: Store, live: Live, rows: Sequence[ReadingRow]) -> Live:
    """The same, with what is stored beside the newest reading of each sensor; rows: newest first."""
    newest: dict[str, ReadingRow] = {}
    for row in rows:
        newest.setdefault(row.sensor, row)
    numbers: dict[str, list[int]] = defaultdict(list)
    for row in newest.values():
        numbers[row.source].append(row.sequence)
    found = {source: store.findings(source, sequences) for source, sequences in numbers.items()}
    sensors = (
        replace(one, findings=found[newest[one.sensor].source].get(newest[one.sensor].sequence)) for one in live.sensors
    )
    return replace(live, sensors=tuple(sensors))


def topics(work: Work, session_id: str) -> tuple[str, str]:
    """Keys under which what `look` shows is announced: the session's and its machine's. Raises NotFound."""
    with work.read() as store:
        return session_id, require(store, SessionRow, session_id).machine_id


def window(work: Work, session_id: str, since: datetime | None = None) -> Take | None:
    """The window that `look` sees, of the source with the most readings in it: what a run taken now is made of.

    None where no bound source has a reading. Raises NotFound.
    """
    with work.read() as store:
        session = require(store, SessionRow, session_id)
        sources = [row.name for row in store.sources() if row.machine_id == session.machine_id]
        rows = store.newest_readings(session.machine_id, session.id, sources, _first(session, since), MOST_READINGS)
        newest = max((row.taken_at for row in rows), default=None)
        recent = [
            row for row in rows if newest is not None and newest - row.taken_at <= WINDOW and row.source in sources
        ]
        if not recent:
            return None
        source = Counter(row.source for row in recent).most_common(1)[0][0]
        times = [row.taken_at for row in recent if row.source == source]
        return Take(source=source, since=min(times), until=max(times))


def _first(session: SessionRow, since: datetime | None) -> datetime:
    return session.created_at if since is None else max(session.created_at, since)


def _seen(session_id: str, machine: Machine, rows: Sequence[ReadingRow]) -> Live:
    newest = max((row.taken_at for row in rows), default=None)
    recent = [row for row in rows if newest is not None and newest - row.taken_at <= WINDOW]
    by_sensor: dict[str, list[ReadingRow]] = defaultdict(list)
    for row in sorted(recent, key=lambda one: (one.taken_at, one.sequence)):
        by_sensor[row.sensor].append(row)
    names = [sensor.name for sensor in machine.sensors]
    sensors = tuple(_sensor(name, by_sensor[name], machine.phase_sense) for name in names if by_sensor[name])
    return Live(
        session_id=session_id,
        newest_at=newest,
        since=min((row.taken_at for row in recent), default=None),
        sensors=sensors,
        steady=len(sensors) == len(names) and all(sensor.steady for sensor in sensors),
    )


def _sensor(name: str, rows: Sequence[ReadingRow], sense: PhaseSense) -> SensorNow:
    """Spread of amplitude and phase about the mean vector, and drift between the halves."""
    phased = all(row.phase_deg is not None for row in rows)
    amplitudes = np.array([row.amplitude for row in rows])
    vectors = np.array([phasor(row.amplitude, row.phase_deg or 0.0, sense) for row in rows])
    mean = complex(vectors.mean())
    amplitude, phase = polar(mean, sense)
    scale = max(float(amplitudes.mean()), 1e-12)
    half = len(rows) // 2
    drift = abs(complex(vectors[half:].mean()) - complex(vectors[:half].mean())) / scale if half else 0.0
    turns = np.angle(vectors * np.conj(mean)) if abs(mean) > 0.0 else np.zeros(len(rows))
    spread = float(amplitudes.std()) / scale
    phase_spread = math.degrees(float(np.sqrt(np.mean(turns**2)))) if phased else None
    why_not = _why_not(len(rows), spread, phase_spread, drift)
    speeds = [row.speed_rpm for row in rows if row.speed_rpm is not None]
    return SensorNow(
        sensor=name,
        readings=len(rows),
        amplitude=amplitude,
        phase_deg=phase if phased else None,
        speed_rpm=float(np.mean(speeds)) if speeds else None,
        amplitude_spread=spread,
        phase_spread_deg=phase_spread,
        drift=drift,
        steady=why_not is None,
        why_not=why_not,
    )


def _why_not(count: int, spread: float, phase_spread: float | None, drift: float) -> str | None:
    if count < LEAST:
        return f"{count} readings so far, {LEAST} are needed"
    if spread > STEADY_AMPLITUDE:
        return f"the amplitude varies by {100 * spread:.0f} %, {100 * STEADY_AMPLITUDE:.0f} % is steady"
    if phase_spread is not None and phase_spread > STEADY_PHASE_DEG:
        return f"the phase varies by {phase_spread:.0f} degrees, {STEADY_PHASE_DEG:.0f} is steady"
    # Half the window against the other half: small spreads may hide a slow change.
    if drift > STEADY_AMPLITUDE:
        return f"the vibration drifts by {100 * drift:.0f} % over the window: let the machine settle"
    return None
