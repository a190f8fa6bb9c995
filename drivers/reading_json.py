"""Readings and answers as JSON: on the way to the service, in the spool and in recordings."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import lru_cache

from drivers.errors import BrokenSource
from drivers.reading import Answer, Reading

_OPTIONAL = ("phase_deg", "speed_rpm", "scatter", "overall_rms", "session_id")
_encode = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode


@lru_cache(maxsize=1024)
def _quoted(name: str) -> str:
    return _encode(name)


def reading_to_dict(reading: Reading) -> dict[str, object]:
    """Return the fields of a reading that are not None; taken_at as RFC 3339 in UTC with microseconds."""
    found: dict[str, object] = {
        "source": reading.source,
        "sequence": reading.sequence,
        "taken_at": reading.taken_at.astimezone(UTC).isoformat(timespec="microseconds").replace("+00:00", "Z"),
        "sensor": reading.sensor,
        "amplitude": reading.amplitude,
    }
    for name in _OPTIONAL:
        value = getattr(reading, name)
        if value is not None:
            found[name] = value
    return found


def reading_to_json(reading: Reading) -> str:
    """JSON object of a reading; raises `BrokenSource` for a NaN or infinite number, which JSON does not have.

    Written out, as a bridge writes thousands a second: the same as the encoder makes of `reading_to_dict`.
    """
    moment = reading.taken_at.astimezone(UTC).isoformat(timespec="microseconds")[:-6]
    parts = [
        f'{{"source":{_quoted(reading.source)},"sequence":{reading.sequence},"taken_at":"{moment}Z",'
        f'"sensor":{_quoted(reading.sensor)},"amplitude":{float.__repr__(reading.amplitude)}'
    ]
    whole = reading.amplitude
    if (phase := reading.phase_deg) is not None:
        parts.append(f',"phase_deg":{float.__repr__(phase)}')
        whole += phase
    if (speed := reading.speed_rpm) is not None:
        parts.append(f',"speed_rpm":{float.__repr__(speed)}')
        whole += speed
    if (scatter := reading.scatter) is not None:
        parts.append(f',"scatter":{float.__repr__(scatter)}')
        whole += scatter
    if (overall := reading.overall_rms) is not None:
        parts.append(f',"overall_rms":{float.__repr__(overall)}')
        whole += overall
    if reading.session_id is not None:
        parts.append(f',"session_id":{_encode(reading.session_id)}')
    if not math.isfinite(whole):
        raise _not_finite(reading.source, reading.sequence, reading.sequence)
    return "".join(parts) + "}"


def readings_to_json(readings: Sequence[Reading]) -> bytes:
    """JSON list of readings, UTF-8; raises `BrokenSource` for a NaN or infinite number, which JSON does not have."""
    try:
        return _encode([reading_to_dict(one) for one in readings]).encode()
    except ValueError as error:
        raise _not_finite(readings[0].source, readings[0].sequence, readings[-1].sequence) from error


def answer_to_json(answer: Answer) -> str:
    """JSON object of a balancer's answer, as the service takes it."""
    body = {
        "source": answer.source,
        "sequence": answer.sequence,
        "taken_at": answer.taken_at.astimezone(UTC).isoformat(timespec="microseconds").replace("+00:00", "Z"),
        "masses": [{"plane": plane, "mass_g": mass, "angle_deg": angle} for plane, mass, angle in answer.masses],
    }
    try:
        return _encode(body)
    except ValueError as error:
        raise _not_finite(answer.source, answer.sequence, answer.sequence) from error


def answer_from_json(body: str) -> Answer:
    """An answer as `answer_to_json` wrote it."""
    found = json.loads(body)
    masses = tuple((one["plane"], one["mass_g"], one["angle_deg"]) for one in found["masses"])
    return Answer(found["source"], found["sequence"], datetime.fromisoformat(found["taken_at"]), masses)


def _not_finite(source: str, first: int, last: int) -> BrokenSource:
    return BrokenSource(
        f"a reading of {source!r}, sequences {first} to {last}, holds a NaN or infinite number: a source gives None "
        "for what it does not know"
    )
