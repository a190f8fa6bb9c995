"""Frames for tests: those of Drumtrue's own balancer, and a stranger's DBC."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import can

from drivers.can.decoder import FrameDecoder, Masses, Vector
from drivers.can.mapping_file import standard_mapping
from drivers.can.sender import FrameEncoder
from drivers.reading import Reading

START = datetime(2026, 7, 1, 12, 0, 0, tzinfo=UTC)

STRANGER_DBC = """VERSION ""
NS_ :
BS_:
BU_: X
BO_ 2566852641 Vib: 8 X
 SG_ Seq : 0|4@1+ (1,0) [0|15] "" X
 SG_ Ok : 4|1@1+ (1,0) [0|1] "" X
 SG_ Amp : 8|16@1+ (0.001,0) [0|60] "in/s" X
 SG_ Rms : 24|16@1+ (0.001,0) [0|60] "in/s" X
BO_ 2566852897 Ang: 4 X
 SG_ Seq : 0|4@1+ (1,0) [0|15] "" X
 SG_ Pha : 8|16@1- (0.001,0) [-3.142|3.142] "rad" X
BO_ 2566853153 Rot: 4 X
 SG_ Rev : 0|32@1- (1,0) [0|500] "Hz" X
SIG_VALTYPE_ 2566853153 Rev : 1;
"""
STRANGER_TOML = """dbc = "stranger.dbc"
counter = "Seq"
node = 0x21

[speed]
message = "Rot"
signal = "Rev"

[[sensor]]
name = "left"
unit = "mm/s"
amplitude = {message = "Vib", signal = "Amp", detection = "peak", valid = "Ok"}
phase = {message = "Ang", signal = "Pha", sense = "lead"}
overall = {message = "Vib", signal = "Rms"}
"""


def stranger(folder: Path, text: str = STRANGER_TOML) -> Path:
    """A mapping file with its DBC beside it."""
    (folder / "stranger.dbc").write_text(STRANGER_DBC)
    path = folder / "mapping.toml"
    path.write_text(text)
    return path


def readings(
    count: int, *, sensors: tuple[str, ...] = ("P", "Q"), source: str = "can", first: int = 1
) -> list[Reading]:
    """Readings whose amplitude tells them apart and which the standard frames hold exactly."""
    return [
        Reading(
            source=source,
            sequence=first + index,
            taken_at=START + timedelta(milliseconds=index),
            sensor=sensors[index % len(sensors)],
            amplitude=round(0.001 * (first + index), 3),
            phase_deg=round(0.1 * (index % 3600), 1),
            speed_rpm=460.0,
            overall_rms=2.5,
        )
        for index in range(count)
    ]


def sensor_frames(count: int, *, j1939: bool = False) -> list[can.Message]:
    """Frames of sensor P only, each one reading, behind one frame of the speed."""
    encoder = FrameEncoder(standard_mapping(("P",), j1939=j1939))
    found: list[can.Message] = []
    for reading in readings(count, sensors=("P",)):
        frames = encoder.reading(reading)
        found += frames if not found else frames[1:]
    return found


def feed(decoder: FrameDecoder, frames: list[can.Message], *, step_s: float = 0.001) -> list[Vector | Masses]:
    """What the decoder makes of frames that come step_s apart."""
    return [
        one
        for index, frame in enumerate(frames)
        for one in decoder.feed(frame.arbitration_id, frame.is_extended_id, frame.data, index * step_s)
    ]
