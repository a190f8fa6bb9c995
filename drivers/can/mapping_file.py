"""Reading a mapping file: TOML to `CanMapping`, every error with the line it is on."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import cantools
from cantools.database.can import Database, Message, Signal

from drivers.can.mapping import ANGLE_SENSES, PHASE_SENSES, CanMapping, Field, PlaneMap, SensorMap
from drivers.errors import InvalidSetting
from drivers.files.toml_lines import Where, lines_of
from drivers.quantities import PER_PEAK, PER_UNIT

PER_RPM = {"rpm": 1.0, "r/min": 1.0, "1/min": 1.0, "Hz": 60.0, "rad/s": 30.0 / math.pi}
PER_DEGREE = {"deg": 1.0, "degree": 1.0, "°": 1.0, "rad": 180.0 / math.pi}
PER_GRAM = {"g": 1.0, "kg": 1000.0}

_TOP = frozenset(
    {"dbc", "counter", "node", "max_age_s", "phase_sense", "angle_sense"}
    | {"speed", "sensor", "correction", "heartbeat", "status"}
)


def read_mapping(path: Path) -> CanMapping:
    """Read a mapping file and its DBC. Raises `InvalidSetting` naming file, line, value and rule."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidSetting(f"mapping {path} cannot be read ({error}): give a TOML file in UTF-8") from error
    return parse_mapping(text, path)


def parse_mapping(text: str, path: Path | None = None) -> CanMapping:
    """Read a mapping from its text; path: where it is from, for errors and for the DBC beside it."""
    name = str(path) if path else "mapping"
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InvalidSetting(f"{name} is no TOML ({error}): correct it there") from error
    return _Reader(data, lines_of(text), name, path).mapping()


def standard_mapping(sensors: Sequence[str], planes: Sequence[str] = (), *, j1939: bool = False) -> CanMapping:
    """Map Drumtrue's own balancer.dbc: its Sensor1, 2 ... are `sensors`, its Correction1, 2 ... the `planes`."""
    return parse_mapping(standard_mapping_text(sensors, planes, j1939=j1939))


def standard_mapping_text(sensors: Sequence[str], planes: Sequence[str] = (), *, j1939: bool = False) -> str:
    """Write that mapping as TOML: a file to start one's own from."""
    mark = "J1939" if j1939 else ""
    lines = ['counter = "Counter"', "", "[speed]", f'message = "{mark}Speed"', 'signal = "Speed"']
    lines += ['valid = "SpeedValid"', "", "[heartbeat]", f'message = "{mark}Heartbeat"', ""]
    lines += ["[status]", f'message = "{mark}Status"', 'signal = "State"']
    for index, sensor in enumerate(sensors, 1):
        lines += ["", "[[sensor]]", f"name = {_quoted(sensor)}"]
        for key, signal, valid in (
            ("amplitude", "Amplitude", "AmplitudeValid"),
            ("phase", "Phase", "PhaseValid"),
            ("overall", "OverallRms", "OverallValid"),
        ):
            lines.append(f'{key} = {{message = "{mark}Sensor{index}", signal = "{signal}", valid = "{valid}"}}')
    for index, plane in enumerate(planes, 1):
        lines += ["", "[[correction]]", f"plane = {_quoted(plane)}"]
        for key, signal in (("mass", "Mass"), ("angle", "Angle"), ("number", "AnswerNumber")):
            valid = ', valid = "MassValid"' if key == "mass" else ""
            lines.append(f'{key} = {{message = "{mark}Correction{index}", signal = "{signal}"{valid}}}')
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


@cache
def own_database() -> Database:
    """Drumtrue's own balancer.dbc."""
    text = files("drivers").joinpath("balancer.dbc").read_text(encoding="utf-8")
    database = cantools.database.load_string(text, "dbc")
    assert isinstance(database, Database)  # noqa: S101
    return database


