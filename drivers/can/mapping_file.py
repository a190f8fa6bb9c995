"""Reading a mapping file: TOML to `CanMapping`, every error with the line it is on."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import cantools
from cantools.database.can import Database

from drivers.can.dbc import BrokenDatabase, check_messages, load_dbc
from drivers.can.mapped_signals import LEVELS, MappedSignals
from drivers.can.mapping import ANGLE_SENSES, PHASE_SENSES, CanMapping, Field, PlaneMap, SensorMap
from drivers.can.toml_values import TomlValues
from drivers.errors import InvalidSetting
from drivers.files.toml_lines import Where, lines_of, quoted
from drivers.quantities import PER_PEAK
from drivers.units import PER_GRAM, PER_RPM, level_of

ANY = "any"
_FILE: Where = ("", 0, "")
_TOP = frozenset(
    {"dbc", "counter", "node", "node_name", "max_age_s", "phase_sense", "angle_sense"}
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
    return _Reader(TomlValues(data, lines_of(text), name), path).mapping()


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
        lines += ["", "[[sensor]]", f"name = {quoted(sensor)}"]
        for key, signal, valid in (
            ("amplitude", "Amplitude", "AmplitudeValid"),
            ("phase", "Phase", "PhaseValid"),
            ("overall", "OverallRms", "OverallValid"),
        ):
            lines.append(f'{key} = {{message = "{mark}Sensor{index}", signal = "{signal}", valid = "{valid}"}}')
    for index, plane in enumerate(planes, 1):
        lines += ["", "[[correction]]", f"plane = {quoted(plane)}"]
        for key, signal in (("mass", "Mass"), ("angle", "Angle"), ("number", "AnswerNumber")):
            valid = ', valid = "MassValid"' if key == "mass" else ""
            lines.append(f'{key} = {{message = "{mark}Correction{index}", signal = "{signal}"{valid}}}')
    return "\n".join(lines) + "\n"


@cache
def own_database() -> Database:
    """Drumtrue's own balancer.dbc."""
    text = files("drivers").joinpath("balancer.dbc").read_text(encoding="utf-8")
    database = cantools.database.load_string(text, "dbc")
    assert isinstance(database, Database)  # noqa: S101
    return database


