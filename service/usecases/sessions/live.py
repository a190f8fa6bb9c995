"""Live view of a session: the newest readings, and whether a run may be taken.

A reading's place in time is when it was measured by the service's clock (`clocks.measured`): that alone tells whether
it is fresh, within the window, or from after the machine was released.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

import numpy as np

from db.rows import ReadingRow, SessionRow
from db.store import Store
from service.balancing.rotor.phasors import PhaseSense, phasor, polar
from service.messages import Message, Quantity, render
from service.model.base import document
from service.model.findings import Findings
from service.model.machine import Machine
from service.model.message import MessageData, message_data
from service.model.run import Take
from service.runtime.context import AppContext, require
from service.usecases.readings.clocks import TOLERANCE_S, ClockOfSource, SourceClock, measured, of_sources, shown

WINDOW = timedelta(seconds=10)
MAX_READINGS = 400
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
    why_not_data: MessageData | None = None
    """The same as key and parameters, for other languages and units."""
    findings: Findings | None = None
    """What the signal chain found beside the newest reading, where that came from a block of waveforms."""


@document
class Live:
    """The newest readings of a session's machine."""

    session_id: str
    """Session."""
    newest_at: datetime | None
    """When the newest reading of the window was taken as its source dates it, UTC; null where there is none."""
    since: datetime | None
    """When the oldest reading of the window was taken as its source dates it, UTC: a run may be taken from here."""
    sensors: tuple[SensorNow, ...]
    """Sensors of the machine that have readings."""
    steady: bool
    """Every sensor of the machine is steady."""
    measured_at: datetime | None = None
    """When the newest reading was measured by the service's clock, UTC; null where there is none."""
    ready: bool = False
    """A run may be taken: every sensor is steady, and the clocks of the sources are known."""
    clocks: tuple[ClockOfSource, ...] = ()
    """Clocks of the machine's sources, and of those in the window: how far they are off."""


def look(work: AppContext, session_id: str, since: datetime | None = None) -> Live:
    """The window of the last 10 s before the newest reading, at most 400 readings. Raises NotFound.

    since: nothing from before it is seen, such as the moment the machine was released with other masses on.
    """
    with work.read() as store:
        session = require(store, SessionRow, session_id)
        now = work.now()
        window = _window(store, session, since, now)
        return _with_findings(store, _seen(session.id, session.machine, window, now), window)


@dataclass(frozen=True, slots=True)
class _Window:
    """Readings of the last seconds before the newest, newest first, each with when it was measured; all the clocks."""

    rows: Sequence[tuple[ReadingRow, datetime]]
    clocks: dict[str, SourceClock]


def _window(store: Store, session: SessionRow, since: datetime | None, now: datetime) -> _Window:
    """What was received last, of the sources on the machine and for the session: its length bounds the work."""
    opened = session.created_at
    first = opened if since is None else max(opened, since)
    bound = store.sources_on(session.machine_id)
    rows = list(store.received_for_session(session.id, first, MAX_READINGS))
    for source in bound:
        # What it sent before it was mounted here is of another machine.
        begin = max(first, source.bound_at)
        rows += store.received_of_source(source.name, session.machine_id, begin, MAX_READINGS)
    clocks = of_sources(store, {source.name for source in bound} | {row.source for row in rows})
    timed = [(row, measured(row, clocks[row.source], now)) for row in rows]
    # What came after the session was opened is of it, unless a clock that is known well says that it is older.
    earliest = opened - timedelta(seconds=TOLERANCE_S)
    mine = [
        (row, at)
        for row, at in timed
        if (since is None or at >= since) and (at >= earliest or not clocks[row.source].steady(now))
    ]
    mine.sort(key=lambda one: (one[1], one[0].sequence), reverse=True)
    newest = mine[0][1] if mine else None
    recent = [one for one in mine[:MAX_READINGS] if newest is not None and newest - one[1] <= WINDOW]
    return _Window(recent, clocks)


def _with_findings(store: Store, live: Live, window: _Window) -> Live:
    """The same, with what is stored beside the newest reading of each sensor."""
    newest: dict[str, ReadingRow] = {}
    for row, _ in window.rows:
        newest.setdefault(row.sensor, row)
    numbers: dict[str, list[int]] = defaultdict(list)
    for row in newest.values():
        numbers[row.source].append(row.sequence)
    found = {source: store.findings(source, sequences) for source, sequences in numbers.items()}
    sensors = (
        replace(one, findings=found[newest[one.sensor].source].get(newest[one.sensor].sequence)) for one in live.sensors
    )
    return replace(live, sensors=tuple(sensors))


def topics(work: AppContext, session_id: str) -> tuple[str, str]:
    """Keys under which what `look` shows is announced: the session's and its machine's. Raises NotFound."""
    with work.read() as store:
        return session_id, require(store, SessionRow, session_id).machine_id


def window(work: AppContext, session_id: str, since: datetime | None = None) -> Take | None:
    """The window that `look` sees, of the source with the most readings in it: what a run taken now is made of.

    None where no bound source has a reading. Raises NotFound.
    """
    with work.read() as store:
        session = require(store, SessionRow, session_id)
        bound = {source.name for source in store.sources_on(session.machine_id)}
        recent = [row for row, _ in _window(store, session, since, work.now()).rows if row.source in bound]
        if not recent:
            return None
        source = Counter(row.source for row in recent).most_common(1)[0][0]
        mine = [row for row in recent if row.source == source]
        times = [row.taken_at for row in mine]
        received = min((row.received_at for row in mine if row.received_at is not None), default=None)
        return Take(source=source, since=min(times), until=max(times), received_from=received)


def _seen(session_id: str, machine: Machine, window: _Window, now: datetime) -> Live:
    by_sensor: dict[str, list[ReadingRow]] = defaultdict(list)
    for row, _ in reversed(window.rows):
        by_sensor[row.sensor].append(row)
    names = [sensor.name for sensor in machine.sensors]
    sensors = tuple(_sensor(name, by_sensor[name], machine.phase_sense) for name in names if by_sensor[name])
    steady = len(sensors) == len(names) and all(sensor.steady for sensor in sensors)
    within = {row.source for row, _ in window.rows}
    return Live(
        session_id=session_id,
        newest_at=max((row.taken_at for row, _ in window.rows), default=None),
        since=min((row.taken_at for row, _ in window.rows), default=None),
        sensors=sensors,
        steady=steady,
        measured_at=window.rows[0][1] if window.rows else None,
        ready=steady and all(window.clocks[source].steady(now) for source in within),
        clocks=tuple(shown(source, clock, now) for source, clock in sorted(window.clocks.items())),
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
        why_not=None if why_not is None else render(why_not),
        why_not_data=message_data(why_not),
    )


def _why_not(count: int, spread: float, phase_spread: float | None, drift: float) -> Message | None:
    if count < LEAST:
        return Message("not_steady.few_readings", count=count, least=LEAST)
    if spread > STEADY_AMPLITUDE:
        return Message("not_steady.amplitude", spread=spread, most=STEADY_AMPLITUDE)
    if phase_spread is not None and phase_spread > STEADY_PHASE_DEG:
        return Message("not_steady.phase", spread=Quantity(round(phase_spread), "deg"), most=STEADY_PHASE_DEG)
    # Half the window against the other half: small spreads may hide a slow change.
    if drift > STEADY_AMPLITUDE:
        return Message("not_steady.drift", drift=drift)
    return None
