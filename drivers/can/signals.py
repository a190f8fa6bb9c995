"""Numbers in the data of a frame, as a DBC places them: raw and whole, so that named and missing values can be told.

cantools decodes whole messages of exactly the stated length, and one page or one broken signal that was not asked for
stops it. Here each signal is taken by itself from what is there. tests/drivers/can compares both on every DBC at hand.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from cantools.database.can import Message, Signal

_FLOATS = {16: ("<e", 2), 32: ("<f", 4), 64: ("<d", 8)}


@dataclass(frozen=True, slots=True)
class RawSignal:
    """Where a signal lies. place: its first bit from the least (little) or the most significant end (big-endian).

    needs: bytes that a frame must have to hold it. plain: a whole number in little-endian order, on every page. pages:
    the multiplexers that must show these values, outermost first.
    """

    name: str
    little: bool
    place: int
    length: int
    mask: int
    sign: int
    float_bits: int
    scale: float
    offset: float
    needs: int
    plain: bool
    pages: tuple[tuple[RawSignal, frozenset[int]], ...] = ()

    def raw(self, data: bytes | bytearray | memoryview) -> float:
        """The bits as a whole number, or as the floating-point number that they are. data: at least `needs` bytes."""
        if self.little:
            bits = (int.from_bytes(data, "little") >> self.place) & self.mask
        else:
            bits = (int.from_bytes(data, "big") >> (8 * len(data) - self.place - self.length)) & self.mask
        if self.float_bits:
            form, size = _FLOATS[self.float_bits]
            return float(struct.unpack(form, bits.to_bytes(size, "little"))[0])
        return bits - ((bits & self.sign) << 1)

    def value(self, raw: float) -> float:
        """What the raw number stands for, in the DBC's unit."""
        return raw * self.scale + self.offset

    def shown(self, data: bytes | bytearray | memoryview) -> bool | None:
        """Whether the frame's page has it; None where the frame is too short to tell."""
        for multiplexer, values in self.pages:
            if len(data) < multiplexer.needs:
                return None
            if int(multiplexer.raw(data)) not in values:
                return False
        return True


def raw_signal(message: Message, name: str) -> RawSignal:
    """Place of a signal of a message. Raises KeyError where it has none of this name."""
    signal = message.get_signal_by_name(name)
    little = signal.byte_order == "little_endian"
    start, length = int(signal.start), int(signal.length)
    place = start if little else 8 * (start // 8) + 7 - start % 8
    pages = _pages(message, signal)
    return RawSignal(
        name=name,
        little=little,
        place=place,
        length=length,
        mask=(1 << length) - 1,
        sign=1 << (length - 1) if signal.is_signed and not signal.is_float else 0,
        float_bits=length if signal.is_float else 0,
        scale=_number(signal.scale),
        offset=_number(signal.offset),
        needs=(place + length + 7) // 8,
        plain=little and not signal.is_float and not pages,
        pages=pages,
    )


def _pages(message: Message, signal: Signal) -> tuple[tuple[RawSignal, frozenset[int]], ...]:
    name = signal.multiplexer_signal
    if name is None or not signal.multiplexer_ids:
        return ()
    outer = raw_signal(message, name)
    return (*outer.pages, (outer, frozenset(signal.multiplexer_ids)))


def _number(value: float) -> float:
    """A whole number as one: its products are exact."""
    return int(value) if math.isfinite(value) and value == int(value) else float(value)
