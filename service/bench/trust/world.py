"""What really happens to a rotor: runs with every kind of error, and what is true beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from service.bench.trust.cases import Case, answers, near
from service.bench.trust.rotor import Complex, Real

UNSEEN = 1e-4
"""Least scatter of a reading, as a share of the as-found amplitude: nothing reads without any."""


@dataclass(frozen=True)
class ErrorSet:
    """Standard deviations, shares of an amplitude unless stated; of both components together where it is a vector's.

    within: of a reading, share of the as-found amplitude, per real component, and known. repeat: from start to start.
    drift: change per run, all sensors alike. warm: how much more the first run reads, dying out by a third each run.
    speed: of the speed of a run, measured. mass, angle_deg: of each piece. step: of the display, share of the as-found
    amplitude; the phase to 1 degree with it.
    """

    within: float = 0.002
    repeat: float = 0.0
    drift: float = 0.0
    warm: float = 0.0
    speed: float = 0.0
    mass: float = 0.0
    angle_deg: float = 0.0
    step: float = 0.0


@dataclass(frozen=True)
class Piece:
    """A piece as it is stated, and as it really is: complex g."""

    plane: int
    stated: complex
    true: complex


@dataclass(frozen=True)
class Seen:
    """A run as it is read: vectors (S,), the scatter of the readings (S,), the speed share that it turned off."""

    vibration: Complex
    scatter: Real
    speed: float


@dataclass
class World:
    """A rotor with its unbalance. runs: how many were taken."""

    case: Case
    errors: ErrorSet
    rng: np.random.Generator
    own: Complex = field(init=False)
    runs: int = 0

    def __post_init__(self) -> None:
        """Draw the rotor's own unbalance and how it warms up."""
        count = len(self.case.own)
        self.own = self.case.typical / np.sqrt(2.0) * _circular(self.rng, count)
        self.drifting = self.errors.drift / np.sqrt(2.0) * complex(_circular(self.rng, 1)[0])
        self.warming = self.errors.warm / np.sqrt(2.0) * complex(_circular(self.rng, 1)[0])
        self.bow = np.zeros(self.rows, dtype=np.complex128)

    @property
    def rows(self) -> int:
        """How many sensors at how many speeds."""
        return len(self.case.probes) * len(self.case.speeds)

    @property
    def influence(self) -> Complex:
        """True coefficients (S, P), per g."""
        return answers_of(self.case)[0]

    @property
    def initial(self) -> Complex:
        """True vibration (S,) as found."""
        return np.asarray(answers_of(self.case)[1] @ self.own + self.bow)

    def true(self, masses: Complex) -> Complex:
        """True vibration (S,) at the nominal speeds with masses (P,) complex g on."""
        return np.asarray(self.initial + self.influence @ masses)

    def piece(self, plane: int, stated: complex) -> Piece:
        """A piece as it is bolted on."""
        off = 1.0 + self.errors.mass * self.rng.standard_normal()
        turn = np.radians(self.errors.angle_deg) * self.rng.standard_normal()
        return Piece(plane, stated, stated * off * np.exp(1j * turn))

    def run(self, pieces: Sequence[Piece] = ()) -> Seen:
        """Take a run."""
        masses = on_planes(pieces, len(self.case.planes), true=True)
        speed = self.errors.speed * float(self.rng.standard_normal())
        A, own = at_speed(self.case, speed) if speed else answers_of(self.case)
        v = own @ self.own + self.bow + A @ masses
        v = v * (1.0 + self.errors.repeat / np.sqrt(2.0) * _circular(self.rng, len(v)))
        v = v * (1.0 + self.drifting * self.runs + self.warming * 3.0**-self.runs)
        self.runs += 1
        size = np.abs(self.initial)
        scatter = np.maximum(self.errors.within, UNSEEN) * size
        v = v + scatter * _circular(self.rng, len(v))
        if self.errors.step:
            step, turn = self.errors.step * size, np.radians(1.0)
            v = np.round(np.abs(v) / step) * step * np.exp(1j * np.round(np.angle(v) / turn) * turn)
            scatter = np.sqrt(scatter**2 + step**2 / 12.0 + (np.abs(v) * turn) ** 2 / 24.0)
        return Seen(np.asarray(v), np.asarray(scatter), speed)


_ANSWERS: dict[str, tuple[Complex, Complex]] = {}


def answers_of(case: Case) -> tuple[Complex, Complex]:
    """Coefficients and own response at the nominal speeds, computed once."""
    if case.name not in _ANSWERS:
        found = answers(case)
        _ANSWERS[case.name] = (found.influence, found.own)
    return _ANSWERS[case.name]


def at_speed(case: Case, share: float) -> tuple[Complex, Complex]:
    """The same at the nominal speeds times 1 + `share`, interpolated."""
    shares, A, own = near(case.name)
    place = float(np.clip((share - shares[0]) / (shares[1] - shares[0]), 0.0, len(shares) - 1.001))
    k, part = int(place), place - int(place)
    return np.asarray((1.0 - part) * A[k] + part * A[k + 1]), np.asarray((1.0 - part) * own[k] + part * own[k + 1])


def on_planes(pieces: Sequence[Piece], planes: int, *, true: bool) -> Complex:
    """Vector sums (P,) of pieces."""
    out = np.zeros(planes, dtype=np.complex128)
    for piece in pieces:
        out[piece.plane] += piece.true if true else piece.stated
    return out


def _circular(rng: np.random.Generator, count: int) -> Complex:
    return np.asarray(rng.standard_normal(count) + 1j * rng.standard_normal(count))
