"""The moves of an arrangement one after the other, with what is laid down on the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from service.model.arrangement import Arrangement

Action = Literal["off", "lay", "move", "on"]


@dataclass(frozen=True)
class Handling:
    """One thing to do: take a part off for good, lay it down, move it to another place, or mount what lies there."""

    action: Action
    part: str
    leaves: str | None
    to: str | None


def handlings(made: Arrangement) -> tuple[Handling, ...]:
    """What is done with each part, in order: at most one part that goes back on lies aside at any time.

    What is gone, such as a broken part, comes off first. A part whose place is needed before its own turn is laid down.
    """
    inside = {move.leaves: move.part for move in made.moves if move.leaves is not None}
    lying: set[str] = set()
    out = [Handling("off", p.id, p.present, None) for p in made.request.parts if p.may == "gone" and p.present]
    for move in made.moves:
        inside = {place: part for place, part in inside.items() if part != move.part}
        if move.to is None:
            out.append(Handling("off", move.part, move.leaves, None))
            continue
        held = inside.pop(move.to, None)
        if held is not None:
            lying.add(held)
            out.append(Handling("lay", held, move.to, None))
        aside = move.part in lying or move.leaves is None
        lying.discard(move.part)
        out.append(Handling("on" if aside else "move", move.part, None if aside else move.leaves, move.to))
    return tuple(out)
