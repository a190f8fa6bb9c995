"""Every form carries a token that only a page of this service can have put there.

A cookie holds a secret of the browser's own; the token is derived from it, so that nothing is kept at the server and
any replica can check it. The guard refuses what other sites make a browser send before that; this holds where a browser
does not say where a request comes from.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets

from fastapi import Request, Response

from service.errors import Forbidden
from service.messages import Message
from service.web.forms import typed_fields

COOKIE = "drumtrue_form"
FIELD = "form_token"
HEADER = "x-form-token"
"""Where a script sends the token when it sends no form."""
SAFE = frozenset({"GET", "HEAD", "OPTIONS"})
_SECRET = re.compile(r"[\w-]{43}", re.ASCII)


class FormToken:
    """The token of one browser's forms; one without a secret is given one with the page."""

    def __init__(self, request: Request) -> None:
        kept = request.cookies.get(COOKIE, "")
        self._is_new = _SECRET.fullmatch(kept) is None
        self._secret = secrets.token_urlsafe(32) if self._is_new else kept
        self._secure = request.url.scheme == "https"

    @property
    def text(self) -> str:
        """What a form carries in its field, or a script in its header."""
        return hmac.digest(self._secret.encode(), b"drumtrue form", hashlib.sha256).hex()

    def hand_over(self, response: Response) -> None:
        """Give the browser its secret, where it has none."""
        if self._is_new:
            response.set_cookie(COOKIE, self._secret, httponly=True, samesite="lax", secure=self._secure)


async def require_form_token(request: Request) -> None:
    """Refuse what changes something and does not carry the token of this browser. Raises Forbidden."""
    if request.method in SAFE:
        return
    given = request.headers.get(HEADER) or (await typed_fields(request)).get(FIELD, "")
    if not hmac.compare_digest(given.encode(), FormToken(request).text.encode()):
        raise Forbidden(Message("form_token_wrong"))
