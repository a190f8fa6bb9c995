"""Waveforms in a WAV file: whole numbers of 8 to 32 bits, or floating point of 32 or 64, any number of channels.

Format: Multimedia Programming Interface and Data Specifications 1.0 (IBM, Microsoft 1991), with the extensible header.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drivers.errors import UnreadableFile
from drivers.files.recording import Recording, read_bytes
from drivers.signal.block import Floats

PCM, FLOAT, EXTENSIBLE = 1, 3, 0xFFFE


@dataclass(frozen=True, slots=True)
class _Format:
    code: int
    channels: int
    rate: int
    bits: int


def read_wav(path: Path) -> Recording:
    """Read a file; columns 1, 2 ... in shares of the full scale, -1 to 1.

    Raises `UnreadableFile` for what breaks the format, other codings (compressed), and a file cut short.
    """
    name = str(path)
    contents = read_bytes(path)
    if contents[:4] != b"RIFF" or contents[8:12] != b"WAVE":
        raise UnreadableFile("is no WAV file: it does not begin with RIFF and WAVE", path=name)
    chunks = _chunks(contents, name)
    form = _format(chunks.get(b"fmt ", b""), name)
    data = chunks.get(b"data", b"")
    frame = form.channels * form.bits // 8
    if len(data) < 2 * frame or len(data) % frame:
        raise UnreadableFile(f"has {len(data)} bytes of samples, no whole number of {frame} each", path=name)
    samples = _samples(data, form)
    if not np.isfinite(samples).all():
        raise UnreadableFile("holds samples that are no finite numbers: record again", path=name)
    rows = samples.reshape(-1, form.channels).T
    return Recording(name, float(form.rate), {str(i): row for i, row in enumerate(rows, start=1)}, unitless=True)


def _chunks(contents: bytes, path: str) -> dict[bytes, bytes]:
    """Chunks by name, the first of each; raises where one is longer than the file."""
    chunks: dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= len(contents):
        name, size = struct.unpack_from("<4sI", contents, at)
        if at + 8 + size > len(contents):
            raise UnreadableFile(
                f"is cut short: {size} bytes announced at byte {at}, {len(contents) - at - 8} there", path=path
            )
        chunks.setdefault(name, contents[at + 8 : at + 8 + size])
        at += 8 + size + size % 2
    return chunks


def _format(chunk: bytes, path: str) -> _Format:
    if len(chunk) < 16:
        raise UnreadableFile("has no format chunk: it is no complete WAV file", path=path)
    code, channels, rate, _, _, bits = struct.unpack_from("<HHIIHH", chunk)
    if code == EXTENSIBLE and len(chunk) >= 26:
        (code,) = struct.unpack_from("<H", chunk, 24)  # the first two bytes of the sub-format are the coding
    known = (code == PCM and bits in (8, 16, 24, 32)) or (code == FLOAT and bits in (32, 64))
    if not known or not 1 <= channels <= 256 or rate == 0:
        raise UnreadableFile(
            f"has coding {code} with {bits} bits, {channels} channels at {rate} Hz: save it as PCM or float", path=path
        )
    return _Format(code, channels, rate, bits)


def _samples(data: bytes, form: _Format) -> Floats:
    if form.code == FLOAT:
        return np.frombuffer(data, f"<f{form.bits // 8}").astype(float)
    if form.bits == 8:
        return (np.frombuffer(data, np.uint8).astype(float) - 128.0) / 128.0
    if form.bits == 24:
        three = np.frombuffer(data, np.uint8).reshape(-1, 3)
        four = np.concatenate([np.zeros((len(three), 1), np.uint8), three], axis=1)  # the low byte is nought
        return four.view("<i4").ravel().astype(float) / 2.0**31
    return np.frombuffer(data, f"<i{form.bits // 8}").astype(float) / 2.0 ** (form.bits - 1)
