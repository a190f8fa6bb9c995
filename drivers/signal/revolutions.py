"""Key-phasor edges as turns of the rotor: faults repaired or refused, angle and speed at any time.

Between edges the angle follows the cubic spline through all of them: an even angular acceleration is followed exactly,
hunting within some turns closely, and where edges were missed the curve runs on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from drivers.checks import require
from drivers.errors import SignalRefused
from drivers.signal.block import Floats

MIN_TURNS = 4
MAX_REPAIRED = 0.1
"""Share of edges that may be missed, extra or out of place; a key-phasor worse than that needs a hand, not a repair."""
MAX_GAP = 3
"""Edges missed in a row; over a longer gap the count of turns would rest on the speed being steady."""
MAX_EDGES = 20_000
"""Edges in a block: more than three minutes at 6000 r/min, or a key-phasor that sees noise."""
OUT_OF_STEP = 0.12
"""Share of a turn by which an edge may differ from where the last period puts it, before it counts as extra."""
STEP_SLIP, PLACE_SLIP = 1.6, 1.1
"""As OUT_OF_STEP and OUT_OF_PLACE, in sample intervals of a sampled key-phasor: an edge is off by up to half of one."""
LARGEST_SLIP = 0.4
OUT_OF_PLACE = 0.02
"""Share of a turn by which an edge may always differ from the line between its neighbours."""


@dataclass(frozen=True, slots=True, eq=False)
class Revolutions:
    """Accepted edges: times (m,) in s and the number (m,) of the turn that begins there, counted from 0.

    missed, extra: edges that were lacking, and edges that were left out.
    """

    times: Floats
    numbers: Floats
    missed: int = 0
    extra: int = 0

    @property
    def count(self) -> int:
        """Whole turns between the first and the last edge."""
        return int(self.numbers[-1])

    def angle_and_speed(self, times: Floats) -> tuple[Floats, Floats]:
        """Rotor angle, rad from the first edge, and speed, rad/s, at times (n,) between the first and last edge."""
        t, y = self.times, math.tau * self.numbers
        slopes = _slopes(t, y)
        i = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
        h = np.diff(t)[i]
        s = (times - t[i]) / h
        rise = np.diff(y)[i]
        d0, d1 = h * slopes[i], h * slopes[i + 1]
        square, cube = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
        angle = y[i] + s * (d0 + s * (square + s * cube))
        speed = (d0 + s * (2.0 * square + 3.0 * s * cube)) / h
        return angle, speed


def turns_of(edges_s: Floats, *, most: int | None = MAX_EDGES, step_s: float = 0.0) -> Revolutions:
    """Count the turns of edges (m,), s, one to a turn.

    step_s: sample interval of the signal in which they were found, by half of which each may be off; 0: they are exact.
    An edge that is missing is counted over, one that comes between two turns or out of place is left out.
    Raises `InvalidSetting` for times that are not finite or do not increase, and `SignalRefused` (`too_short`: fewer
    than 4 turns; `tacho`: more than `most` edges, or more than a tenth of them or more than 3 in a row to be
    repaired).
    """
    require(edges_s.ndim == 1, f"shape {edges_s.shape} of edges", "be (m,)")
    require(bool(np.isfinite(edges_s).all()), "an edge time", "be a finite number of seconds")
    gaps = np.diff(edges_s)
    require(bool((gaps > 0.0).all()), "edge times", "increase")
    if len(edges_s) < MIN_TURNS + 1:
        raise SignalRefused(
            f"{len(edges_s)} key-phasor edges in the block; {MIN_TURNS + 1} are the least: record for longer, or "
            "check the key-phasor",
            code="too_short",
        )
    if most is not None and len(edges_s) > most:
        raise SignalRefused(
            f"{len(edges_s)} key-phasor edges in a block; {most} are the most: take shorter blocks, or raise the "
            "hysteresis if it sees noise",
            code="tacho",
        )
    off = step_s / float(np.median(gaps))
    walks = [
        _walk(edges_s, start, float(np.median(gaps[start : start + few])), off)
        for start in range(min(3, len(gaps)))
        for few in (7, len(gaps))
    ]
    index, numbers = _without_strays(edges_s, *min(walks, key=lambda walk: _repairs(edges_s, walk)), off)
    missing = np.diff(numbers) - 1.0
    turns = Revolutions(edges_s[index], numbers - numbers[0], int(missing.sum()), len(edges_s) - len(index))
    _judge(turns, int(missing.max(initial=0)))
    return turns


def one_a_turn(edges_s: Floats, pulses: int, *, before: int = 0, step_s: float = 0.0) -> Floats:
    """Every `pulses`-th edge of edges (m,), s, counted over those that were missed.

    before: pulses that came before the first edge. The phase counts from the first pulse of all: which of several equal
    marks that was, nothing tells.
    Raises as `turns_of`.
    """
    turns = turns_of(edges_s, most=None, step_s=step_s)
    return np.asarray(turns.times[(turns.numbers + before) % pulses == 0.0], float)


def _walk(edges: Floats, start: int, period: float, off: float) -> tuple[list[int], list[int]]:
    """Indices of the edges that come in step from `start` on, and their turn numbers; off: sample interval in turns."""
    kept, numbers = [start], [0]
    for index in range(start + 1, len(edges)):
        steps = (edges[index] - edges[kept[-1]]) / period
        whole = round(steps)
        if whole >= 1 and abs(steps - whole) <= min(max(OUT_OF_STEP, STEP_SLIP * off), LARGEST_SLIP):
            period = 0.5 * (period + (edges[index] - edges[kept[-1]]) / whole)
            kept.append(index)
            numbers.append(numbers[-1] + whole)
    return kept, numbers


def _repairs(edges: Floats, walk: tuple[list[int], list[int]]) -> int:
    """Edges missed and left out on a walk; one before its start weighs as a gap, or a gap would be cut off with it."""
    kept, numbers = walk
    return (numbers[-1] + 1 - len(kept)) + (len(edges) - len(kept)) + MAX_GAP * kept[0]


def _without_strays(
    edges: Floats, kept: list[int], numbers: list[int], off_by: float
) -> tuple[NDArray[np.intp], Floats]:
    """Leave out, worst first, the edges that stand off the line between their neighbours much more than the rest."""
    index, number = np.array(kept, np.intp), np.array(numbers, float)
    for _ in range(int(MAX_REPAIRED * len(kept)) + 1):
        if len(index) < 4:
            break
        t = edges[index]
        share = np.diff(t)[:-1] / (t[2:] - t[:-2])
        off = np.abs(number[1:-1] - (number[:-2] + share * (number[2:] - number[:-2])))
        worst = int(np.argmax(off))
        if off[worst] <= max(OUT_OF_PLACE, PLACE_SLIP * off_by, 8.0 * float(np.median(off))):
            break
        index, number = np.delete(index, worst + 1), np.delete(number, worst + 1)
    return index, number


def _judge(turns: Revolutions, longest_gap: int) -> None:
    if turns.count < MIN_TURNS:
        raise SignalRefused(
            f"{turns.count} turns in step; {MIN_TURNS} are the least: record for longer, or check the key-phasor",
            code="too_short" if turns.extra <= 1 else "tacho",
        )
    repaired = turns.missed + turns.extra
    if repaired > max(1.0, MAX_REPAIRED * turns.count) or longest_gap > MAX_GAP:
        raise SignalRefused(
            f"{turns.missed} key-phasor edges missed (up to {longest_gap} in a row) and {turns.extra} too many in "
            f"{turns.count} turns; at most {MAX_REPAIRED:.0%} and {MAX_GAP} in a row can be repaired: check the "
            "gap, the mark (one to a turn) and the threshold",
            code="tacho",
        )


def _slopes(t: Floats, y: Floats) -> Floats:
    """Slope at each knot of the cubic spline through all."""
    return np.asarray(CubicSpline(t, y)(t, 1), float)
