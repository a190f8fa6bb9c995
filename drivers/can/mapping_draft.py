"""A first mapping for a DBC: signals that look like a balancer's, told by unit and name; the rest to be corrected."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from cantools.database.can import Database, Message, Signal

from drivers.can.dbc import BrokenDatabase, check_messages
from drivers.files.toml_lines import quoted
from drivers.units import level_of, unit_of

MAX_SHOWN = 60
"""Messages that the heading tells of."""
_AMPLITUDE = re.compile(r"amp|ampl|vib|level|peak|swing|magn|1x|order", re.I)
_PHASE = re.compile(r"pha|angle|winkel|ang$|deg|lag", re.I)
_OVERALL = re.compile(r"rms|overall|total|broad|summ|gesamt|effekt", re.I)
_SPEED = re.compile(r"rpm|speed|rev|drehz|n_|giri|tacho", re.I)
_COUNTER = re.compile(
    r"^(msg_?|frame_?|roll\w*_?|seq\w*_?|alive_?|life_?)?(counter|count|cnt|ctr|seq|alive|rolling)\w*$", re.I
)
_VALID = re.compile(r"valid|ok$|_ok|good|quality|status|qf$|sts$", re.I)
_MASS = re.compile(r"mass|weight|corr|gewicht", re.I)
_ALIVE = re.compile(r"heart|alive|life|hb$", re.I)
_NOISE = re.compile(
    r"amplitude|ampl|amp|vibration|vib|phase|pha|angle|ang|overall|rms|value|val|level|signal|valid|ok|1x", re.I
)


@dataclass(frozen=True, slots=True)
class Place:
    """A signal of a message."""

    message: Message
    signal: Signal

    @property
    def stem(self) -> str:
        """What is left of the name without words for what it is: tells one sensor's signals from another's."""
        return re.sub(r"[\W_]+", "", _NOISE.sub("", self.signal.name)).casefold()


@dataclass(frozen=True, slots=True)
class Sensor:
    """Signals that look like one sensor's. stated: their units are in the DBC."""

    name: str
    amplitude: Place
    phase: Place | None
    overall: Place | None


def described(database: Database) -> list[str]:
    """The messages and signals of a DBC, line by line."""
    lines = [f"{len(database.messages)} messages"]
    for message in database.messages[:MAX_SHOWN]:
        number = f"0x{message.frame_id:X}" + (" (29 bits)" if message.is_extended_frame else "")
        signals = ", ".join(f"{one.name}{f' [{one.unit}]' if one.unit else ''}" for one in message.signals)
        lines.append(f"  {message.name} {number}, {message.length} bytes: {signals or 'no signals'}")
    if len(database.messages) > MAX_SHOWN:
        lines.append(f"  and {len(database.messages) - MAX_SHOWN} more")
    return lines


def sensors_in(database: Database) -> list[Sensor]:
    """Vibration amplitudes of a DBC, each with the phase and the overall value that seem to belong to it."""
    sound = [message for message in database.messages if _is_sound(message)]
    places = [Place(m, s) for m in sound for s in m.signals if s.length >= 8 and not _COUNTER.match(s.name)]
    levels = [
        one
        for one in places
        if level_of(one.signal.unit or "")[0] is not None
        and not (one.signal.unit == "g" and _MASS.search(one.signal.name))
    ]
    if not levels:
        levels = [one for one in places if not one.signal.unit and _AMPLITUDE.search(one.signal.name)]
    phases = [one for one in places if unit_of(one.signal.unit or "", "angle") and not _mass_beside(one)]
    if not phases:
        phases = [one for one in places if not one.signal.unit and _PHASE.search(one.signal.name)]
    overalls = [one for one in levels if _OVERALL.search(one.signal.name) and _others(one, levels)]
    amplitudes = [one for one in levels if one not in overalls]
    found = []
    for one in amplitudes:
        phase, overall = _nearest(one, phases, amplitudes), _nearest(one, overalls, amplitudes)
        name = one.message.name if _alone(one, amplitudes) else f"{one.message.name}.{one.signal.name}"
        found.append(Sensor(name, one, phase, overall))
    return found


def draft(database: Database, path: Path) -> str:
    """The mapping as TOML, which `read_mapping` reads once what it marks is put right."""
    sensors = sensors_in(database)
    lines = [f"# {path.name}: {line}" if not i else f"# {line}" for i, line in enumerate(described(database))]
    lines += ["# Correct what is marked, and the names of the sensors: as the machine calls them.", ""]
    lines.append(f"dbc = {quoted(path.name)}")
    used = {place.message.name for sensor in sensors for place in _places(sensor)}
    counters = _counters(database, used)
    lines += [f"counter = {quoted(counters[0])}"] if counters else []
    extended = [m for m in database.messages if m.name in used and m.is_extended_frame]
    if extended:
        lines.append('# node = 0x21    # J1939: source address of the balancer, or "any"; left out: as in the DBC')
    lines += ['phase_sense = "lag"    # of the machine, see its page', *_speed(database, used)]
    for sensor in sensors:
        lines += ["", "[[sensor]]", f"name = {quoted(sensor.name)}"]
        lines.append(_field("amplitude", sensor.amplitude, unit="mm/s"))
        if sensor.phase is not None:
            lines.append(
                _field("phase", sensor.phase, unit="deg", more=', sense = "lag"', mark="lag or lead? see its manual")
            )
        if sensor.overall is not None:
            lines.append(_field("overall", sensor.overall, unit="mm/s"))
    if not sensors:
        lines += ["", "# No signal has a unit or a name of vibration. Name the signals of each sensor:", "# [[sensor]]"]
        lines += ['# name = "P"', '# amplitude = {message = "", signal = "", unit = "mm/s"}']
        lines += ['# phase = {message = "", signal = "", unit = "deg"}']
    lines += _heartbeat(database)
    return "\n".join(lines) + "\n"


