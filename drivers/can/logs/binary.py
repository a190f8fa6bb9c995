"""Logs in bytes: Vector's .blf by python-can, ASAM .mf4 by python-can with asammdf."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import can
from can.io.blf import BLFReader

from drivers.can.logs.frame import EARLIEST_S, LogClock, LogFrame, StartUnknown, Times
from drivers.can.logs.lines import COMPRESSED, opened
from drivers.errors import LogError

MDF_MISSING = (
    "install asammdf (pip install 'drumtrue[mf4]'), or export the log as .asc, .blf or .csv with the logger's own tool"
)


def read_blf(path: Path, clock: LogClock, on_frame: Callable[[], None]) -> Iterator[LogFrame]:
    """Frames of a .blf. Raises `LogError` with the number of frames before the damage, `StartUnknown`."""
    with opened(path) as file:
        reader = _made(path, lambda: BLFReader(cast(Any, file)))
        yield from _frames(path, reader, clock, on_frame)
        if path.suffix.lower() != COMPRESSED and reader.file_size > path.stat().st_size:
            raise LogError(path, None, "it is cut short: its header announces more", code="damaged")


def read_mf4(path: Path, clock: LogClock, on_frame: Callable[[], None]) -> Iterator[LogFrame]:
    """Frames of a .mf4 with bus logging. Raises `LogError`, also where asammdf is not installed, `StartUnknown`."""
    try:
        import asammdf  # noqa: F401  (an extra)
    except ImportError as error:
        raise LogError(path, None, f"a .mf4 needs a package that is not installed ({error})", MDF_MISSING) from error
    from can.io.mf4 import MF4Reader

    with opened(path) as file:
        reader = _made(path, lambda: MF4Reader(cast(Any, file), relative_timestamp=False))
        yield from _frames(path, reader, clock, on_frame)


def _made(path: Path, make: Callable[[], Any]) -> Any:
    try:
        return make()
    except LogError:
        raise
    except Exception as error:  # whatever a head that is none makes the library stumble over
        raise LogError(path, None, f"its head cannot be read ({_said(error)})", code="damaged") from error


def _frames(path: Path, reader: Any, clock: LogClock, on_frame: Callable[[], None]) -> Iterator[LogFrame]:
    count = 0
    messages = iter(reader)
    while True:
        try:
            message: can.Message | None = next(messages, None)
            frame = None if message is None else _frame(message, clock)
        except (StartUnknown, LogError):
            raise
        except Exception as error:  # whatever a damaged file makes the library stumble over
            reason = f"it is damaged after {count} frames ({_said(error)})"
            raise LogError(path, None, reason, code="damaged") from error
        if frame is None:
            return
        count += 1
        on_frame()
        yield frame


def _frame(message: can.Message, clock: LogClock) -> LogFrame:
    clock.times = Times.EPOCH if message.timestamp >= EARLIEST_S else Times.START
    return LogFrame(
        clock.tick(message.timestamp),
        message.arbitration_id,
        message.is_extended_id,
        bytes(message.data),
        not (message.is_error_frame or message.is_remote_frame),
    )


def _said(error: Exception) -> str:
    return (str(error) or type(error).__name__)[:200]
