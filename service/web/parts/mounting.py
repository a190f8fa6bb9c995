"""The moves of an arrangement one after the other, with what is laid down on the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from service.model.arrangement import Move

Action = Literal["off", "lay", "move", "on"]


@dataclass(frozen=True)
class Handling:
    """One thing to do: take a part off for good, lay it down, move it to another place, or mount what lies there."""

    action: Action
    part: str
    leaves: str | None
    to: str | None


def handlings(moves: Sequence[Move]) -> tuple[Handling, ...]:
    """What is done with each part, in order: at most one part that goes back on lies aside at any time.

    A part whose place is needed before its own turn is laid down first.
    """
    inside = {move.leaves: move.part for move in moves if move.leaves is not None}
    lying: set[str] = set()
    out: list[Handling] = []
    for move in moves:
        if move.to is None:
            inside = {place: part for place, part in inside.items() if part != move.part}
            out.append(Handling("off", move.part, move.leaves, None))
            continue
        held = inside.pop(move.to, None)
        if held is not None:
            lying.add(held)
            out.append(Handling("lay", held, move.to, None))
        aside = move.part in lying or move.leaves is None
        if move.leaves is not None:
            lying.discard(move.part)
            inside = {place: part for place, part in inside.items() if part != move.part}
        out.append(Handling("on" if aside else "move", move.part, None if aside else move.leaves, move.to))
    return tuple(out)
