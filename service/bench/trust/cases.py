"""Rotors of the campaign: linear responses of each to its masses and its own unbalance, at any speed near its own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from service.bench.trust.rotor import Beam, Complex, Disc, Real, Support, response


@dataclass(frozen=True)
class Probe:
    """A sensor: station, direction x or y, and whether it reads displacement (um peak to peak) or mm/s rms."""

    station: int
    direction: Literal["x", "y"] = "x"
    displacement: bool = False


@dataclass(frozen=True)
class Case:
    """speeds: r/min. planes, own: stations of the correction planes, and of the rotor's own unbalance.

    radius: m, of the planes. typical: kg m, size of the unbalance in a station.
    """

    name: str
    what: str
    beam: Beam
    speeds: tuple[float, ...]
    planes: tuple[int, ...]
    own: tuple[int, ...]
    probes: tuple[Probe, ...]
    radius: float
    typical: float
    trial_g: float


@dataclass(frozen=True)
class Answers:
    """influence: (S, P) per g; own: (S, U) per kg m; rows are the probes at each speed, in the product's lag sense."""

    influence: Complex
    own: Complex


def answers(case: Case, share: float = 0.0) -> Answers:
    """What the case does at its speeds times 1 + `share`."""
    rows_a, rows_b = [], []
    for rpm in case.speeds:
        turned = rpm * (1.0 + share)
        both = response(case.beam, turned, (*case.planes, *case.own))
        omega = turned * 2.0 * np.pi / 60.0
        for probe in case.probes:
            q = both[4 * probe.station + (probe.direction == "y")]
            # m to um peak to peak, or to mm/s rms. A lag is minus the phase of exp(j w t).
            seen = 2e6 * q if probe.displacement else 1e3 / np.sqrt(2.0) * 1j * omega * q
            lag = seen.conj()
            rows_a.append(lag[: len(case.planes)] * case.radius * 1e-3)
            rows_b.append(lag[len(case.planes) :])
    return Answers(np.array(rows_a), np.array(rows_b))


@cache
def near(name: str, steps: int = 41, most: float = 0.03) -> tuple[Real, Complex, Complex]:
    """Shares (N,), influence (N, S, P) and own (N, S, U) over a range of speeds, to interpolate in."""
    shares = np.linspace(-most, most, steps)
    found = [answers(CASES[name], float(share)) for share in shares]
    return shares, np.array([one.influence for one in found]), np.array([one.own for one in found])


def _drum(k: float, ratio: float = 1.0, c: float = 400.0) -> Beam:
    """A drum of 142 kg: stub shafts at the ends, a tube of 0.9 m between."""
    lengths = (0.12, *(0.9 / 6,) * 6, 0.12)
    outer = (0.07, *(0.46,) * 6, 0.07)
    inner = (0.0, *(0.4435,) * 6, 0.0)
    end = 20.0
    discs = (Disc(1, end, 0.5 * end * 0.05, 0.25 * end * 0.05), Disc(7, end, 0.5 * end * 0.05, 0.25 * end * 0.05))
    return Beam(lengths, outer, inner, discs, (Support(0, k, k * ratio, c), Support(8, 1.15 * k, 1.15 * k * ratio, c)))


def _overhung() -> Beam:
    """A fan of 55 kg on the free end of a shaft."""
    lengths = (0.3, 0.3, 0.11, 0.11)
    outer = (0.09,) * 4
    discs = (Disc(4, 55.0, 3.2, 1.9), Disc(3, 8.0, 0.1, 0.06))
    supports = (Support(0, 3e7, 3e7, 2e3), Support(2, 3e7, 3e7, 2e3))
    return Beam(lengths, outer, (0.0,) * 4, discs, supports)


def _flexible() -> Beam:
    """A rotor of about 150 kg that runs above its first critical speed."""
    lengths = (0.25,) * 8
    discs = (Disc(1, 30.0, 0.4, 0.25), Disc(4, 30.0, 0.5, 0.3), Disc(6, 25.0, 0.4, 0.25))
    k = 1.6e7
    return Beam(lengths, (0.085,) * 8, (0.0,) * 8, discs, (Support(0, k, k, 1e4), Support(8, 0.7 * k, 0.7 * k, 1e4)))


_ENDS = (Probe(0), Probe(8))
CASES: dict[str, Case] = {
    "a": Case("a", "drum on soft supports", _drum(2.6e6), (800.0,), (1, 7), (2, 3, 4, 6), _ENDS, 0.23, 1.2e-2, 150.0),
    "a-stiff": Case(
        "a-stiff",
        "drum on stiff supports",
        _drum(4e7, c=2e3),
        (800.0,),
        (1, 7),
        (2, 3, 4, 6),
        _ENDS,
        0.23,
        1.2e-2,
        150.0,
    ),
    "b": Case("b", "near a resonance", _drum(7.6e5), (900.0,), (1, 7), (2, 3, 4, 6), _ENDS, 0.23, 6e-3, 60.0),
    "c": Case("c", "overhung fan", _overhung(), (1480.0,), (3, 4), (1, 3, 4), (Probe(0), Probe(2)), 0.3, 6e-3, 40.0),
    "d": Case(
        "d",
        "flexible, two speeds above the first critical",
        _flexible(),
        (2400.0, 3000.0),
        (1, 4, 6),
        (1, 3, 5, 7),
        (Probe(0), Probe(8), Probe(3, displacement=True), Probe(5, displacement=True)),
        0.15,
        8e-4,
        12.0,
    ),
    "e": Case(
        "e",
        "anisotropic supports 1 : 4.4",
        _drum(2.0e6, 4.4),
        (800.0,),
        (1, 7),
        (2, 3, 4, 6),
        (Probe(0), Probe(0, "y"), Probe(8), Probe(8, "y")),
        0.23,
        1.2e-2,
        150.0,
    ),
}
