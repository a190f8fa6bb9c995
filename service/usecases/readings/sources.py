"""Sources of readings: the machine each is mounted on, and what it sent."""

from __future__ import annotations

from datetime import datetime

from db.rows import MachineRow, SourceRow
from service.errors import InvalidInput
from service.messages import Message
from service.model.base import document
from service.model.findings import Findings
from service.runtime.context import AppContext, require


@document
class Source:
    """A source of readings and the machine it is mounted on."""

    name: str
    """Name of the source."""
    machine_id: str
    """Machine."""
    bound_at: datetime
    """When it was bound, UTC."""


@document
class StoredReading:
    """A raw reading as it is stored, until it is rolled up."""

    source: str
    """Who measured."""
    sequence: int
    """Its number."""
    machine_id: str
    """Machine it belongs to."""
    session_id: str | None
    """Session it was sent for; null for a source that is bound to the machine."""
    taken_at: datetime
    """When it was taken, UTC."""
    sensor: str
    """Sensor."""
    amplitude: float
    """1x amplitude, in the sensor's quantity, unit and detection."""
    phase_deg: float | None
    """1x phase, degrees, in the machine's phase sense."""
    speed_rpm: float | None
    """Speed, r/min."""
    scatter: float | None
    """Standard deviation of the 1x vector per real component, in the amplitude's unit."""
    overall_rms: float | None
    """Broadband value, rms, in the sensor's unit."""
    received_at: datetime | None
    """When the service received it, UTC; null: it was stored by a version that did not note that."""
    apart: str | None
    """Why it is in no window, mean or run: clock_ahead (dated after it was received) or withdrawn; null: it is."""
    findings: Findings | None
    """What the signal chain found beside it, where it was measured from a block of waveforms."""


def bind(work: AppContext, name: str, machine_id: str) -> Source:
    """Bind a source to the machine it is mounted on. Raises NotFound."""
    with work.write() as store:
        require(store, MachineRow, machine_id)
        row = store.lock(SourceRow, name)
        if row is None:
            new = SourceRow(name=name, machine_id=machine_id, bound_at=work.now())
            if store.added(new):
                return Source(name=name, machine_id=machine_id, bound_at=new.bound_at)
            row = require(store, SourceRow, name, lock=True)  # another request bound it meanwhile: this comes after it
        row.machine_id, row.bound_at = machine_id, work.now()
        return Source(name=row.name, machine_id=row.machine_id, bound_at=row.bound_at)


def bound(work: AppContext) -> tuple[Source, ...]:
    """Bound sources, by name."""
    with work.read() as store:
        return tuple(Source(name=r.name, machine_id=r.machine_id, bound_at=r.bound_at) for r in store.sources())


def readings_of(
    work: AppContext, name: str, since: datetime | None, until: datetime | None, limit: int, offset: int
) -> tuple[StoredReading, ...]:
    """Raw readings of a bound source with what was found beside them, newest first. Raises NotFound, InvalidInput."""
    if since is not None and until is not None and since > until:
        raise InvalidInput(Message("invalid_input.times_reversed"), field="from", value=since.isoformat())
    with work.read() as store:
        require(store, SourceRow, name)
        rows = store.readings_of(name, since, until, limit, offset)
        found = store.findings(name, [row.sequence for row in rows])
        columns = [column for column in StoredReading.__dataclass_fields__ if column != "findings"]
        return tuple(
            StoredReading(**{name: getattr(row, name) for name in columns}, findings=found.get(row.sequence))
            for row in rows
        )
