from drivers.clock import ManualClock
from drivers.protocol import Driver
from drivers.simulator.drum_driver import Faults, SimulatedDrum, threshing_drum_example
from tests.support.drivers.driver_contract import DriverContract


class TestSimulatedDrum(DriverContract):
    def make_driver(self) -> Driver:
        return SimulatedDrum(threshing_drum_example(), seed=1, clock=ManualClock())


class TestSimulatedDrumLosingReadings(DriverContract):
    """The promises hold while readings get lost and a sensor hangs."""

    def make_driver(self) -> Driver:
        drum = SimulatedDrum(threshing_drum_example(seed=3), seed=2, clock=ManualClock(), sequence_start=1000)
        drum.set_faults(Faults(dropout=0.3, stuck=("P",), no_key_phasor=True))
        return drum


class TestSimulatedDrumWhoseClockIsSetBack(DriverContract):
    def make_driver(self) -> Driver:
        return SimulatedDrum(threshing_drum_example(), seed=1, clock=BackwardClock())


class BackwardClock(ManualClock):
    """A clock that somebody keeps setting back."""

    def sleep(self, seconds: float) -> None:
        self.advance(-seconds)
