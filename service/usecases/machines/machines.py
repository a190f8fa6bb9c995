"""Machines: stored whole, changed by a merge patch; open sessions keep their own copy."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from db.rows import MachineRow
from service.engine.validation import normalised
from service.errors import InvalidInput
from service.messages import Message
from service.model.base import read_json, to_plain
from service.model.machine import Machine, StoredMachine
from service.runtime.context import AppContext, require
from service.usecases.names import name_taken, named_once


def create(work: AppContext, machine: Machine) -> StoredMachine:
    """Store a machine. Raises InvalidInput where a rule is broken, Conflict where the name is taken."""
    checked = normalised(machine)
    with named_once("machine", checked.name), work.write() as store:
        if store.machine_named(checked.name) is not None:
            raise name_taken("machine", checked.name)
        now = work.now()
        row = MachineRow(id=work.new_id(), name=checked.name, spec=checked, created_at=now, updated_at=now)
        store.add(row)
        return _view(row)


def get(work: AppContext, machine_id: str) -> StoredMachine:
    """One machine. Raises NotFound."""
    with work.read() as store:
        return _view(require(store, MachineRow, machine_id))


def find(work: AppContext, limit: int, offset: int) -> tuple[StoredMachine, ...]:
    """Machines, newest first."""
    with work.read() as store:
        return tuple(_view(row) for row in store.machines(limit, offset))


def change(work: AppContext, machine_id: str, patch: Mapping[str, Any]) -> StoredMachine:
    """Merge `patch` into a machine (RFC 7396, top level). Raises ValidationError or InvalidInput, nothing stored."""
    _require_known(patch)
    with named_once("machine", str(patch.get("name"))), work.write() as store:
        row = require(store, MachineRow, machine_id, lock=True)
        merged = {key: value for key, value in {**to_plain(row.spec), **patch}.items() if value is not None}
        # Written by json, which keeps NaN and Infinity: turned into null they would erase a field unseen.
        machine = normalised(read_json(Machine, json.dumps(merged)))
        other = store.machine_named(machine.name)
        if other is not None and other.id != row.id:
            raise name_taken("machine", machine.name)
        row.spec, row.name, row.updated_at = machine, machine.name, work.now()
        return _view(row)


def _require_known(patch: Mapping[str, Any]) -> None:
    """Every field of a patch is one of the machine's, also those that null takes away. Raises InvalidInput."""
    known = {field.name for field in fields(Machine)}
    for name in patch:
        if name not in known:
            raise InvalidInput(Message("invalid_input.unknown_field", name=name), field=name, value=name)


def _view(row: MachineRow) -> StoredMachine:
    return StoredMachine(**vars(row.spec), id=row.id, created_at=row.created_at, updated_at=row.updated_at)
