"""The whole signal chain: a block of raw samples and key-phasor edges in, a measurement of each channel out.

Bounds, proved in tests/drivers/signal: with noise 40 dB below the 1x component, 16 turns or more and a speed that
drifts evenly by 3 % over the block, amplitude within 0.5 % and phase within 0.5 degree; the drift alone, without noise,
turns the phase by less than 0.06 degree, by nothing where the velocity keeps its size. The vector belongs to the speed
that is stated with it, the mean speed under the same taper: where the response grows as the n-th power of the speed,
what its curvature adds, n (n - 1) / 2 times the variance of the relative speed, is taken out (see `wander`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from drivers.checks import require
from drivers.errors import SignalRefused
from drivers.quantities import PER_PEAK, PER_UNIT
from drivers.signal.block import Block, Channel, Floats, dot
from drivers.signal.broadband import band_rms, usual_band
from drivers.signal.close_tones import close_tone_of
from drivers.signal.integrity import bridged, integrity_of
from drivers.signal.neighbours import Neighbour, neighbour_of
from drivers.signal.orders import Complexes, Course, basis_of, fit_orders, turned
from drivers.signal.pulses import pulses_seen
from drivers.signal.revolutions import Revolutions, turns_of
from drivers.signal.scatter import scatter_of
from drivers.signal.steadying import steadied
from drivers.signal.wander import UNKNOWN, drift_of, speed_effect
from drivers.signal.windows import COSINES, Window, half_width, taper

Flag = Literal["clipped", "dropout", "edges_repaired", "neighbour_tone", "beating", "speed_off"]
DERIVATIVE = {"displacement": 0, "velocity": 1, "acceleration": 2}
MAX_LOST = 0.1
"""Share of samples that may be lost."""
MAX_DRIFT = 0.1
"""Greatest speed over least, less 1: beyond it one vector cannot speak for the block."""
SAMPLES_PER_PERIOD = 2.5
"""Least samples in a period of the highest order: the anti-aliasing filter needs the room."""
GREATEST = 1e9
"""Greatest value of a reading, and far more than any sensor feels."""
NOISY = 2.0
"""Steps of the converter from which on noise would not leave a top at one value turn by turn."""
UNDITHERED = 0.5
"""Steps of the converter below which the noise does not even them out."""
LOUD = 0.1
"""Share of the 1x amplitude from which a neighbour is worth a flag."""


@dataclass(frozen=True, slots=True)
class Settings:
    """How a block is measured.

    harmonics: orders 1 to this are fitted and reported, fewer where the sample rate allows fewer. band_hz: band of the
    overall rms; None: that of the standards (see `broadband`). accept_clipped: measure a clipped channel all the same,
    with its flag. nominal_rpm: refuse a speed that is off by more than a quarter (two marks, a missing one); None: any.
    machine_rpm: speed of service; one that is off by more than a quarter is flagged. one_pulse: the key-phasor is known
    to give one pulse a turn; else, where no speed vouches for that, a vibration that turns once in several pulses
    refuses the channel.
    """

    phase_sense: Literal["lag", "lead"] = "lag"
    window: Window = "blackman_harris"
    harmonics: int = 5
    band_hz: tuple[float, float] | None = None
    accept_clipped: bool = False
    nominal_rpm: float | None = None
    machine_rpm: float | None = None
    one_pulse: bool = False

    def __post_init__(self) -> None:
        require(self.phase_sense in ("lag", "lead"), f"phase_sense {self.phase_sense!r}", "be lag or lead")
        require(self.window in COSINES, f"window {self.window!r}", f"be one of {', '.join(COSINES)}")
        require(1 <= self.harmonics <= 20, f"harmonics {self.harmonics}", "be within 1 and 20")
        if self.band_hz is not None:
            low, high = self.band_hz
            require(
                0.0 < low < high < math.inf, f"band_hz {self.band_hz}", "be two frequencies above 0, the lower first"
            )
        for name in ("nominal_rpm", "machine_rpm"):
            speed = getattr(self, name)
            require(speed is None or 0.0 < speed < math.inf, f"{name} {speed}", "be a number above 0")


@dataclass(frozen=True, slots=True)
class Component:
    """One order of a channel: amplitude in the reading's unit and detection, phase in degrees in the phase sense.

    The phase of order k counts degrees of the signal's own period, k of which fit into a turn.
    """

    order: int
    amplitude: float
    phase_deg: float


@dataclass(frozen=True, slots=True)
class Measured:
    """What a channel says. amplitude, scatter: in its unit and detection; overall_rms: rms, in its unit.

    components: orders 1, 2 ...; the first is the reading's. scatter: standard deviation of the 1x vector per real
    component; 95 % of the errors are within 2.45 of it, those of a tone that makes less than a third of a beat too.
    neighbour: order and amplitude (in the unit and detection) of the strongest tone within half an order of 1x. Flags:
    `clipped`; `dropout`: samples were lost and left out; `edges_repaired`; `neighbour_tone`: one of at least a tenth
    of the 1x amplitude, kept out by the taper; `beating`: one too close to be kept out, or a vector that drifts:
    measure for longer; `speed_off`: the speed is not the machine's.
    """

    channel: Channel
    components: tuple[Component, ...]
    speed_rpm: float
    scatter: float | None
    overall_rms: float
    turns: int
    neighbour: Neighbour | None = None
    flags: tuple[Flag, ...] = ()

    @property
    def amplitude(self) -> float:
        """1x amplitude."""
        return self.components[0].amplitude

    @property
    def phase_deg(self) -> float:
        """1x phase, 0 <= phase < 360."""
        return self.components[0].phase_deg


@dataclass(frozen=True, slots=True)
class Refusal:
    """A channel from which no reading is taken, while others of the block may be: code as in `SignalRefused`."""

    channel: Channel
    code: str
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class _Grid:
    """What the channels of a block share: samples `first` to `last`, their course, basis and taper."""

    first: int
    last: int
    course: Course
    basis: Floats
    weights: Floats
    orders: int
    repaired: bool = field(default=False)
    turned_together: float = 0.0
    turned_each: float = 0.0
    """Standard deviation of the angle, rad, by which all edges may be off together, and each besides."""


def measure(block: Block, settings: Settings | None = None) -> tuple[Measured | Refusal, ...]:
    """Measure each channel of a block, in their order.

    Raises `SignalRefused` where the key-phasor, the speed or the sample rate leaves no channel to be measured:
    codes `too_short`, `tacho`, `speed`, `sampling`.
    """
    settings = settings or Settings()
    grid = _grid(block, settings)
    out: list[Measured | Refusal] = []
    for channel, samples in zip(block.channels, block.samples, strict=True):
        try:
            out.append(_measure(channel, samples, block.sample_rate_hz, grid, settings))
        except SignalRefused as refused:
            out.append(Refusal(channel, refused.code, str(refused)))
    return tuple(out)


def _grid(block: Block, settings: Settings) -> _Grid:
    edges = block.edges_s[(block.edges_s >= 0.0) & (block.edges_s <= block.seconds)]
    found = steadied(turns_of(edges, step_s=block.edge_step_s), block.edge_step_s)
    turns = found.turns
    first = max(math.ceil(turns.times[0] * block.sample_rate_hz), 0)
    last = min(math.ceil(turns.times[-1] * block.sample_rate_hz), block.samples.shape[1])
    angle, speed = turns.angle_and_speed(np.arange(first, last) / block.sample_rate_hz)
    orders = min(settings.harmonics, _orders_within(speed, block.sample_rate_hz))
    _check_speed(turns, settings)
    course = Course(angle, speed, turns.count)
    weights = taper(settings.window, course.place)
    mean_speed = math.tau * turns.count / float(turns.times[-1] - turns.times[0])
    return _Grid(
        first=first,
        last=last,
        course=course,
        basis=basis_of(course, orders),
        weights=weights,
        orders=orders,
        repaired=turns.missed + turns.extra > 0,
        turned_together=mean_speed * found.together,
        turned_each=mean_speed * found.each,
    )


def _orders_within(speed: Floats, sample_rate_hz: float) -> int:
    """How many orders the sample rate carries; raises `SignalRefused` for none."""
    fastest_hz = float(speed.max()) / math.tau if speed.size else math.inf
    orders = int(sample_rate_hz / (SAMPLES_PER_PERIOD * fastest_hz))
    if orders < 1:
        raise SignalRefused(
            f"sample rate {sample_rate_hz:g} Hz at {60.0 * fastest_hz:.4g} r/min; a turn needs at least "
            f"{SAMPLES_PER_PERIOD} samples: sample faster",
            code="sampling",
        )
    return orders


def _check_speed(turns: Revolutions, settings: Settings) -> None:
    """Judge the speed by the periods, so that one jittering edge cannot refuse a block: over four turns each."""
    span = min(4, len(turns.times) - 1)
    speeds = 60.0 * (turns.numbers[span:] - turns.numbers[:-span]) / (turns.times[span:] - turns.times[:-span])
    low, high = float(speeds.min()), float(speeds.max())
    if high > low * (1.0 + MAX_DRIFT):
        raise SignalRefused(
            f"the speed runs from {low:.4g} to {high:.4g} r/min within the block; {MAX_DRIFT:.0%} is the most: wait "
            "until it is steady, or take shorter blocks",
            code="speed",
        )
    nominal = settings.nominal_rpm
    if nominal is not None and not _near(float(np.median(speeds)), nominal):
        raise SignalRefused(
            f"the key-phasor says {float(np.median(speeds)):.4g} r/min where {nominal:.4g} was named: one mark to a "
            "turn? right speed?",
            code="speed",
        )


def _near(speed_rpm: float, nominal_rpm: float) -> bool:
    return 0.75 * nominal_rpm <= speed_rpm <= 1.25 * nominal_rpm


def _measure(channel: Channel, samples: Floats, rate: float, grid: _Grid, settings: Settings) -> Measured:
    raw = samples[grid.first : grid.last]
    _check_size(float(np.abs(raw).max(initial=0.0, where=~np.isnan(raw))))
    state = integrity_of(raw, channel.full_scale)
    _check_samples(state.clipped, float(state.lost.mean()), settings)
    power = DERIVATIVE[channel.quantity] - DERIVATIVE[channel.raw_quantity]
    scale = PER_UNIT[channel.raw_quantity][channel.raw_unit] / PER_UNIT[channel.quantity][channel.unit]
    filled = scale * bridged(raw, state.lost)
    values = filled * grid.course.speed**power
    weights = np.where(state.lost, 0.0, grid.weights)
    fitted, coefficients = fit_orders(grid.basis, weights, values)
    seen = np.where(state.lost, 0.0, 1.0)
    close = close_tone_of(grid.course, grid.basis, values, seen, float(abs(fitted[0])))
    if close is not None:
        values = values - close.samples
        fitted, coefficients = fit_orders(grid.basis, weights, values)
    speed_rpm = dot(weights, grid.course.speed) / float(weights.sum()) * 60.0 / math.tau
    rest = np.where(state.lost, 0.0, values - np.einsum("k,kn->n", coefficients, grid.basis))
    step = abs(scale) * float(np.mean(grid.course.speed**power)) * state.step
    clipped = state.clipped or (state.piled if float(np.median(np.abs(rest))) > NOISY * step else 0)
    _check_samples(clipped, 0.0, settings)
    _check_pulses(grid.course, rest, float(abs(fitted[0])), speed_rpm, settings)
    effect = speed_effect(grid.course, grid.basis, rest, weights)
    tone, rest = _without_neighbour(effect.rest, weights, grid, settings)
    drift, rest = drift_of(grid.course, grid.basis, rest, weights)
    vectors = turned(np.array([fitted[0] + effect.shift, *fitted[1:]]), power) * PER_PEAK[channel.detection]
    deviation = scatter_of(grid.course, rest, weights)
    if deviation is not None:
        widened = deviation * effect.widening * (1.0 if close is None else close.widening)
        turned_off = float(abs(fitted[0])) * _turned_off(grid) / math.sqrt(2.0)
        rounded = _rounded(rest, step, len(rest) / grid.course.turns)
        deviation = math.hypot(widened, effect.off, drift, turned_off, rounded)
    if close is not None and (tone is None or close.amplitude > tone.amplitude):
        tone = Neighbour(close.order, close.amplitude)
    neighbour = _stated(tone, power, PER_PEAK[channel.detection])
    band = settings.band_hz or usual_band(speed_rpm, rate)
    overall = band_rms(filled, rate, band, power)
    _check_size(max(float(np.abs(vectors).max()), overall))
    return Measured(
        channel,
        components=_components(vectors, settings.phase_sense),
        speed_rpm=speed_rpm,
        scatter=None if deviation is None else deviation * PER_PEAK[channel.detection],
        overall_rms=overall,
        turns=grid.course.turns,
        neighbour=neighbour,
        flags=_flags(
            clipped > 0,
            bool(state.lost.any()),
            neighbour,
            abs(vectors[0]),
            close is not None or (tone is not None and _resolved(tone, grid, settings)),
            drifts=drift / UNKNOWN >= (LOUD + 4.0 * _turned_off(grid)) * abs(fitted[0]),
            repaired=grid.repaired,
        )
        + (("speed_off",) if settings.machine_rpm and not _near(speed_rpm, settings.machine_rpm) else ()),
    )


def _rounded(rest: Floats, step: float, per_turn: float) -> float:
    """Standard deviation by the converter's steps (in the unit of rest), where no noise evens them out.

    Sampling that keeps to the turn rounds each turn alike: the error is that of one turn.
    """
    undithered = math.isfinite(step) and math.sqrt(dot(rest, rest) / len(rest)) < UNDITHERED * step
    return step / math.sqrt(12.0) * math.sqrt(2.0 / per_turn) if undithered else 0.0


def _turned_off(grid: _Grid) -> float:
    """Standard deviation of the phase, rad, that the key-phasor's own error makes: all edges, and their mean."""
    effective = grid.weights.sum() ** 2 / dot(grid.weights, grid.weights) / len(grid.weights) * grid.course.turns
    return math.hypot(grid.turned_together, grid.turned_each / math.sqrt(max(float(effective), 1.0)))


