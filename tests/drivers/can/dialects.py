"""Writes frames as loggers do: each writer takes frames and gives the text of a log, and says what it can hold."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from itertools import pairwise

from drivers.can.logs.frame import LogFrame

DLC = {0: 0, 1: 1, 2: 2, 3: 3, 4: 4, 5: 5, 6: 6, 7: 7, 8: 8, 12: 9, 16: 10, 20: 11, 24: 12, 32: 13, 48: 14, 64: 15}
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


@dataclass(frozen=True)
class Dialect:
    """A kind of log: its suffix, how it is written, and whether it holds frames of CAN FD and states its start.

    step_s: to which its times are written.
    """

    name: str
    suffix: str
    write: Callable[[datetime, Sequence[LogFrame]], str]
    fd: bool = True
    start: bool = True
    step_s: float = 1e-6


def _since(start: datetime, frame: LogFrame) -> float:
    return frame.timestamp - start.timestamp()


def _hex(data: bytes, between: str = " ") -> str:
    return between.join(f"{one:02X}" for one in data)


# ---------------------------------------------------------------- Vector
def _asc_line(time: str, frame: LogFrame, base: str, fd: bool) -> str:
    ident = f"{frame.arbitration_id:{'X' if base == 'hex' else 'd'}}{'x' if frame.is_extended_id else ''}"
    data = " ".join(f"{one:02X}" if base == "hex" else f"{one:d}" for one in frame.data)
    if fd or len(frame.data) > 8:
        dlc = f"{DLC[len(frame.data)]:x}"
        return f"{time} CANFD   1 Rx {ident:>10}   some_name   1 0 {dlc} {len(frame.data)} {data}   0  0   200000 0 0 0"
    length = f"{len(frame.data):{'x' if base == 'hex' else 'd'}}"
    return f"{time} 1  {ident:<15} Rx   d {length} {data}  Length = 0 BitCount = 64 ID = {frame.arbitration_id}"


def asc(
    date: Callable[[datetime], str],
    *,
    base: str = "hex",
    relative: bool = False,
    trigger: bool = True,
    fd: bool = False,
) -> Callable[[datetime, Sequence[LogFrame]], str]:
    """A writer of .asc with such a date, base and times."""

    def write(start: datetime, frames: Sequence[LogFrame]) -> str:
        lines = [f"date {date(start)}", f"base {base}  timestamps {'relative' if relative else 'absolute'}"]
        lines += ["no internal events logged", "// version 9.0.0"]
        if trigger:
            lines += [f"Begin Triggerblock {date(start)}", "   0.000000 Start of measurement"]
        times = [_since(start, one) for one in frames]
        if relative:
            times = [times[0], *(b - a for a, b in pairwise(times))] if times else []
        for time, frame in zip(times, frames, strict=True):
            lines.append(_asc_line(f"{time:11.6f}", frame, base, fd))
            lines.append(f"{0.0 if relative else time:11.6f} 1  Statistic: D 4 R 0 XD 0 XR 0 E 0 O 0 B 0.20%")
        return "\n".join([*lines, "End TriggerBlock", ""])

    return write


def english(moment: datetime) -> str:
    """As an English Windows: Mon May 4 08:30:00.000 am 2026."""
    clock = moment.strftime("%I:%M:%S.") + f"{moment.microsecond // 1000:03d} {'am' if moment.hour < 12 else 'pm'}"
    return f"{moment:%a %b} {moment.day} {clock} {moment.year}"


def day_first(moment: datetime) -> str:
    """04.05.2026 08:30:00.000."""
    return f"{moment:%d.%m.%Y %H:%M:%S}.{moment.microsecond // 1000:03d}"


def iso(moment: datetime) -> str:
    """2026-05-04T08:30:00.000+00:00."""
    return moment.isoformat(timespec="milliseconds")


# ---------------------------------------------------------------- candump
def _logged(frame: LogFrame) -> str:
    ident = f"{frame.arbitration_id:08X}" if frame.is_extended_id else f"{frame.arbitration_id:03X}"
    return f"{ident}##1{_hex(frame.data, '')}" if len(frame.data) > 8 else f"{ident}#{_hex(frame.data, '')}"


def candump_log(direction: str = "", zero: bool = False) -> Callable[[datetime, Sequence[LogFrame]], str]:
    """`candump -l`, with a direction behind (`-x`); zero: times from the start (`-tz`)."""

    def write(start: datetime, frames: Sequence[LogFrame]) -> str:
        times = ((_since(start, one) if zero else one.timestamp) for one in frames)
        return "".join(
            f"({time:017.6f}) vcan0 {_logged(one)}{direction}\n" for time, one in zip(times, frames, strict=True)
        )

    return write


def candump_shown(
    marks: str = "", *, text: bool = False, colour: bool = False, bits: bool = False, dated: bool = False
) -> Callable[[datetime, Sequence[LogFrame]], str]:
    """`candump -ta` (dated: `-tA`), with marks (`-x`), the text of the bytes (`-a`), colours (`-c`) or bits (`-i`)."""

    def write(start: datetime, frames: Sequence[LogFrame]) -> str:
        lines = []
        for one in frames:
            ident = f"{one.arbitration_id:08X}" if one.is_extended_id else f"     {one.arbitration_id:03X}"
            data = " ".join(f"{byte:08b}" for byte in one.data) if bits else _hex(one.data)
            moment = EPOCH + timedelta(microseconds=round(one.timestamp * 1e6))
            time = f"{moment:%Y-%m-%d %H:%M:%S.%f}" if dated else f"{one.timestamp:.6f}"
            tail = "   '" + "".join(chr(byte) if 32 < byte < 127 else "." for byte in one.data) + "'" if text else ""
            length = f"[{len(one.data):02d}]" if len(one.data) > 8 else f"[{len(one.data)}]"
            line = f" ({time})  can0  {marks}{ident}   {length}  {data}{tail}"
            lines.append(f"\x1b[31m{line}\x1b[0m\n" if colour else line + "\n")
        return "".join(lines)

    return write


# ---------------------------------------------------------------- PEAK
def trc(version: str) -> Callable[[datetime, Sequence[LogFrame]], str]:
    """A trace of a version."""

    def write(start: datetime, frames: Sequence[LogFrame]) -> str:
        days = (start - datetime(1899, 12, 30, tzinfo=UTC)) / timedelta(days=1)
        lines = [f";$FILEVERSION={version}"] if version != "1.0" else []
        if version >= "1.1":
            lines.append(f";$STARTTIME={days:.10f}")
        if version >= "2.0":
            lines.append(f";$COLUMNS=N,O,T,{'B,' if version == '2.1' else ''}I,d,{'R,' if version == '2.1' else ''}L,D")
        lines += [";", f";   Start time: {start:%d.%m.%Y %H:%M:%S}.{start.microsecond // 1000:03d}.0", ";---+--"]
        for number, one in enumerate(frames, start=1):
            ident = f"{one.arbitration_id:08X}" if one.is_extended_id else f"{one.arbitration_id:04X}"
            time, size, data = f"{_since(start, one) * 1000:.3f}", DLC[len(one.data)], _hex(one.data)
            kind = "FD" if len(one.data) > 8 else "DT"
            lines.append(
                {
                    "1.0": f"{number:6}) {time:>10} {ident:>8} {size}  {data}",
                    "1.1": f"{number:6}) {time:>11}  Rx {ident:>12}  {size}  {data}",
                    "1.2": f"{number:6}) {time:>13} 1 Rx {ident:>8}  {size}  {data}",
                    "1.3": f"{number:6}) {time:>13} 1 Rx {ident:>8} - {size}  {data}",
                    "2.0": f"{number:7} {time:>13} {kind} {ident:>8} Rx {size}  {data}",
                    "2.1": f"{number:7} {time:>13} {kind} 1 {ident:>8} Rx - {size}  {data}",
                }[version].rstrip()
            )
        return "\r\n".join(lines) + "\r\n"

    return write


# ---------------------------------------------------------------- tables
def python_can(_start: datetime, frames: Sequence[LogFrame]) -> str:
    """The table of python-can."""
    rows = [
        f"{one.timestamp:.6f},0x{one.arbitration_id:x},{int(one.is_extended_id)},0,0,{len(one.data)},"
        + base64.b64encode(one.data).decode()
        for one in frames
    ]
    return "\n".join(["timestamp,arbitration_id,extended,remote,error,dlc,data", *rows, ""])


def css(_start: datetime, frames: Sequence[LogFrame]) -> str:
    """The table of CSS Electronics' converter."""
    rows = [
        f"{one.timestamp:.6f};1;{one.arbitration_id:X};{int(one.is_extended_id)};{DLC[len(one.data)]};{len(one.data)};"
        f"0;{int(len(one.data) > 8)};0;{_hex(one.data, '')}"
        for one in frames
    ]
    return "\n".join(["TimestampEpoch;BusChannel;ID;IDE;DLC;DataLength;Dir;EDL;BRS;DataBytes", *rows, ""])


