"""Five mixed-variable design problems, vectorised over members.

Source: thesis on the dynamic performance of the thresher machine, chapter 4 (modified Jaya algorithm), its equations
with the printed slips corrected; optima recomputed by enumeration or closed form (the truss: best found).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from service.optimize.problem import Continuous, Discrete, FloatArray, Integer, MixedProblem


@dataclass(frozen=True)
class Design:
    """A problem, an optimal x to the digits known, and the optimum."""

    problem: MixedProblem
    best_x: tuple[float, ...]
    optimum: float


def _welded_beam(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Welded beam; x = [l, h, b, t] in inches."""
    length, h, b, t = x.T
    load, arm, young, shear = 6000.0, 14.0, 30e6, 12e6
    cost = 1.10471 * h**2 * length + 0.04811 * b * t * (arm + length)
    sigma = 6.0 * load * arm / (b * t**2)
    tau1 = load / (math.sqrt(2.0) * h * length)
    radius = np.sqrt(length**2 / 4.0 + ((h + t) / 2.0) ** 2)
    polar = 2.0 * math.sqrt(2.0) * h * length * (length**2 / 12.0 + ((h + t) / 2.0) ** 2)
    tau2 = load * (arm + length / 2.0) * radius / polar
    tau = np.sqrt(tau1**2 + 2.0 * tau1 * tau2 * length / (2.0 * radius) + tau2**2)
    slender = 1.0 - t / (2.0 * arm) * math.sqrt(young / (4.0 * shear))
    buckling = 4.013 * np.sqrt(young * shear * t**2 * b**6 / 36.0) / arm**2 * slender
    delta = 4.0 * load * arm**3 / (young * t**3 * b)
    g = [
        h / b - 1.0,
        sigma / 30000.0 - 1.0,
        (0.10471 * h**2 + 0.04811 * b * t * (arm + length)) / 5.0 - 1.0,
        tau / 13600.0 - 1.0,
        1.0 - h / 0.125,
        1.0 - buckling / load,
        delta / 0.25 - 1.0,
    ]
    return cost, np.stack(g, axis=1)


_HALVES = tuple(np.arange(0.5, 10.01, 0.5).tolist())
WELDED_BEAM = Design(
    MixedProblem((Integer(1, 10), Integer(1, 2), Discrete(_HALVES), Discrete(_HALVES)), _welded_beam),
    (1.0, 1.0, 1.0, 4.5),
    4.352135,
)


