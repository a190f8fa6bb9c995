"""Writers of recordings, plain enough to be trusted: a published drum with a tachometer beside its sensors."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Callable
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from drivers.files.recording import Layout
from drivers.signal.block import Block, Channel, Floats
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.waveforms import Disturbance, simulate_block

RATE = 640.0
FULL_SCALE = 5.0
STARTED = datetime(2026, 5, 4, 8, 30, tzinfo=UTC)
CHANNELS = (Channel("P", full_scale=FULL_SCALE), Channel("Q", full_scale=FULL_SCALE))


@cache
def drum_block(seconds: float = 26.0) -> Block:
    """The drum of the example without scatter, sampled."""
    quiet = Disturbance(electronics=0.002)
    rng = np.random.default_rng(8)
    return simulate_block(threshing_drum_example(), seconds=seconds, sample_rate_hz=RATE, rng=rng, disturbance=quiet)


def tacho(block: Block) -> Floats:
    """A pulse of 20 ms at each edge, with flanks as an anti-aliasing filter leaves them: three samples long."""
    since = np.arange(block.samples.shape[1])[:, None] / RATE - block.edges_s[None, :]
    rising = np.clip(since * RATE / 3.0 + 0.5, 0.0, 1.0)
    falling = np.clip((since - 0.02) * RATE / 3.0 + 0.5, 0.0, 1.0)
    return np.asarray((rising - falling).sum(axis=1), float)


def layout(names: tuple[str, str, str], **changes: Any) -> Layout:
    """The layout of a file whose columns bear these names: P, Q, key-phasor."""
    channels = tuple(zip(names[:2], CHANNELS, strict=True))
    stated: dict[str, Any] = {"channels": channels, "key_phasor": names[2], "started_at": STARTED}
    return Layout(**(stated | changes))


_WRITTEN: dict[object, tuple[bytes, Layout]] = {}


def recorded(write: Callable[..., Layout], path: Path, **options: Any) -> Layout:
    """The drum's recording as `write` writes it; written once, for it takes longer than reading it."""
    key = (write, *sorted(options.items()))
    if key not in _WRITTEN:
        used = write(path, drum_block(), **options)
        _WRITTEN[key] = (path.read_bytes(), used)
    contents, used = _WRITTEN[key]
    path.write_bytes(contents)
    return used


def write_csv(path: Path, block: Block, separator: str = ",", point: str = ".", time: bool = True) -> Layout:
    rows = np.column_stack([np.arange(block.samples.shape[1]) / RATE, *block.samples, tacho(block)])
    lines = ["# drum", separator.join(['"t"', "P", "Q", "kp"])]
    lines += [separator.join(f"{value:.9g}".replace(".", point) for value in row) for row in rows]
    if not time:
        lines = lines[:1] + [line.split(separator, 1)[1] for line in lines[1:]]
        path.write_text("\n".join(lines) + "\n")
        return layout(("P", "Q", "kp"), sample_rate_hz=RATE)
    path.write_text("\r\n".join(lines))
    return layout(("P", "Q", "kp"), time="t")


def write_wav(path: Path, block: Block, bits: int = 16, code: int = 1, extensible: bool = False) -> Layout:
    shares = np.column_stack([*(block.samples / FULL_SCALE), tacho(block) * 0.9])
    assert np.abs(shares).max() < 1.0
    if code == 3:
        data = shares.astype(f"<f{bits // 8}").tobytes()
    elif bits == 8:
        data = np.round(shares * 127.0 + 128.0).astype(np.uint8).tobytes()
    else:
        whole = np.round(shares * 2.0 ** (bits - 1)).astype("<i4")
        data = whole.view(np.uint8).reshape(-1, 4)[:, : bits // 8].tobytes()
    frame = 3 * bits // 8
    form = struct.pack("<HHIIHH", 0xFFFE if extensible else code, 3, int(RATE), int(RATE) * frame, frame, bits)
    if extensible:
        form += struct.pack(
            "<HHIH14s", 22, bits, 0, code, bytes.fromhex("0000 0000 1000 8000 00aa 0038 9b71".replace(" ", ""))
        )
    chunks = b"".join(
        name + struct.pack("<I", len(body)) + body + b"\0" * (len(body) % 2)
        for name, body in ((b"fmt ", form), (b"LIST", b"odd"), (b"data", data))
    )
    path.write_bytes(b"RIFF" + struct.pack("<I", 4 + len(chunks)) + b"WAVE" + chunks)
    return layout(("1", "2", "3"))


def write_uff(path: Path, block: Block, binary: int = 1, **changes: Any) -> Layout:
    import pyuff

    columns = [
        (1, 3, 12, "m/s^2", block.samples[0]),
        (2, 3, 12, "m/s^2", block.samples[1]),
        (9, 0, 0, "V", tacho(block)),
    ]
    sets = []
    for node, direction, kind, label, data in columns:
        sets.append(
            pyuff.prepare_58(
                binary=binary, func_type=1, rsp_node=node, rsp_dir=direction, ref_node=0, ref_dir=0, id1="drum",
                data=data, x=np.arange(len(data)) / RATE, abscissa_spacing=1, abscissa_spec_data_type=17,
                ordinate_spec_data_type=kind, orddenom_spec_data_type=0, ordinate_axis_units_lab=label,
            ) | changes
        )  # fmt: skip
    path.unlink(missing_ok=True)  # overwriting, pyuff begins a binary set with two delimiters
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # its writer leaves files open; its reader does not
        pyuff.UFF(str(path)).write_sets(sets, mode="add")
    return layout(("1+Z", "2+Z", "9"))
