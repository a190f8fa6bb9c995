"""What stands in for a bus: a recording, a waveform file, a simulated drum."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from drivers.block_driver import BlockDriver
from drivers.can.driver import CanDriver
from drivers.can.mapping import CanMapping
from drivers.can.refusals import counted, table
from drivers.clock import Clock, SystemClock
from drivers.errors import InvalidSetting, UnreadableFile
from drivers.files.driver import WaveformFile
from drivers.files.layout_file import Layouts, read_layout
from drivers.files.replay import ReplayDriver, is_can_log
from drivers.protocol import Driver
from drivers.simulator.drum_driver import SimulatedDrum, threshing_drum_example
from drivers.simulator.waveform_driver import SimulatedWaveforms

BLOCK_S = 4.0


@dataclass(frozen=True)
class Waveform:
    """A waveform file and its layout."""

    file: Path
    layouts: Layouts

    @property
    def first_sequence(self) -> int:
        """Its readings' first number: the millisecond of its start.

        The same file has the same numbers each time, another one of the same source has others.
        """
        return int(self.layouts.layout.started_at.timestamp() * 1000)

    def driver(self, source: str) -> WaveformFile:
        """Read it as this source."""
        found = self.layouts
        return WaveformFile(
            self.file,
            found.layout,
            source=source,
            block_s=found.block_s,
            settings=found.settings,
            sequence_start=self.first_sequence,
        )


def waveform_of(file: Path, layout: Path | None, started_at: datetime | None) -> Waveform:
    """A file and its layout, read. Raises `InvalidSetting`."""
    if layout is None:
        raise InvalidSetting(f"waveform {file} needs a layout that says which column is which sensor: name it")
    found = read_layout(layout, started_at)
    least = len(found.layout.channels) / 1000.0
    if found.block_s < least:
        raise InvalidSetting(f"layout {layout}: block_s {found.block_s} is too short to number readings: {least} s")
    return Waveform(file, found)


@dataclass(frozen=True)
class Simulation:
    """A simulated drum: its readings every interval_s, or the waveforms of its sensors, in blocks of 4 s."""

    seed: int
    interval_s: float = 1.0
    waveforms: bool = False

    def driver(self, source: str, first: int, clock: Clock) -> SimulatedDrum | SimulatedWaveforms:
        """Run it as this source, with numbers from `first`."""
        spec = threshing_drum_example(self.seed)
        if self.waveforms:
            return SimulatedWaveforms(
                spec, seed=self.seed, clock=clock, source=source, sequence_start=first, block_s=BLOCK_S
            )
        return SimulatedDrum(
            spec, seed=self.seed, clock=clock, source=source, sequence_start=first, interval_s=self.interval_s
        )


@dataclass(frozen=True)
class Recorded:
    """A recording, session log or CAN log, with what the last needs: a mapping, and its start if it states none."""

    file: Path
    mapping: CanMapping | None = None
    started_at: datetime | None = None


StandIn = Waveform | Simulation | Recorded


def stand_in(one: StandIn, source: str, first: int, highest: int) -> Driver:
    """Its driver. first: a number above all used before; highest: the highest of those."""
    if isinstance(one, Waveform):
        return one.driver(source)
    if isinstance(one, Simulation):
        return one.driver(source, first, SystemClock())
    return ReplayDriver(
        one.file,
        clock=SystemClock(),
        source=source,
        mapping=one.mapping,
        started_at=one.started_at,
        # A CAN log has numbers of its own time, and an older one, read later, has lower ones.
        after=-1 if is_can_log(one.file) else highest,
    )


def why_refused(driver: Driver) -> str:
    """Why the first block was refused, to go behind a line of counts; empty where none was."""
    reason = driver.first_refusal if isinstance(driver, BlockDriver) else None
    return f"; the first because: {reason}" if reason else ""


def tell_of(driver: Driver) -> None:
    """Say how a CAN log's times are known, and why frames of a log or a bus gave no reading."""
    lines: list[str] = []
    if isinstance(driver, ReplayDriver):
        lines = driver.told()
    elif isinstance(driver, CanDriver) and counted(driver.decoder.counts):
        lines = [f"frames without a reading, of {driver.decoder.frames}:", *table(driver.decoder.counts)]
    elif isinstance(driver, WaveformFile):
        lines = [f"{driver.path}: {note}" for note in driver.notes]
    for line in lines:
        print(line, flush=True)


def require_read(driver: Driver) -> None:
    """Raise `UnreadableFile` for a waveform file that was read and refused whole."""
    if isinstance(driver, WaveformFile) and driver.first_refusal and not driver.health().delivered:
        raise UnreadableFile(f"gives no reading: {driver.first_refusal}", path=str(driver.path))


def named(one: StandIn) -> str:
    """What it is, as text."""
    return "simulated drum" if isinstance(one, Simulation) else str(one.file)
