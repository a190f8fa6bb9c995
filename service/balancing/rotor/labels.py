"""Names by which messages call runs, planes and sensors."""

from __future__ import annotations

from dataclasses import dataclass

from service.messages import Part
from service.messages.message import PartKind


@dataclass(frozen=True)
class Labels:
    """Names of the runs (K), planes (P) and sensors (S), or whole parts; what has no name is numbered from 1."""

    runs: tuple[str | Part, ...] = ()
    planes: tuple[str | Part, ...] = ()
    sensors: tuple[str | Part, ...] = ()

    def run(self, index: int) -> Part:
        """`run "trial left"`, or `run 2`."""
        return _part("run", self.runs, index)

    def plane(self, index: int) -> Part:
        """`plane "left"`, or `plane 1`."""
        return _part("plane", self.planes, index)

    def sensor(self, index: int) -> Part:
        """`sensor "A"`, or `sensor 1`."""
        return _part("sensor", self.sensors, index)


def _part(kind: PartKind, names: tuple[str | Part, ...], index: int) -> Part:
    name = names[index] if index < len(names) else None
    return name if isinstance(name, Part) else Part(kind, int(index) + 1, name)
