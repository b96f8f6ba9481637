"""Sessions of browsers: a name and password, a token, a link or an invitation, exchanged for a cookie. By hand: they
are about HTTP itself."""

from __future__ import annotations

import html
from typing import Annotated
from urllib.parse import urlencode

from fastapi import APIRouter, Form, Header, Query, Request, Response
from fastapi.responses import HTMLResponse, RedirectResponse

from mcml.errors import AccessError, AttemptsError, ConflictError, NotFoundError, RequestError
from mcml_schemas.team.sessions import SessionOpened, SessionRequest
from mcml_schemas.team.shares import Shared, SharedMotion, SharedRequest
from mcml_service.api.authentication import SHARED, cookie_name, share_cookie_name
from mcml_service.api.page import page
from mcml_service.passwords import check_name, hash_password, opens
from mcml_service.settings import Settings
from mcml_service.storage.counting import count_attempt, forget_attempts
from mcml_service.storage.database import Database
from mcml_service.storage.team.sessions import SESSION_HOURS

LOGIN_PATH = "/login"
NOTHING_SAID = SessionRequest()

router = APIRouter(tags=["session"])
pages = APIRouter(include_in_schema=False)

FORM = """<h1>MCML Repository</h1><p>{why}</p>
<form method="post" action="{path}"><input type="hidden" name="then" value="{then}">
<p><label>Name <input name="name" autocomplete="username" size="24" autofocus></label></p>
<p><label>Password <input name="password" type="password" autocomplete="current-password" size="24"></label>
<button>Log in</button></p></form>{signing}
<details><summary>With a token</summary><form method="post" action="{path}">
<input type="hidden" name="then" value="{then}">
<p><label>Token <input name="token" type="password" autocomplete="off" size="52"></label>
<button>Open</button></p></form></details>
<p>The administrator of the server invites people and creates tokens: <code>mcml account invite</code>,
<code>mcml token add NAME</code>.</p>"""

JOIN = """<h1>MCML Repository</h1><p>{why}</p>
<form method="post" action="{path}"><input type="hidden" name="{kind}" value="{code}">
<p><label>Name <input name="name" autocomplete="username" size="24" maxlength="64" required autofocus></label></p>
<p><label>Password <input name="password" type="password" autocomplete="new-password" size="24" minlength="10"
maxlength="256" required></label> <button>Make the account</button></p></form>
<p>A password has ten characters or more. Revisions carry the name.</p>"""

FOLLOW = """<h1>MCML Repository</h1><p>This link opens the repository once, in this browser.</p>
<form method="post" action="{path}"><input type="hidden" name="link" value="{link}">
<button>Open</button></form>"""

SIGN_IN = """<p class="other"><a href="{address}">Sign in with {name}</a></p>"""

FIRST = "This server has no owner yet. Create the first account; it becomes the owner."
INVITED = "You are invited to this repository."


@router.post("/session", status_code=201, operation_id="open_session")
def open_session(
    http: Request,
    response: Response,
    request: SessionRequest = NOTHING_SAID,
    authorization: Annotated[str | None, Header(description="Bearer and a token", examples=["Bearer mcml_0"])] = None,
) -> SessionOpened:
    """Exchange credentials (name and password, token, or code of a link or invitation) for a session cookie.

    The cookie is valid for some hours. The token is in the body, or in `Authorization`. Writes with the cookie need the
    same `Origin`. Revoking the token ends the session.
    """
    scheme, _, credential = (authorization or "").partition(" ")
    if request.token is None and scheme.lower() == "bearer":
        request = request.model_copy(update={"token": credential.strip()})
    author, secret = _open_session(http, request)
    begin_session(http, response, secret)
    return SessionOpened(author=author, hours=SESSION_HOURS)


@router.delete("/session", status_code=204, operation_id="close_session")
def close_session(http: Request) -> Response:
    """End the session of this browser."""
    _end(http)
    # Documents that pages have cached end with it.
    response = Response(status_code=204, headers={"clear-site-data": '"cache", "storage"'})
    response.delete_cookie(cookie_name(http.url.scheme), secure=_by_tls(http), httponly=True, samesite="strict")
    return response


