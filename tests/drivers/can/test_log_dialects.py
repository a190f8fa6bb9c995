"""Logs in every dialect: the frames that were written come back, with their times."""

from __future__ import annotations

import gzip
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivers.can.logs.can_log import CanLog
from drivers.can.logs.frame import LogFrame
from drivers.can.logs.lines import FREE_BYTES
from drivers.errors import LogError
from tests.drivers.can.dialects import DIALECTS, DLC, Dialect

ENDS = ("\n", "\r\n", "\r")
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16")


@st.composite
def recorded(draw: st.DrawFn, *, fd: bool) -> tuple[datetime, list[LogFrame]]:
    """A start to the millisecond and frames at increasing times after it."""
    start = datetime(2001, 1, 1, tzinfo=UTC) + timedelta(milliseconds=draw(st.integers(0, 2_800_000_000_000)))
    sizes = st.sampled_from([size for size in DLC if fd or size <= 8])
    passed, frames = 0, []
    for _ in range(draw(st.integers(3, 12))):
        passed += draw(st.integers(1, 90_000)) * 10  # microseconds
        extended = draw(st.booleans())
        frames.append(
            LogFrame(
                start.timestamp() + passed * 1e-6,
                draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF)),
                extended,
                draw(sizes.flatmap(lambda size: st.binary(min_size=size, max_size=size))),
            )
        )
    return start, frames


@pytest.mark.parametrize("dialect", DIALECTS, ids=[one.name for one in DIALECTS])
@given(data=st.data())
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_was_written_is_read(tmp_path: Path, dialect: Dialect, data: st.DataObject) -> None:
    start, frames = data.draw(recorded(fd=dialect.fd))
    text = dialect.write(start, frames)
    if dialect.suffix != ".trc":
        text = text.replace("\n", data.draw(st.sampled_from(ENDS)))
    contents = text.encode(data.draw(st.sampled_from(ENCODINGS)))
    packed = data.draw(st.booleans())
    path = tmp_path / f"log{dialect.suffix}{'.gz' if packed else ''}"
    path.write_bytes(gzip.compress(contents) if packed else contents)
    log = CanLog(path, started_at=None if dialect.start else start)
    found = list(log)
    assert [one[1:] for one in found] == [one[1:] for one in frames]
    assert [one.timestamp for one in found] == pytest.approx(
        [one.timestamp for one in frames], abs=1.1 * dialect.step_s + 1e-6
    )


@pytest.mark.parametrize(
    "dialect", [one for one in DIALECTS if one.name in ("vector", "candump_shown", "trc_2.1", "css")]
)
@given(data=st.data())
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_log_cut_anywhere_gives_what_lies_before(tmp_path: Path, dialect: Dialect, data: st.DataObject) -> None:
    start, frames = data.draw(recorded(fd=False))
    contents = dialect.write(start, frames).encode()
    cut = data.draw(st.integers(len(contents) // 2, len(contents)))
    path = tmp_path / f"log{dialect.suffix}"
    path.write_bytes(contents[:cut])
    found: list[LogFrame] = []
    try:
        found.extend(CanLog(path))
    except LogError as error:
        assert error.line is not None or not found  # noqa: PT017
    assert [one[1:] for one in found[:-1]] == [one[1:] for one in frames[: max(len(found) - 1, 0)]]


def test_delta_times_are_recognised(tmp_path: Path) -> None:
    path = tmp_path / "delta.log"
    path.write_text("".join(f"({0.001 * (1 + i % 3):010.6f}) can0 123#0{i}\n" for i in range(9)))
    start = datetime(2026, 5, 4, 8, 30, tzinfo=UTC)
    found = [round(one.timestamp - start.timestamp(), 6) for one in CanLog(path, started_at=start)]
    assert found == [0.001, 0.003, 0.006, 0.007, 0.009, 0.012, 0.013, 0.015, 0.018]


def test_a_start_that_no_line_states_is_asked_for(tmp_path: Path) -> None:
    for name, text in (
        ("a.asc", "base hex timestamps absolute\n 0.5 1 123 Rx d 1 00\n"),
        ("b.asc", "date 05/04/2026 08:30:00\n 0.5 1 123 Rx d 1 00\n"),
        ("c.asc", "date Qux Foo 4 08:30:00 2026\n 0.5 1 123 Rx d 1 00\n"),
        ("d.log", "(000000.500000) can0 123#00\n"),
        ("e.trc", ";$FILEVERSION=1.1\n 1) 1.0 Rx 0123 1 00\n"),
        ("f.csv", "Time,ID,DLC,Data\n0.5,0x123,1,00\n"),
    ):
        path = tmp_path / name
        path.write_text(text)
        with pytest.raises(LogError, match="state when the recording began: --started-at") as refused:
            list(CanLog(path))
        assert refused.value.code == "start_unknown"
        start = datetime(2026, 5, 4, 8, 30, tzinfo=UTC)
        (frame,) = CanLog(path, started_at=start)
        assert 0.0 <= frame.timestamp - start.timestamp() <= 0.5


def test_a_packed_bomb_is_refused_early(tmp_path: Path) -> None:
    path = tmp_path / "bomb.log.gz"
    line = b"(1777883400.000000) can0 123#0011223344556677\n"
    path.write_bytes(gzip.compress(line * (3 * FREE_BYTES // len(line)), 9))
    log = CanLog(path)
    with pytest.raises(LogError, match="it unpacks to over") as refused:
        sum(1 for _ in log)
    assert refused.value.code == "too_large"
    assert log.frames < 2 * FREE_BYTES // len(line)


def test_an_endless_line_is_refused_early(tmp_path: Path) -> None:
    path = tmp_path / "endless.asc"
    path.write_bytes(b"0" * 5_000_000)
    with pytest.raises(LogError, match="longer than"):
        list(CanLog(path))
