"""Reading a design document strictly: every problem of it is found, with its path, and nothing is guessed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from service.design.findings import Finding, RefusedDesign
from service.design.units import PURE, UNITS
from service.messages import Message

NAN = math.nan
LARGEST = 1e100
"""No quantity of a machine is larger, in any unit; what is would overflow in products."""


@dataclass(frozen=True)
class Asked:
    """A field that reading asked for: its quantity, and what it may be where that is a choice."""

    quantity: str = PURE
    choices: tuple[str, ...] = ()


@dataclass
class Problems:
    """What reading has found so far, the units of the document, and the fields that were asked for by path."""

    units: Mapping[str, str] = field(default_factory=dict)
    found: list[Finding] = field(default_factory=list)
    asked: dict[str, Asked] = field(default_factory=dict)

    def add(self, message: Message) -> None:
        """Note a refusal."""
        self.found.append(Finding(message))

    def factor(self, quantity: str, field: str) -> float:
        """Factor to SI of a quantity in the document's units; NaN, noted, where the unit is not stated."""
        if quantity == PURE:
            return 1.0
        unit = self.units.get(quantity)
        if unit is None:
            self.add(Message("design_unit_missing", field=field, quantity=quantity, known=listed(UNITS[quantity])))
            return NAN
        return UNITS[quantity].get(unit, NAN)

    def raise_any(self) -> None:
        """Raise RefusedDesign if anything was refused."""
        if refused(self):
            raise RefusedDesign(one for one in self.found if one.severity == "refusal")


