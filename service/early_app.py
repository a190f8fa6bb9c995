"""The application from the first moment: it tells its health at once and builds all else behind that.

To import and build every route takes three times as long as all else of a start. A supervisor that asks whether the
service is up, or a tablet that connects, need not wait for it: whole and early application share middleware, state and
the routes of health, so an answer does not tell which of them gave it.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable

from starlette.types import ASGIApp, Receive, Scope, Send

from service.api.base_app import PREFIX, AppState, allow_threads, base_app, include_health
from service.runtime.context import AppContext
from service.settings import Settings

HEALTH = frozenset(
    prefix + path for prefix in ("", PREFIX) for path in ("/health", "/health/live", "/health/ready", "/metrics")
)
WARM_AFTER_S = 0.5
"""The rest is built after this time without being asked for: long enough for a probe to come first."""


class EarlyApp:
    """ASGI application of a served database.

    built: called, in the thread that builds, once the whole application stands.
    """

    def __init__(
        self, settings: Settings, work: AppContext, ending: Callable[[], bool], built: Callable[[], None]
    ) -> None:
        self._settings, self._built = settings, built
        self._state = AppState(ending, work=work)
        self._health = base_app(settings, self._state)
        include_health(self._health)
        self._whole: ASGIApp | None = None
        self._building = threading.Lock()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request of health with what is there, any other with the whole application."""
        if scope["type"] == "lifespan":
            await self._live(scope, receive, send)
        elif self._whole is None and scope["type"] == "http" and scope["path"] in HEALTH:
            await self._health(scope, receive, send)
        else:
            whole = self._whole if self._whole is not None else await asyncio.to_thread(self.whole)
            await whole(scope, receive, send)

    async def _live(self, scope: Scope, receive: Receive, send: Send) -> None:
        allow_threads()
        later = asyncio.get_running_loop().call_later(WARM_AFTER_S, self._warm)
        try:
            await self._health(scope, receive, send)
        finally:
            later.cancel()  # what is being built is not waited for: a stop is prompt
            if self._state.work is not None:
                self._state.work.background.close()

    def _warm(self) -> None:
        threading.Thread(target=self.whole, name="building", daemon=True).start()

    def whole(self) -> ASGIApp:
        """The whole application, built by who asks for it first."""
        with self._building:
            if self._whole is None:
                from service.app import create_app  # what takes long is its import

                whole = create_app(self._settings, self._state.work, self._state)
                self._state.put_on(whole)
                self._built()
                self._whole = whole
            return self._whole
