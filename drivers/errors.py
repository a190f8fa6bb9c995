"""The errors that drivers raise on purpose; nothing else leaves a driver.

Each message names the value, the rule it breaks and what to do.
"""

from __future__ import annotations

CORRECT = "correct the file, or ask for the rest to be used all the same"
READABLE = "check its name, and that this user may read it"
WRITABLE = "name a file in a folder that this user can write and that has room"


class DriverError(Exception):
    """Base of every deliberate error of a driver; raised through its children only."""


class InvalidSetting(DriverError, ValueError):
    """A drum, mass, speed, fault or option breaks a rule: unknown plane, negative mass, NaN, a name used twice."""


class DriverClosed(DriverError):
    """Readings asked of a driver that is not open, or a driver opened that is open already."""


class BrokenSource(DriverError):
    """A source breaks its own promise: a sequence number not above the last one, or a time without a zone."""


class DeliveryError(DriverError):
    """Base of the errors on the way out to the service; raised through its children only."""


class DeliveryFailed(DeliveryError):
    """The service was not reached, could not do it now (5xx, 408, 425, 429), or something else answered in its place.

    The same batch may be posted again.
    """


class DeliveryRefused(DeliveryError):
    """The service refused a batch for what is in it, in problem JSON of its own (4xx): posting it again cannot help.

    status: the HTTP status. detail: what the service said, shortened.
    """

    def __init__(self, message: str, *, status: int, detail: str) -> None:
        super().__init__(message)
        self.status = status
        self.detail = detail


class DeliveryGivenUp(DeliveryError):
    """A source that ends was read, and the service would not have all of it in the time given: the rest is spooled."""


class PortUnavailable(DriverError, OSError):
    """The control port cannot be opened: in use, not permitted, or no such address."""


class BusUnavailable(DriverError, OSError):
    """A CAN bus cannot be opened, or was lost: no such interface or adapter, no permission, cable out, bus off."""


class LogError(DriverError, ValueError):
    """A line or block of a recording or log is no reading or frame, or the file cannot be read or written.

    file, line (from 1; None for a binary file) and reason say which and why; advice: what to do. code: `wrong_line`,
    `start_unknown`, `damaged`, `no_log`, `too_large`, `nothing_read` or `log`, the same in every version.
    """

    def __init__(
        self, file: object, line: int | None, reason: str, advice: str = CORRECT, *, code: str | None = None
    ) -> None:
        where = f"{file}" if line is None else f"{file}, line {line}"
        super().__init__(f"{where}: {reason}; {advice}")
        self.file, self.line, self.reason, self.advice = file, line, reason, advice
        self.code = code or ("log" if line is None else "wrong_line")


class SpoolError(DriverError):
    """Base of the errors of the spool; raised through its children only."""


class SpoolFull(SpoolError):
    """The spool or its disk is full: nothing of what was put is in it, everything before still is."""


class SpoolUnusable(SpoolError, OSError):
    """The spool's file cannot be opened or read: no permission, in use by another bridge, or no spool at all."""


class SignalRefused(DriverError, ValueError):
    """A waveform that gives no honest reading: too few turns, edges that no repair explains, a speed that runs away.

    code: `too_short`, `tacho`, `speed`, `pulses`, `sampling`, `clipped`, `dropout` or `numbers`, the same in every
    version.
    """

    def __init__(self, message: str, *, code: str) -> None:
        super().__init__(message)
        self.code = code


class UnreadableFile(DriverError, ValueError):
    """A waveform file that cannot be opened, is not what its name says, or lacks a column that was asked for.

    path: the file. line: the line of a text file, counted from 1.
    """

    def __init__(self, message: str, *, path: str, line: int | None = None) -> None:
        where = path if line is None else f"{path}, line {line}"
        super().__init__(f"{where}: {message}")
        self.path = path
        self.line = line
