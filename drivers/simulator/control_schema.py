"""Control messages of the simulated drum as JSON: strict about names and types, all or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from typing import Protocol

from drivers.checks import require
from drivers.errors import InvalidSetting
from drivers.protocol import Driver
from drivers.simulator.faults import Faults, LooseMass
from drivers.simulator.rotor import Bend
from drivers.simulator.spec import DrumSpec, FittedMass

MAX_PIECES = 1000

Reader = Callable[[object, str], object]


class ControllableDrum(Driver, Protocol):
    """A simulated drum that can be told what to do, whether it makes readings or waveforms."""

    @property
    def spec(self) -> DrumSpec:
        """The drum."""
        ...

    @property
    def masses(self) -> tuple[FittedMass, ...]:
        """The pieces bolted on."""
        ...

    @property
    def speed_rpm(self) -> float:
        """Nominal speed."""
        ...

    @property
    def faults(self) -> Faults:
        """The faults in force."""
        ...

    @property
    def run(self) -> int:
        """Number of the present run."""
        ...

    def fit_masses(self, masses: Iterable[FittedMass]) -> None:
        """Bolt on these pieces, in place of all before."""
        ...

    def set_speed(self, speed_rpm: float) -> None:
        """Turn at this speed."""
        ...

    def set_faults(self, faults: Faults) -> None:
        """State all faults."""
        ...

    def new_run(self) -> None:
        """Stop and start again."""
        ...


def number(value: object, where: str) -> float:
    """Take a JSON number as a float; true and "1" are none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidSetting(f"{where} is {value!r}: give a number")
    try:
        return float(value)
    except OverflowError as error:
        raise InvalidSetting(f"{where} has more than 300 digits: give a number that is meant") from error


def text(value: object, where: str) -> str:
    """Take a JSON string."""
    if not isinstance(value, str):
        raise InvalidSetting(f"{where} is {value!r}: give a string")
    return value


def truth(value: object, where: str) -> bool:
    """Take JSON true or false."""
    if not isinstance(value, bool):
        raise InvalidSetting(f"{where} is {value!r}: give true or false")
    return value


def names(value: object, where: str) -> tuple[str, ...]:
    """Take a JSON list of strings."""
    if not isinstance(value, list):
        raise InvalidSetting(f"{where} is {value!r}: give a list of names")
    return tuple(text(one, where) for one in value)


def pair(value: object, where: str) -> tuple[str, ...] | None:
    """Take a JSON list of two strings, or null."""
    if value is None:
        return None
    found = names(value, where)
    require(len(found) == 2, f"{where} {list(found)}", "be two names, or null")
    return found


def loose(value: object, where: str) -> LooseMass | None:
    """Take a loose mass as a JSON object, or null."""
    return None if value is None else LooseMass(**fields_of(value, LOOSE, where, needed={"plane"}))  # type: ignore[arg-type]


def bend(value: object, where: str) -> Bend | None:
    """Take a bent shaft as a JSON object, or null."""
    if value is None:
        return None
    return Bend(**fields_of(value, BEND, where, needed={"tilt_mrad", "angle_deg"}))  # type: ignore[arg-type]


PIECE: Mapping[str, Reader] = {"plane": text, "mass_g": number, "angle_deg": number}
LOOSE: Mapping[str, Reader] = {"plane": text, "slip_deg": number, "wander_deg": number, "lost": truth}
BEND: Mapping[str, Reader] = {"tilt_mrad": number, "angle_deg": number}
FAULTS: Mapping[str, Reader] = {
    "dropout": number,
    "silent": names,
    "stuck": names,
    "swapped": pair,
    "wrong_phase_sense": truth,
    "wrong_angle_sense": truth,
    "pickup_shift_deg": number,
    "no_key_phasor": truth,
    "loose_trial_mass": loose,
    "bent_shaft": bend,
}


def fields_of(value: object, readers: Mapping[str, Reader], where: str, *, needed: set[str]) -> dict[str, object]:
    """Take the fields of a JSON object, each through its reader; unknown ones and lacking needed ones are refused."""
    if not isinstance(value, dict):
        raise InvalidSetting(f"{where} is {value!r}: give an object with {', '.join(readers)}")
    for name in value:
        if name not in readers:
            raise InvalidSetting(f"field {name!r} of {where} is unknown: use {', '.join(readers)}")
    lacking = sorted(needed - value.keys())
    require(not lacking, f"fields of {where}", f"include {', '.join(lacking)}")
    return {name: readers[name](one, f"{where}.{name}") for name, one in value.items()}


def put_masses(drum: ControllableDrum, body: object) -> None:
    """Bolt on a JSON list of {plane, mass_g, angle_deg}, in place of all before."""
    if not isinstance(body, list):
        raise InvalidSetting(f"masses are {body!r}: give a list of objects with {', '.join(PIECE)}")
    require(len(body) <= MAX_PIECES, f"number of masses {len(body)}", f"be at most {MAX_PIECES}")
    pieces = (
        fields_of(one, PIECE, f"masses[{index}]", needed={"plane", "mass_g", "angle_deg"})
        for index, one in enumerate(body)
    )
    drum.fit_masses([FittedMass(**piece) for piece in pieces])  # type: ignore[arg-type]


def put_speed(drum: ControllableDrum, body: object) -> None:
    """Turn at {speed_rpm}."""
    stated = fields_of(body, {"speed_rpm": number}, "speed", needed={"speed_rpm"})
    drum.set_speed(number(stated["speed_rpm"], "speed.speed_rpm"))


def put_faults(drum: ControllableDrum, body: object) -> None:
    """State all faults as an object of the fields of `Faults`; what is left out is no fault, {} heals everything."""
    drum.set_faults(Faults(**fields_of(body, FAULTS, "faults", needed=set())))  # type: ignore[arg-type]


def put_new_run(drum: ControllableDrum, body: object) -> None:
    """Stop and start again; the body is empty, null or {}."""
    require(body is None or body == {}, f"body {body!r} of new-run", "be empty")
    drum.new_run()


COMMANDS: Mapping[str, Callable[[ControllableDrum, object], None]] = {
    "masses": put_masses,
    "speed": put_speed,
    "faults": put_faults,
    "new-run": put_new_run,
}


def state_of(drum: ControllableDrum) -> dict[str, object]:
    """Describe the drum as JSON values: name, source, run, speed_rpm, masses, faults, health."""
    health = asdict(drum.health())
    taken = drum.health().last_taken_at
    health["last_taken_at"] = None if taken is None else taken.isoformat()
    return {
        "name": drum.spec.name,
        "source": drum.source,
        "run": drum.run,
        "speed_rpm": drum.speed_rpm,
        "masses": [asdict(piece) for piece in drum.masses],
        "faults": asdict(drum.faults),
        "health": health,
    }
