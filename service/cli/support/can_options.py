"""What the commands that touch a CAN bus have in common: which bus, which messages."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from drivers.can.mapping import CanMapping

Bus = Annotated[
    str,
    typer.Option(
        "--can",
        metavar="INTERFACE:CHANNEL[,option=value]",
        help="CAN bus by python-can's names, such as socketcan:can0 or slcan:/dev/ttyACM0,bitrate=500000.",
    ),
]
MappingFile = Annotated[
    Path | None,
    typer.Option("--mapping", dir_okay=False, help="TOML file that maps another balancer's DBC; default: our own DBC."),
]
Sensors = Annotated[str, typer.Option(help="Sensors of the machine behind Sensor1, 2 ... of our own DBC.")]
Planes = Annotated[str, typer.Option(help="Planes of the machine behind Correction1, 2 ... of our own DBC.")]
SpoolFile = Annotated[
    Path | None, typer.Option("--spool", dir_okay=False, help="File that keeps what was read and not stored yet.")
]
SpoolSize = Annotated[int, typer.Option(min=1, help="Most megabytes of it; the oldest readings are kept.")]
WaveformPath = Annotated[
    Path | None,
    typer.Option("--waveform", dir_okay=False, help="Waveform file (CSV, WAV, UFF 58) to read, to its end."),
]
LayoutPath = Annotated[
    Path | None,
    typer.Option("--layout", dir_okay=False, help="TOML file that says which column of a waveform is which sensor."),
]
StartedAt = Annotated[
    datetime | None,
    typer.Option(
        formats=["%Y-%m-%dT%H:%M:%S%z", "%Y-%m-%dT%H:%M:%S.%f%z"],
        help="When a waveform's first sample was taken, or a CAN log began, RFC 3339; default: what it says itself.",
    ),
]
Waveforms = Annotated[
    bool, typer.Option("--waveforms", help="Simulate the sensors' waveforms, and measure them, instead of readings.")
]
J1939 = Annotated[bool, typer.Option("--j1939", help="Our own DBC's messages with 29-bit identifiers.")]


def mapping_of(file: Path | None, sensors: str, planes: str, *, j1939: bool) -> CanMapping:
    """The mapping of a file, else of our own DBC. Raises `InvalidSetting`."""
    from drivers.can.mapping_file import read_mapping, standard_mapping

    if file is not None:
        return read_mapping(file)
    return standard_mapping(_names(sensors), _names(planes), j1939=j1939)


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())
