"""A reading as JSON: on the way to the service and in recordings."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC

from drivers.errors import BrokenSource
from drivers.reading import Reading


def reading_to_dict(reading: Reading) -> dict[str, object]:
    """Return the fields of a reading that are not None; taken_at as RFC 3339 in UTC with microseconds."""
    moment = reading.taken_at.astimezone(UTC).isoformat(timespec="microseconds").replace("+00:00", "Z")
    return {name: value for name, value in asdict(reading).items() if value is not None} | {"taken_at": moment}


def readings_to_json(readings: Sequence[Reading]) -> bytes:
    """JSON list of readings, UTF-8; raises `BrokenSource` for a NaN or infinite number, which JSON does not have."""
    try:
        return json.dumps([reading_to_dict(one) for one in readings], allow_nan=False).encode()
    except ValueError as error:
        raise BrokenSource(
            f"a reading of {readings[0].source!r}, sequences {readings[0].sequence} to {readings[-1].sequence}, holds "
            "a NaN or infinite number: a source gives None for what it does not know"
        ) from error