class Table:
    """A table of the document; each field is asked for by name and kind, `close` refuses those that never were."""

    def __init__(self, values: Mapping[str, Any], path: str, problems: Problems) -> None:
        self.values, self.path, self.problems = values, path, problems
        self._asked: set[str] = set()

    def __contains__(self, name: str) -> bool:
        """Whether the field is stated."""
        return name in self.values

    def at(self, name: str) -> str:
        """Path of a field."""
        return f"{self.path}.{name}" if self.path else name

    def number(
        self,
        name: str,
        quantity: str = PURE,
        *,
        default: float | None = None,
        above: float | None = None,
        least: float | None = None,
        below: float | None = None,
        most: float | None = None,
    ) -> float:
        """A number in SI; limits: in the document's unit. default: in SI."""
        if not self._stated(name, default is not None, Asked(quantity)):
            return NAN if default is None else default
        value = self._number(self.values[name], self.at(name))
        if not math.isnan(value):
            self._within(value, self.at(name), above, least, below, most)
        return value * self.problems.factor(quantity, self.at(name))

    def whole(self, name: str, *, default: int | None = None, least: int, most: int) -> int:
        """A whole number from least to most."""
        if not self._stated(name, default is not None):
            return least if default is None else default
        value = self.values[name]
        if isinstance(value, bool) or not isinstance(value, int):
            self.problems.add(Message("design_not_whole", field=self.at(name), value=told(value)))
            return least
        self._within(float(max(min(value, LARGEST), -LARGEST)), self.at(name), None, least, None, most)
        return value

    def text(self, name: str, *, default: str | None = None, choices: Iterable[str] = ()) -> str:
        """A text, one of the choices if there are any."""
        known = tuple(choices)
        if not self._stated(name, default is not None, Asked(choices=known)):
            return default or ""
        value = self.values[name]
        if not isinstance(value, str):
            self.problems.add(Message("design_not_text", field=self.at(name), value=told(value)))
            return known[0] if known else ""
        if known and value not in known:
            self.problems.add(Message("design_not_a_choice", field=self.at(name), value=value, known=listed(known)))
            return known[0]
        return value

    def flag(self, name: str, *, default: bool) -> bool:
        """True or false."""
        if not self._stated(name, optional=True):
            return default
        value = self.values[name]
        if not isinstance(value, bool):
            self.problems.add(Message("design_not_a_flag", field=self.at(name), value=told(value)))
            return default
        return value

    def numbers(
        self,
        name: str,
        quantity: str = PURE,
        *,
        count: int | None = None,
        default: tuple[float, ...] | None = None,
        most: int = 100,
    ) -> tuple[float, ...]:
        """A list of numbers in SI. count: how many it must hold; default: in SI."""
        if not self._stated(name, default is not None, Asked(quantity)):
            return default if default is not None else (NAN,) * (count or 1)
        values = self.values[name]
        if not isinstance(values, list) or (count is not None and len(values) != count) or len(values) > most:
            wanted = count if count is not None else most
            self.problems.add(
                Message(
                    "design_not_a_list" if count is not None else "design_not_a_list.at_most",
                    field=self.at(name),
                    value=told(values),
                    count=wanted,
                )
            )
            return (NAN,) * (count or 1)
        factor = self.problems.factor(quantity, self.at(name))
        return tuple(self._number(one, f"{self.at(name)}[{i}]") * factor for i, one in enumerate(values))

    def texts(self, name: str, *, count: int, optional: bool = False) -> tuple[str, ...]:
        """A list of texts; count: how many it must hold. Empty where it may be left out and is."""
        if not self._stated(name, optional):
            return () if optional else ("",) * count
        values = self.values[name]
        if isinstance(values, list) and len(values) == count and all(isinstance(one, str) for one in values):
            return tuple(values)
        self.problems.add(Message("design_not_names", field=self.at(name), value=told(values), count=count))
        return ("",) * count

    def bounds(
        self, name: str, quantity: str = PURE, default: tuple[float, float] | None = None
    ) -> tuple[float, float]:
        """Two numbers, the lower first. default: in SI."""
        lower, upper = self.numbers(name, quantity, count=2, default=default)
        if lower > upper:
            one, other = self.values[name]
            self.problems.add(Message("design_bounds_crossed", field=self.at(name), lower=one, upper=other))
        return lower, upper

    def table(self, name: str, *, optional: bool = False) -> Table | None:
        """A table within this one; None where it is not stated or is none."""
        if not self._stated(name, optional):
            return None
        value = self.values[name]
        if not isinstance(value, Mapping):
            self.problems.add(Message("design_not_a_table", field=self.at(name), value=told(value)))
            return None
        return Table(value, self.at(name), self.problems)

    def tables(self, name: str, *, least: int = 0, most: int) -> list[Table]:
        """A list of tables."""
        if not self._stated(name, least == 0):
            return []
        values = self.values[name]
        if not isinstance(values, list) or not all(isinstance(one, Mapping) for one in values):
            self.problems.add(Message("design_not_a_table", field=self.at(name), value=told(values)))
            return []
        if not least <= len(values) <= most:
            self.problems.add(
                Message("design_count_out_of_range", field=self.at(name), value=len(values), least=least, most=most)
            )
            return []
        return [Table(one, f"{self.at(name)}[{i}]", self.problems) for i, one in enumerate(values)]

    def pick(self, name: str, known: Iterable[str]) -> str:
        """A name that must be among the known ones."""
        value, names = self.text(name), tuple(known)
        if value not in names:
            if value:
                self.problems.add(Message("design_name_unknown", field=self.at(name), value=value, known=listed(names)))
            return names[0] if names else ""
        return value

    def ask(self, name: str) -> object:
        """A field as it is stated, for the caller to check; None, noted, where it is not."""
        return self.values[name] if self._stated(name, optional=False) else None

    def close(self) -> None:
        """Refuse fields that no one asked for."""
        for name in self.values:
            if name not in self._asked:
                self.problems.add(
                    Message("design_field_unknown", field=self.at(str(name)), known=listed(sorted(self._asked)))
                )

    def _stated(self, name: str, optional: bool, asked: Asked | None = None) -> bool:
        self._asked.add(name)
        if asked is not None:
            self.problems.asked[self.at(name)] = asked
        if name in self.values:
            return True
        if not optional:
            self.problems.add(Message("design_field_missing", field=self.at(name)))
        return False

    def _number(self, value: object, path: str) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.problems.add(Message("design_not_a_number", field=path, value=told(value)))
            return NAN
        if abs(value) > LARGEST or not math.isfinite(value):
            self.problems.add(Message("design_not_finite", field=path, value=told(value)))
            return NAN
        return float(value)

    def _within(
        self,
        value: float,
        path: str,
        above: float | None,
        least: float | None,
        below: float | None,
        most: float | None,
    ) -> None:
        if above is not None and not value > above:
            self.problems.add(Message("design_out_of_range.above", field=path, value=value, bound=above))
        elif least is not None and not value >= least:
            self.problems.add(Message("design_out_of_range.at_least", field=path, value=value, bound=least))
        elif below is not None and not value < below:
            self.problems.add(Message("design_out_of_range.below", field=path, value=value, bound=below))
        elif most is not None and not value <= most:
            self.problems.add(Message("design_out_of_range.at_most", field=path, value=value, bound=most))


def read_units(root: Table) -> None:
    """Take the document's table of units into its problems' units."""
    table = root.table("units", optional=True)
    if table is None:
        return
    stated: dict[str, str] = {}
    for quantity in UNITS:
        if quantity in table:
            stated[quantity] = table.text(quantity, choices=UNITS[quantity])
    table.close()
    root.problems.units = stated


def refused(problems: Problems) -> bool:
    """Whether anything was refused so far."""
    return any(one.severity == "refusal" for one in problems.found)


def listed(names: Iterable[str]) -> str:
    """Names with commas between."""
    return ", ".join(names) or "none"


def told(value: object) -> str:
    """A value as a message shows it, cut short."""
    text = "true" if value is True else "false" if value is False else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
