"""The CAN driver over python-can's virtual bus: a balancer sends, the driver reads."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import can
import pytest

from drivers.can.bus import BusAddress, open_bus
from drivers.can.driver import CanDriver
from drivers.can.frames import Frames, FramesHere
from drivers.can.mapping_file import standard_mapping
from drivers.can.sender import CanOut
from drivers.clock import ManualClock
from drivers.protocol import Driver
from drivers.simulator.drum_driver import SimulatedDrum, threshing_drum_example
from tests.support.drivers.driver_contract import SOME, DriverContract

CHANNELS = (f"contract-{number}" for number in itertools.count())


class CanContract(DriverContract):
    """Each opening finds `2 * SOME` readings waiting on the bus."""

    j1939 = False
    spoil: Callable[[list[can.Message]], list[can.Message]] = staticmethod(lambda frames: frames)

    @pytest.fixture(autouse=True)
    def balancer(self) -> object:
        self.channel = next(CHANNELS)
        self.mapping = standard_mapping(("P", "Q"), j1939=self.j1939)
        self.out = CanOut(BusAddress("virtual", self.channel), self.mapping)
        self.drum = SimulatedDrum(threshing_drum_example(), seed=1, clock=ManualClock())
        yield
        self.out.close()

    def make_driver(self) -> Driver:
        return CanDriver(
            BusAddress("virtual", self.channel), self.mapping, clock=ManualClock(), open_with=self.open_and_send
        )

    def open_and_send(self, address: BusAddress) -> Frames:
        bus = open_bus(address)
        with self.drum:
            self.out.post(self.drum.measure(SOME))
        return FramesHere(bus)


class TestCanDriver(CanContract):
    pass


class TestCanDriverOfJ1939(CanContract):
    j1939 = True