def savvy(_start: datetime, frames: Sequence[LogFrame]) -> str:
    """The table of SavvyCAN: microseconds, and a column for each byte."""
    rows = [
        f"{round(one.timestamp * 1e6)},{one.arbitration_id:08X},{str(one.is_extended_id).lower()},Rx,0,{len(one.data)},"
        + ",".join(f"{byte:02X}" for byte in one.data.ljust(8, b"\0"))
        for one in frames
    ]
    return "\n".join(["Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8", *rows, ""])


def kvaser(start: datetime, frames: Sequence[LogFrame]) -> str:
    """The table of Kvaser's tools: decimal numbers, and dates of whole seconds beside the time from the start."""
    rows = []
    for number, one in enumerate(frames):
        cells = [str(byte) for byte in one.data] + [""] * (8 - len(one.data))
        moment = start + timedelta(seconds=_since(start, one))
        rows.append(
            f"{_since(start, one):.6f},0,{one.arbitration_id},{4 * one.is_extended_id + 2 * (not one.is_extended_id)},"
            f"{len(one.data)},{','.join(cells)},{number},{moment:%Y-%m-%d %H:%M:%S}"
        )
    head = "Time,Channel,ID,Flags,DLC,Data0,Data1,Data2,Data3,Data4,Data5,Data6,Data7,Counter,AbsTime"
    return "\n".join([head, *rows, ""])


