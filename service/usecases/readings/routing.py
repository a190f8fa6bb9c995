"""Route a reading or an answer to the machine behind its source or session."""

from __future__ import annotations

from collections.abc import Iterable

from db.rows import MachineRow, SessionRow
from db.store import Store
from drivers.reading import Reading
from service.engine import session_state
from service.engine.validation import sensor_index
from service.errors import Conflict, InvalidInput, NotFound
from service.messages import Message
from service.model.machine import Machine
from service.runtime.context import require


class Targets:
    """Which machine a reading belongs to, looked up once per source and session."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self._bound: dict[str, str | None] = {}
        self._machines: dict[str, Machine] = {}
        self._of: dict[tuple[str, str | None], str] = {}
        self._of_sensor: dict[tuple[str, str | None, str], str] = {}

    def expect(self, sources: Iterable[str]) -> None:
        """Look up the machines of these sources at once, as far as their names are any; of others as they come."""
        unknown = {source for source in sources if source not in self._bound and source.isprintable()}
        found = self.store.mounted(sorted(unknown))
        self._bound |= {source: found[source][0] if source in found else None for source in unknown}
        self._machines |= dict(found.values())

    def of_reading(self, reading: Reading, index: int) -> str:
        """The machine, once source, session and sensor are known to fit; thousands of readings ask for the same."""
        key = (reading.source, reading.session_id, reading.sensor)
        found = self._of_sensor.get(key)
        if found is None:
            _check_source(reading.source, f"[{index}].source")
            found = self.machine_of(reading.source, reading.session_id, f"[{index}].session_id")
            sensor_index(self.machine(found), reading.sensor, f"[{index}].sensor")
            self._of_sensor[key] = found
        return found

    def machine_of(self, source: str, session_id: str | None, field: str) -> str:
        """Identifier of the machine. Raises NotFound for an unknown session or an unbound source, and Conflict."""
        key = (source, session_id)
        if key not in self._of:
            self._of[key] = self._look_up(source, session_id, field)
        return self._of[key]

    def machine(self, machine_id: str) -> Machine:
        """The machine itself."""
        if machine_id not in self._machines:
            self._machines[machine_id] = require(self.store, MachineRow, machine_id).spec
        return self._machines[machine_id]

    def _look_up(self, source: str, session_id: str | None, field: str) -> str:
        self.expect((source,))
        bound = self._bound.get(source)
        if session_id is None:
            if bound is None:
                raise NotFound(Message("source_not_bound", source=source), field=field, value=source)
            return bound
        session = require(self.store, SessionRow, session_id)
        session_state.after(session, "run")
        if bound is not None and bound != session.machine_id:
            raise Conflict(
                Message("source_of_other_machine.session", source=source, session=session_id),
                field=field,
                value=session_id,
            )
        return session.machine_id


def machine_behind(store: Store, source: str, session_id: str | None) -> Machine:
    """The machine of a source and a session. Raises as `Targets.machine_of` does."""
    targets = Targets(store)
    return targets.machine(targets.machine_of(source, session_id, "session_id"))


def reused(key: tuple[str, int], field: str) -> Conflict:
    """The refusal of a number that a source used before for something else."""
    return Conflict(Message("sequence_reused", source=key[0], sequence=key[1]), field=field, value=key[1])


def _check_source(source: str, field: str) -> None:
    """Refuse what a Reading's type lets pass and no table takes: a name with control signs."""
    if not source.isprintable():
        raise InvalidInput(Message("invalid_input.source_name"), field=field, value=source)
