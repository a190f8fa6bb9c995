"""Throttle clients after repeated authentication failures; a good token always passes."""

from __future__ import annotations

import ipaddress
import math
import threading
from collections import OrderedDict, deque
from collections.abc import Callable
from typing import TypeVar

from service.errors import TooManyAttempts, Unauthorized
from service.messages import Message
from service.usecases.access import tokens

T = TypeVar("T")

MOST = 10
"""Failures of one address, or for one token, in WINDOW_S."""
WINDOW_S = 60.0
MAX_KEYS = 10_000
"""Addresses and tokens remembered; beyond that the longest quiet one is forgotten."""


class LoginThrottle:
    """Failures of the last minute, by client address and by the token they named; kept in this process only.

    monotonic: seconds of a clock that is never set back.
    """

    def __init__(self, monotonic: Callable[[], float]) -> None:
        self.monotonic = monotonic
        self._failures: OrderedDict[str, deque[float]] = OrderedDict()
        self._lock = threading.Lock()

    def guarded(self, address: str, text: str, act: Callable[[], T]) -> T:
        """What `act` gives, which looks at the token `text` sent from `address`; its refusal counts as a failure.

        The token is looked at first: a secret has 160 bits, and nothing is gained by refusing a good one because of
        what others send from the same address, or for the same token. Raises what `act` raises, and TooManyAttempts in
        its place where there were too many failures.
        """
        try:
            return act()
        except Unauthorized:
            keys = _keys(address, text)
            self._require_few(keys)
            self._count(keys)
            raise

    def _require_few(self, keys: tuple[str, ...]) -> None:
        now = self.monotonic()
        with self._lock:
            wait = max((self._wait_s(key, now) for key in keys), default=0.0)
        if wait > 0.0:
            seconds = math.ceil(wait)
            raise TooManyAttempts(
                Message("too_many_attempts", most=MOST, window=WINDOW_S, seconds=seconds), retry_after_s=seconds
            )

    def _wait_s(self, key: str, now: float) -> float:
        failures = self._failures.get(key)
        if failures is None:
            return 0.0
        while failures and failures[0] <= now - WINDOW_S:
            failures.popleft()
        if not failures:
            del self._failures[key]
        return failures[0] + WINDOW_S - now if len(failures) >= MOST else 0.0

    def _count(self, keys: tuple[str, ...]) -> None:
        now = self.monotonic()
        with self._lock:
            for key in keys:
                self._failures.setdefault(key, deque(maxlen=MOST)).append(now)
                self._failures.move_to_end(key)
            while len(self._failures) > MAX_KEYS:
                self._failures.popitem(last=False)


def _keys(address: str, text: str) -> tuple[str, ...]:
    """The address, in IPv6 the network of 64 bits that one host may have whole, and the token that is named."""
    parts = tokens.split(text)
    try:
        ip = ipaddress.ip_address(address)
    except ValueError:
        network = address
    else:
        network = str(ipaddress.ip_network((ip, 64), strict=False)) if ip.version == 6 else address
    return (f"address {network}",) if parts is None else (f"address {network}", f"token {parts[0]}")
