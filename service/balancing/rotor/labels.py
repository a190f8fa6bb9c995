"""Names by which messages call runs, planes and sensors."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Labels:
    """Names of the runs (K), planes (P) and sensors (S); what has no name is numbered from 1."""

    runs: tuple[str, ...] = ()
    planes: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()

    def run(self, index: int) -> str:
        """`run "trial left"`, or `run 2`."""
        return _label("run", self.runs, index)

    def plane(self, index: int) -> str:
        """`plane "left"`, or `plane 1`."""
        return _label("plane", self.planes, index)

    def sensor(self, index: int) -> str:
        """`sensor "A"`, or `sensor 1`."""
        return _label("sensor", self.sensors, index)


def _label(kind: str, names: tuple[str, ...], index: int) -> str:
    return f'{kind} "{names[index]}"' if index < len(names) else f"{kind} {index + 1}"


def listed(words: Iterable[str]) -> str:
    """Join words as a sentence does: `a`, `a and b`, `a, b and c`."""
    items = list(words)
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}" if items else ""