@router.post("/shared", status_code=201, operation_id="open_shared")
def open_shared(http: Request, response: Response, request: SharedRequest) -> Shared:
    """Exchange the secret of a link to some documents for a cookie, and learn what it shows.

    The cookie opens the API's addresses of these documents below `/api/v1/shared`: their skeletons, frames, labels,
    thumbnails, and exports in the formats that are named; `/api/v1/shared/documents/ID/frames` for example.
    """
    database: Database = http.app.state.repository.database
    counted = {"address": http.client.host if http.client else ""}
    count_attempt(database, counted)
    with database.write("session") as tx:
        shown = tx.shares.find(request.secret)
        if shown is None:
            raise AccessError("This link has expired or was revoked.", remedy="Ask for another one.")
        secret = tx.sessions.open_share(shown)
        view = tx.shares.view(shown)
        tx.attempts.forget(counted)
    with database.for_call(view).read() as tx:
        # Documents that were deleted or moved to another project meanwhile are left out.
        motions = [SharedMotion(**vars(motion)) for motion in tx.shares.motions(shown)]
    named, lasts = share_cookie_name(http.url.scheme), SESSION_HOURS * 3600
    response.set_cookie(
        named, secret, max_age=lasts, path=SHARED, secure=_by_tls(http), httponly=True, samesite="strict"
    )
    return Shared(name=shown.name, expires=shown.expires, formats=sorted(shown.formats), documents=motions)


@pages.get(LOGIN_PATH)
def login(
    http: Request,
    link: Annotated[str | None, Query()] = None,
    invitation: Annotated[str | None, Query()] = None,
    then: Annotated[str, Query()] = "/",
) -> HTMLResponse:
    """Show the sign-in page, for a name and a password, or a token; or follow a link or an invitation."""
    if invitation is not None:
        return join_page(http, "invitation", invitation, INVITED)
    if link is not None:
        return page("MCML Repository", _follow_link(http, link), forms=True)
    return login_page("An account opens it.", then=then, provider=_provider(http))


@pages.post(LOGIN_PATH)
def post_login(
    http: Request,
    token: Annotated[str | None, Form()] = None,
    name: Annotated[str | None, Form()] = None,
    password: Annotated[str | None, Form()] = None,
    link: Annotated[str | None, Form()] = None,
    invitation: Annotated[str | None, Form()] = None,
    then: Annotated[str, Form()] = "/",
) -> Response:
    """Receive the forms."""
    try:
        request = SessionRequest(token=token, name=name, password=password, link=link, invitation=invitation)
        _, secret = _open_session(http, request)
    except (AccessError, AttemptsError, RequestError, ConflictError, NotFoundError) as error:
        why = f"{error.what} {error.remedy or ''}"
        if invitation or (link and name is not None):
            return join_page(http, "invitation" if invitation else "link", invitation or link or "", why, status=403)
        status = 429 if isinstance(error, AttemptsError) else 403
        return login_page(why, status=status, then=then, provider=_provider(http))
    response = RedirectResponse(safe_path(then), 303)
    begin_session(http, response, secret)
    return response


def safe_path(then: str) -> str:
    """Return a path of this server: the front page for anything that looks like another address."""
    return then if then.startswith("/") and not then.startswith(("//", "/\\")) else "/"


def login_page(why: str, *, status: int = 200, then: str = "/", provider: str | None = None) -> HTMLResponse:
    """The page that lets a browser in. provider: with which one signs in, too."""
    texts = {"why": html.escape(why), "path": LOGIN_PATH, "then": html.escape(then)}
    shown = FORM.format(**texts, signing=_signing(provider, then=then))
    return page("MCML Repository", shown, status=status, forms=True)


def join_page(http: Request, kind: str, code: str, why: str, *, status: int = 200) -> HTMLResponse:
    """The page on which an account is made."""
    shown = JOIN.format(why=html.escape(why), path=LOGIN_PATH, kind=kind, code=html.escape(code))
    shown += _signing(_provider(http), **{kind: code})
    return page("MCML Repository", shown, status=status, forms=True)


def _provider(http: Request) -> str | None:
    settings: Settings = http.app.state.repository.settings
    return settings.openid


