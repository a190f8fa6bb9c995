"""SAE J1939 on the bus: parameter groups from any node, nodes known by their names, messages in several frames.

Identifier: priority (3 bits), two pages, PF, PS, source address. With PF below 240 (PDU1) PS is the destination and no
part of the group's number (SAE J1939-21). A node claims its address with its name in group 60928 (SAE J1939-81).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

PDU2_FROM = 240
ADDRESS_CLAIMED, CONNECTION, TRANSFER = 0xEE00, 0xEC00, 0xEB00
NULL_ADDRESS = 0xFE
"""No node sends from it but to say that it has no address: in a DBC it stands for any."""
BROADCAST, REQUEST, ABORT = 32, 16, 255
MAX_TRANSFERS = 64
MAX_BYTES = 1785
PATIENCE_S = 1.25
"""Longest time between two packets (T2 of SAE J1939-21)."""


def group_of(identifier: int) -> int:
    """Parameter group number of a 29-bit identifier."""
    group = identifier >> 8 & 0x3FFFF
    return group if group >> 8 & 0xFF >= PDU2_FROM else group & 0x3FF00


@dataclass(slots=True)
class Node:
    """The balancer among the nodes of a bus.

    address: its source address; None: the first that is heard. name: known from the mapping, or from its claim.
    """

    address: int | None = None
    name: int | None = None
    heard_at: float = 0.0
    found: bool = False
    """The address is one that was heard, not one that the mapping names: it goes when it is not heard any more."""

    def takes(self, source: int, at: float, patience_s: float) -> bool:
        """Whether a frame from this source address is the balancer's."""
        if self.address is None:
            if self.name is not None:
                return False  # until it claims an address
            self.address, self.found = source, True
        elif source != self.address:
            if not self.found or self.name is not None or at - self.heard_at <= patience_s:
                return False
            self.address = source
        self.heard_at = at
        return True

    def claimed(self, source: int, name: int) -> None:
        """A node says which address it has: the balancer is followed to another, and loses one to a lower name."""
        if name == self.name:
            self.address = None if source == NULL_ADDRESS else source
        elif source == self.address:
            if self.name is None:
                self.name = name
            elif name < self.name:
                self.address = None


@dataclass(slots=True)
class _Transfer:
    group: int
    size: int
    packets: int
    at: float
    priority: int
    data: bytearray = field(default_factory=bytearray)
    expected: int = 1


class Transfers:
    """Puts messages of more than 8 bytes together: broadcast ones (BAM), and those between two nodes, overheard.

    groups: the ones that are wanted. broken: transfers of these that were not completed.
    """

    def __init__(self, groups: Iterable[int]) -> None:
        self._groups = frozenset(groups)
        self._open: dict[tuple[int, int], _Transfer] = {}
        self.broken = 0

    def take(self, identifier: int, data: bytes, at: float) -> tuple[int, bytes] | None:
        """Take a frame of the transport protocol; returns identifier and data of the message that it completes."""
        group, source, destination = group_of(identifier), identifier & 0xFF, identifier >> 8 & 0xFF
        if len(data) < 8:
            return None
        if group == CONNECTION:
            self._connect(source, destination, data, at, identifier >> 26 & 7)
            return None
        return self._packet(source, destination, data, at)

    def _connect(self, source: int, destination: int, data: bytes, at: float, priority: int) -> None:
        control, group = data[0], int.from_bytes(data[5:8], "little")
        if control == ABORT:
            for key in ((source, destination), (destination, source)):
                self._drop(key)
        elif control in (BROADCAST, REQUEST) and group in self._groups:
            size, packets = int.from_bytes(data[1:3], "little"), data[3]
            self._drop((source, destination))
            if 8 < size <= MAX_BYTES and packets == (size + 6) // 7:
                while len(self._open) >= MAX_TRANSFERS:
                    self._drop(next(iter(self._open)))
                self._open[source, destination] = _Transfer(group, size, packets, at, priority)
            else:
                self.broken += 1

    def _packet(self, source: int, destination: int, data: bytes, at: float) -> tuple[int, bytes] | None:
        key = (source, destination)
        transfer = self._open.get(key)
        if transfer is None:
            return None
        if data[0] == transfer.expected - 1 and data[1:8] == bytes(transfer.data[-7:]):
            return None  # asked for once more
        if data[0] != transfer.expected or at - transfer.at > PATIENCE_S:
            self._drop(key)
            return None
        transfer.data += data[1:8]
        transfer.expected, transfer.at = transfer.expected + 1, at
        if transfer.expected <= transfer.packets:
            return None
        del self._open[key]
        low = destination << 8 if transfer.group >> 8 & 0xFF < PDU2_FROM else 0
        identifier = transfer.priority << 26 | transfer.group << 8 | low | source
        return identifier, bytes(transfer.data[: transfer.size])

    def _drop(self, key: tuple[int, int]) -> None:
        if self._open.pop(key, None) is not None:
            self.broken += 1
