"""The discrete problem: which stock masses go into which positions.

Every objective of the product is a norm of r = offset + matrix @ u, where u[p] is the vector sum, in g, of the masses
fitted in plane p (`SelectionPlane.fixed` included):

================== ============================= ==================== =========== ==========
objective          r                             matrix               weights     norm
================== ============================= ==================== =========== ==========
components         unbalance missed, g.mm        diag(radius)         0.5         components
residual_vibration residual 1x vibration         influence per g      1 / limit   sum max rms
bearing_force      reactions of a rigid rotor, N force per g          0.5 / |F0|  sum
================== ============================= ==================== =========== ==========
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.messages import Message

BoolArray = NDArray[np.bool_]
Norm = Literal["components", "sum", "max", "rms"]
Status = Literal["optimal", "within_uncertainty", "limit_reached", "heuristic", "infeasible"]

UNLIMITED = int(np.iinfo(np.int64).max)
"""Count of a catalogue item, or pieces a position takes, when there is no limit."""


@dataclass(frozen=True)
class Objective:
    """Norm of r = offset + matrix @ u; see the table above.

    matrix: (S, P) complex, unit of r per g; offset: (S,) complex; weights: (S,) positive.
    norm: `components` sum w (|Re r| + |Im r|); `sum` sum w |r|; `max` max w |r|; `rms` sqrt(mean (w |r|)^2).
    """

    matrix: ComplexArray
    offset: ComplexArray
    weights: FloatArray
    norm: Norm


@dataclass(frozen=True)
class SelectionPlane:
    """One correction plane as the selection sees it.

    angles: (H,) radians, internal sense. capacity: (H,) pieces that each position still takes (0: blocked or
    occupied). capacity_g: (H,) grams that each position still takes, fasteners included. max_pieces, max_mass_g: of the
    pieces chosen. fixed: vector sum, in g, of pieces that stay whatever is chosen. allowed: (H, I), which item may go
    into which position, where that is restricted.
    """

    angles: FloatArray
    capacity: IntArray
    capacity_g: FloatArray
    max_pieces: int
    max_mass_g: float = float("inf")
    fixed: complex = 0j
    allowed: BoolArray | None = None


@dataclass(frozen=True)
class Stock:
    """The box of stock masses, shared by all planes.

    masses_g: (I,). counts: (I,) pieces of each. fasteners_g: (I,) of each mass's fastener, counted as mass.
    """

    masses_g: FloatArray
    counts: IntArray
    fasteners_g: FloatArray


@dataclass(frozen=True)
class SelectionProblem:
    """Objective, planes and stock; `validate` is called by every solver before it starts."""

    objective: Objective
    planes: tuple[SelectionPlane, ...]
    stock: Stock


@dataclass(frozen=True, order=True)
class Piece:
    """One mass in one position: indices into the plane's angles and the stock's items."""

    position: int
    item: int


@dataclass(frozen=True)
class SelectionResult:
    """What a solver found and what it proved.

    pieces: one sorted tuple of `Piece` per plane, or None when infeasible. vectors: (P,) complex g, fixed included.
    residual: (S,) complex r. lower_bound: no feasible selection has a smaller objective (0 where nothing is proved).
    message: what is proved. reason: why there is no selection, and what would help.
    """

    status: Status
    message: Message
    pieces: tuple[tuple[Piece, ...], ...] | None
    value: float
    lower_bound: float
    vectors: ComplexArray
    residual: ComplexArray
    evaluations: int
    reason: Message | None = None
    details: dict[str, float] = field(default_factory=dict)

    @property
    def gap(self) -> float:
        """How much better, at most, another selection could be, in the objective's unit."""
        return max(0.0, self.value - self.lower_bound)
