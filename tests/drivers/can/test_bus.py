"""Opening a bus: addresses read, and every way of failing told in words."""

from __future__ import annotations

import socket
from typing import Any

import can
import pytest

from drivers.can.bus import BusAddress, open_bus, parse_bus
from drivers.can.driver import CanDriver
from drivers.can.frames import FramesHere
from drivers.can.mapping_file import standard_mapping
from drivers.clock import ManualClock
from drivers.errors import BusUnavailable, InvalidSetting


def test_addresses() -> None:
    assert parse_bus("virtual") == BusAddress("virtual")
    assert parse_bus("socketcan:can0,bitrate=500000") == BusAddress("socketcan", "can0", {"bitrate": 500000})
    assert parse_bus("slcan:socket://127.0.0.1:9,sleep_after_open=0.5") == BusAddress(
        "slcan", "socket://127.0.0.1:9", {"sleep_after_open": 0.5}
    )
    assert parse_bus("udp_multicast:239.1.2.3,fd=false,name=x").options == {"fd": False, "name": "x"}
    for wrong in ("", ":can0", "virtual,speed"):
        with pytest.raises(InvalidSetting):
            parse_bus(wrong)


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (OSError(97, "Address family not supported by protocol"), "kernel may have no CAN"),
        (can.CanInitializationError("no such device"), "no such device"),
        (NotImplementedError("x"), "cannot be used here .*install the package"),
        (can.CanInterfaceNotImplementedError("no serial module"), "no serial module.*install the package"),
        (ImportError("No module named 'uptime'"), "needs a package"),
        (TypeError("unexpected keyword"), "check the channel and the options"),
    ],
)
def test_a_bus_that_cannot_be_had_is_told_in_words(
    monkeypatch: pytest.MonkeyPatch, error: Exception, words: str
) -> None:
    def broken(**_: Any) -> can.BusABC:
        raise error

    monkeypatch.setattr(can, "Bus", broken)
    with pytest.raises(BusUnavailable, match=words) as failed:
        open_bus(BusAddress("socketcan", "can0"))
    assert failed.value.__cause__ is error


def test_an_unknown_interface_is_told_by_the_real_library() -> None:
    with pytest.raises(BusUnavailable, match=r"'carrier_pigeon' is unknown: use one of .*socketcan"):
        open_bus(BusAddress("carrier_pigeon", "x"))


def test_multicast_stays_on_this_machine_unless_told_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[dict[str, Any]] = []

    def opened(**settings: Any) -> can.BusABC:
        seen.append(settings)
        return LostBus()

    monkeypatch.setattr(can, "Bus", opened)
    open_bus(BusAddress("udp_multicast"))
    open_bus(BusAddress("udp_multicast", "239.1.1.1", {"hop_limit": 2}))
    assert [(one["channel"], one["hop_limit"]) for one in seen] == [("239.74.163.2", 0), ("239.1.1.1", 2)]


class LostBus(can.BusABC):
    """A bus whose cable comes out."""

    def __init__(self) -> None:
        super().__init__(channel="lost")

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        raise can.CanOperationError("bus off")

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        raise OSError(100, "Network is down")


def test_a_lost_bus_ends_the_iteration_with_words() -> None:
    driver = CanDriver(
        BusAddress("socketcan", "can0"),
        standard_mapping(("P",)),
        clock=ManualClock(),
        open_with=lambda _: FramesHere(LostBus()),
    )
    with driver, pytest.raises(BusUnavailable, match=r"socketcan:can0 was lost .*Network is down"):
        next(iter(driver))
    assert driver.health().state == "closed"


def test_socketcan_that_this_kernel_has_not_or_whose_interface_is_not_there_is_told_in_words() -> None:
    with pytest.raises(BusUnavailable, match=r"socketcan:none0 cannot be opened .*kernel may have no CAN") as failed:
        open_bus(BusAddress("socketcan", "none0"))
    assert isinstance(failed.value.__cause__, OSError)


def test_the_queue_in_the_kernel_is_made_long(monkeypatch: pytest.MonkeyPatch) -> None:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)

    class SocketBus(LostBus):
        def fileno(self) -> int:
            return ours.fileno()

    monkeypatch.setattr(can, "Bus", lambda **_: SocketBus())
    before = ours.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
    open_bus(BusAddress("socketcan", "can0"))
    assert ours.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) >= before
    assert theirs.send(b"still open") == 10  # the bus keeps its socket
    ours.close()
    theirs.close()
