"""Sign-in with a provider of OpenID Connect: the authorization code flow with PKCE (RFC 7636).

The state of the flow is kept in a cookie of the browser; the server stores nothing.
"""

from __future__ import annotations

import json
import logging
import secrets
from base64 import urlsafe_b64decode, urlsafe_b64encode
from functools import lru_cache
from typing import Annotated, Any, TypedDict, cast

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import RedirectResponse

from mcml.errors import AccessError, AttemptsError, ConflictError, NotFoundError, RequestError
from mcml_service.api.login_pages import LOGIN_PATH
from mcml_service.api.sessions import begin_session, pages_for, safe_path
from mcml_service.passwords import check_name
from mcml_service.settings import Settings
from mcml_service.storage.counting import count_attempt, forget_attempts
from mcml_service.storage.database import Database
from mcml_service.storage.team.accounts import Account

START, BACK = f"{LOGIN_PATH}/openid", f"{LOGIN_PATH}/openid/back"
FLOW_COOKIE = "mcml_openid"
FLOW_SECONDS = 600
ALGORITHMS = ["RS256", "RS384", "RS512", "PS256", "PS384", "PS512", "ES256", "ES384", "EdDSA"]
"""Accepted signature algorithms: with keys that only the provider has."""
SCOPE = "openid profile email"
SECONDS = 10.0
"""That a provider has to answer."""

_log = logging.getLogger("mcml.api")

router = APIRouter(include_in_schema=False)


class Flow(TypedDict):
    """The state in the browser's cookie.

    then: path after the sign-in. invitation, link: codes that allow a new account.
    """

    state: str
    nonce: str
    verifier: str
    then: str
    invitation: str | None
    link: str | None


class Claims(TypedDict):
    """Claims of the provider about a person."""

    sub: str
    name: str


@router.get(START)
def start(
    http: Request,
    then: Annotated[str, Query()] = "/",
    invitation: Annotated[str | None, Query()] = None,
    link: Annotated[str | None, Query()] = None,
) -> Response:
    """Send the browser to the provider."""
    settings = _settings(http)
    flow: Flow = {
        "state": secrets.token_urlsafe(32),
        "nonce": secrets.token_urlsafe(32),
        "verifier": secrets.token_urlsafe(48),
        "then": safe_path(then),
        "invitation": invitation,
        "link": link,
    }
    with _client(settings, http) as client:
        address, _ = client.create_authorization_url(
            _provider(settings)["authorization_endpoint"],
            state=flow["state"],
            nonce=flow["nonce"],
            code_verifier=flow["verifier"],
        )
    response = RedirectResponse(address, 303)
    packed = urlsafe_b64encode(json.dumps(flow).encode()).decode()
    # Lax: the browser comes back from another site.
    secure = http.url.scheme == "https"
    response.set_cookie(
        FLOW_COOKIE, packed, max_age=FLOW_SECONDS, path=START, secure=secure, httponly=True, samesite="lax"
    )
    return response


@router.get(BACK)
def back(
    http: Request,
    code: Annotated[str | None, Query()] = None,
    state: Annotated[str | None, Query()] = None,
    error: Annotated[str | None, Query()] = None,
) -> Response:
    """Receive the browser from the provider, with a code that is exchanged for the person's identity."""
    settings = _settings(http)
    database: Database = http.app.state.repository.database
    address = http.client.host if http.client else ""
    flow = _flow(http.cookies.get(FLOW_COOKIE))
    try:
        count_attempt(database, {"address": address})
        if flow is None or state is None or not secrets.compare_digest(state, flow["state"]):
            raise AccessError("This sign-in was not begun here, or took too long.", remedy="Begin again.")
        if error is not None or code is None:
            raise AccessError(f"{settings.openid_name} did not complete the sign-in.", remedy="Begin again.")
        person = _person(database.for_call(database.view, address), settings, _claims(settings, http, code, flow), flow)
        forget_attempts(database, {"address": address})
    except (AccessError, AttemptsError, RequestError, ConflictError, NotFoundError) as refusal:
        shown = pages_for(http)
        why = shown.explain(refusal)
        if flow is not None and flow["invitation"]:
            return shown.join("invitation", flow["invitation"], why, status=403)
        return shown.login(why, status=429 if isinstance(refusal, AttemptsError) else 403)
    response = RedirectResponse(flow["then"], 303)
    response.delete_cookie(FLOW_COOKIE, path=START, httponly=True, samesite="lax")
    with database.write("session") as tx:
        secret = tx.sessions.open_for(person)
    begin_session(http, response, secret)
    return response


