"""One signal of a mapping file as a field of a reading: its place in the DBC, unit, sense, validity and range."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from cantools.database.can import Database, Message, Signal

from drivers.can.mapping import Field, Validity
from drivers.can.toml_values import TomlValues
from drivers.files.toml_lines import Where
from drivers.quantities import PER_PEAK, PER_UNIT
from drivers.units import PER_DEGREE, level_of, unit_of

KEYS = frozenset(("message", "signal", "unit", "valid", "not_available", "min", "max"))
LEVELS = {unit: family for family in PER_UNIT.values() for unit in family}
"""The units of each level's quantity, by unit."""


class MappedSignals:
    """The signals of one DBC as the tables of a mapping file name them. All raise `InvalidSetting` with the line."""

    def __init__(self, toml: TomlValues, database: Database) -> None:
        self._toml, self._database = toml, database

    def level(self, table: Any, key: str, where: Where, own_unit: str, own_detection: str) -> Field:
        """An amplitude or overall value: its unit and detection turned into those of the machine's sensor."""
        here = (where[0], where[1], key)
        value = table[key]
        stated, in_dbc, signal = self._units(value, here)
        unit, _ = self._known(value, here, stated or in_dbc, signal, dict.fromkeys(LEVELS, 1.0), "level")
        dbc_unit, dbc_detection = level_of(in_dbc)
        if stated and dbc_unit is not None and dbc_unit != unit:
            raise self._contradicts(here, stated, in_dbc, signal)
        detection = self._detection(value, here, level_of(stated)[1], dbc_detection)
        wanted = own_unit or unit
        family = LEVELS[unit]
        if wanted not in family:
            raise self._toml.wrong(here, f"is in {unit}, the sensor in {wanted}: these are different quantities")
        factor = family[unit] / family[wanted] * PER_PEAK[own_detection] / PER_PEAK[detection]
        return self._field(value, here, factor, also={"detection"})

    def level_unit(self, table: Any, key: str, where: Where) -> str:
        """The unit that an amplitude or overall value has on the bus."""
        here = (where[0], where[1], key)
        stated, in_dbc, signal = self._units(table[key], here)
        return self._known(table[key], here, stated or in_dbc, signal, dict.fromkeys(LEVELS, 1.0), "level")[0]

    def angle(self, table: Any, where: Where, senses: tuple[str, ...], machine_sense: str) -> Field:
        """A phase or an angle, in degrees in the machine's sense."""
        sense = self._toml.choice(table, "sense", senses, where, default=machine_sense)
        sign = 1.0 if sense == machine_sense else -1.0
        return self._field(table, where, sign * self._factor(table, where, PER_DEGREE, "angle"), also={"sense"})

    def quantity(self, table: Any, where: Where, units: Mapping[str, float], quantity: str) -> Field:
        """A signal in any of these units of a quantity."""
        return self._field(table, where, self._factor(table, where, units, quantity))

    def plain(self, table: Any, where: Where) -> Field:
        """A signal without a unit."""
        return self._field(table, where, 1.0)

    def message(self, table: Any, where: Where) -> Message:
        """The message that a table names."""
        name = self._toml.text(table, "message", where)
        for message in self._database.messages:
            if message.name == name:
                return message
        known = ", ".join(sorted(m.name for m in self._database.messages)[:20])
        raise self._toml.wrong(where, f"names message {name!r}, which the DBC has not: use one of {known}", "message")

    # ------------------------------------------------------------ parts of a field
    def _field(self, table: Any, where: Where, factor: float, *, also: Iterable[str] = ()) -> Field:
        self._toml.only(table, KEYS | set(also), where)
        message = self.message(table, where)
        signal = self._signal(message, self._toml.text(table, "signal", where), where)
        low, high = (self._limit(table, key, where) for key in ("min", "max"))
        if low is not None and high is not None and low > high:
            raise self._toml.wrong(where, f"has min {low} above max {high}: correct one", "min")
        return Field(
            message=message.name,
            signal=signal.name,
            factor=factor,
            valid=self._valid(table, message, where),
            not_available=self._whole_numbers(table, "not_available", where),
            low=low,
            high=high,
        )

    def _signal(self, message: Message, name: str, where: Where) -> Signal:
        for signal in message.signals:
            if signal.name == name:
                return signal
        known = ", ".join(sorted(s.name for s in message.signals))
        raise self._toml.wrong(
            where, f"names signal {name!r}, which message {message.name} has not: use one of {known}", "signal"
        )

    def _factor(self, table: Any, where: Where, units: Mapping[str, float], quantity: str) -> float:
        stated, in_dbc, signal = self._units(table, where)
        unit, factor = self._known(table, where, stated or in_dbc, signal, units, quantity)
        if stated and unit_of(in_dbc, quantity) not in (None, unit):
            raise self._contradicts(where, stated, in_dbc, signal)
        return factor

    def _units(self, table: Any, where: Where) -> tuple[str, str, Signal]:
        """The unit that the mapping states, that of the DBC, each "" if there is none, and the signal."""
        signal = self._signal(self.message(table, where), self._toml.text(table, "signal", where), where)
        return self._toml.text(table, "unit", where, None) or "", (signal.unit or "").strip(), signal

    def _known(
        self, table: Any, where: Where, text: str, signal: Signal, units: Mapping[str, float], quantity: str
    ) -> tuple[str, float]:
        known = ", ".join(sorted(units))
        if not text:
            raise self._toml.wrong(where, f"has no unit, nor has the DBC for {signal.name}: state one of {known}")
        unit = level_of(text)[0] if quantity == "level" else unit_of(text, quantity)
        if unit is None or unit not in units:
            where_from = "" if table.get("unit") else f" by the DBC; state it here, as unit = {next(iter(units))!r}"
            raise self._toml.wrong(where, f"is in {text!r}{where_from}: use one of {known}", "unit")
        return unit, units[unit]

    def _contradicts(self, where: Where, stated: str, in_dbc: str, signal: Signal) -> Exception:
        return self._toml.wrong(where, f"states {stated}, the DBC says {in_dbc} for {signal.name}: correct one", "unit")

    def _detection(self, table: Any, where: Where, in_unit: str | None, in_dbc: str | None) -> str:
        """As stated, else as it is written with the unit, else rms."""
        stated = self._toml.choice(table, "detection", tuple(PER_PEAK), where, default="") or in_unit or ""
        if stated and in_dbc and stated != in_dbc:
            raise self._toml.wrong(
                where, f"states {stated}, the unit in the DBC says {in_dbc}: correct one", "detection"
            )
        return stated or in_dbc or "rms"

    def _limit(self, table: Any, key: str, where: Where) -> float | None:
        value = table.get(key)
        if value is not None and (isinstance(value, bool) or not isinstance(value, int | float) or value != value):
            raise self._toml.wrong(where, f"has {key} {value!r}: state a number", key)
        return None if value is None else float(value)

    def _whole_numbers(self, table: Any, key: str, where: Where) -> frozenset[int] | None:
        value = table.get(key)
        if value is None:
            return None
        found = value if isinstance(value, list) else [value]
        if not all(isinstance(one, int) and not isinstance(one, bool) for one in found):
            raise self._toml.wrong(where, f"has {key} {value!r}: state the raw value, or several in brackets", key)
        return frozenset(found)

    # ------------------------------------------------------------ validity
    def _valid(self, table: Any, message: Message, where: Where) -> Validity | None:
        stated = table.get("valid")
        if not isinstance(stated, dict):
            name = self._toml.text(table, "valid", where, None)
            return None if name is None else Validity(self._signal(message, name, where).name)
        self._toml.only(stated, {"signal", "equals", "not", "bits"}, where)
        signal = self._signal(message, self._toml.text(stated, "signal", where), where)
        if ("equals" in stated) == ("not" in stated) and ("equals" in stated or "bits" not in stated):
            raise self._toml.wrong(where, "has valid without or with both of equals and not: state one", "valid")
        bits = stated.get("bits")
        if bits is not None and (isinstance(bits, bool) or not isinstance(bits, int) or bits <= 0):
            raise self._toml.wrong(where, f"has valid with bits {bits!r}: state a mask, such as 0x0C", "valid")
        key = "not" if "not" in stated else "equals"
        values = stated.get(key, bits)
        raws = (self._raw(signal, one, where) for one in (values if isinstance(values, list) else [values]))
        return Validity(signal.name, frozenset(raws), key == "not", bits)

    def _raw(self, signal: Signal, value: Any, where: Where) -> int:
        """A raw value, stated as a number or by its name in the DBC's value table."""
        if isinstance(value, int):
            return int(value)
        for raw, name in (signal.choices or {}).items():
            if str(name) == value:
                return int(raw)
        known = ", ".join(f"{name!r}" for name in (signal.choices or {}).values()) or "none"
        raise self._toml.wrong(
            where, f"has valid with {value!r}: state a raw value, or a name of {signal.name}'s table ({known})", "valid"
        )
