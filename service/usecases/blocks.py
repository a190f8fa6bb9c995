"""Blocks of raw waveforms: measured by the signal chain, stored as readings."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le, Len
from pydantic import AwareDatetime

from db.documents.base import Finite, Name, NotNegative, Positive, Sequence, document
from db.documents.machine import Machine, Quantity, Unit
from drivers.block_driver import reading_of
from drivers.errors import InvalidSetting, SignalRefused
from drivers.signal.block import Block, Channel, Floats
from drivers.signal.chain import Flag, Measured, Refusal, Settings, measure
from drivers.signal.directions import Doubt, compare
from drivers.signal.edges import find_edges
from drivers.signal.windows import Window
from service.errors import InvalidInput
from service.usecases import readings
from service.usecases.rules import sensor_index
from service.usecases.work import Work

Samples = Annotated[tuple[float | None, ...], Len(2, 2_000_000)]


@document
class BlockChannel:
    """Raw samples of one sensor."""

    sensor: Name
    """Sensor of the machine; its quantity, unit and detection are those of the reading."""
    samples: Samples
    """Samples, in `unit`; null: the sample was lost."""
    quantity: Quantity = "acceleration"
    """What is sampled."""
    unit: Unit = "m/s2"
    """Unit of the samples."""
    full_scale: Positive | None = None
    """Greatest value that the input takes, in `unit`; tells clipping where the samples alone cannot."""


@document
class Tachometer:
    """Sampled signal of the key-phasor, together with the channels."""

    samples: Samples
    """Samples, in any unit; null: the sample was lost."""
    slope: Literal["rising", "falling"] = "rising"
    """The flank at which the mark passes the pick-up."""
    threshold: Finite | None = None
    """Where an edge lies, in the unit of the samples; null: midway."""
    hysteresis: NotNegative | None = None
    """How far the signal must come back before the next edge, in the unit of the samples; null: 30 % of its swing."""


@document
class RawBlock:
    """A block of raw waveforms. Give either `edges_s` or `tachometer`."""

    source: Name
    """Who measured."""
    sequence: Sequence
    """Number of the first channel's reading; each further channel takes the next one."""
    taken_at: AwareDatetime
    """Time of the first sample, with its zone (RFC 3339)."""
    session_id: Name | None = None
    """Session; null for a source that is bound to a machine."""
    sample_rate_hz: Positive
    """Samples of each channel in a second."""
    channels: Annotated[tuple[BlockChannel, ...], Len(1, 64)]
    """The channels, all taken together and of one length."""
    edges_s: Annotated[tuple[Finite, ...], Len(0, 100_000)] | None = None
    """Times at which the mark passed the pick-up, s from the first sample, increasing."""
    tachometer: Tachometer | None = None
    """Signal of the key-phasor, from which the edges are taken."""
    window: Window = "blackman_harris"
    """Taper over the block: how well a tone near the 1x component is kept out."""
    harmonics: Annotated[int, Ge(1), Le(20)] = 5
    """Orders 1 to this are measured."""
    band_hz: tuple[Annotated[float, Gt(0)], Annotated[float, Gt(0)]] | None = None
    """Band of the overall rms, Hz; null: 10 Hz to 1000 Hz, from 2 Hz below 600 r/min."""
    nominal_rpm: Positive | None = None
    """Speed that is expected, r/min: one that is off by more than a quarter is refused."""
    accept_clipped: bool = False
    """Measure a clipped channel all the same; it reads too low."""


@document
class OrderComponent:
    """One order of a channel."""

    order: int
    """Multiple of the speed."""
    amplitude: float
    """Amplitude, in the sensor's unit and detection."""
    phase_deg: float
    """Phase, degrees of the component's own period, in the machine's phase sense."""


@document
class NeighbourTone:
    """A tone of another machine."""

    order: float
    """Its frequency over that of the rotor."""
    amplitude: float
    """Amplitude, in the sensor's unit and detection."""


@document
class MeasuredChannel:
    """What a channel says; the reading that was stored, and what lies beside it."""

    sensor: str
    """Sensor."""
    sequence: int
    """Number of its reading."""
    amplitude: float
    """1x amplitude, in the sensor's quantity, unit and detection."""
    phase_deg: float
    """1x phase, degrees, in the machine's phase sense."""
    speed_rpm: float
    """Speed that the vector belongs to, r/min."""
    scatter: float | None
    """Standard deviation of the 1x vector per real component; null below 8 turns."""
    overall_rms: float
    """Broadband value, rms, in the sensor's unit."""
    turns: int
    """Whole turns that were measured."""
    components: tuple[OrderComponent, ...]
    """Order 1 and its harmonics."""
    neighbour: NeighbourTone | None
    """The strongest tone within half an order of 1x."""
    flags: tuple[Flag, ...]
    """What to know before trusting it: beating means that a tone was too near to be kept out."""


