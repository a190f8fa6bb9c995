"""A rotor of beam elements on springs: what a drum does, computed with nothing that the product computes with.

Euler-Bernoulli shaft elements with rotary inertia and gyroscopic moments, discs, isotropic or anisotropic supports with
damping; four coordinates a station (x, y, slopes about them). The response to unbalance is that of
M q'' + (C + w G) q' + K q = F at the speed w (Nelson and McVaugh 1976; Friswell et al., Dynamics of Rotating Machines,
2010, chapters 5 and 6).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
STEEL_E, STEEL_RHO = 2.06e11, 7850.0


@dataclass(frozen=True)
class Disc:
    """station: index. mass: kg. polar, transverse: moments of inertia, kg m^2."""

    station: int
    mass: float
    polar: float
    transverse: float


@dataclass(frozen=True)
class Support:
    """station: index. kx, ky: stiffness, N/m. c: damping, N s/m."""

    station: int
    kx: float
    ky: float
    c: float


@dataclass(frozen=True)
class Beam:
    """lengths: (E,) m of the elements. outer, inner: (E,) m, diameters."""

    lengths: tuple[float, ...]
    outer: tuple[float, ...]
    inner: tuple[float, ...]
    discs: tuple[Disc, ...]
    supports: tuple[Support, ...]

    @property
    def stations(self) -> int:
        """How many stations there are."""
        return len(self.lengths) + 1


def response(beam: Beam, rpm: float, stations: tuple[int, ...]) -> Complex:
    """Displacement (4 N, U) in m, amplitude and phase of exp(j w t), for 1 kg m of unbalance at each station (U,)."""
    omega = rpm * 2.0 * np.pi / 60.0
    M, G, K, C = matrices(beam)
    dynamic = K - omega**2 * M + 1j * omega * (C + omega * G)
    force = np.zeros((len(M), len(stations)), dtype=np.complex128)
    for column, station in enumerate(stations):
        # The force turns with the rotor, from x to y.
        force[4 * station, column] = omega**2
        force[4 * station + 1, column] = -1j * omega**2
    return np.asarray(np.linalg.solve(dynamic, force))


def criticals(beam: Beam, count: int = 3) -> Real:
    """Natural frequencies (count,) of the rotor at rest, r/min, both planes together."""
    M, _, K, _ = matrices(beam)
    values = np.linalg.eigvals(np.linalg.solve(M, K)).real
    return np.asarray(np.sqrt(np.sort(values[values > 1.0])[:count]) * 60.0 / (2.0 * np.pi))


def matrices(beam: Beam) -> tuple[Real, Real, Real, Real]:
    """Mass, gyroscopic (per rad/s), stiffness and damping matrices (4 N, 4 N)."""
    size = 4 * beam.stations
    M, G, K, C = (np.zeros((size, size)) for _ in range(4))
    for e, (length, outer, inner) in enumerate(zip(beam.lengths, beam.outer, beam.inner, strict=True)):
        at = np.arange(4 * e, 4 * e + 8)
        for whole, part in zip((M, G, K), _element(length, outer, inner), strict=True):
            whole[np.ix_(at, at)] += part
    for disc in beam.discs:
        x, y, a, b = range(4 * disc.station, 4 * disc.station + 4)
        M[x, x] += disc.mass
        M[y, y] += disc.mass
        M[a, a] += disc.transverse
        M[b, b] += disc.transverse
        G[a, b] += disc.polar
        G[b, a] -= disc.polar
    for support in beam.supports:
        x, y = 4 * support.station, 4 * support.station + 1
        K[x, x] += support.kx
        K[y, y] += support.ky
        C[x, x] += support.c
        C[y, y] += support.c
    return M, G, K, C


def _element(length: float, outer: float, inner: float) -> tuple[Real, Real, Real]:
    """Mass, gyroscopic and stiffness of an element in x1 y1 a1 b1 x2 y2 a2 b2; slopes a about x, b about y."""
    area = np.pi * (outer**2 - inner**2) / 4.0
    second = np.pi * (outer**4 - inner**4) / 64.0
    L = length
    k = STEEL_E * second / L**3 * np.array(
        [[12, 6 * L, -12, 6 * L], [6 * L, 4 * L**2, -6 * L, 2 * L**2], [-12, -6 * L, 12, -6 * L],
         [6 * L, 2 * L**2, -6 * L, 4 * L**2]]
    )  # fmt: skip
    m = STEEL_RHO * area * L / 420.0 * np.array(
        [[156, 22 * L, 54, -13 * L], [22 * L, 4 * L**2, 13 * L, -3 * L**2], [54, 13 * L, 156, -22 * L],
         [-13 * L, -3 * L**2, -22 * L, 4 * L**2]]
    )  # fmt: skip
    turning = STEEL_RHO * second / (30.0 * L) * np.array(
        [[36, 3 * L, -36, 3 * L], [3 * L, 4 * L**2, -3 * L, -(L**2)], [-36, -3 * L, 36, -3 * L],
         [3 * L, -(L**2), -3 * L, 4 * L**2]]
    )  # fmt: skip
    # In x the slope is that about y, in y it is minus that about x.
    to_x = np.zeros((4, 8))
    to_y = np.zeros((4, 8))
    for row, (x, y, sign) in enumerate(((0, 1, 1.0), (3, 2, -1.0), (4, 5, 1.0), (7, 6, -1.0))):
        to_x[row, x] = 1.0
        to_y[row, y] = sign
    mass = to_x.T @ (m + turning) @ to_x + to_y.T @ (m + turning) @ to_y
    stiff = to_x.T @ k @ to_x + to_y.T @ k @ to_y
    gyro = 2.0 * (to_x.T @ turning @ to_y - to_y.T @ turning @ to_x)
    return mass, np.asarray(gyro), stiff
