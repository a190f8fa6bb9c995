"""Waveforms in a WAV file: whole numbers of 8 to 32 bits, or floating point of 32 or 64, any number of channels.

Format: Multimedia Programming Interface and Data Specifications 1.0 (IBM, Microsoft 1991), with the extensible header;
RF64 for files above 4 GB (EBU Tech 3306). A recorder that streams, or loses its power, leaves sizes open or too great:
the samples that are there count.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np

from drivers.errors import UnreadableFile
from drivers.files.began import moment_of
from drivers.files.recording import Recording, read_bytes
from drivers.signal.block import Floats

PCM, FLOAT, EXTENSIBLE = 1, 3, 0xFFFE
KNOWN = (b"data", b"fmt ", b"LIST", b"fact", b"bext", b"iXML", b"cue ", b"smpl", b"JUNK", b"id3 ", b"PEAK")
LOOKED_AT = 4096
"""Bytes in which the date of a recording is looked for."""
OPEN = (0, 0xFFFFFFFF, 0xFFFFFFFE, 0x7FFFFFFF)
"""Sizes of a chunk that was still being written."""


@dataclass(frozen=True, slots=True)
class _Format:
    code: int
    channels: int
    rate: int
    bits: int


def read_wav(path: Path) -> Recording:
    """Read a file; columns 1, 2 ... in shares of the full scale, -1 to 1.

    Raises `UnreadableFile` for what breaks the format, and other codings (compressed).
    """
    name = str(path)
    contents = read_bytes(path)
    if contents[:4] not in (b"RIFF", b"RF64", b"BW64") or contents[8:12] != b"WAVE":
        raise UnreadableFile("is no WAV file: it does not begin with RIFF and WAVE", path=name)
    chunk, data, notes = _chunks(contents)
    form = _format(chunk, name)
    frame = form.channels * form.bits // 8
    if len(data) < 2 * frame:
        raise UnreadableFile(f"has {len(data)} bytes of samples, no whole number of {frame} each", path=name)
    samples = _samples(data[: len(data) - len(data) % frame], form)
    if not np.isfinite(samples).all():
        raise UnreadableFile("holds samples that are no finite numbers: record again", path=name)
    rows = samples.reshape(-1, form.channels).T
    columns = {str(i): row for i, row in enumerate(rows, start=1)}
    return Recording(name, float(form.rate), columns, unitless=True, began=_began(contents), notes=tuple(notes))


def _began(contents: bytes) -> datetime | None:
    """Date and time of day in the chunk bext of broadcast files (EBU Tech 3285)."""
    at = contents.find(b"bext", 12, LOOKED_AT)
    stated = contents[at + 8 + 320 : at + 8 + 338] if at >= 0 else b""
    return moment_of(f"{stated[:10].decode('latin-1')} {stated[10:].decode('latin-1')}".replace("\0", " "))


def _chunks(contents: bytes) -> tuple[bytes, memoryview, list[str]]:
    """The format, the samples as far as they are there, and notes; chunks behind the samples do not matter."""
    form, at, whole = b"", 12, memoryview(contents)
    large: int | None = None
    while at + 8 <= len(contents):
        name, size = struct.unpack_from("<4sI", contents, at)
        body = at + 8
        if name == b"data":
            return form, *_data(whole, body, size if large is None or size not in OPEN else large)
        if name == b"fmt ":
            form = contents[body : body + size]
        elif name == b"ds64" and size >= 16:
            large = struct.unpack_from("<Q", contents, body + 8)[0]
        at = _next(contents, body + size, odd=bool(size % 2))
    return form, memoryview(b""), []


def _data(whole: memoryview, body: int, size: int) -> tuple[memoryview, list[str]]:
    there = len(whole) - body
    if size in OPEN and there:
        return whole[body:], ["its size was left open, as by a recorder that streams: all that is there is read"]
    if size > there:
        return whole[body:], [f"it is cut short: {size} bytes of samples are announced, {there} are there and read"]
    return whole[body : body + size], []


def _next(contents: bytes, end: int, *, odd: bool) -> int:
    """Where the next chunk begins: behind a byte of padding if the size is odd, unless a writer left it out."""
    if not odd:
        return end
    there, padded = contents[end : end + 4], contents[end + 1 : end + 5]
    return end if there in KNOWN or (_is_name(there) and not _is_name(padded)) else end + 1


def _is_name(found: bytes) -> bool:
    return len(found) == 4 and all(32 <= one < 127 for one in found) and found.strip() != b""


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


def _samples(data: memoryview, form: _Format) -> Floats:
    if form.code == FLOAT:
        return np.frombuffer(data, f"<f{form.bits // 8}").astype(float)
    if form.bits == 8:
        return (np.frombuffer(data, np.uint8).astype(float) - 128.0) / 128.0
    if form.bits == 24:
        three = np.frombuffer(data, np.uint8).reshape(-1, 3)
        four = np.concatenate([np.zeros((len(three), 1), np.uint8), three], axis=1)  # the low byte is nought
        return four.view("<i4").ravel().astype(float) / 2.0**31
    return np.frombuffer(data, f"<i{form.bits // 8}").astype(float) / 2.0 ** (form.bits - 1)