def _pressure_vessel(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Pressure vessel; x = [T_h, T_s, L, R] in inches."""
    head, shell, length, radius = x.T
    cost = (
        0.6224 * shell * length * radius
        + 1.7781 * head * radius**2
        + 3.1661 * shell**2 * length
        + 19.84 * shell**2 * radius
    )
    volume = math.pi * radius**2 * length + 4.0 / 3.0 * math.pi * radius**3
    g = [0.0193 * radius / shell - 1.0, 0.00954 * radius / head - 1.0, 1.0 - volume / 1296000.0, length / 240.0 - 1.0]
    return cost, np.stack(g, axis=1)


_PLATES = tuple((0.0625 * np.arange(1, 100)).tolist())
PRESSURE_VESSEL = Design(
    MixedProblem(
        (Discrete(_PLATES), Discrete(_PLATES), Continuous(10.0, 200.0), Continuous(10.0, 200.0)), _pressure_vessel
    ),
    (0.4375, 0.8125, 176.63659584, 42.09844560),
    6059.714335,
)

_SECTIONS = (
    *(1.62, 1.80, 1.99, 2.13, 2.38, 2.62, 2.63, 2.88, 2.93, 3.09, 3.13, 3.38, 3.47, 3.55, 3.63, 3.84, 3.87, 3.88, 4.18),
    *(4.22, 4.49, 4.59, 4.80, 4.97, 5.12, 5.74, 7.22, 7.97, 11.5, 13.5, 13.9, 14.2, 15.5, 16.0, 16.9, 18.8, 19.9, 22.0),
    *(22.9, 26.5, 30.0, 33.5),
)
_NODES = np.array([[720.0, 360.0], [720.0, 0.0], [360.0, 360.0], [360.0, 0.0], [0.0, 360.0], [0.0, 0.0]])
_BARS = np.array([[5, 3], [3, 1], [6, 4], [4, 2], [3, 4], [1, 2], [5, 4], [6, 3], [3, 2], [4, 1]]) - 1


def _truss(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ten-bar truss; x = areas in square inches; nodes 5 and 6 held, 100 kips down at nodes 2 and 4."""
    span = _NODES[_BARS[:, 1]] - _NODES[_BARS[:, 0]]
    length = np.hypot(span[:, 0], span[:, 1])
    elongation = np.zeros((10, 12))
    for bar, (a, b) in enumerate(_BARS):
        elongation[bar, 2 * a : 2 * a + 2] = -span[bar] / length[bar]
        elongation[bar, 2 * b : 2 * b + 2] = span[bar] / length[bar]
    free = elongation[:, :8]
    stiffness = np.einsum("bi,nb,bj->nij", free, 1e4 * x / length, free)
    load = np.zeros(8)
    load[[3, 7]] = -100.0
    moved = np.linalg.solve(stiffness, np.broadcast_to(load[:, None], (len(x), 8, 1)))[:, :, 0]
    stress = 1e4 * (moved @ free.T) / length
    return 0.1 * x @ length, np.concatenate([np.abs(stress) / 25.0 - 1.0, np.abs(moved) / 2.0 - 1.0], axis=1)


TRUSS = Design(
    MixedProblem((Discrete(_SECTIONS),) * 10, _truss),
    (33.5, 1.62, 22.9, 14.2, 1.62, 1.62, 7.97, 22.9, 22.0, 1.62),
    5490.737892,
)

_WIRES = (
    *(0.009, 0.0095, 0.0104, 0.0118, 0.0128, 0.0132, 0.014, 0.015, 0.0162, 0.0173, 0.018, 0.020, 0.023, 0.025, 0.028),
    *(0.032, 0.035, 0.041, 0.047, 0.054, 0.063, 0.072, 0.080, 0.092, 0.105, 0.120, 0.135, 0.148, 0.162, 0.177, 0.192),
    *(0.207, 0.225, 0.244, 0.263, 0.283, 0.307, 0.331, 0.362, 0.394, 0.4375, 0.500),
)


def _spring(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Helical compression spring; x = [D, N, d] in inches."""
    coil, turns, wire = x.T
    largest, force, stress, modulus = 1000.0, 300.0, 189000.0, 11.5e6
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = (4.0 * coil / wire - 1.0) / (4.0 * coil / wire - 4.0) + 0.615 * wire / coil
        stiffness = modulus * wire**4 / (8.0 * turns * coil**3)
        free = largest / stiffness + 1.05 * (turns + 2.0) * wire
        solid = 1.05 * (turns + 2.0) * wire
        preload = force / stiffness
        travel = (largest - force) / stiffness
        g = [
            8.0 * factor * largest * coil / (math.pi * wire**3) / stress - 1.0,
            free / 14.0 - 1.0,
            1.0 - wire / 0.2,
            coil / 3.0 - 1.0,
            1.0 - coil / wire / 3.0,
            preload / 6.0 - 1.0,
            (preload + travel + solid - free) / free,
            1.0 - travel / 1.25,
        ]
    return math.pi**2 * coil * wire**2 * (turns + 2.0) / 4.0, np.nan_to_num(np.stack(g, axis=1), nan=1e6, posinf=1e6)


SPRING = Design(
    MixedProblem((Continuous(0.6, 3.0), Integer(1, 70), Discrete(_WIRES)), _spring),
    (1.2230410100, 9.0, 0.283),
    2.658559166,
)


def _gear_train(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gear train of ratio 1 / 6.931; x = four numbers of teeth."""
    return (1.0 / 6.931 - x[:, 0] * x[:, 1] / (x[:, 2] * x[:, 3])) ** 2, np.zeros((len(x), 1))


GEAR_TRAIN = Design(MixedProblem((Integer(12, 60),) * 4, _gear_train), (16.0, 19.0, 43.0, 49.0), 2.700857e-12)
