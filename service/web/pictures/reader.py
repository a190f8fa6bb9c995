"""The reader of a picture: language, numbers and units. What is stored never changes, only what is shown."""

from __future__ import annotations

from datetime import datetime

from service.messages import Message
from service.model.machine import Sensor
from service.model.message import MessageData
from service.web.display import Display
from service.web.language import translations
from service.web.numbers import MINUS
from service.web.preferences import Preferences
from service.web.sentences import Stated, advice_of, message_of, sentence
from service.web.units import Unit


class Reader:
    """Texts, numbers and units of a picture in somebody's language."""

    def __init__(self, preferences: Preferences | None = None) -> None:
        self.preferences = preferences or Preferences()
        self.show = Display(self.preferences)

    def gettext(self, message: str) -> str:
        """The message in the reader's language; %(name)s are for the caller to fill in."""
        return translations(self.preferences.language).gettext(message)

    def words(self, told: str | Message | MessageData | None) -> str:
        """What a use case says, as a sentence in the reader's language and units, without a full stop."""
        return sentence(told, self.show)

    def message(self, told: Stated) -> str:
        """What an error or a finding says, likewise."""
        return message_of(told, self.show)

    def advice(self, told: Stated) -> str:
        """What to do about an error or a finding, likewise."""
        return advice_of(told, self.show)

    def number(self, value: float, digits: int = 3) -> str:
        """A number, noughts after its decimal sign cut off."""
        text = self.show.number(value, digits=digits)
        return text.rstrip("0").rstrip(".,") if "." in text.replace(",", ".") else text

    def signed(self, value: float, digits: int = 3) -> str:
        """A number with its sign, plus too."""
        text = self.number(abs(value), digits)
        return f"{MINUS if value < 0 else '+'}{text}"

    def amplitude_unit(self, sensor: Sensor) -> Unit:
        """Unit with detection in which amplitudes of a sensor are shown; the quantity stays, so phases do too."""
        return self.show.amplitude_unit(sensor)

    def mass(self, grams: float) -> str:
        """A mass with its unit."""
        return self.show.mass(grams)

    def angle(self, degrees: float) -> str:
        """An angle, 0 to 360 degrees."""
        return self.show.angle(degrees)

    def date(self, moment: datetime) -> str:
        """A day, UTC."""
        return f"{moment:%Y-%m-%d}"

    def moment(self, moment: datetime) -> str:
        """A day and a time, UTC."""
        return f"{moment:%Y-%m-%d %H:%M} UTC"
