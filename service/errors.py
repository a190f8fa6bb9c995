"""The errors that the product raises on purpose.

Each carries a `Message`: the key of a text that names the value, the rule it breaks and what to do, with its values.
`status` is the HTTP status under which the API shows an error; the command line shows the same text. Numerics raise
`NumericsError` only.
"""

from __future__ import annotations

from service.messages import Message, render, render_advice


class DrumtrueError(Exception):
    """Base of every deliberate error; raised through its children only.

    data: the message as key and values. code: by default that of the message, `code` in the key `code.variant`.
    """

    status = 500
    code = "error"

    def __init__(
        self,
        message: Message,
        *,
        code: str | None = None,
        field: str | None = None,
        value: object = None,
        retry_after_s: int | None = None,
    ) -> None:
        super().__init__(message)
        self.data = message
        self.code = code or message.code
        self.field = field
        self.value = value
        self.retry_after_s = retry_after_s

    @property
    def message(self) -> str:
        """What is wrong, in English."""
        return render(self.data)

    @property
    def advice(self) -> str | None:
        """What to do, in English."""
        return render_advice(self.data)

    def __str__(self) -> str:
        return self.message


class InvalidInput(DrumtrueError):
    """A value that breaks a rule of the field: unknown sensor, angle that is no position, trial run without a mass."""

    status = 422
    code = "invalid_input"


class NumericsError(InvalidInput):
    """An array of the wrong shape, a NaN where a number must be, or a set of runs that cannot be solved."""

    code = "numerics"


class Unauthorized(DrumtrueError):
    """A request without a token, or with one that is not good (any more)."""

    status = 401
    code = "unauthorized"


class Forbidden(DrumtrueError):
    """A request that its bearer's scopes do not allow, or that another site sent through the browser."""

    status = 403
    code = "forbidden"


class NotFound(DrumtrueError):
    """A machine, catalogue, session, run, correction or plan that is not stored."""

    status = 404
    code = "not_found"


class Conflict(DrumtrueError):
    """A request that contradicts what is stored: a sequence number used twice, too few pieces in stock."""

    status = 409
    code = "conflict"


class OutOfOrder(Conflict):
    """A step of a session taken before the step it needs, or after the session is closed."""

    code = "out_of_order"


class PreconditionFailed(DrumtrueError):
    """A change that states a version of something that has none."""

    status = 412
    code = "version_unknown"


class Abandoned(DrumtrueError):
    """A computation that was ended because who asked for it hung up; no one reads this answer."""

    status = 408
    code = "request_abandoned"


class Stale(DrumtrueError):
    """A change made on a version that is not the present one. current: the document as it is now."""

    status = 412
    code = "version_stale"

    def __init__(self, message: Message, *, current: object, field: str, value: object) -> None:
        super().__init__(message, field=field, value=value)
        self.current = current


class TooLarge(DrumtrueError):
    """A request body or a list above the service's limit."""

    status = 413
    code = "too_large"


class UnsupportedMediaType(DrumtrueError):
    """A request body that is not declared as JSON."""

    status = 415
    code = "unsupported_media_type"


class TooManyAttempts(DrumtrueError):
    """Too many tokens that were not good, from one address or for one token."""

    status = 429
    code = "too_many_attempts"


class Unavailable(DrumtrueError):
    """The database does not answer: wrong address, server down, locked for long, folder that cannot be written."""

    status = 503
    code = "unavailable"


class StorageFull(Unavailable):
    """The database answers, but what it was to store has no room on its disk."""

    code = "storage_full"