def _is_sound(message: Message) -> bool:
    try:
        check_messages([message])
    except BrokenDatabase:
        return False
    return True


def _places(sensor: Sensor) -> Iterator[Place]:
    yield from (one for one in (sensor.amplitude, sensor.phase, sensor.overall) if one is not None)


def _others(place: Place, places: Iterable[Place]) -> bool:
    return any(one.message is place.message and not _OVERALL.search(one.signal.name) for one in places)


def _alone(place: Place, places: Iterable[Place]) -> bool:
    return not any(one.message is place.message and one != place for one in places)


def _mass_beside(place: Place) -> bool:
    """Whether the message holds a mass: its angle is then that of a correction."""
    return any(
        one is not place.signal and (unit_of(one.unit or "", "mass") or _MASS.search(one.name))
        for one in place.message.signals
        if level_of(one.unit or "")[0] is None
    ) and not any(level_of(one.unit or "")[0] == "mm/s" for one in place.message.signals)


def _nearest(place: Place, candidates: list[Place], amplitudes: list[Place]) -> Place | None:
    """The candidate of the same message and name, else the only one there, else the one of the same name elsewhere."""
    here = [one for one in candidates if one.message is place.message and one != place]
    same = [one for one in here if one.stem == place.stem]
    if len(same) == 1:
        return same[0]
    if len(here) == 1 and _alone(place, amplitudes):
        return here[0]
    elsewhere = [one for one in candidates if one.message is not place.message and place.stem]
    named = [one for one in elsewhere if one.stem == place.stem]
    return named[0] if not here and len(named) == 1 else None


def _counters(database: Database, used: set[str]) -> list[str]:
    """Names of counters in the used messages, the commonest first."""
    names = [s.name for m in database.messages if m.name in used for s in m.signals if _COUNTER.match(s.name)]
    return sorted(set(names), key=lambda name: (-names.count(name), name))


def _speed(database: Database, used: set[str]) -> list[str]:
    places = [Place(m, s) for m in database.messages for s in m.signals if s.length >= 8]
    turning = [one for one in places if unit_of(one.signal.unit or "", "speed") in ("rpm", "rad/s")]
    turning += [
        one for one in places if unit_of(one.signal.unit or "", "speed") == "Hz" and _SPEED.search(one.signal.name)
    ]
    turning.sort(key=lambda one: (one.message.name not in used, not _SPEED.search(one.signal.name)))
    if not turning:
        return ["", "# [speed]    # no signal has a unit of speed", '# message = ""', '# signal = ""', '# unit = "rpm"']
    one, *others = turning
    lines = ["", "[speed]", f"message = {quoted(one.message.name)}", f"signal = {quoted(one.signal.name)}"]
    if flag := _flag(one):
        lines.append(f"valid = {quoted(flag)}")
    if others:
        names = ", ".join(f"{other.message.name}.{other.signal.name}" for other in others[:8])
        lines[1] += f"    # or {names}"
    return lines


def _heartbeat(database: Database) -> list[str]:
    found = [m.name for m in database.messages if _ALIVE.search(m.name)]
    return ["", "[heartbeat]", f"message = {quoted(found[0])}"] if found else []


def _field(key: str, place: Place, *, unit: str, more: str = "", mark: str = "") -> str:
    """The line of a signal; where the DBC has no unit, or one that is not known, one is put in and marked."""
    stated = place.signal.unit or ""
    known = level_of(stated)[0] if key != "phase" else unit_of(stated, "angle")
    unit_text = "" if known else f', unit = "{unit}"'
    said = f"the DBC says {stated!r}: correct it" if stated else "the DBC has no unit: correct it"
    marks = [one for one in (said if unit_text else "", mark) if one]
    flag = _flag(place)
    valid = f", valid = {quoted(flag)}" if flag else ""
    comment = f"    # {'; '.join(marks)}" if marks else ""
    message, signal = quoted(place.message.name), quoted(place.signal.name)
    return f"{key} = {{message = {message}, signal = {signal}{unit_text}{more}{valid}}}{comment}"


def _flag(place: Place) -> str | None:
    """A signal of 1 or 2 bits in the same message that is called as the signal is, and valid."""
    flags = [s for s in place.message.signals if s.length <= 2 and _VALID.search(s.name)]
    own = place.signal.name.casefold()
    named = [
        s.name for s in flags if s.name.casefold().startswith(own) or _of(s.name) == own or own.startswith(_of(s.name))
    ]
    return named[0] if named else None


def _of(name: str) -> str:
    """The name of a flag without its word for valid."""
    return re.sub(r"[\W_]+$|^[\W_]+", "", _VALID.sub("", name)).casefold() or name.casefold()
