"""Whatever a file holds, its reader gives a recording or the documented error, and so does the driver over it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.errors import DriverError
from drivers.files.driver import WaveformFile, read_recording
from drivers.files.recording import Layout
from tests.support.drivers.waveform_files import drum_block, write_csv, write_uff, write_wav

SUFFIXES = [".csv", ".wav", ".uff"]


@pytest.fixture(scope="module")
def originals(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Layout, bytes]]:
    """A valid short file of each format, its layout and its contents."""
    out = {}
    for suffix, write in ((".csv", write_csv), (".wav", write_wav), (".uff", write_uff)):
        path = tmp_path_factory.mktemp("fuzz") / f"short{suffix}"
        used = write(path, drum_block(1.5))
        out[suffix] = (path, used, path.read_bytes())
    return out


def use(path: Path, layout: Layout, contents: bytes) -> None:
    """Read the recording, and all readings that a driver makes of it."""
    path.write_bytes(contents)
    try:
        recording = read_recording(path, layout)
        assert recording.sample_rate_hz > 0.0
        assert len({column.shape for column in recording.columns.values()}) == 1
        assert not any(np.isinf(column).any() for column in recording.columns.values())
        with WaveformFile(path, layout, source="fuzz", block_s=1.0) as file:
            for reading in file:
                assert np.isfinite(reading.amplitude)
    except DriverError as error:
        assert str(error)  # noqa: PT017


@st.composite
def damage(draw: st.DrawFn, size: int) -> list[tuple[str, int, bytes]]:
    """Bytes overwritten, put in or taken out; mostly near the front, where the headers are."""
    place = st.one_of(st.integers(0, min(size, 300)), st.integers(0, size))
    piece = st.one_of(
        st.binary(min_size=1, max_size=8), st.sampled_from([b"-1", b"    -1\n", b"\n", b"1e309", b"\xff\xff\xff\x7f"])
    )
    return draw(
        st.lists(st.tuples(st.sampled_from(["over", "in", "out", "end"]), place, piece), min_size=1, max_size=4)
    )


def damaged(contents: bytes, hurts: list[tuple[str, int, bytes]]) -> bytes:
    for kind, at, piece in hurts:
        if kind == "over":
            contents = contents[:at] + piece + contents[at + len(piece) :]
        elif kind == "in":
            contents = contents[:at] + piece + contents[at:]
        elif kind == "out":
            contents = contents[:at] + contents[at + len(piece) :]
        else:
            contents = contents[:at]
    return contents


@pytest.mark.parametrize("suffix", SUFFIXES)
class TestFuzz:
    def test_random_bytes(self, originals: dict[str, tuple[Path, Layout, bytes]], suffix: str) -> None:
        path, used, _ = originals[suffix]
        heads = {".csv": b"t,P,Q,kp\n", ".wav": b"RIFF\x24\0\0\0WAVEfmt \x10\0\0\0", ".uff": b"    -1\n    58\n"}

        @given(st.booleans(), st.binary(max_size=400))
        @settings(max_examples=60, deadline=None)
        def check(headed: bool, contents: bytes) -> None:
            use(path, used, (heads[suffix] if headed else b"") + contents)

        check()

    def test_damaged_files(self, originals: dict[str, tuple[Path, Layout, bytes]], suffix: str) -> None:
        path, used, good = originals[suffix]

        @given(damage(len(good)))
        @settings(max_examples=60, deadline=None)
        def check(hurts: list[tuple[str, int, bytes]]) -> None:
            use(path, used, damaged(good, hurts))

        check()


def test_the_files_that_are_damaged_were_whole(originals: dict[str, tuple[Path, Layout, bytes]]) -> None:
    for path, used, good in originals.values():
        path.write_bytes(good)
        with WaveformFile(path, used, source="fuzz") as file:
            assert len(list(file)) == 2
