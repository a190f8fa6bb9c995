"""Raw values that stand for no value: named so in the DBC, kept for it by J1939, or all bits set where no range is.

SAE J1939-71 keeps the upper end of every parameter: 8 bits from FB (reserved, error FE, not available FF), 16 and 32
bits by their first byte likewise, 2 bits 10 and 11, else the two highest values.
"""

from __future__ import annotations

import math
import re

from cantools.database.can import Message, Signal

_A_VALUE = re.compile(
    r"^\s*[-+]?\d|^(zero|null|none|min|max|minimum|maximum|ok|good|valid|normal|nominal|active|on|low|high|stop|stopped|"
    r"standstill|idle)\b",
    re.IGNORECASE,
)
"""Names in a value table that describe a number that was measured."""
WIDE = 16
"""Bits from which on all of them set are not believed even where the DBC's range goes to the end of the raw numbers."""


def named(signal: Signal) -> frozenset[int]:
    """Raw values that the DBC's value table names, but for names of a number that was measured."""
    return frozenset(int(raw) for raw, name in (signal.choices or {}).items() if not _A_VALUE.match(str(name)))


def kept_from(message: Message, signal: Signal, *, j1939: bool, angle: bool) -> float:
    """The lowest raw number that stands for none, as do all above; infinite where there is none."""
    length = int(signal.length)
    if signal.is_float or signal.is_signed or length < 2:
        return math.inf
    whole = (1 << length) - 1
    if j1939 and message.is_extended_frame:
        if length in (8, 16, 24, 32):
            return 0xFB << (length - 8)
        return whole - 1 if length > 2 else 2
    end = whole * float(signal.scale) + float(signal.offset)
    if angle and abs(end) <= 360.0:
        return math.inf  # a turn in whole steps
    no_range = signal.minimum is None and signal.maximum is None
    full = signal.maximum is not None and float(signal.maximum) >= end - 0.5 * abs(float(signal.scale))
    return whole if length >= 8 and (no_range or (full and length >= WIDE)) else math.inf
