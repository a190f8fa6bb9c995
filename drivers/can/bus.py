"""Open a CAN bus by python-can's names, and explain why it cannot be opened."""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

import can

from drivers.errors import BusUnavailable, InvalidSetting

QUEUE_BYTES = 16 * 1024 * 1024
"""Some seconds of a full bus, at what the kernel counts for a frame; it may grant less to who is not root."""
SO_RCVBUFFORCE = 33
"""As SO_RCVBUF, beyond what the machine's setting allows: for root on Linux."""
MULTICAST_GROUP = "239.74.163.2"
DEFAULTS: Mapping[str, Mapping[str, object]] = {
    # The IPv6 group that python-can takes by itself does not work on the loopback interface alone, and a hop limit of 1
    # lets the frames out of this machine.
    "udp_multicast": {"channel": MULTICAST_GROUP, "hop_limit": 0},
    # Frames of CAN FD come in as well; a bus without any is read as before.
    "socketcan": {"channel": "can0", "fd": True},
}


@dataclass(frozen=True)
class BusAddress:
    """Which bus: python-can's interface name, channel and the options of that interface."""

    interface: str
    channel: str | None = None
    options: Mapping[str, object] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.interface if self.channel is None else f"{self.interface}:{self.channel}"


def parse_bus(text: str) -> BusAddress:
    """Read `INTERFACE[:CHANNEL][,option=value...]`, such as `socketcan:can0` or `slcan:/dev/ttyACM0,bitrate=500000`.

    Raises `InvalidSetting`.
    """
    address, *options = text.split(",")
    interface, _, channel = address.strip().partition(":")
    if not interface:
        raise InvalidSetting(f"bus {text!r} names no interface: write INTERFACE:CHANNEL, such as socketcan:can0")
    stated: dict[str, object] = {}
    for option in options:
        name, equals, value = option.strip().partition("=")
        if not equals or not name.isidentifier():
            raise InvalidSetting(f"option {option!r} of bus {text!r} is none: write name=value, such as bitrate=500000")
        stated[name] = _value(value)
    return BusAddress(interface, channel or None, stated)


def open_bus(address: BusAddress) -> can.BusABC:
    """Open the bus. Raises `BusUnavailable` with what is wrong and what to do."""
    settings = {**DEFAULTS.get(address.interface, {}), **address.options}
    if address.channel is not None:
        settings["channel"] = address.channel
    try:
        bus = can.Bus(interface=address.interface, ignore_config=True, **settings)  # type: ignore[arg-type]
        _widen(bus)
        return bus
    except (can.CanInterfaceNotImplementedError, NotImplementedError) as error:
        if address.interface in can.VALID_INTERFACES:
            raise BusUnavailable(
                f"CAN interface {address.interface!r} cannot be used here ({error}): install the package or driver "
                "it needs"
            ) from error
        known = ", ".join(sorted(can.VALID_INTERFACES))
        raise BusUnavailable(f"CAN interface {address.interface!r} is unknown: use one of {known}") from error
    except ImportError as error:
        raise BusUnavailable(
            f"CAN interface {address.interface!r} needs a package that is not installed ({error}): install it"
        ) from error
    except (can.CanError, OSError) as error:
        raise BusUnavailable(f"{address} cannot be opened ({error}): {_advice(address)}") from error
    except (TypeError, ValueError, KeyError, AttributeError) as error:
        raise BusUnavailable(f"{address} cannot be opened ({error}): check the channel and the options") from error


def _widen(bus: can.BusABC) -> None:
    """Ask for a long queue in the kernel: what a short one cannot hold while this process is busy is lost unseen."""
    try:
        with socket.socket(fileno=os.dup(bus.fileno())) as queue:
            queue.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, QUEUE_BYTES)
            if sys.platform == "linux":
                queue.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, QUEUE_BYTES)
    except (OSError, NotImplementedError):
        return  # no socket: an adapter with a queue of its own


@contextmanager
def bus_errors(address: BusAddress) -> Iterator[None]:
    """Turn what a bus raises while it is used into `BusUnavailable`."""
    try:
        yield
    except BusUnavailable:
        raise
    except (can.CanError, OSError, ValueError) as error:
        raise BusUnavailable(f"{address} was lost ({error}): {_advice(address)}") from error


def _value(text: str) -> object:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _advice(address: BusAddress) -> str:
    interface = address.interface
    if interface == "socketcan":
        channel = address.channel or DEFAULTS[interface]["channel"]
        return (
            "this machine's kernel may have no CAN, or the interface is not up; try "
            f"`ip link set {channel} up type can bitrate 500000` as root"
        )
    if interface == "udp_multicast":
        return "there must be a route for the group, such as `ip route add 224.0.0.0/4 dev lo` as root"
    if interface == "slcan":
        return "check the serial port, and that this user may open it"
    return "check that the adapter is plugged in, its driver installed, and the channel right"
