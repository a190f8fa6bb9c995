"""The history: who changed what, when; and what a check of it found."""

from __future__ import annotations

from dataclasses import field
from datetime import datetime
from typing import Any

from service.model.base import document


@document
class HistoryEntry:
    """One change."""

    id: int
    """Number of the entry, in the order of writing."""
    at: datetime
    """When, UTC."""
    actor: str
    """Who: the name of a token; local where none is needed; migration for what an upgrade did."""
    action: str
    """added, changed, removed, closed, repaired or imported; of a box the kind of movement; of readings sent."""
    kind: str
    """What: machine, catalogue, session, run, correction, plan, influence, source, token, reading ..."""
    key: str
    """Identifier of the thing; of readings the source."""
    session_id: str | None
    """Session it belongs to."""
    changes: dict[str, Any]
    """Of a changed thing [before, after] of every field; else what there is to tell."""
    rows: dict[str, str | None] = field(default_factory=dict)
    """SHA-256 of each row the change wrote, as it was stored then; in the chain they are `changes["#rows"]`."""
    number: int | None
    """Place in the hash chain, from 1; null for telemetry, which is not chained."""
    hash: str | None
    """SHA-256 of the entry and of the hash before it."""


@document
class Finding:
    """Something that is not as the history says."""

    code: str
    """entry_altered, entry_missing, entry_forged, session_altered, session_missing, session_inserted, row_altered,
    row_missing, row_inserted, readings_altered, readings_missing, head_missing or balance."""
    detail: str
    """What, in a sentence."""
    session_id: str | None
    """The session, where it is one."""


@document
class Verdict:
    """What a walk along the hash chain found."""

    entries: int
    """Entries of the chain."""
    sessions: int
    """Closed sessions whose record was compared."""
    head: str
    """NUMBER:HASH of the last entry; kept elsewhere, it shows later that the end was not cut off."""
    findings: tuple[Finding, ...]
    """What is wrong; empty: nothing."""