def busmaster(mode: str) -> Callable[[datetime, Sequence[LogFrame]], str]:
    """A log of BUSMASTER with times of day, from the start, or from the line before."""

    def write(start: datetime, frames: Sequence[LogFrame]) -> str:
        lines = ["***BUSMASTER Ver 3.2.2***", "***PROTOCOL CAN***", "***NOTE: PLEASE DO NOT EDIT THIS DOCUMENT***"]
        ms = start.microsecond // 1000
        lines.append("***[START LOGGING SESSION]***")
        lines.append(
            f"***START DATE AND TIME {start.day}:{start.month}:{start.year} {start.hour}:{start.minute}:"
            f"{start.second}:{ms:03d}***"
        )
        lines += ["***HEX***", f"***{mode} MODE***", "***START CHANNEL BAUD RATE***", "***<Time><Tx/Rx>***"]
        day = start.replace(hour=0, minute=0, second=0, microsecond=0)
        before = 0.0
        for one in frames:
            since = _since(start, one)
            time = {"SYSTEM": _since(day, one), "ABSOLUTE": since, "RELATIVE": since - before}[mode]
            before = since
            whole = round(time * 1e4)
            clock = f"{whole // 36_000_000}:{whole // 600_000 % 60}:{whole // 10_000 % 60}:{whole % 10_000:04d}"
            kind = "x" if one.is_extended_id else "s"
            lines.append(f"{clock} Rx 1 0x{one.arbitration_id:X} {kind} {len(one.data)} {_hex(one.data)} ")
        return "\n".join([*lines, "***[STOP LOGGING SESSION]***", ""])

    return write


DIALECTS = [
    Dialect("vector", ".asc", asc(english)),
    Dialect("vector_decimal", ".asc", asc(english, base="dec")),
    Dialect("vector_fd_channel", ".asc", asc(day_first, fd=True)),
    Dialect("relative", ".asc", asc(iso, relative=True), step_s=2e-5),
    Dialect("no_trigger", ".asc", asc(day_first, trigger=False)),
    Dialect("candump", ".log", candump_log()),
    Dialect("candump_direction", ".log", candump_log(" R")),
    Dialect("candump_from_zero", ".log", candump_log(zero=True), start=False),
    Dialect("candump_shown", ".log", candump_shown()),
    Dialect("candump_marks", ".txt", candump_shown("RX B E  ")),
    Dialect("candump_text", ".log", candump_shown(text=True)),
    Dialect("candump_colour", ".log", candump_shown(colour=True)),
    Dialect("candump_bits", ".log", candump_shown(bits=True)),
    Dialect("candump_dated", ".log", candump_shown(dated=True)),
    *(Dialect(f"trc_{version}", ".trc", trc(version), fd=version >= "2.0") for version in ("1.0", "1.1", "1.2", "1.3")),
    *(Dialect(f"trc_{version}", ".trc", trc(version)) for version in ("2.0", "2.1")),
    Dialect("python_can", ".csv", python_can),
    Dialect("css", ".csv", css),
    Dialect("savvy", ".csv", savvy, fd=False),
    Dialect("kvaser", ".csv", kvaser, fd=False, step_s=1.0),
    *(
        Dialect(f"busmaster_{mode.lower()}", ".log", busmaster(mode), fd=False, step_s=2e-3)
        for mode in ("SYSTEM", "ABSOLUTE", "RELATIVE")
    ),
]
