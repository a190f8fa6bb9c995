"""The type of a finding, and what may be known of a session besides its vectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from service.balancing.phasors import FloatArray

Severity = Literal["info", "warning", "error"]
Direction = Literal["horizontal", "vertical", "axial"]


@dataclass(frozen=True)
class Finding:
    """code: stable. runs, planes, sensors: indices that it is about, empty where it is about all."""

    code: str
    severity: Severity
    message: str
    advice: str
    runs: tuple[int, ...] = ()
    planes: tuple[int, ...] = ()
    sensors: tuple[int, ...] = ()


@dataclass(frozen=True)
class Circumstances:
    """What else is known of K runs and S sensors; None, nan or an empty tuple where it is not.

    speed_rpm: (K, S) measured. nominal_rpm: (S,) the speed that a row stands for. overall: (K, S) broadband value on
    the scale of the amplitude (equal to it for a pure sine). check: (K,) True for runs made to check a plan. direction,
    bearing: of each sensor.
    """

    speed_rpm: FloatArray | None = None
    nominal_rpm: FloatArray | None = None
    overall: FloatArray | None = None
    check: NDArray[np.bool_] | None = None
    direction: tuple[Direction | None, ...] = ()
    bearing: tuple[str | None, ...] = ()


NOTHING_ELSE = Circumstances()