def _check_pulses(course: Course, rest: Floats, one_x: float, speed_rpm: float, settings: Settings) -> None:
    """Refuse a channel that turns once in several pulses, unless a speed or the user vouches for one a turn."""
    speeds = (settings.nominal_rpm, settings.machine_rpm)
    if settings.one_pulse or any(speed is not None and _near(speed_rpm, speed) for speed in speeds):
        return
    pulses = pulses_seen(course, rest, one_x)
    if pulses is not None:
        raise SignalRefused(
            f"the vibration turns once in {pulses} pulses of the key-phasor, at {speed_rpm / pulses:.4g} r/min and not "
            f"{speed_rpm:.4g}: state pulses_per_turn = {pulses}, or use one mark a turn; if it is right, state "
            "pulses_per_turn = 1, or the nominal speed",
            code="pulses",
        )


def _check_samples(clipped: int, lost: float, settings: Settings) -> None:
    if lost > MAX_LOST:
        raise SignalRefused(
            f"{lost:.0%} of the samples are lost or frozen; {MAX_LOST:.0%} are the most: check the sensor's cable "
            "and supply",
            code="dropout",
        )
    if clipped and not settings.accept_clipped:
        raise SignalRefused(
            f"{clipped} samples are clipped, so the 1x component reads too low: choose a greater range or a less "
            "sensitive sensor",
            code="clipped",
        )


