"""A page: the request, the reader's language and units, and how a template is rendered for them."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from typing import Annotated, Any

from fastapi import Depends, Request
from fastapi.responses import HTMLResponse, RedirectResponse, Response
from markupsafe import Markup

from service.messages import Message
from service.messages.catalogue import word
from service.model.message import MessageData
from service.runtime.context import AppContext
from service.runtime.presence import Presence
from service.usecases.access.tokens import Principal
from service.version import __version__
from service.web.display import Display
from service.web.environment import environment
from service.web.form_tokens import FIELD, FormToken
from service.web.language import translations
from service.web.preferences import COOKIE, LANGUAGES, Preferences
from service.web.sentences import Stated, advice_of, message_of, sentence

FORM_KEY = "form_key"
"""The field with which a form is known when it is sent again."""
OUTBOX = "x-outbox"
"""Header of a form that a page's script sends, and keeps until it is answered."""
HEADERS = {
    # Nothing from anywhere else, no script or style in the page itself: what a page shows cannot be made to run.
    "content-security-policy": "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; "
    "form-action 'self'; object-src 'none'",
    "cache-control": "no-store",
    "referrer-policy": "same-origin",
    "x-content-type-options": "nosniff",
}


class Page:
    """One request for a page."""

    def __init__(self, request: Request, looking: ExitStack | None = None) -> None:
        self.request = request
        self._looking = looking
        self._work: AppContext | None = None
        header = request.headers.get("accept-language")
        self.preferences = Preferences.read(request.cookies.get(COOKIE), header)
        self.language = self.preferences.language
        self.display = Display(self.preferences)
        self.form_token = FormToken(request)
        self.secure = request.url.scheme == "https"

    @property
    def work(self) -> AppContext:
        """What the use cases need. A page that only shows sees one moment, whatever it looks at."""
        if self._work is None:
            work: AppContext = self.request.app.state.work
            actor = work.actor if self.principal is None else self.principal.name
            work = replace(work, gone=Presence(self.request), actor=actor)
            self._work = work if self._looking is None else work.looking_within(self._looking)
        return self._work

    @property
    def principal(self) -> Principal | None:
        """Who asks, and what they may do; None on a page that everyone may see."""
        found: Principal | None = getattr(self.request.state, "principal", None)
        return found

    @property
    def back(self) -> str:
        """The address to come back to: of this page, or of the first one where a form was sent to it."""
        url = self.request.url
        if self.request.method != "GET":
            return "/"
        return f"{url.path}?{url.query}" if url.query else url.path

    def text(self, message: str, **values: object) -> str:
        """A text in the reader's language, `%(name)s` filled in."""
        found = translations(self.language).gettext(message)
        return found % values if values else found

    def word(self, name: str) -> str:
        """A word of the product's vocabulary in the reader's language."""
        return word("word", name, self.language)

    def words(self, told: str | Message | MessageData | None) -> str:
        """What a use case says, as a sentence in the reader's language and units."""
        return sentence(told, self.display)

    def message(self, told: Stated) -> str:
        """What an error or a finding says, as a sentence in the reader's language and units."""
        return message_of(told, self.display)

    def advice(self, told: Stated) -> str:
        """What to do about an error or a finding, likewise."""
        return advice_of(told, self.display)

    def render(self, template: str, *, status: int = 200, **context: Any) -> HTMLResponse:
        """The page that a template makes of what is handed to it.

        Every template finds `page`, `show` (stored numbers as text), `prefs`, `languages` and `hidden_fields` too.
        """
        body = (
            environment(self.language)
            .get_template(template)
            .render(
                page=self,
                show=self.display,
                prefs=self.preferences,
                languages=LANGUAGES,
                version=__version__,
                hidden_fields=self.hidden_fields,
                **context,
            )
        )
        answer = HTMLResponse(body, status_code=status, headers=HEADERS)
        self.form_token.hand_over(answer)
        return answer

    def goto(self, path: str) -> Response:
        """Send on after a form was taken: loading the next page again stores nothing.

        A script that sent the form is told where to go: it goes there once it has noted that the form was taken.
        """
        if OUTBOX in self.request.headers:
            return Response(status_code=204, headers={"x-goto": path, "cache-control": "no-store"})
        return RedirectResponse(path, status_code=303)

    def hidden_fields(self) -> Markup:
        """Fields that every form of the page carries unseen."""
        field = Markup('<input type="hidden" name="{}" value="{}">')
        return field.format(FIELD, self.form_token.text) + field.format(FORM_KEY, uuid.uuid4().hex)


def _page(request: Request) -> Iterator[Page]:
    """A page; what one that only shows has looked at is let go before it is sent."""
    with ExitStack() as looking:
        yield Page(request, looking if request.method in ("GET", "HEAD") else None)


def _long_page(request: Request) -> Page:
    """A page that is made for seconds or hours: each look of it is a moment of its own."""
    return Page(request)


PageDep = Annotated[Page, Depends(_page, scope="function")]
LongPageDep = Annotated[Page, Depends(_long_page)]
