"""Documents of raw blocks: what is posted, and what became of each channel."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, Len

from drivers.signal.windows import Window
from service.model.base import Finite, Moment, Name, NotNegative, Positive, Sequence, document
from service.model.findings import BearingDirections, Flag, NeighbourTone, OrderComponent
from service.model.machine import Quantity, Unit

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
    taken_at: Moment
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