class _Reader:
    """One mapping being read."""

    def __init__(self, data: dict[str, Any], lines: dict[Where, int], name: str, path: Path | None) -> None:
        self._data, self._lines, self._name, self._path = data, lines, name, path
        self._database = own_database()

    def mapping(self) -> CanMapping:
        self._only(self._data, _TOP, ("", 0, ""))
        self._database = self._load()
        phase_sense = self._choice(self._data, "phase_sense", PHASE_SENSES, ("", 0, ""))
        angle_sense = self._choice(self._data, "angle_sense", ANGLE_SENSES, ("", 0, ""))
        sensors = tuple(self._sensor(t, i, phase_sense) for i, t in enumerate(self._tables("sensor")))
        if not sensors:
            raise self._wrong(("", 0, ""), "has no [[sensor]]: map one sensor or more")
        planes = tuple(self._plane(t, i, angle_sense) for i, t in enumerate(self._tables("correction")))
        for table, names in (("sensor", [s.name for s in sensors]), ("correction", [p.plane for p in planes])):
            for index, name in enumerate(names):
                if name in names[:index]:
                    raise self._wrong((table, index, "name"), f"maps {name!r} twice: map it once")
        heart, status = self._data.get("heartbeat"), self._data.get("status")
        mapping = CanMapping(
            database=self._database,
            sensors=sensors,
            speed=self._speed(),
            corrections=planes,
            counter=self._text(self._data, "counter", ("", 0, ""), None),
            node=self._node(),
            max_age_s=self._number(self._data, "max_age_s", ("", 0, ""), 1.0),
            heartbeat=None if heart is None else self._heartbeat(heart),
            heartbeat_timeout_s=3.0 if heart is None else self._number(heart, "timeout_s", ("heartbeat", 0, ""), 3.0),
            status=None if status is None else self._field(status, ("status", 0, ""), {}, 1.0),
            path=self._path,
        )
        self._check_counter(mapping)
        return mapping

    # ------------------------------------------------------------ parts of the file
    def _load(self) -> Database:
        stated = self._text(self._data, "dbc", ("", 0, ""), None)
        if stated is None:
            return own_database()
        path = (self._path.parent if self._path else Path()) / stated
        try:
            database = cantools.database.load_file(path, "dbc", encoding="utf-8")
        except (OSError, UnicodeDecodeError, cantools.Error) as error:
            raise self._wrong(("", 0, "dbc"), f"names {path}, which is no DBC that can be read ({error})") from error
        assert isinstance(database, Database)  # noqa: S101
        return database

    def _speed(self) -> Field | None:
        table = self._data.get("speed")
        return None if table is None else self._field(table, ("speed", 0, ""), PER_RPM, 1.0)

    def _heartbeat(self, table: Any) -> str:
        where = ("heartbeat", 0, "")
        self._only(table, {"message", "timeout_s"}, where)
        return self._message(table, where).name

    def _node(self) -> int | None:
        node = self._data.get("node")
        if node is not None and (isinstance(node, bool) or not isinstance(node, int) or not 0 <= node <= 253):
            raise self._wrong(("", 0, "node"), f"states node {node!r}: a J1939 source address is 0 to 253")
        return node

    def _sensor(self, table: Any, index: int, machine_sense: str) -> SensorMap:
        where = ("sensor", index, "")
        self._only(table, {"name", "unit", "detection", "amplitude", "phase", "overall"}, where)
        units = {unit: factor for factors in PER_UNIT.values() for unit, factor in factors.items()}
        amplitude = table.get("amplitude")
        if amplitude is None:
            raise self._wrong(where, "has no amplitude: every sensor needs one")
        own_unit = self._choice(table, "unit", tuple(units), where, default="")
        own_detection = self._choice(table, "detection", tuple(PER_PEAK), where, default="rms")
        return SensorMap(
            name=self._name_of(table, "name", where),
            amplitude=self._level(table, "amplitude", where, own_unit, own_detection),
            phase=None
            if "phase" not in table
            else self._angle(table["phase"], ("sensor", index, "phase"), PHASE_SENSES, machine_sense),
            overall=None if "overall" not in table else self._level(table, "overall", where, own_unit, "rms"),
        )

    def _level(self, table: Any, key: str, where: Where, own_unit: str, own_detection: str) -> Field:
        """An amplitude or overall value: its unit and detection turned into those of the machine's sensor."""
        here = (where[0], where[1], key)
        detection = self._choice(table[key], "detection", tuple(PER_PEAK), here, default="rms")
        unit = self._unit(table[key], here, [u for units in PER_UNIT.values() for u in units])
        wanted = own_unit or unit
        family = next(units for units in PER_UNIT.values() if unit in units)
        if wanted not in family:
            raise self._wrong(here, f"is in {unit}, the sensor in {wanted}: these are different quantities")
        factor = family[unit] / family[wanted] * PER_PEAK[own_detection] / PER_PEAK[detection]
        return self._field(table[key], here, {unit: 1.0}, factor, also={"detection"})

    def _angle(self, table: Any, where: Where, senses: tuple[str, ...], machine_sense: str) -> Field:
        sense = self._choice(table, "sense", senses, where, default=machine_sense)
        return self._field(table, where, PER_DEGREE, 1.0 if sense == machine_sense else -1.0, also={"sense"})

    def _plane(self, table: Any, index: int, machine_sense: str) -> PlaneMap:
        where = ("correction", index, "")
        self._only(table, {"plane", "mass", "angle", "number"}, where)
        for key in ("mass", "angle", "number"):
            if key not in table:
                raise self._wrong(where, f"has no {key}: a correction needs mass, angle and number")
        return PlaneMap(
            plane=self._name_of(table, "plane", where),
            mass=self._field(table["mass"], ("correction", index, "mass"), PER_GRAM, 1.0),
            angle=self._angle(table["angle"], ("correction", index, "angle"), ANGLE_SENSES, machine_sense),
            number=self._field(table["number"], ("correction", index, "number"), {}, 1.0),
        )

    # ------------------------------------------------------------ one signal
    def _field(
        self, table: Any, where: Where, units: dict[str, float], factor: float, *, also: Iterable[str] = ()
    ) -> Field:
        """A mapped signal, checked against the DBC; units: what its unit may be, with factors; {}: it has none."""
        self._only(table, {"message", "signal", "unit", "valid", *also}, where)
        message = self._message(table, where)
        signal = self._signal(message, self._text(table, "signal", where), where)
        valid = self._text(table, "valid", where, None)
        if valid is not None:
            self._signal(message, valid, where)
        if units:
            factor *= units[self._unit(table, where, units)]
        return Field(message.name, signal.name, factor, valid)

    def _message(self, table: Any, where: Where) -> Message:
        name = self._text(table, "message", where)
        for message in self._database.messages:
            if message.name == name:
                return message
        known = ", ".join(sorted(m.name for m in self._database.messages)[:20])
        raise self._wrong(where, f"names message {name!r}, which the DBC has not: use one of {known}", "message")

    def _signal(self, message: Message, name: str, where: Where) -> Signal:
        for signal in message.signals:
            if signal.name == name:
                return signal
        known = ", ".join(sorted(s.name for s in message.signals))
        raise self._wrong(
            where, f"names signal {name!r}, which message {message.name} has not: use one of {known}", "signal"
        )

    def _unit(self, table: Any, where: Where, units: Iterable[str]) -> str:
        """The stated unit, which must be the DBC's where that has one."""
        signal = self._signal(self._message(table, where), self._text(table, "signal", where), where)
        stated = self._text(table, "unit", where, None)
        in_dbc = (signal.unit or "").strip()
        unit = stated or in_dbc
        known = sorted(units)
        if not unit:
            raise self._wrong(where, f"has no unit, nor has the DBC for {signal.name}: state one of {', '.join(known)}")
        if unit not in known:
            raise self._wrong(where, f"is in {unit!r}: use one of {', '.join(known)}", "unit")
        if stated and in_dbc in known and in_dbc != stated:
            raise self._wrong(where, f"states {stated}, the DBC says {in_dbc} for {signal.name}: correct one", "unit")
        return unit

    def _check_counter(self, mapping: CanMapping) -> None:
        if mapping.counter is None:
            return
        if not any(_has(m, mapping.counter) for m in mapping.messages()):
            raise self._wrong(
                ("", 0, "counter"), f"names {mapping.counter!r}, which is in no mapped message: leave it out"
            )

    # ------------------------------------------------------------ values of TOML
    def _tables(self, name: str) -> list[Any]:
        value = self._data.get(name, [])
        if not isinstance(value, list):
            raise self._wrong((name, 0, ""), f"is [{name}]: write [[{name}]], one for each")
        return value

    def _only(self, table: Any, known: Iterable[str], where: Where) -> None:
        if not isinstance(table, dict):
            raise self._wrong(where, f"is {table!r}: write a table")
        for key in table:
            if key not in known:
                raise self._wrong(where, f"has the unknown key {key!r}: use {', '.join(sorted(known))}", key)

    def _text(self, table: Any, key: str, where: Where, *default: None) -> Any:
        value = table.get(key) if isinstance(table, dict) else None
        if value is None and default:
            return None
        if not isinstance(value, str) or not value:
            raise self._wrong(where, f"has {key} {value!r}: state a text", key)
        return value

    def _name_of(self, table: Any, key: str, where: Where) -> str:
        name = self._text(table, key, where)
        if len(name) > 100:
            raise self._wrong(where, f"has a {key} of {len(name)} characters: 100 are the most", key)
        return str(name)

    def _number(self, table: Any, key: str, where: Where, default: float) -> float:
        value = table.get(key, default) if isinstance(table, dict) else default
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < 1e6:
            raise self._wrong(where, f"has {key} {value!r}: state a number above 0", key)
        return float(value)

    def _choice(self, table: Any, key: str, known: tuple[str, ...], where: Where, default: str | None = None) -> str:
        value = table.get(key, known[0] if default is None else default) if isinstance(table, dict) else None
        if value not in known and not (value == "" and key not in table):
            raise self._wrong(where, f"has {key} {value!r}: use one of {', '.join(known)}", key)
        return str(value)

    def _wrong(self, where: Where, what: str, key: str = "") -> InvalidSetting:
        table, index, own_key = where
        places = [(table, index, own_key or key), (table, index, own_key), (table, index, ""), (key, 0, "")]
        line = next((self._lines[place] for place in places if place in self._lines), None)
        label = " ".join(part for part in (f"[{table}]" if table else "", own_key) if part)
        return InvalidSetting(f"{self._name}{f', line {line}' if line else ''}: {label + ' ' if label else ''}{what}")


def _has(message: Message, signal: str) -> bool:
    return any(one.name == signal for one in message.signals)