def _signing(provider: str | None, **carried: str) -> str:
    """Return the link to the provider, with values that come back from there."""
    if provider is None:
        return ""
    return SIGN_IN.format(address=html.escape(f"{LOGIN_PATH}/openid?{urlencode(carried)}"), name=html.escape(provider))


def _follow_link(http: Request, link: str) -> str:
    """Follow a sign-in link: it offers the first account if there is none, and access without an account."""
    with http.app.state.repository.database.read() as tx:
        first = not tx.accounts.have_owner()
    follow = FOLLOW.format(path=LOGIN_PATH, link=html.escape(link))
    if not first:
        return follow
    join = JOIN.format(why=FIRST, path=LOGIN_PATH, kind="link", code=html.escape(link))
    join += _signing(_provider(http), link=link)
    return join + follow.replace("<h1>MCML Repository</h1><p>", "<h2>Or without an account</h2><p>")


def _open_session(http: Request, request: SessionRequest) -> tuple[str, str]:
    """Return (author, secret of a new session).

    Raises AccessError for invalid credentials, AttemptsError for too many attempts.
    """
    database: Database = http.app.state.repository.database
    address, name = http.client.host if http.client else "", (request.name or "").strip()
    # Tokens and links have no name, so wrong ones lock nobody out.
    counted = {"address": address} | ({"name": name} if name else {})
    count_attempt(database, counted)
    if request.invitation is not None or (request.link is not None and request.name is not None):
        opened = _join_account(database.for_call(database.view, address), request)
    elif request.link is not None:
        opened = _use_link(database, request.link)
    elif request.name is not None:
        opened = _log_in(database, name, request.password or "")
    else:
        opened = _exchange_token(database, request.token)
    forget_attempts(database, counted)
    return opened


def _join_account(database: Database, request: SessionRequest) -> tuple[str, str]:
    """By an account that a link or an invitation becomes."""
    name = check_name(request.name or "")
    password = hash_password(request.password or "", name)
    with database.write(name) as tx:
        granted: tuple[str, int | None] | None = None
        if request.invitation is not None:
            granted = tx.accounts.accept(request.invitation)
        elif request.link is not None and not tx.accounts.have_owner() and tx.sessions.follow(request.link) is not None:
            granted = "owner", None
        if granted is None:
            raise AccessError("This link was used, or is too old.", remedy="Ask for another one.")
        role, project = granted
        person = tx.accounts.add(name, role if project is None else "member", password)
        if project is not None:
            tx.members.put(project, name, role)
        return person.name, tx.sessions.open_for(person)


def _use_link(database: Database, link: str) -> tuple[str, str]:
    with database.write("session") as tx:
        author = tx.sessions.follow(link)
        if author is None:
            raise AccessError("This link was used, or is too old.", remedy="Start the server again for another.")
        return author, tx.sessions.open(author)


def _log_in(database: Database, name: str, password: str) -> tuple[str, str]:
    with database.read() as tx:
        person = tx.accounts.find(name)
    # An unknown name takes as long.
    if not opens(password, None if person is None else person.password) or person is None or person.closed is not None:
        raise AccessError("This is no name and password of an account.", remedy="Check both.")
    with database.write("session") as tx:
        return person.name, tx.sessions.open_for(person)


def _exchange_token(database: Database, token: str | None) -> tuple[str, str]:
    with database.write("session") as tx:
        entry = tx.tokens.entry(token) if token else None
        if entry is None:
            raise AccessError("This token opens nothing.", remedy="Check it; `mcml token list` shows the names of all.")
        return entry.author, tx.sessions.open(entry.author, tx.tokens.name(token or ""))


def begin_session(http: Request, response: Response, secret: str) -> None:
    """Let the browser have a new session, and no other."""
    _end(http)
    named, lasts = cookie_name(http.url.scheme), SESSION_HOURS * 3600
    response.set_cookie(named, secret, max_age=lasts, path="/", secure=_by_tls(http), httponly=True, samesite="strict")


def _end(http: Request) -> None:
    """End the session that a browser has."""
    secret = http.cookies.get(cookie_name(http.url.scheme))
    if secret is not None:
        with http.app.state.repository.database.write("session") as tx:
            tx.sessions.close(secret)


def _by_tls(http: Request) -> bool:
    return http.url.scheme == "https"
