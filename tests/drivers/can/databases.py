"""Random DBCs: messages with signals of every kind, and the raw values that frames of them hold."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st


@dataclass(frozen=True)
class Drawn:
    """A signal: as `RawSignal`, with its scaling and the page of its message that has it (None: all)."""

    name: str
    start: int
    length: int
    little: bool
    signed: bool
    scale: float
    offset: float
    page: int | None

    def line(self) -> str:
        """Its line in a DBC."""
        page = "" if self.page is None else f" m{self.page}"
        order, sign = int(self.little), "-" if self.signed else "+"
        return (
            f' SG_ {self.name}{page} : {self.start}|{self.length}@{order}{sign} ({self.scale},{self.offset}) [0|0] "" X'
        )


@st.composite
def messages(draw: st.DrawFn, size: int = 8) -> tuple[str, list[Drawn]]:
    """A DBC with one message of `size` bytes, 0x123, whose first byte is the page."""
    signals = []
    for number in range(draw(st.integers(1, 5))):
        little = draw(st.booleans())
        length = draw(st.integers(1, min(40, 8 * size - 8)))
        place = draw(st.integers(8, 8 * size - length))
        start = place if little else 8 * (place // 8) + 7 - place % 8
        scale = draw(st.sampled_from([1, 0.5, 0.01, 0.125, 3, -0.1]))
        signals.append(
            Drawn(
                f"S{number}",
                start,
                length,
                little,
                draw(st.booleans()),
                scale,
                draw(st.sampled_from([0, -40, 0.5])),
                draw(st.none() | st.integers(0, 2)),
            )
        )
    lines = ['VERSION ""', "NS_ :", "BS_:", "BU_: X", f"BO_ 291 Msg: {size} X", ' SG_ Page M : 0|8@1+ (1,0) [0|0] "" X']
    return "\n".join([*lines, *(one.line() for one in signals), ""]), signals
