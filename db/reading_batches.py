"""Digests of batches of readings, and the numbers of readings that are no longer stored one by one.

The line of history that tells of a batch holds its numbers as ranges and SHA-256 over its readings, so that `verify`
finds what was altered or removed. These lines are outside the hash chain: somebody who rewrites reading and line alike
is not found.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

BATCH = "#batch"
"""Where a line `sent` holds {"sequences": [[first, last], ...], "sha256": ...}."""
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_MICROSECOND = timedelta(microseconds=1)
_NOT_STATED = float("nan")

Range = tuple[int, int]
"""First and last number, both of them in it."""


def batch_digest(rows: Iterable[Any]) -> str:
    """SHA-256 over rows of readings of one source, in the order of their numbers. Format 1 must never change."""
    hashed = hashlib.sha256(b"1")
    for row in sorted(rows, key=lambda row: row.sequence):
        moment = (row.taken_at - _EPOCH) // _MICROSECOND
        names = f"{row.sequence}\x1f{row.machine_id}\x1f{row.session_id or ''}\x1f{moment}\x1f{row.sensor}\x1e"
        values = (row.amplitude, row.phase_deg, row.speed_rpm, row.scatter, row.overall_rms)
        hashed.update(names.encode("utf-8", "surrogatepass"))
        hashed.update(struct.pack(">5d", *(_NOT_STATED if value is None else value for value in values)))
    return hashed.hexdigest()


def ranges_of(numbers: Iterable[int]) -> list[Range]:
    """Numbers as ranges, in order."""
    out: list[Range] = []
    for number in sorted(numbers):
        if out and number <= out[-1][1] + 1:
            out[-1] = (out[-1][0], number)
        else:
            out.append((number, number))
    return out


def merged(ranges: Iterable[Range]) -> list[Range]:
    """Ranges without overlaps or neighbours, in order."""
    out: list[Range] = []
    for first, last in sorted(ranges):
        if out and first <= out[-1][1] + 1:
            out[-1] = (out[-1][0], max(out[-1][1], last))
        else:
            out.append((first, last))
    return out


def is_within(number: int, ranges: Sequence[Range]) -> bool:
    """Whether a number is in one of these ranges."""
    return any(first <= number <= last for first, last in ranges)
