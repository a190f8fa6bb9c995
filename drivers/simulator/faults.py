"""Faults of a drum, its instruments and its technician, each a named knob; none by default."""

from __future__ import annotations

from dataclasses import dataclass

from drivers.checks import require, require_finite, require_known
from drivers.simulator.rotor import Bend
from drivers.simulator.spec import DrumSpec


@dataclass(frozen=True, slots=True)
class LooseMass:
    """The pieces bolted into `plane` do not stay where they were put.

    slip_deg: they sit this far from the stated angle (in the drum's angle sense) from the first turn on.
    wander_deg: and move about by this standard deviation from one reading to the next. lost: they fell off.
    """

    plane: str
    slip_deg: float = 0.0
    wander_deg: float = 0.0
    lost: bool = False

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.wander_deg >= 0.0, f"wander_deg {self.wander_deg} in plane {self.plane!r}", "be >= 0")


@dataclass(frozen=True, slots=True)
class Faults:
    """What is wrong besides the unbalance.

    dropout: probability that a reading never arrives; its sequence number is lost with it. silent: sensors of which
    none arrives. stuck: sensors that repeat their last amplitude, phase and overall value. swapped: two sensors whose
    cables are exchanged: each reports what is felt at the other's place. wrong_phase_sense: phases are reported with
    the sign turned. wrong_angle_sense: pieces were bolted on counting angles the wrong way round. pickup_shift_deg: the
    pick-up was knocked this far, counter-clockwise. no_key_phasor: neither phase nor speed is known.
    loose_trial_mass: see `LooseMass`. bent_shaft: see `drivers.simulator.rotor.Bend`.
    """

    dropout: float = 0.0
    silent: tuple[str, ...] = ()
    stuck: tuple[str, ...] = ()
    swapped: tuple[str, str] | None = None
    wrong_phase_sense: bool = False
    wrong_angle_sense: bool = False
    pickup_shift_deg: float = 0.0
    no_key_phasor: bool = False
    loose_trial_mass: LooseMass | None = None
    bent_shaft: Bend | None = None

    def __post_init__(self) -> None:
        require_finite(self)
        require(0.0 <= self.dropout <= 1.0, f"dropout {self.dropout}", "be a probability within 0 and 1")


NO_FAULTS = Faults()


def check_faults(faults: Faults, spec: DrumSpec) -> None:
    """Raise `InvalidSetting` for a sensor or plane that is not on the drum."""
    sensors = [sensor.name for sensor in spec.sensors]
    for name in (*faults.silent, *faults.stuck, *(faults.swapped or ())):
        require_known(name, sensors, "sensor")
    if faults.swapped is not None:
        require(faults.swapped[0] != faults.swapped[1], f"swapped sensors {faults.swapped}", "be two different ones")
    if faults.loose_trial_mass is not None:
        spec.plane(faults.loose_trial_mass.plane)
