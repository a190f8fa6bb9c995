"""Replayed files pass the contract of all drivers."""

from __future__ import annotations

import json
from pathlib import Path

import can
import pytest

from drivers.can.mapping_file import standard_mapping
from drivers.clock import ManualClock
from drivers.files.readings import Recorder
from drivers.files.replay import ReplayDriver
from drivers.protocol import Driver
from tests.support.drivers.driver_contract import SOME, DriverContract
from tests.support.drivers.frames import START, readings, sensor_frames


class ReplayContract(DriverContract):
    name = ""

    @pytest.fixture(autouse=True)
    def folder(self, tmp_path: Path) -> None:
        self.path = tmp_path / self.name
        self.write()

    def write(self) -> None:
        """A CAN log of frames 10 ms apart."""
        with can.Logger(self.path) as log:
            for index, frame in enumerate(sensor_frames(2 * SOME)):
                frame.timestamp = START.timestamp() + 0.01 * index
                log.on_message_received(frame)

    def make_driver(self) -> Driver:
        return ReplayDriver(self.path, clock=ManualClock(), mapping=standard_mapping(("P",)), speed=2.0)


class TestReplayOfARecording(ReplayContract):
    name = "shed.jsonl"

    def write(self) -> None:
        with Recorder(self.path) as recorder:
            recorder.write(readings(2 * SOME))


class TestReplayOfASessionLog(ReplayContract):
    name = "session.json"

    def write(self) -> None:
        stated = [{"sensor": "P", "amplitude": 1.0, "phase_deg": 20.0}, {"sensor": "Q", "amplitude": 2.0}]
        run = {"kind": "initial", "taken_at": START.isoformat(), "readings": stated}
        self.path.write_text(json.dumps({"format": "drumtrue-session", "runs": [run] * SOME}))


class TestReplayOfCandump(ReplayContract):
    name = "bus.log"


class TestReplayOfAsc(ReplayContract):
    name = "bus.asc"


class TestReplayOfBlf(ReplayContract):
    name = "bus.blf"


class TestReplayOfCsv(ReplayContract):
    name = "bus.csv"


class TestReplayOfTrc(ReplayContract):
    name = "bus.trc"
