"""Where an angle of the machine's conventions lies on paper.

Angles are drawn as somebody sees the drum who stands on the side named by `seen_from`, with the key-phasor mark up.
Internal angles count against the rotation: clockwise on paper where the drum turns counter-clockwise. A phase lag
counts that way too, so that a vector lies in the same place whether it is stated as lag or lead.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace

from service.balancing.rotor.phasors import to_degrees, to_radians
from service.model.machine import AngleSense, Machine, PhaseSense
from service.web.pictures.drawing import Line, Point


@dataclass(frozen=True)
class Compass:
    """Angles on paper about `centre`; `clockwise` is the way internal angles count. The mark is up."""

    clockwise: bool
    centre: Point = (0.0, 0.0)

    def point(self, radius: float, internal: float) -> Point:
        """The point at `radius` and the internal angle in radians."""
        turn = internal if self.clockwise else -internal
        return self.centre[0] + radius * math.sin(turn), self.centre[1] - radius * math.cos(turn)

    def at(self, radius: float, degrees: float, sense: AngleSense | PhaseSense) -> Point:
        """The point at `radius` and the angle stated in `sense`."""
        return self.point(radius, to_radians(degrees, sense))

    def tip(self, vector: complex, scale: float) -> Point:
        """The tip of an internal vector drawn from the centre, `scale` units of paper for 1."""
        return self.point(abs(vector) * scale, cmath.phase(vector))

    def stated(self, where: Point, sense: AngleSense | PhaseSense) -> float:
        """The angle in degrees in `sense` at which a point of the paper lies: `at` undone."""
        turn = math.atan2(where[0] - self.centre[0], self.centre[1] - where[1])
        return to_degrees(turn if self.clockwise else -turn, sense)

    def arrow(self, radius: float, begin: float, end: float, cls: str, head: float = 9.0) -> tuple[Line, Line]:
        """An arc with a head, from one internal angle in radians to another."""
        steps = max(4, int(abs(end - begin) / math.radians(4.0)))
        angles = [begin + (end - begin) * step / steps for step in range(steps + 1)]
        arc = tuple(self.point(radius, angle) for angle in angles)
        return Line(arc, cls), arrow_head(arc[-2], arc[-1], cls + "-head", head)


def compass_of(machine: Machine, centre: Point, *, mirrored: bool = False) -> Compass:
    """The compass of a machine; `mirrored`: as seen from the other end, or as if a sense were the other one."""
    return Compass((machine.rotation == "ccw") != mirrored, centre)


def arrow_head(tail: Point, tip: Point, cls: str, size: float = 9.0) -> Line:
    """A head at `tip` for a line that comes from `tail`."""
    dx, dy = tip[0] - tail[0], tip[1] - tail[1]
    length = math.hypot(dx, dy) or 1.0
    ux, uy = dx / length * size, dy / length * size
    back = (tip[0] - ux, tip[1] - uy)
    return Line(
        (tip, (back[0] - 0.42 * uy, back[1] + 0.42 * ux), (back[0] + 0.42 * uy, back[1] - 0.42 * ux)), cls, True
    )


def flipped(machine: Machine, sense: str) -> Machine:
    """The machine with its `angle_sense` or `phase_sense` the other way: the same numbers, the mirrored picture."""
    if sense == "phase_sense":
        return replace(machine, phase_sense="lead" if machine.phase_sense == "lag" else "lag")
    return replace(
        machine, angle_sense="with_rotation" if machine.angle_sense != "with_rotation" else "against_rotation"
    )
