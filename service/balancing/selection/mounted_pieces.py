"""Pieces that are on the rotor already: they stay, may be moved, or may come off.

A piece that may move or come off becomes a piece of the box that may go anywhere, or only back to its own position; its
effect is taken off the rotor first. So every solver treats them like stock, and what becomes of them is read off the
selection afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from service.balancing.selection.placements import Selection, effective_g
from service.balancing.selection.problem import UNLIMITED, Piece, SelectionPlane, SelectionProblem, Stock
from service.errors import NumericsError
from service.messages import Message, Quantity

May = Literal["stay", "move", "remove"]
ALIKE_G = 1e-9
"""Two pieces whose masses differ by less are alike."""


@dataclass(frozen=True)
class MountedPiece:
    """A piece on the rotor: plane index, angle in radians (internal sense), mass in g with its fastener.

    may: `stay` it must; `move` it may stay, go to any position of any plane, or come off; `remove` it may come off.
    """

    plane: int
    angle: float
    mass_g: float
    may: May


@dataclass(frozen=True)
class PieceAction:
    """What becomes of a fitted piece; `to` is its plane and position where it stays or moves."""

    piece: MountedPiece
    does: Literal["stays", "moves", "comes_off"]
    to: tuple[int, int] | None


@dataclass(frozen=True)
class MountedProblem:
    """The problem with the fitted pieces in it; items and positions of the movable ones."""

    problem: SelectionProblem
    fitted: tuple[MountedPiece, ...]
    places: tuple[int, ...]
    items: tuple[int | None, ...]

    def fates(self, selection: Selection) -> tuple[tuple[PieceAction, ...], Selection]:
        """What becomes of each fitted piece, in order, and the pieces that come new out of the box."""
        left = [list(pieces) for pieces in selection]
        mass = effective_g(self.problem.stock)
        fates: dict[int, PieceAction] = {}
        for n, (piece, place, item) in enumerate(zip(self.fitted, self.places, self.items, strict=True)):
            if item is None:
                fates[n] = PieceAction(piece, "stays", (piece.plane, place))
                continue
            # A piece is not unbolted to bolt its like into the same hole.
            alike = [q for q in left[piece.plane] if q.position == place and abs(mass[q.item] - mass[item]) < ALIKE_G]
            if alike:
                left[piece.plane].remove(Piece(place, item) if Piece(place, item) in alike else alike[0])
                fates[n] = PieceAction(piece, "stays", (piece.plane, place))
        for n, (piece, item) in enumerate(zip(self.fitted, self.items, strict=True)):
            if n in fates:
                continue
            target = next(((p, q) for p, pieces in enumerate(left) for q in pieces if q.item == item), None)
            if target is None:
                fates[n] = PieceAction(piece, "comes_off", None)
            else:
                left[target[0]].remove(target[1])
                fates[n] = PieceAction(piece, "moves", (target[0], target[1].position))
        return tuple(fates[n] for n in range(len(self.fitted))), tuple(tuple(pieces) for pieces in left)


def with_fitted(
    problem: SelectionProblem, fitted: Sequence[MountedPiece], *, in_offset: bool, tolerance: float
) -> MountedProblem:
    """Add pieces on the rotor to a problem that was stated without them.

    in_offset: whether the objective's offset was measured with them on (as-found pieces), or not (pieces of a plan, of
    which the correction is the total). tolerance: radians within which an angle is a position. Raises NumericsError for
    a piece in no plane, at no position, or without a mass.
    """
    planes, stock = list(problem.planes), problem.stock
    places, items = [], []
    restricted: list[tuple[int, int, int]] = []
    for piece in fitted:
        _require(piece, len(planes))
        place = position_at(planes[piece.plane], piece.angle, tolerance)
        vector = piece.mass_g * np.exp(1j * planes[piece.plane].angles[place])
        item: int | None = None
        if piece.may == "stay":
            planes[piece.plane] = _occupied(planes[piece.plane], place, piece.mass_g)
            change = 0.0 if in_offset else vector
        else:
            stock, item = _into_the_box(stock, piece, restricted)
            if piece.may == "remove":
                restricted.append((item, piece.plane, place))
            change = -vector if in_offset else 0.0
        planes[piece.plane] = replace(planes[piece.plane], fixed=complex(planes[piece.plane].fixed + change))
        places.append(place)
        items.append(item)
    planes = [_restricted(plane, p, stock, restricted) for p, plane in enumerate(planes)]
    return MountedProblem(
        replace(problem, planes=tuple(planes), stock=stock), tuple(fitted), tuple(places), tuple(items)
    )


def position_at(plane: SelectionPlane, angle: float, tolerance: float) -> int:
    """Position nearest to `angle`; raises NumericsError where none lies within `tolerance` (radians)."""
    away = np.abs(np.angle(np.exp(1j * (plane.angles - angle))))
    nearest = int(away.argmin())
    if not away[nearest] <= tolerance:
        raise NumericsError(
            Message(
                "numerics.piece_between_positions",
                angle=Quantity(math.degrees(angle), "deg"),
                away=Quantity(math.degrees(float(away[nearest])), "deg"),
                most=Quantity(math.degrees(tolerance), "deg"),
            ),
            field="fitted.angle",
            value=math.degrees(angle),
        )
    return nearest


def _require(piece: MountedPiece, planes: int) -> None:
    if not 0 <= piece.plane < planes:
        raise NumericsError(
            Message("numerics.piece_plane_unknown", plane=piece.plane, planes=planes),
            field="fitted.plane",
            value=piece.plane,
        )
    if not (math.isfinite(piece.mass_g) and piece.mass_g > 0.0):
        raise NumericsError(
            Message("numerics.piece_mass_not_positive", mass=Quantity(piece.mass_g, "g")),
            field="fitted.mass_g",
            value=piece.mass_g,
        )


def _occupied(plane: SelectionPlane, place: int, mass_g: float) -> SelectionPlane:
    capacity, grams = plane.capacity.copy(), plane.capacity_g.copy()
    if capacity[place] < UNLIMITED:
        capacity[place] = max(int(capacity[place]) - 1, 0)
    grams[place] = max(float(grams[place]) - mass_g, 0.0)
    return replace(
        plane,
        capacity=capacity,
        capacity_g=grams,
        max_pieces=max(plane.max_pieces - 1, 0) if plane.max_pieces < UNLIMITED else plane.max_pieces,
        max_mass_g=max(plane.max_mass_g - mass_g, 0.0),
    )


def _into_the_box(stock: Stock, piece: MountedPiece, restricted: list[tuple[int, int, int]]) -> tuple[Stock, int]:
    """Add a piece: to the item of the same mass where it may go anywhere, as an item of its own otherwise."""
    own = {item for item, _, _ in restricted}
    if piece.may == "move":
        same = [
            int(i) for i in np.flatnonzero(np.abs(effective_g(stock) - piece.mass_g) < ALIKE_G) if int(i) not in own
        ]
        if same:
            counts = stock.counts.copy()
            if counts[same[0]] < UNLIMITED:
                counts[same[0]] += 1
            return replace(stock, counts=counts), same[0]
    return (
        Stock(
            masses_g=np.append(stock.masses_g, piece.mass_g),
            counts=np.append(stock.counts, 1),
            fasteners_g=np.append(stock.fasteners_g, 0.0),
        ),
        len(stock.masses_g),
    )


def _restricted(
    plane: SelectionPlane, p: int, stock: Stock, restricted: Sequence[tuple[int, int, int]]
) -> SelectionPlane:
    """The plane with columns for all items, each restricted item only in its own position.

    Where that takes one piece, nothing alike goes there: it would be the same selection once more.
    """
    if not restricted and plane.allowed is None:
        return plane
    mass = effective_g(stock)
    allowed = np.ones((len(plane.angles), len(mass)), dtype=bool)
    if plane.allowed is not None:
        allowed[:, : plane.allowed.shape[1]] = plane.allowed
    for item, where, place in restricted:
        allowed[:, item] = False
        if where == p:
            if plane.capacity[place] == 1:
                allowed[place, np.abs(mass - mass[item]) < ALIKE_G] = False
            allowed[place, item] = True
    return replace(plane, allowed=allowed)


def placement_uncertainty(problem: SelectionProblem, selection: Selection, tolerance: float) -> float:
    """Most that the objective can change where every piece sits up to `tolerance` radians off its position.

    Each piece moves its vector by at most 2 m sin(tolerance / 2); the norm of the changes bounds the
    change of the norm.
    """
    objective, mass = problem.objective, effective_g(problem.stock)
    moved = 2.0 * math.sin(min(tolerance, math.pi) / 2.0)
    per_plane = np.array([moved * sum(mass[piece.item] for piece in pieces) for pieces in selection])
    each = objective.weights * (np.abs(objective.matrix) @ per_plane)
    if objective.norm == "components":
        return float(math.sqrt(2.0) * each.sum())
    if objective.norm == "sum":
        return float(each.sum())
    if objective.norm == "max":
        return float(each.max())
    return float(np.sqrt((each**2).mean()))