def _person(database: Database, settings: Settings, claims: Claims, flow: Flow) -> Account:
    """Return the account of the person; create it if there is none and new accounts are allowed."""
    issuer = str(settings.openid_issuer)
    with database.write(settings.openid_name) as tx:
        person = tx.accounts.find_identified(issuer, claims["sub"])
        if person is not None:
            if person.closed is not None:
                raise AccessError("This account is closed.", remedy="Ask an owner of the repository.")
            return person
        offered = tx.accounts.accept(flow["invitation"]) if flow["invitation"] else None
        if flow["link"] and not tx.accounts.have_owner() and tx.sessions.follow(flow["link"]) is not None:
            offered = "owner", None
        if offered is None:
            if settings.openid_role == "none":
                raise AccessError(
                    "You have no invitation to this repository.", remedy="Ask an owner of the repository."
                )
            offered = settings.openid_role, None
        role, project = offered
        name = check_name(claims["name"])
        # No password opens it: none has this hash.
        person = tx.accounts.add(name, role if project is None else "member", "")
        if project is not None:
            tx.members.put(project, name, role)
        tx.accounts.identify(person, issuer, claims["sub"])
        return person


def _claims(settings: Settings, http: Request, code: str, flow: Flow) -> Claims:
    """Return the person's identity from the provider (OpenID Connect Core 1.0, 3.1.3).

    Raises AccessError for invalid signatures or claims.
    """
    from authlib.common.errors import AuthlibBaseError
    from joserfc import jwt
    from joserfc.errors import JoseError
    from joserfc.jwk import KeySet
    from joserfc.jwt import JWTClaimsRegistry

    provider = _provider(settings)
    try:
        with _client(settings, http) as client:
            token = client.fetch_token(provider["token_endpoint"], code=code, code_verifier=flow["verifier"])
            keys = KeySet.import_key_set(client.request("GET", provider["jwks_uri"], withhold_token=True).json())
        claims = jwt.decode(token["id_token"], keys, algorithms=ALGORITHMS).claims
        JWTClaimsRegistry(
            leeway=60,
            iss={"essential": True, "value": provider["issuer"]},
            aud={"essential": True, "value": settings.openid_client_id},
            nonce={"essential": True, "value": flow["nonce"]},
            exp={"essential": True},
            sub={"essential": True},
        ).validate(claims)
    except (AuthlibBaseError, JoseError, asking().HTTPError, KeyError, ValueError, TypeError) as error:
        _log.warning("a sign-in with %s failed: %r", settings.openid_issuer, error)
        raise AccessError(
            f"What {settings.openid_name} answered cannot be believed: {type(error).__name__}.", remedy="Begin again."
        ) from error
    name = claims.get("preferred_username") or claims.get("email") or claims.get("name") or claims["sub"]
    return {"sub": str(claims["sub"]), "name": str(name)}


def asking() -> Any:
    """Return the HTTP module that authlib uses."""
    try:
        import httpx2
    except ModuleNotFoundError:
        import httpx

        return httpx
    return httpx2


def _settings(http: Request) -> Settings:
    settings: Settings = http.app.state.repository.settings
    if settings.openid is None:
        raise NotFoundError("This server has no provider to sign in with.", remedy="Set MCML_OPENID_ISSUER.")
    return settings


def _client(settings: Settings, http: Request) -> Any:
    from authlib.integrations.httpx_client import OAuth2Client

    secret = settings.openid_client_secret
    return OAuth2Client(
        client_id=settings.openid_client_id,
        client_secret=secret,
        token_endpoint_auth_method="client_secret_basic" if secret else "none",
        scope=SCOPE,
        redirect_uri=str(http.base_url).rstrip("/") + BACK,
        code_challenge_method="S256",
        timeout=SECONDS,
    )


def _provider(settings: Settings) -> dict[str, Any]:
    """Return the provider's metadata (OpenID Connect Discovery 1.0, 4)."""
    return _discover(str(settings.openid_issuer))


@lru_cache(maxsize=4)
def _discover(issuer: str) -> dict[str, Any]:
    httpx = asking()
    try:
        answer = httpx.get(f"{issuer.rstrip('/')}/.well-known/openid-configuration", timeout=SECONDS)
        metadata: dict[str, Any] = answer.raise_for_status().json()
        if metadata["issuer"].rstrip("/") != issuer.rstrip("/"):
            raise ValueError(metadata["issuer"])
        return metadata
    except (httpx.HTTPError, ValueError, KeyError, AttributeError) as error:
        raise AccessError(
            "The sign-in provider is unreachable.", remedy="Log in with a password, or try again later."
        ) from error


def _flow(packed: str | None) -> Flow | None:
    """Read the state from the browser's cookie, None if it is missing or invalid."""
    try:
        flow = json.loads(urlsafe_b64decode(packed or ""))
        kept = {name: flow[name] for name in Flow.__annotations__}
    except (ValueError, KeyError, TypeError):
        return None
    plain = all(isinstance(kept[name], str) for name in ("state", "nonce", "verifier", "then"))
    others = all(kept[name] is None or isinstance(kept[name], str) for name in ("invitation", "link"))
    return cast(Flow, kept | {"then": safe_path(kept["then"])}) if plain and others else None
