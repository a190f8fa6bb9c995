"""Logging in with a token, and out."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, Response

from service.errors import TooManyAttempts, Unauthorized
from service.usecases.access import logins
from service.usecases.access.login_throttle import LoginThrottle
from service.web.forms import Form, TypedDep
from service.web.language import N_
from service.web.rendering import Page, PageDep
from service.web.routers.preferences import local

router = APIRouter()

COOKIE = "drumtrue_login"


@router.get("/login")
def show_login(page: PageDep, back: str = "/") -> HTMLResponse:
    """Where the token is typed in."""
    return page.render("login.html", form=Form(preferences=page.preferences), back=local(back))


@router.post("/login")
def log_in(page: PageDep, typed: TypedDep) -> Response:
    """Take the token and go on to where the reader wanted to be; what is typed is not shown again."""
    form, back = Form({"token": ""}, page.preferences), local(typed.get("back", "/"))
    text = typed.get("token", "").strip()
    if not text:
        form.wrong("token", N_("Fill in this field."))
        return page.render("login.html", status=422, form=form, back=back)
    attempts: LoginThrottle = page.request.app.state.attempts
    address = page.request.client.host if page.request.client else "unknown"
    try:
        secret = attempts.guarded(address, text, lambda: logins.log_in(page.work, text))
    except Unauthorized:
        form.wrong("token", N_("This token is not good: mistyped, revoked or over. Ask who runs the service for one."))
        return page.render("login.html", status=401, form=form, back=back)
    except TooManyAttempts as refused:
        seconds = refused.retry_after_s or 0
        form.wrong("token", N_("Too many wrong tokens. Wait %(seconds)s s and try again."), seconds=seconds)
        answer = page.render("login.html", status=429, form=form, back=back)
        answer.headers["retry-after"] = str(seconds)
        return answer
    return _with_cookie(page, page.goto(back), secret)


@router.post("/logout")
def log_out(page: PageDep) -> Response:
    """End the login at the server too: its cookie is worth nothing from now on."""
    if secret := page.request.cookies.get(COOKIE):
        logins.log_out(page.work, secret)
    answer = page.goto("/login")
    answer.delete_cookie(COOKIE, httponly=True, samesite="lax", secure=page.secure)
    return answer


def _with_cookie(page: Page, answer: Response, secret: str) -> Response:
    """The answer with a cookie that scripts cannot read and other sites' forms do not send."""
    seconds = int(logins.LASTS.total_seconds())
    answer.set_cookie(COOKIE, secret, max_age=seconds, httponly=True, samesite="lax", secure=page.secure)
    return answer
