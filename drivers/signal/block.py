"""A block of raw samples with the key-phasor edges that belong to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.checks import require, require_distinct, require_finite
from drivers.quantities import PER_PEAK, PER_UNIT, Detection, Quantity

Floats = NDArray[np.float64]


def dot(one: Floats, other: Floats) -> float:
    """Sum of the products of (n,) and (n,), on one core: BLAS would wake the others, at hundreds of times the cost."""
    return float(np.einsum("i,i->", one, other))


@dataclass(frozen=True, slots=True)
class Channel:
    """What is sampled (raw_quantity in raw_unit) and how its reading is stated (quantity, unit, detection).

    full_scale: greatest raw value the input can take, in raw_unit; None where it is not known.
    """

    sensor: str
    quantity: Quantity = "velocity"
    unit: str = "mm/s"
    detection: Detection = "rms"
    raw_quantity: Quantity = "acceleration"
    raw_unit: str = "m/s2"
    full_scale: float | None = None

    def __post_init__(self) -> None:
        require_finite(self)
        for what, quantity, unit in (
            ("", self.quantity, self.unit),
            ("raw_", self.raw_quantity, self.raw_unit),
        ):
            require(quantity in PER_UNIT, f"{what}quantity {quantity!r}", f"be one of {', '.join(PER_UNIT)}")
            units = PER_UNIT[quantity]
            require(unit in units, f"{what}unit {unit!r} of {quantity}", f"be one of {', '.join(units)}")
        require(self.detection in PER_PEAK, f"detection {self.detection!r}", f"be one of {', '.join(PER_PEAK)}")
        require(self.full_scale is None or self.full_scale > 0.0, f"full_scale {self.full_scale}", "be > 0")


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Samples (channels, n) in each channel's raw unit, taken together at sample_rate_hz; NaN: the sample was lost.

    edges_s (m,): times at which the mark passed the pick-up, s from the first sample, increasing. edge_step_s: sample
    interval of the signal in which they were found; 0: they are exact.
    """

    channels: tuple[Channel, ...]
    samples: Floats
    sample_rate_hz: float
    edges_s: Floats
    edge_step_s: float = 0.0

    def __post_init__(self) -> None:
        require_finite(self)
        require(bool(self.channels), "number of channels 0", "be one or more")
        require_distinct((channel.sensor for channel in self.channels), "sensor")
        require(self.sample_rate_hz > 0.0, f"sample_rate_hz {self.sample_rate_hz}", "be > 0")
        require(self.edge_step_s >= 0.0, f"edge_step_s {self.edge_step_s}", "be >= 0")
        shape = self.samples.shape
        rule = f"be ({len(self.channels)}, n), one row for each channel"
        require(self.samples.ndim == 2 and shape[0] == len(self.channels), f"shape {shape} of samples", rule)
        require(self.edges_s.ndim == 1, f"shape {self.edges_s.shape} of edges_s", "be (m,)")
        require(not bool(np.isinf(self.samples).any()), "an infinite sample", "be a number, or NaN where it was lost")

    @property
    def seconds(self) -> float:
        """Length of the block."""
        return float(self.samples.shape[1] / self.sample_rate_hz)
