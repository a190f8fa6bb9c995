from pathlib import Path

import pytest

from drivers.clock import ManualClock
from drivers.files.driver import WaveformFile
from drivers.files.recording import Layout
from drivers.protocol import Driver
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.waveform_driver import SimulatedWaveforms
from drivers.simulator.waveforms import Disturbance
from tests.contract.test_simulated_driver import BackwardClock
from tests.support.drivers.driver_contract import DriverContract
from tests.support.drivers.waveform_files import recorded, write_csv, write_uff, write_wav


class TestSimulatedWaveforms(DriverContract):
    def make_driver(self) -> Driver:
        return SimulatedWaveforms(threshing_drum_example(), seed=1, clock=ManualClock())


class TestSimulatedWaveformsOfAPoorKeyPhasorWhileTheClockIsSetBack(DriverContract):
    def make_driver(self) -> Driver:
        disturbance = Disturbance(jitter_s=1e-4, missed=0.01, doubled=0.01)
        return SimulatedWaveforms(
            threshing_drum_example(), seed=2, clock=BackwardClock(), disturbance=disturbance, sequence_start=100
        )


class FileContract(DriverContract):
    """Each test gets a folder of its own, with a recording of 26 s: six blocks of two sensors, and a rest."""

    name: str

    @pytest.fixture(autouse=True)
    def recording(self, tmp_path: Path) -> None:
        self.path = tmp_path / self.name
        self.layout = self.write(self.path)

    def write(self, path: Path) -> Layout:
        raise NotImplementedError

    def make_driver(self) -> Driver:
        return WaveformFile(self.path, self.layout, source="recording", sequence_start=7)


class TestWavFile(FileContract):
    name = "drum.wav"

    def write(self, path: Path) -> Layout:
        return recorded(write_wav, path)


class TestCsvFile(FileContract):
    name = "drum.csv"

    def write(self, path: Path) -> Layout:
        return recorded(write_csv, path)


class TestUffFile(FileContract):
    name = "drum.uff"

    def write(self, path: Path) -> Layout:
        return recorded(write_uff, path)