@document
class RefusedChannel:
    """A channel of which no reading was stored."""

    sensor: str
    """Sensor."""
    code: str
    """Stable code of the reason."""
    detail: str
    """What is wrong and what to do."""


@document
class BearingDirections:
    """1x components in different directions at one bearing."""

    bearing: str
    """Bearing."""
    h_to_v: float | None
    """Horizontal over vertical amplitude."""
    h_minus_v_deg: float
    """Phase of horizontal less that of vertical, degrees."""
    axial_to_radial: float | None
    """Axial over the greater radial amplitude; null without an axial sensor."""
    doubts: tuple[Doubt, ...]
    """Signs that something besides unbalance is at work."""


@document
class BlockReceipt:
    """What became of a block."""

    accepted: int
    """Readings stored now."""
    duplicates: int
    """Readings that were stored before, with the same contents."""
    measured: tuple[MeasuredChannel, ...]
    """Channels of which a reading is stored."""
    refused: tuple[RefusedChannel, ...]
    """Channels of which none is."""
    directions: tuple[BearingDirections, ...]
    """Bearings with a horizontal and a vertical sensor in the block, stated alike."""


def ingest_block(work: Work, raw: RawBlock) -> BlockReceipt:
    """Measure a block and store a reading of each channel that gives one; sent again, they are stored once.

    Raises InvalidInput for channels that do not fit together, and where no channel gives a reading (code `signal_` and
    that of `drivers.errors.SignalRefused`), else as `readings.ingest` does.
    """
    with work.database.read() as store:
        machine = readings.machine_behind(store, raw.source, raw.session_id)
    try:
        outcomes = measure(_block(raw, machine), _settings(raw, machine))
    except SignalRefused as refused:
        raise _nothing(refused.code, str(refused)) from refused
    except InvalidSetting as wrong:
        raise InvalidInput(str(wrong), advice="correct the block and send it again") from wrong
    numbered = list(enumerate(outcomes, start=raw.sequence))
    found = {number: one for number, one in numbered if isinstance(one, Measured)}
    if not found:
        first = next(one for one in outcomes if isinstance(one, Refusal))
        raise _nothing(first.code, f"{first.channel.sensor}: {first.reason}")
    receipt = readings.ingest(
        work,
        [
            reading_of(one, source=raw.source, sequence=number, taken_at=raw.taken_at, session_id=raw.session_id)
            for number, one in found.items()
        ],
    )
    return BlockReceipt(
        accepted=receipt.accepted,
        duplicates=receipt.duplicates,
        measured=tuple(_measured(number, one) for number, one in found.items()),
        refused=tuple(
            RefusedChannel(sensor=one.channel.sensor, code=one.code, detail=one.reason)
            for one in outcomes
            if isinstance(one, Refusal)
        ),
        directions=_directions(machine, list(found.values())),
    )


def _nothing(code: str, reason: str) -> InvalidInput:
    field = "edges_s" if code in ("too_short", "tacho", "speed") else "channels"
    return InvalidInput(
        reason, code=f"signal_{code}", field=field, advice="put right what the message names, and measure again"
    )


def _block(raw: RawBlock, machine: Machine) -> Block:
    lengths = {len(channel.samples) for channel in raw.channels}
    if raw.tachometer is not None:
        lengths.add(len(raw.tachometer.samples))
    if len(lengths) > 1:
        raise InvalidInput(
            f"channels of {', '.join(map(str, sorted(lengths)))} samples in one block",
            field="channels",
            value=sorted(lengths),
            advice="send as many samples of each channel, and of the tachometer, taken together",
        )
    channels = tuple(_channel(one, index, machine) for index, one in enumerate(raw.channels))
    samples = np.stack([_array(one.samples) for one in raw.channels])
    return Block(channels, samples, raw.sample_rate_hz, _edges(raw))


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
            "a block needs its key-phasor once: edges_s or tachometer",
            field="edges_s",
            advice="send the times of the edges, or the signal they are to be found in",
        )
    if tachometer is None:
        return np.array(raw.edges_s, float)
    return find_edges(
        _array(tachometer.samples),
        raw.sample_rate_hz,
        slope=tachometer.slope,
        threshold=tachometer.threshold,
        hysteresis=tachometer.hysteresis,
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
