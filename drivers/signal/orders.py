"""1x and its harmonics by weighted least squares on the rotor angle of each sample.

The model is y = d0 + d1 u + Re sum_k c_k exp(j k angle), k = 1..K, u the place in the block. The kernels follow the
angle, so a drifting speed smears nothing, and no sample is interpolated: a time-variant discrete Fourier transform
whose orthogonality error the normal equations remove (J. R. Blough, Development and analysis of time variant discrete
Fourier transform order tracking, Mechanical Systems and Signal Processing 17 (2003) 1185-1199).

A quantity is integrated (p = -1, -2) or differentiated (p = 1, 2) sample by sample with the speed w of the moment: if
x = Re(X exp(j k angle)) with a constant X, its derivative is Re(j k w X exp(j k angle)). Hence c_k is fitted to
y w^p and multiplied by (j k)^p. Exact where the amplitude of the result is constant; where that of the raw signal is
constant instead, the phase is turned by the relative change of speed per rad: 0.03 / (2 pi 8) rad = 0.034 degrees for
3 % of drift over 8 turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.signal.block import Floats

PIECE = 1024
Complexes = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """The samples between the first and last edge: angle (n,) rad from the first edge, speed (n,) rad/s."""

    angle: Floats
    speed: Floats
    turns: int

    @property
    def place(self) -> Floats:
        """Place (n,) of each sample in the block, 0 to 1 by angle."""
        return self.angle / (math.tau * self.turns)


def basis_of(course: Course, orders: int) -> Floats:
    """Rows (2 + 2 orders, n): 1, u, then cosine and sine of each order."""
    rows = np.empty((2 + 2 * orders, len(course.angle)))
    rows[0], rows[1] = 1.0, 2.0 * course.place - 1.0
    rows[2], rows[3] = np.cos(course.angle), np.sin(course.angle)
    for row in range(4, len(rows), 2):  # one turn on from the order before; faster than a cosine for each
        before, odd_before = rows[row - 2], rows[row - 1]
        rows[row] = before * rows[2] - odd_before * rows[3]
        rows[row + 1] = odd_before * rows[2] + before * rows[3]
    return rows


def fit_orders(basis: Floats, weights: Floats, values: Floats) -> tuple[Complexes, Floats]:
    """Vectors c_k (K,), peak, of values (n,) under weights (n,), and the coefficients (2 + 2 K,) of the basis.

    Raises numpy.linalg.LinAlgError where the weights leave too few samples to tell the rows apart.
    """
    coefficients = np.linalg.solve(*normal_equations(basis, weights, values))
    pairs = coefficients[2:].reshape(-1, 2)
    return np.asarray(pairs[:, 0] - 1j * pairs[:, 1], complex), np.asarray(coefficients, float)


def normal_equations(rows: Floats, weights: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Matrix (m, m) and right side (m,) of the weighted least squares of values (n,) on rows (m, n).

    Summed up in pieces that stay in the cache, and small enough to be multiplied on one core: spread over several, such
    slim products cost more than they save.
    """
    matrix, side = np.zeros((len(rows), len(rows))), np.zeros(len(rows))
    for first in range(0, rows.shape[1], PIECE):
        piece = slice(first, first + PIECE)
        weighted = rows[:, piece] * weights[piece]
        matrix += weighted @ rows[:, piece].T
        side += (weighted * values[piece]).sum(axis=1)
    return matrix, side


def turned(vectors: Complexes, power: int) -> Complexes:
    """Vectors c_k (K,) times (j k)^power."""
    orders = np.arange(1, len(vectors) + 1)
    return np.asarray(vectors * (1j * orders) ** power)
