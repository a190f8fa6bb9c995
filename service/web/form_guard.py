"""Guard of forms: each is done once, and only on the state that its page showed.

A form carries a key of its own: sent again - a lost answer, two taps - it is answered as the first time. A form of a
session is refused in the very unit of work in which it would be done, if anything changed meanwhile.
"""

from __future__ import annotations

import hashlib
import json
import uuid
from collections.abc import Callable, Mapping

from fastapi.responses import HTMLResponse, Response

from service import errors
from service.runtime import idempotency
from service.runtime.context import AppContext
from service.usecases import optimistic_lock
from service.web.forms import Form
from service.web.language import N_
from service.web.rendering import FORM_KEY, Page
from service.web.session import steps
from service.web.session.guide import Guide, look
from service.web.session.refused_form import kept

Act = Callable[[AppContext], str]
"""Does what was asked for; tells the path to go on with."""
CHANGED = N_(
    "Somebody has gone on with this session meanwhile, on another tablet perhaps. What you sent was not stored. "
    "This is how the session stands now."
)
_OF_THE_PAGE = frozenset({"form_token", "stamp", "moment", FORM_KEY})
"""Fields that do not say what is asked for."""
MAX_KEY = 64


class Stale(Exception):
    """A form was sent from a page that shows an older state of the session."""

    def __init__(self, page: Page, guide: Guide, typed: dict[str, str]) -> None:
        self.page, self.guide, self.typed = page, guide, typed

    def answer(self) -> HTMLResponse:
        """The newer state and the refused form; that is filled in again where the page still asks for the same."""
        page, same = self.page, self.typed.get("moment") == self.guide.moment
        return steps.show(
            page,
            self.guide,
            form=Form(self.typed if same else None, page.preferences),
            status=409,
            notice=page.text(CHANGED),
            typing=same and page.request.url.path.endswith("/runs"),
            held=kept(page, self.guide, self.typed),
        )


class Done(Exception):
    """A form was sent again: what it asks for was done before."""

    def __init__(self, page: Page, path: str) -> None:
        self.page, self.path = page, path

    def answer(self) -> Response:
        """On to where the first one went."""
        return self.page.goto(self.path)


def done(page: Page, typed: Mapping[str, str], act: Act) -> Response:
    """Do it once, in one unit of work. Raises what `act` raises."""
    key, asked = _name(page, typed)
    given = idempotency.answer(page.work, key, asked, lambda work: idempotency.Answer(303, act(work)))
    return page.goto(given.body)


def done_in(page: Page, guide: Guide, typed: dict[str, str], act: Act) -> Response:
    """Do it once, in one unit of work, unless the session is another than `guide` since. Raises Stale, and as `act`."""

    def unchanged(work: AppContext) -> str:
        optimistic_lock.hold(work.having_seen(guide.session.version), guide.session.id)
        return act(work)

    return done_on(page, guide, typed, unchanged)


def done_on(page: Page, guide: Guide, typed: dict[str, str], act: Act) -> Response:
    """As `done_in`, for what takes its time and looks itself whether the session is the one that was seen."""
    try:
        return done(page, typed, act)
    except errors.Stale:
        raise Stale(page, look(page.work, guide.session.id), typed) from None


def require_fresh(page: Page, guide: Guide, typed: dict[str, str]) -> None:
    """The form is of the session as it stands. Raises Stale, or Done where it was sent again."""
    if typed.get("stamp") == guide.stamp:
        return

    def stale(_work: AppContext) -> idempotency.Answer:
        raise Stale(page, guide, typed)

    key, asked = _name(page, typed)
    raise Done(page, idempotency.answer(page.work, key, asked, stale).body)


def again(page: Page, typed: Mapping[str, str], busy: errors.Unavailable) -> HTMLResponse:
    """A page that says that the service is busy, and sends the same form again by itself after a while."""
    seconds = busy.retry_after_s or 1
    answer = page.render("again.html", status=busy.status, detail=page.message(busy), seconds=seconds, typed=typed)
    answer.headers["retry-after"] = str(seconds)
    return answer


def _name(page: Page, typed: Mapping[str, str]) -> tuple[str, str]:
    """Key of what is asked for, and its digest; with other fields it is another form."""
    fields = sorted((name, text) for name, text in typed.items() if name not in _OF_THE_PAGE)
    asked = hashlib.sha256(json.dumps([page.request.url.path, fields]).encode()).hexdigest()
    key = typed.get(FORM_KEY, "")[:MAX_KEY] or uuid.uuid4().hex
    return f"form {key} {asked}", asked
