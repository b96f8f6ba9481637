"""Sessions of browsers: a token, or a one-time link, exchanged for a cookie. By hand: they are about HTTP itself."""

from __future__ import annotations

import html
from typing import Annotated, Any

from fastapi import APIRouter, Form, Header, Query, Request, Response
from fastapi.responses import HTMLResponse, RedirectResponse

from schemas.sessions import SessionOpened, SessionRequest
from service.api.doors import COOKIE
from service.api.page import page
from service.errors import AccessError
from service.storage.database import Database
from service.storage.visits import SESSION_HOURS

LOGIN_PATH = "/login"
NOTHING_SAID = SessionRequest()

router = APIRouter(tags=["session"])
pages = APIRouter(include_in_schema=False)

FORM = """<h1>MCML Repository</h1><p>{why}</p>
<form method="post" action="{path}"><input type="hidden" name="then" value="{then}">
<p><label>Token <input name="token" type="password" autocomplete="current-password" size="52" autofocus></label>
<button>Open</button></p></form>
<p>Whoever keeps the server makes one: <code>mcml token add NAME</code>.</p>"""

FOLLOW = """<h1>MCML Repository</h1><p>This link opens the repository once, in this browser.</p>
<form method="post" action="{path}"><input type="hidden" name="link" value="{link}">
<button autofocus>Open</button></form>"""


@router.post("/session", status_code=201, operation_id="open_session")
def open_session(
    http: Request,
    response: Response,
    request: SessionRequest = NOTHING_SAID,
    authorization: Annotated[str | None, Header(description="Bearer and a token", examples=["Bearer mcml_0"])] = None,
) -> SessionOpened:
    """Exchange a token, or a one-time link, for a cookie that opens the repository for some hours.

    The token stands in the body, or in `Authorization`. Writes with the cookie need the same `Origin`. Revoking the
    token ends the session.
    """
    scheme, _, given = (authorization or "").partition(" ")
    token = request.token or (given.strip() if scheme.lower() == "bearer" else None)
    author, secret = _opened(http.app.state.repository.database, token, request.link)
    _set(http, response, secret)
    return SessionOpened(author=author, hours=SESSION_HOURS)


@router.delete("/session", status_code=204, operation_id="close_session")
def close_session(http: Request) -> Response:
    """End the session of this browser."""
    if COOKIE in http.cookies:
        with http.app.state.repository.database.write("session") as tx:
            tx.sessions.close(http.cookies[COOKIE])
    response = Response(status_code=204)
    response.delete_cookie(COOKIE, httponly=True, samesite="strict")
    return response


@pages.get(LOGIN_PATH)
def login(link: Annotated[str | None, Query()] = None, then: Annotated[str, Query()] = "/") -> HTMLResponse:
    """A page that asks for a token, or follows a one-time link."""
    return login_page("A token opens it." if link is None else "", then=then, link=link)


@pages.post(LOGIN_PATH)
def post_login(
    http: Request,
    token: Annotated[str | None, Form()] = None,
    link: Annotated[str | None, Form()] = None,
    then: Annotated[str, Form()] = "/",
) -> Response:
    """What the form sends."""
    try:
        _, secret = _opened(http.app.state.repository.database, token, link)
    except AccessError as error:
        return login_page(f"{error.what} {error.remedy or ''}", status=403, then=then)
    # Only a path of this server: what looks like another address leads to the front page.
    safe = then if then.startswith("/") and not then.startswith(("//", "/\\")) else "/"
    response = RedirectResponse(safe, 303)
    _set(http, response, secret)
    return response


def login_page(why: str, *, status: int = 200, then: str = "/", link: str | None = None) -> HTMLResponse:
    """The page that lets a browser in."""
    shown = (
        FORM.format(why=html.escape(why), path=LOGIN_PATH, then=html.escape(then))
        if link is None
        else FOLLOW.format(path=LOGIN_PATH, link=html.escape(link))
    )
    return page("MCML Repository", shown, status=status, forms=True)


def _opened(database: Database, token: str | None, link: str | None) -> tuple[str, str]:
    """(author, secret of a new session). AccessError for what opens nothing."""
    with database.write("session") as tx:
        if link:
            author = tx.sessions.follow(link)
            if author is None:
                raise AccessError("This link was used, or is too old.", remedy="Start the server again for another.")
            return author, tx.sessions.open(author)
        owner = tx.tokens.owner(token) if token else None
        if owner is None:
            raise AccessError("This token opens nothing.", remedy="Check it; `mcml token list` shows the names of all.")
        return owner, tx.sessions.open(owner, owner)


def _set(http: Request, response: Response, secret: str) -> None:
    secure: Any = http.url.scheme == "https"
    response.set_cookie(
        COOKIE, secret, max_age=SESSION_HOURS * 3600, path="/", secure=secure, httponly=True, samesite="strict"
    )
