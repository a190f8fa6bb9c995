"""A tone so near the 1x component that the taper cannot keep it out: fitted together with the orders, and taken out.

All frequencies near 1x are tried on samples averaged over parts of a turn, each with the orders by least squares; the
one that explains most is fitted once more to all samples. A 1x component that grows or shrinks evenly over the block
is no such tone: it is taken out before one is looked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drivers.signal.block import Floats
from drivers.signal.orders import Course, normal_equations
from drivers.signal.wander import speed_rows

NEAREST, FARTHEST = 0.36, 4.5
"""Beats in the block that a tone must make to be told from 1x, and beyond which the taper keeps it out."""
MIN_TURNS = 8
PER_TURN = 8
STEPS_A_BEAT = 6
GAUSS_NEWTON, MAX_BEATS = 3, 0.1
"""Steps by which the frequency of a tone is improved, and the largest of them, in beats."""
SURE = 15.0
"""Ratio F of what the tone explains, for each of its two numbers, to what is left for each sample."""
MIN_SHARE = 0.03
"""Share of the 1x amplitude below which it is left alone."""


@dataclass(frozen=True, slots=True, eq=False)
class CloseTone:
    """order; amplitude, peak, in the unit of the values; samples (n,) of it.

    widening: by how much the standard deviation of the 1x vector grows with the tone in the fit.
    """

    order: float
    amplitude: float
    samples: Floats
    widening: float


def close_tone_of(course: Course, basis: Floats, values: Floats, seen: Floats, one_x: float) -> CloseTone | None:
    """Look for a tone within a few beats of 1x in values (n,); seen (n,): 0 for a lost sample, else 1.

    basis (m, n): of the orders; one_x: amplitude of order 1. None where none stands out.
    """
    turns = course.turns
    if turns < MIN_TURNS:
        return None
    place = np.linspace(0.0, 1.0, len(values))
    step = max(1, len(values) // (PER_TURN * turns))
    known = np.vstack([basis, speed_rows(course, basis)])
    thin = _Thin(known, values, seen, course.place, place, step, turns)
    beats = np.arange(NEAREST, min(FARTHEST, 0.45 * turns), 1.0 / STEPS_A_BEAT)
    orders = 1.0 + np.concatenate([-beats[::-1], beats]) / turns
    best = float(orders[int(np.argmax(thin.explained(orders)))])
    width = 1.0 / STEPS_A_BEAT / turns
    for _ in range(3):
        near = best + width * np.linspace(-1.0, 1.0, 11)
        near = near[np.abs(near - 1.0) * turns >= 0.9 * NEAREST]
        best = float(near[int(np.argmax(thin.explained(near)))])
        width /= 5.0
    if not thin.sure(best):
        return None
    tone = _fitted(known, len(basis), values, seen, place, best, turns)
    return tone if tone is not None and tone.amplitude >= MIN_SHARE * one_x else None


class _Thin:
    """The samples averaged over parts of a turn, and what a tone explains of them beside the orders."""

    def __init__(
        self, basis: Floats, values: Floats, seen: Floats, course: Floats, place: Floats, step: int, turns: int
    ) -> None:
        def averaged(rows: Floats) -> Floats:
            count = rows.shape[-1] // step
            cut = (rows * seen)[..., : count * step]
            return np.asarray(cut.reshape(*rows.shape[:-1], count, step).mean(axis=-1))

        trend = 2.0 * course - 1.0
        rows = averaged(np.vstack([basis, trend * basis[2], trend * basis[3]]))
        self._span = np.linalg.qr(rows.T)[0]
        self._rest = self._without(averaged(values))
        self._place, self._seen, self._turns = averaged(place), averaged(np.ones_like(place)), turns
        self._power = float(self._rest @ self._rest)
        self._free = len(self._rest) - len(rows) - 2

    def _without(self, values: Floats) -> Floats:
        return np.asarray(values - self._span @ (self._span.T @ values))

    def explained(self, orders: Floats) -> Floats:
        """Sum of squares (f,) that a tone of each of these orders (f,) explains."""
        angle = math.tau * self._turns * self._place[:, None] * orders
        pairs = np.stack([np.cos(angle), np.sin(angle)]) * self._seen[:, None]
        within = np.einsum("nm,pnf->pmf", self._span, pairs, optimize=True)
        gram = np.einsum("pnf,qnf->fpq", pairs, pairs, optimize=True) - np.einsum("pmf,qmf->fpq", within, within)
        sides = np.einsum("pnf,n->fp", pairs, self._rest)
        size = gram[:, 0, 0] * gram[:, 1, 1] - gram[:, 0, 1] ** 2
        good = size > 1e-9 * (gram[:, 0, 0] + gram[:, 1, 1]) ** 2
        both = gram[:, 1, 1] * sides[:, 0] ** 2 + gram[:, 0, 0] * sides[:, 1] ** 2
        both -= 2.0 * gram[:, 0, 1] * sides[:, 0] * sides[:, 1]
        return np.where(good, both / np.where(good, size, 1.0), 0.0)

    def sure(self, order: float) -> bool:
        """Whether it explains far more than what is left could by chance."""
        found = float(self.explained(np.array([order]))[0])
        left = max(self._power - found, 1e-30 * self._power)
        return self._free > 0 and 0.5 * found > SURE * left / self._free


def _fitted(
    known: Floats, orders: int, values: Floats, seen: Floats, place: Floats, order: float, turns: int
) -> CloseTone | None:
    """The tone beside known rows (m, n), the first this many of them the orders'; None where it comes too near 1x.

    Its frequency is improved by Gauss and Newton's method: the last row is the change of the tone with it, in beats.
    """
    for _ in range(GAUSS_NEWTON):
        angle = math.tau * order * turns * place
        pair = np.stack([np.cos(angle), np.sin(angle)])
        found = np.linalg.solve(*normal_equations(np.vstack([known, pair]), seen, values))
        slide = math.tau * (place - 0.5) * (found[-1] * pair[0] - found[-2] * pair[1])
        matrix, side = normal_equations(np.vstack([known, pair, slide]), seen, values)
        beats = float(np.linalg.lstsq(matrix, side, rcond=1e-12)[0][-1])
        order += min(max(beats, -MAX_BEATS), MAX_BEATS) / turns
        if abs(order - 1.0) * turns < NEAREST:
            return None
    alone = np.linalg.inv(matrix[:orders, :orders])
    joint = np.linalg.pinv(matrix, hermitian=True)  # with its frequency: a third number that the orders share with it
    widening = math.sqrt(float((joint[2, 2] + joint[3, 3]) / (alone[2, 2] + alone[3, 3])))
    samples = np.asarray(found[-2:] @ pair, float)
    return CloseTone(order, math.hypot(found[-2], found[-1]), samples, widening)
