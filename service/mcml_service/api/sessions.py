"""Sessions of browsers: a name and password, a token, a link or an invitation, exchanged for a cookie. By hand: they
are about HTTP itself."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Form, Header, Query, Request, Response
from fastapi.responses import HTMLResponse, RedirectResponse

from mcml.errors import AccessError, AttemptsError, ConflictError, NotFoundError, RequestError
from mcml_schemas.team.sessions import SessionOpened, SessionRequest
from mcml_schemas.team.shares import Shared, SharedMotion, SharedRequest
from mcml_service.api.authentication import SHARED, cookie_name, share_cookie_name
from mcml_service.api.login_pages import LOGIN_PATH, LoginPages
from mcml_service.passwords import check_name, hash_password, opens
from mcml_service.settings import Settings
from mcml_service.storage.counting import count_attempt, forget_attempts
from mcml_service.storage.database import Database
from mcml_service.storage.team.sessions import SESSION_HOURS

NOTHING_SAID = SessionRequest()

router = APIRouter(tags=["session"])
pages = APIRouter(include_in_schema=False)

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
    shown = pages_for(http)
    if invitation is not None:
        return shown.join("invitation", invitation, INVITED)
    if link is not None:
        # Without an account yet, the page offers to create the first one.
        with http.app.state.repository.database.read() as tx:
            return shown.follow(link, first=not tx.accounts.have_owner())
    return shown.login("Sign in to open the repository.", then=then)


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
        shown = pages_for(http)
        why = shown.explain(error)
        if invitation or (link and name is not None):
            return shown.join("invitation" if invitation else "link", invitation or link or "", why, status=403)
        return shown.login(why, status=429 if isinstance(error, AttemptsError) else 403, then=then)
    response = RedirectResponse(safe_path(then), 303)
    begin_session(http, response, secret)
    return response


def safe_path(then: str) -> str:
    """Return a path of this server: the front page for anything that looks like another address."""
    return then if then.startswith("/") and not then.startswith(("//", "/\\")) else "/"


def pages_for(http: Request) -> LoginPages:
    settings: Settings = http.app.state.repository.settings
    return LoginPages(http.headers.get("accept-language", ""), settings.openid)


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
        raise AccessError("Name or password is wrong.", remedy="Check both.")
    with database.write("session") as tx:
        return person.name, tx.sessions.open_for(person)


def _exchange_token(database: Database, token: str | None) -> tuple[str, str]:
    with database.write("session") as tx:
        entry = tx.tokens.entry(token) if token else None
        if entry is None:
            raise AccessError("This token is not valid.", remedy="Check it; `mcml token list` shows the names of all.")
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
