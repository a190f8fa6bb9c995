"""Readings onto a CAN bus, as a balancer would send them: the simulated drum and replayed logs, in any mapped DBC."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import can
from cantools.database import EncodeError
from cantools.database.can import Message

from drivers.can.bus import BusAddress, bus_errors, open_bus
from drivers.can.mapping import CanMapping, Field
from drivers.errors import InvalidSetting
from drivers.reading import Answer, Reading


class FrameEncoder:
    """Turns readings into frames that a `FrameDecoder` with the same mapping turns back, to the step of the signals.

    A value beyond the range of its signal is sent as not valid; where the mapping has no such flag it is cut.
    """

    def __init__(self, mapping: CanMapping) -> None:
        self._mapping = mapping
        self._messages = {message.name: message for message in mapping.messages()}
        self._sensors = {sensor.name: sensor for sensor in mapping.sensors}
        self._counts: dict[str, int] = {}

    def reading(self, reading: Reading) -> list[can.Message]:
        """Frames of one reading, the speed first. Raises `InvalidSetting` for a sensor that is not mapped."""
        sensor = self._sensors.get(reading.sensor)
        if sensor is None:
            known = ", ".join(self._sensors)
            raise InvalidSetting(f"sensor {reading.sensor!r} has no signal in the mapping: map it; there are {known}")
        values: list[tuple[Field | None, float | None]] = [
            (sensor.overall, reading.overall_rms),
            (sensor.amplitude, reading.amplitude),
            (sensor.phase, reading.phase_deg),
        ]
        speed = [(self._mapping.speed, reading.speed_rpm)]
        return [*self._frames(speed), *self._frames(values)]

    def answer(self, answer: Answer, number: int) -> list[can.Message]:
        """Frames of a balancer's own corrections."""
        masses = {plane: (mass, angle) for plane, mass, angle in answer.masses}
        values: list[tuple[Field | None, float | None]] = []
        for plane in self._mapping.corrections:
            mass, angle = masses[plane.plane]
            values += [(plane.mass, mass), (plane.angle, angle), (plane.number, float(number))]
        return self._frames(values)

    def heartbeat(self) -> list[can.Message]:
        """The frame that says the balancer is alive; none where none is mapped."""
        name = self._mapping.heartbeat
        return [] if name is None else [self._frame(self._messages[name], {})]

    def _frames(self, values: Iterable[tuple[Field | None, float | None]]) -> list[can.Message]:
        grouped: dict[str, dict[str, float]] = {}
        for field, value in values:
            if field is None:
                continue
            signals = grouped.setdefault(field.message, {})
            raw, holds = self._raw(field, value)
            signals[field.signal] = raw
            if field.valid is not None:
                flag = self._messages[field.message].get_signal_by_name(field.valid.signal)
                signals[flag.name] = flag.offset + flag.scale * field.valid.example(holds, flag.length)
        return [self._frame(self._messages[name], signals) for name, signals in grouped.items()]

    def _raw(self, field: Field, value: float | None) -> tuple[float, bool]:
        """The signal's value, and whether it is the one that was meant."""
        signal = self._messages[field.message].get_signal_by_name(field.signal)
        low = float(signal.minimum or 0.0)
        high = float("inf") if signal.maximum is None else float(signal.maximum)
        if value is None:
            return low, False
        raw = value / field.factor
        if field.factor < 0.0:
            raw %= 360.0 / abs(field.factor)
        if raw > high and signal.unit == "deg" and raw <= high + float(signal.scale):
            raw = raw - high if raw - high > 0.5 * float(signal.scale) else high
        return min(max(raw, low), high), low <= raw <= high

    def _frame(self, message: Message, values: dict[str, float]) -> can.Message:
        signals = {signal.name: values.get(signal.name, float(signal.minimum or 0.0)) for signal in message.signals}
        counter = self._mapping.counter
        if counter is not None and counter in signals:
            modulus = 1 << message.get_signal_by_name(counter).length
            count = self._counts[message.name] = (self._counts.get(message.name, -1) + 1) % modulus
            signals[counter] = float(count)
        try:
            data = message.encode(signals, strict=False)
        except (EncodeError, ValueError) as error:
            raise InvalidSetting(f"message {message.name} cannot be sent ({error}): correct the DBC") from error
        node = self._mapping.node
        identifier = message.frame_id
        if message.is_extended_frame and node is not None:
            identifier = (identifier & ~0xFF) | node
        return can.Message(arbitration_id=identifier, is_extended_id=message.is_extended_frame, data=data)


class CanOut:
    """A way out onto a CAN bus: an `Outlet` that acknowledges what it sent. A bus keeps nothing."""

    def __init__(self, address: BusAddress, mapping: CanMapping, *, bus: can.BusABC | None = None) -> None:
        self._address = address
        self._encoder = FrameEncoder(mapping)
        self._bus = bus or open_bus(address)

    def post(self, readings: Sequence[Reading]) -> int:
        """Send the frames of these readings behind a heartbeat. Raises `BusUnavailable` where the bus is lost."""
        self._send(self._encoder.heartbeat())
        for reading in readings:
            self._send(self._encoder.reading(reading))
        return len(readings)

    def answer(self, answer: Answer, number: int) -> None:
        """Send a balancer's own corrections."""
        self._send(self._encoder.answer(answer, number))

    def close(self) -> None:
        """Let go of the bus."""
        self._bus.shutdown()

    def _send(self, frames: Iterable[can.Message]) -> None:
        with bus_errors(self._address):
            for frame in frames:
                self._bus.send(frame)
