"""The type of a finding, and what may be known of a session besides its vectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from service.balancing.rotor.phasors import FloatArray
from service.messages import Message, render, render_advice

Severity = Literal["info", "warning", "error"]
Code = Literal[
    "ambiguous_without_phase",
    "bad_run",
    "correction_in_noise",
    "not_linear",
    "not_unbalance_1x_share",
    "not_unbalance_axial",
    "not_unbalance_direction",
    "not_unbalance_phase",
    "one_of_runs_wrong",
    "phase_unsteady",
    "plane_correction_in_noise",
    "planes_buck",
    "planes_dependent",
    "prediction_missed",
    "runs_contradict",
    "sense_mirrored",
    "sensor_incomplete",
    "sensor_silent",
    "sensor_stuck",
    "speed_drift",
    "speed_off_nominal",
    "trial_mass_large",
    "trial_response_small",
]
"""Every code there is. They are stable: clients and translations go by them."""
Direction = Literal["horizontal", "vertical", "axial"]


@dataclass(frozen=True)
class Finding:
    """What was found; runs, planes, sensors: indices that it is about, empty where it is about all."""

    data: Message
    severity: Severity
    runs: tuple[int, ...] = ()
    planes: tuple[int, ...] = ()
    sensors: tuple[int, ...] = ()

    @property
    def code(self) -> Code:
        """The stable code."""
        return cast("Code", self.data.code)

    @property
    def message(self) -> str:
        """What was found, in English."""
        return render(self.data)

    @property
    def advice(self) -> str:
        """What to do, in English."""
        return render_advice(self.data) or ""


@dataclass(frozen=True)
class RunConditions:
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


NOTHING_ELSE = RunConditions()
