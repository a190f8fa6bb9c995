"""Stored numbers as text, in the reader's language and units."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from markupsafe import Markup

from service.messages import Reader
from service.model.machine import Sensor
from service.web import numbers, units
from service.web.language import N_, translations
from service.web.numbers import NO_BREAK
from service.web.preferences import Preferences

_VELOCITY = Sensor(name="velocity")
"""Stands for a limit that holds for every sensor: mm/s rms."""


@dataclass(frozen=True)
class Display(Reader):
    """How numbers are shown to a reader, in messages too; every text carries its unit."""

    preferences: Preferences

    gap = NO_BREAK

    @property
    def language(self) -> str:
        """The reader's language."""
        return self.preferences.language

    def in_unit(self, value: float, unit: str) -> tuple[float, str]:
        """A stored mass, length, unbalance or velocity in the reader's unit; other quantities as they are."""
        shown = self._units().get(unit)
        return (value, unit) if shown is None else (shown.show(value), shown.sign)

    def figure(self, text: str) -> str:
        """A number with the reader's decimal sign."""
        return numbers.localised(text, self.preferences.language)

    def _units(self) -> dict[str, units.Unit]:
        own = self.preferences
        return {
            "g": units.mass(own),
            "mm": units.length(own),
            "g.mm": units.unbalance(own),
            "mm/s rms": self.amplitude_unit(_VELOCITY),
        }

    def number(self, value: float | None, digits: int = 3, places: int | None = None) -> str:
        """A number without a unit."""
        return numbers.write(value, self.preferences.language, digits=digits, places=places)

    def plain(self, value: float | None) -> str:
        """A number for a field."""
        return numbers.plain(value, self.preferences.language)

    def mass(self, grams: float | None) -> str:
        """A mass."""
        return self._with(units.mass(self.preferences), grams, digits=4)

    def rotor_mass(self, kg: float | None) -> str:
        """The mass of a rotor, in kg whatever the reader's unit of pieces is."""
        return self._text(kg, "kg", digits=4)

    def length(self, mm: float | None) -> str:
        """A radius or an axial position."""
        return self._with(units.length(self.preferences), mm, digits=4)

    def unbalance(self, gmm: float | None) -> str:
        """Mass times radius."""
        return self._with(units.unbalance(self.preferences), gmm)

    def amplitude(self, sensor: Sensor, value: float | None) -> str:
        """An amplitude of a sensor, in its quantity."""
        return self._with(units.amplitude(sensor, self.preferences), value)

    def velocity(self, mm_s: float | None) -> str:
        """A vibration velocity, stored in mm/s rms."""
        return self.amplitude(_VELOCITY, mm_s)

    def angle(self, degrees: float | None) -> str:
        """An angle or a phase, 0 to 360 degrees."""
        if degrees is None:
            return "\N{EM DASH}"
        return f"{self.number(degrees % 360.0, places=0).replace('360', '0')}°"

    def speed(self, rpm: float | None) -> str:
        """A stated speed in r/min, as it was typed."""
        return "\N{EM DASH}" if rpm is None else f"{self.plain(rpm)}{NO_BREAK}{self._sign(N_('r/min'))}"

    def measured_speed(self, rpm: float | None) -> str:
        """A speed that a tachometer read, in whole r/min."""
        return self._text(rpm, "r/min", places=0)

    def force(self, newton: float | None) -> str:
        """A force in N."""
        return self._text(newton, "N", digits=2)

    def percent(self, share: float | None) -> str:
        """A share as per cent."""
        return self._text(None if share is None else 100.0 * share, "%", places=0)

    def seconds(self, value: float | None) -> str:
        """A time in s."""
        return self._text(value, "s", digits=2)

    def duration(self, seconds: float | None) -> str:
        """A time that went by, in the unit that suits it: s, min, h, d."""
        for size, sign in ((86400.0, N_("d")), (3600.0, N_("h")), (60.0, N_("min"))):
            if seconds is not None and seconds >= 2.0 * size:
                return self._text(seconds / size, sign, digits=2)
        return self.seconds(seconds)

    def time(self, moment: datetime | None) -> Markup | str:
        """A moment; the page turns it into the tablet's own time, printed text keeps UTC."""
        if moment is None:
            return "\N{EM DASH}"
        text = f"{moment:%Y-%m-%d %H:%M} UTC"
        return Markup('<time datetime="{}">{}</time>').format(moment.isoformat(), text)

    # ------------------------------------------------------------ units of fields
    def mass_unit(self) -> units.Unit:
        """Unit in which masses are typed."""
        return units.mass(self.preferences)

    def length_unit(self) -> units.Unit:
        """Unit in which lengths are typed."""
        return units.length(self.preferences)

    def amplitude_unit(self, sensor: Sensor) -> units.Unit:
        """Unit in which a sensor's amplitudes are typed."""
        return units.amplitude(sensor, self.preferences)

    def _with(self, unit: units.Unit, stored: float | None, digits: int = 3) -> str:
        return self._text(None if stored is None else unit.show(stored), unit.sign, digits=digits)

    def _text(self, value: float | None, sign: str, *, digits: int = 3, places: int | None = None) -> str:
        text = self.number(value, digits=digits, places=places)
        if value is not None and places is None and "." in text.replace(",", "."):
            # 40 g is 40 g: noughts after the decimal sign say nothing of a piece from a box.
            text = text.rstrip("0").rstrip(".,")
        return text if value is None else f"{text}{NO_BREAK}{self._sign(sign)}"

    def _sign(self, sign: str) -> str:
        return translations(self.preferences.language).gettext(sign)
