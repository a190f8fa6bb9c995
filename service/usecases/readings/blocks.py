"""Blocks of raw waveforms: measured by the signal chain, stored as readings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace

import numpy as np

from drivers.block_driver import reading_of
from drivers.errors import InvalidSetting, SignalRefused
from drivers.signal.block import Block, Channel, Floats
from drivers.signal.chain import Measured, Refusal, Settings, measure
from drivers.signal.directions import compare
from drivers.signal.edges import find_edges
from service.engine.validation import sensor_index
from service.errors import InvalidInput
from service.messages import Message
from service.model.findings import BearingDirections, Findings, NeighbourTone, OrderComponent
from service.model.machine import Machine
from service.runtime.context import AppContext
from service.usecases.readings import ingest
from service.usecases.readings.block_documents import (
    BlockChannel,
    BlockReceipt,
    MeasuredChannel,
    RawBlock,
    RefusedChannel,
    Samples,
)
from service.usecases.readings.clocks import Arrival
from service.usecases.readings.routing import machine_behind


def ingest_block(work: AppContext, raw: RawBlock, arrival: Arrival | None = None) -> BlockReceipt:
    """Measure a block and store a reading of each channel that gives one, with what else was found of it.

    Sent again, they are stored once.

    Raises InvalidInput for channels that do not fit together, and where no channel gives a reading (code `signal_` and
    that of `drivers.errors.SignalRefused`), else as `readings.ingest` does.
    """
    with work.read() as store:
        machine = machine_behind(store, raw.source, raw.session_id)
    try:
        outcomes = _outcomes(raw, machine)
    except SignalRefused as refused:
        raise _nothing(refused.code, str(refused)) from refused
    numbered = list(enumerate(outcomes, start=raw.sequence))
    found = {number: one for number, one in numbered if isinstance(one, Measured)}
    if not found:
        first = next(one for one in outcomes if isinstance(one, Refusal))
        raise _nothing(first.code, f"{first.channel.sensor}: {first.reason}")
    directions = _directions(machine, list(found.values()))
    receipt = _store(work, raw, machine, found, directions, arrival)
    return BlockReceipt(
        accepted=receipt.accepted,
        duplicates=receipt.duplicates,
        measured=tuple(_measured(number, one) for number, one in found.items()),
        refused=tuple(
            RefusedChannel(sensor=one.channel.sensor, code=one.code, detail=one.reason)
            for one in outcomes
            if isinstance(one, Refusal)
        ),
        directions=directions,
    )


def _outcomes(raw: RawBlock, machine: Machine) -> Sequence[Measured | Refusal]:
    with _naming("band_hz", raw.band_hz):
        settings = _settings(raw, machine)
    with _naming("channels", [one.sensor for one in raw.channels]):
        return measure(_block(raw, machine), settings)


@contextmanager
def _naming(field: str, value: object) -> Iterator[None]:
    """A block in which what breaks a rule of the signal chain is this field."""
    try:
        yield
    except InvalidSetting as wrong:
        raise InvalidInput(
            Message("invalid_input.block_setting", reason=str(wrong)), field=field, value=value
        ) from wrong


def _store(
    work: AppContext,
    raw: RawBlock,
    machine: Machine,
    found: Mapping[int, Measured],
    directions: Sequence[BearingDirections],
    arrival: Arrival | None,
) -> ingest.Receipt:
    """Store the readings and, beside those that are new or bare, their findings: all in one unit of work."""
    stated = [
        reading_of(one, source=raw.source, sequence=number, taken_at=raw.taken_at, session_id=raw.session_id)
        for number, one in found.items()
    ]
    bearings = {sensor.name: sensor.bearing for sensor in machine.sensors}
    at_bearing = {one.bearing: one for one in directions}
    with work.write() as store:
        receipt = ingest.ingest(replace(work, joined=lambda: nullcontext(store)), stated, arrival)
        store.add_findings(
            raw.source,
            raw.taken_at,
            {
                number: _findings(one, at_bearing.get(bearings[one.channel.sensor] or ""))
                for number, one in found.items()
            },
        )
    return receipt


def _findings(one: Measured, directions: BearingDirections | None) -> Findings:
    seen = _measured(0, one)
    return Findings(
        turns=seen.turns,
        components=seen.components,
        neighbour=seen.neighbour,
        flags=seen.flags,
        directions=directions,
    )


def _nothing(code: str, reason: str) -> InvalidInput:
    field = "edges_s" if code in ("too_short", "tacho", "speed", "pulses") else "channels"
    return InvalidInput(Message("signal_refused", reason=reason), code=f"signal_{code}", field=field)


def _block(raw: RawBlock, machine: Machine) -> Block:
    lengths = {len(channel.samples) for channel in raw.channels}
    if raw.tachometer is not None:
        lengths.add(len(raw.tachometer.samples))
    if len(lengths) > 1:
        raise InvalidInput(
            Message("invalid_input.block_lengths", lengths=sorted(lengths)), field="channels", value=sorted(lengths)
        )
    channels = tuple(_channel(one, index, machine) for index, one in enumerate(raw.channels))
    samples = np.stack([_array(one.samples) for one in raw.channels])
    step_s = 0.0 if raw.tachometer is None else 1.0 / raw.sample_rate_hz
    return Block(channels, samples, raw.sample_rate_hz, _edges(raw), step_s)


def _channel(posted: BlockChannel, index: int, machine: Machine) -> Channel:
    sensor = machine.sensors[sensor_index(machine, posted.sensor, f"channels[{index}].sensor")]
    return Channel(
        sensor.name,
        sensor.quantity,
        sensor.unit,
        sensor.detection,
        posted.quantity,
        posted.unit,
        posted.full_scale,
    )


def _edges(raw: RawBlock) -> Floats:
    tachometer = raw.tachometer
    if (tachometer is None) == (raw.edges_s is None):
        raise InvalidInput(
            Message("invalid_input.block_without_phasor" if tachometer is None else "invalid_input.block_phasor_twice"),
            field="edges_s",
        )
    if tachometer is None:
        edges = np.array(raw.edges_s, float)
        _require_increasing(edges)
        return edges
    with _naming("tachometer", None):
        return find_edges(
            _array(tachometer.samples),
            raw.sample_rate_hz,
            slope=tachometer.slope,
            threshold=tachometer.threshold,
            hysteresis=tachometer.hysteresis,
        )


def _require_increasing(edges: Floats) -> None:
    back = np.flatnonzero(np.diff(edges) <= 0.0)
    if len(back):
        index = int(back[0]) + 1
        raise InvalidInput(
            Message("invalid_input.edges_order", index=index, time=float(edges[index]), before=float(edges[index - 1])),
            field=f"edges_s[{index}]",
            value=float(edges[index]),
        )


def _array(samples: Samples) -> Floats:
    return np.array(samples, float)  # None becomes NaN


def _settings(raw: RawBlock, machine: Machine) -> Settings:
    return Settings(
        phase_sense=machine.phase_sense,
        window=raw.window,
        harmonics=raw.harmonics,
        band_hz=raw.band_hz,
        accept_clipped=raw.accept_clipped,
        nominal_rpm=raw.nominal_rpm,
        machine_rpm=machine.service_speed_rpm,
    )


def _measured(sequence: int, one: Measured) -> MeasuredChannel:
    tone = one.neighbour
    return MeasuredChannel(
        sensor=one.channel.sensor,
        sequence=sequence,
        amplitude=one.amplitude,
        phase_deg=one.phase_deg,
        speed_rpm=one.speed_rpm,
        scatter=one.scatter,
        overall_rms=one.overall_rms,
        turns=one.turns,
        components=tuple(
            OrderComponent(order=c.order, amplitude=c.amplitude, phase_deg=c.phase_deg) for c in one.components
        ),
        neighbour=None if tone is None else NeighbourTone(order=tone.order, amplitude=tone.amplitude),
        flags=one.flags,
    )


def _directions(machine: Machine, found: list[Measured]) -> tuple[BearingDirections, ...]:
    at: dict[str, dict[str, Measured]] = {}
    by_name = {one.channel.sensor: one for one in found}
    for sensor in machine.sensors:
        if sensor.bearing and sensor.direction and sensor.name in by_name:
            at.setdefault(sensor.bearing, {})[sensor.direction] = by_name[sensor.name]
    out = []
    for bearing, felt in at.items():
        if not {"horizontal", "vertical"} <= set(felt):
            continue
        try:
            seen = compare(felt["horizontal"], felt["vertical"], felt.get("axial"))
        except InvalidSetting:
            continue  # stated in different units: nothing to compare
        out.append(
            BearingDirections(
                bearing=bearing,
                h_to_v=seen.h_to_v,
                h_minus_v_deg=seen.h_minus_v_deg,
                axial_to_radial=seen.axial_to_radial,
                doubts=seen.doubts,
            )
        )
    return tuple(out)