def _check_size(greatest: float) -> None:
    if not greatest <= GREATEST:
        raise SignalRefused(
            f"{greatest:.3g} in the raw or the stated unit; {GREATEST:g} is the most: check the unit and the scale",
            code="numbers",
        )


def _components(vectors: Complexes, phase_sense: str) -> tuple[Component, ...]:
    sign = -1.0 if phase_sense == "lag" else 1.0
    phases = np.degrees(sign * np.angle(vectors)) % 360.0
    phases[phases >= 360.0] = 0.0
    return tuple(
        Component(order, float(abs(vector)), float(phase))
        for order, (vector, phase) in enumerate(zip(vectors, phases, strict=True), start=1)
    )


def _without_neighbour(
    rest: Floats, weights: Floats, grid: _Grid, settings: Settings
) -> tuple[Neighbour | None, Floats]:
    """Neighbour, if there is one, and the rest without it where the taper keeps it out of the block's vector too."""
    found = neighbour_of(grid.course, rest, weights)
    if found is None:
        return None, rest
    tone, samples = found
    return tone, rest - samples * (weights > 0.0) if _resolved(tone, grid, settings) else rest


def _stated(neighbour: Neighbour | None, power: int, per_peak: float) -> Neighbour | None:
    """The neighbour in the reading's quantity and detection: its own order, not 1, goes into the derivative."""
    if neighbour is None:
        return None
    return Neighbour(neighbour.order, neighbour.amplitude * neighbour.order**power * per_peak)


def _resolved(neighbour: Neighbour, grid: _Grid, settings: Settings) -> bool:
    return abs(neighbour.order - 1.0) * grid.course.turns >= half_width(settings.window)


def _flags(
    clipped: bool,
    lost: bool,
    neighbour: Neighbour | None,
    one_x: float,
    kept_out: bool,
    *,
    drifts: bool,
    repaired: bool,
) -> tuple[Flag, ...]:
    flags: list[Flag] = []
    if clipped:
        flags.append("clipped")
    if lost:
        flags.append("dropout")
    if repaired:
        flags.append("edges_repaired")
    if neighbour is not None and neighbour.amplitude >= LOUD * one_x:
        flags.append("neighbour_tone" if kept_out else "beating")
    if drifts and "beating" not in flags:
        flags.append("beating")
    return tuple(flags)