class _Reader:
    """One mapping being read."""

    def __init__(self, toml: TomlValues, path: Path | None) -> None:
        self._toml, self._path = toml, path
        toml.only(toml.data, _TOP, _FILE)
        self._database = self._load()
        self._signals = MappedSignals(toml, self._database)

    def mapping(self) -> CanMapping:
        """All of it."""
        toml, data = self._toml, self._toml.data
        phase_sense = toml.choice(data, "phase_sense", PHASE_SENSES, _FILE)
        angle_sense = toml.choice(data, "angle_sense", ANGLE_SENSES, _FILE)
        sensors = tuple(self._sensor(t, i, phase_sense) for i, t in enumerate(toml.tables("sensor")))
        if not sensors:
            raise toml.wrong(_FILE, "has no [[sensor]]: map one sensor or more")
        planes = tuple(self._plane(t, i, angle_sense) for i, t in enumerate(toml.tables("correction")))
        for table, names in (("sensor", [s.name for s in sensors]), ("correction", [p.plane for p in planes])):
            for index, name in enumerate(names):
                if name in names[:index]:
                    raise toml.wrong((table, index, "name"), f"maps {name!r} twice: map it once")
        heart, status = data.get("heartbeat"), data.get("status")
        mapping = CanMapping(
            database=self._database,
            sensors=sensors,
            speed=self._speed(),
            corrections=planes,
            counter=toml.text(data, "counter", _FILE, None),
            node=self._node(),
            max_age_s=toml.number(data, "max_age_s", _FILE, 1.0),
            heartbeat=None if heart is None else self._heartbeat(heart),
            heartbeat_timeout_s=3.0 if heart is None else toml.number(heart, "timeout_s", ("heartbeat", 0, ""), 3.0),
            status=None if status is None else self._signals.plain(status, ("status", 0, "")),
            path=self._path,
            any_node=data.get("node") == ANY,
            node_name=self._node_name(),
        )
        self._check(mapping)
        return mapping

    def _load(self) -> Database:
        stated = self._toml.text(self._toml.data, "dbc", _FILE, None)
        if stated is None:
            return own_database()
        path = (self._path.parent if self._path else Path()) / stated
        try:
            return load_dbc(path)
        except (OSError, BrokenDatabase) as error:
            raise self._unreadable(path, error) from error

    def _unreadable(self, path: Path | str, error: Exception) -> InvalidSetting:
        return self._toml.wrong(("", 0, "dbc"), f"names {path}, which is no DBC that can be read ({error})")

    def _speed(self) -> Field | None:
        table = self._toml.data.get("speed")
        return None if table is None else self._signals.quantity(table, ("speed", 0, ""), PER_RPM, "speed")

    def _heartbeat(self, table: Any) -> str:
        where = ("heartbeat", 0, "")
        self._toml.only(table, {"message", "timeout_s"}, where)
        return self._signals.message(table, where).name

    def _node(self) -> int | None:
        node = self._toml.data.get("node")
        if node is None or node == ANY:
            return None
        if isinstance(node, bool) or not isinstance(node, int) or not 0 <= node <= 253:
            raise self._toml.wrong(
                ("", 0, "node"), f"states node {node!r}: a J1939 source address is 0 to 253, or {ANY!r}"
            )
        return node

    def _node_name(self) -> int | None:
        name = self._toml.data.get("node_name")
        if name is not None and (isinstance(name, bool) or not isinstance(name, int) or not 0 <= name < 2**64):
            raise self._toml.wrong(("", 0, "node_name"), f"states node_name {name!r}: a J1939 name has 64 bits")
        return name

    def _sensor(self, table: Any, index: int, machine_sense: str) -> SensorMap:
        where = ("sensor", index, "")
        toml, signals = self._toml, self._signals
        toml.only(table, {"name", "unit", "detection", "amplitude", "phase", "overall"}, where)
        if table.get("amplitude") is None:
            raise toml.wrong(where, "has no amplitude: every sensor needs one")
        stated = toml.text(table, "unit", where, None)
        own_unit = level_of(stated)[0] if stated else ""
        if own_unit is None:
            raise toml.wrong(where, f"has unit {stated!r}: use one of {', '.join(LEVELS)}", "unit")
        own_detection = toml.choice(table, "detection", tuple(PER_PEAK), where, default="rms")
        return SensorMap(
            name=toml.name_of(table, "name", where),
            amplitude=signals.level(table, "amplitude", where, own_unit, own_detection),
            phase=None
            if "phase" not in table
            else signals.angle(table["phase"], ("sensor", index, "phase"), PHASE_SENSES, machine_sense),
            overall=None if "overall" not in table else signals.level(table, "overall", where, own_unit, "rms"),
            unit=own_unit or signals.level_unit(table, "amplitude", where),
        )

    def _plane(self, table: Any, index: int, machine_sense: str) -> PlaneMap:
        where = ("correction", index, "")
        toml, signals = self._toml, self._signals
        toml.only(table, {"plane", "mass", "angle", "number"}, where)
        for key in ("mass", "angle", "number"):
            if key not in table:
                raise toml.wrong(where, f"has no {key}: a correction needs mass, angle and number")
        return PlaneMap(
            plane=toml.name_of(table, "plane", where),
            mass=signals.quantity(table["mass"], ("correction", index, "mass"), PER_GRAM, "mass"),
            angle=signals.angle(table["angle"], ("correction", index, "angle"), ANGLE_SENSES, machine_sense),
            number=signals.plain(table["number"], ("correction", index, "number")),
        )

    def _check(self, mapping: CanMapping) -> None:
        """The counter is in a mapped message, and no mapped message is broken."""
        messages = mapping.messages()
        counter = mapping.counter
        if counter is not None and not any(one.name == counter for m in messages for one in m.signals):
            raise self._toml.wrong(
                ("", 0, "counter"), f"names {counter!r}, which is in no mapped message: leave it out"
            )
        try:
            check_messages(messages)
        except BrokenDatabase as error:
            raise self._unreadable(str(self._toml.data.get("dbc")), error) from error
