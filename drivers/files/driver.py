"""A recorded waveform as a source of readings."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, timedelta
from pathlib import Path

from drivers.block_driver import BlockDriver, TimedBlock
from drivers.checks import require
from drivers.errors import UnreadableFile
from drivers.files.csv_file import read_csv
from drivers.files.labview_file import read_lvm, read_tdms
from drivers.files.recording import SAME_RATE, Layout, Recording, whole_block
from drivers.files.uff_file import read_uff
from drivers.files.wav_file import read_wav
from drivers.signal.block import Block
from drivers.signal.chain import Settings

SUFFIXES = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat", ".asc"), "text"),
    ".lvm": "lvm",
    ".tdms": "tdms",
    **dict.fromkeys((".wav", ".wave", ".rf64", ".w64"), "wav"),
    **dict.fromkeys((".uff", ".unv", ".ufb", ".uf", ".bunv", ".58"), "uff"),
}
"""Kinds of files by suffix."""


def read_recording(path: Path, layout: Layout) -> Recording:
    """Read what a layout names of a file, by its suffix: see `SUFFIXES`. Raises `UnreadableFile`."""
    kind = SUFFIXES.get(path.suffix.lower())
    wanted = layout.wanted()
    if kind == "text":
        return read_csv(
            path,
            wanted,
            time=layout.time,
            sample_rate_hz=layout.sample_rate_hz,
            time_unit=layout.time_unit,
            encoding=layout.encoding,
        )
    if kind == "lvm":
        return _at_rate(read_lvm(path, wanted, time=layout.time), layout)
    if kind == "tdms":
        return _at_rate(read_tdms(path, wanted, sample_rate_hz=layout.sample_rate_hz), layout)
    if kind == "wav":
        return _at_rate(read_wav(path), layout)
    if kind == "uff":
        return _at_rate(read_uff(path, wanted), layout)
    known = ", ".join(SUFFIXES)
    raise UnreadableFile(f"has the suffix {path.suffix.lower()!r}: use one of {known}", path=str(path))


def _at_rate(recording: Recording, layout: Layout) -> Recording:
    stated, own = layout.sample_rate_hz, recording.rate_of(layout.channels[0][0])
    if stated is not None and abs(stated - own) > SAME_RATE * own:
        raise UnreadableFile(
            f"is sampled at {own:.9g} Hz, the layout says sample_rate_hz {stated:.9g}: leave it out of the layout",
            path=recording.path,
        )
    return recording


class WaveformFile(BlockDriver):
    """A file, cut into blocks of block_s seconds; what is left at its end and too short for a block is not read.

    Opening reads the file; opened again, it goes on where it was closed. The same file, layout and block length give
    the same readings with the same sequence numbers in every run, so that a service that knows them counts duplicates.
    Raises `UnreadableFile` and `SignalRefused` from `open`.
    """

    def __init__(
        self,
        path: Path,
        layout: Layout,
        *,
        source: str,
        block_s: float = 4.0,
        settings: Settings | None = None,
        sequence_start: int = 1,
        session_id: str | None = None,
    ) -> None:
        settings = settings or Settings()
        if layout.pulses_per_turn is not None:
            settings = replace(settings, one_pulse=True)  # the edges are one a turn then
        super().__init__(source, settings=settings, sequence_start=sequence_start, session_id=session_id)
        require(0.0 < block_s <= 3600.0, f"block_s {block_s}", "be above 0 and at most 3600")
        self.path = path
        self.layout = layout
        self._block_s = block_s
        self.notes: tuple[str, ...] = ()
        """What the user should know of how the file was read."""
        self._whole: Block | None = None
        self._at = 0

    def _connect(self) -> None:
        recording = read_recording(self.path, self.layout)
        self.notes = recording.notes
        self._whole = whole_block(recording, self.layout)

    def _disconnect(self) -> None:
        self._whole = None

    def _next_block(self) -> TimedBlock | None:
        whole = self._whole
        if whole is None:
            return None
        total = whole.samples.shape[1]
        length = min(total, max(1, round(self._block_s * whole.sample_rate_hz)))
        first = self._at * length
        if first + length > total:
            return None
        self._at += 1
        start, end = first / whole.sample_rate_hz, (first + length) / whole.sample_rate_hz
        edges = whole.edges_s[(whole.edges_s >= start) & (whole.edges_s < end)] - start
        samples = whole.samples[:, first : first + length]
        block = Block(whole.channels, samples, whole.sample_rate_hz, edges, whole.edge_step_s)
        return TimedBlock(self.layout.started_at.astimezone(UTC) + timedelta(seconds=start), block)
