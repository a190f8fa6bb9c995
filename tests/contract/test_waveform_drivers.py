from drivers.clock import ManualClock
from drivers.example import threshing_drum_example
from drivers.protocol import Driver
from drivers.simulated_waveforms import SimulatedWaveforms
from drivers.waveform import Disturbance
from tests.contract.driver_contract import DriverContract
from tests.contract.test_simulated_driver import BackwardClock


class TestSimulatedWaveforms(DriverContract):
    def make_driver(self) -> Driver:
        return SimulatedWaveforms(threshing_drum_example(), seed=1, clock=ManualClock())


class TestSimulatedWaveformsOfAPoorKeyPhasorWhileTheClockIsSetBack(DriverContract):
    def make_driver(self) -> Driver:
        disturbance = Disturbance(jitter_s=1e-4, missed=0.01, doubled=0.01)
        return SimulatedWaveforms(
            threshing_drum_example(), seed=2, clock=BackwardClock(), disturbance=disturbance, sequence_start=100
        )
