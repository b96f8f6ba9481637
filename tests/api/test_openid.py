"""Signing in with a provider of OpenID Connect: a real one on loopback, and answers that cannot be believed."""

from __future__ import annotations

import json
import re
import time
from base64 import urlsafe_b64encode
from collections.abc import Iterator
from datetime import timedelta
from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx
import pytest
from fastapi.testclient import TestClient
from joserfc import jwt
from joserfc.jwk import RSAKey
from oidc_provider_mock import run_server_in_thread

from mcml_service.api import openid
from mcml_service.api.openid import BACK, FLOW_COOKIE, START, asking
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import SECRET, one_kind

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")
API = "/api/v1"
HOME = "http://127.0.0.1:8000"


@pytest.fixture(scope="module")
def issuer() -> Iterator[str]:
    with run_server_in_thread() as server:
        yield f"http://localhost:{server.server_port}"


def visitor(database: Database, issuer: str, **settings: Any) -> TestClient:
    """A browser of somebody elsewhere, at a server of a store that is closed."""
    with database.write() as tx:
        if not tx.tokens.exist():
            tx.tokens.add("closes the door")
    chosen = Settings.model_validate(
        {"openid_issuer": issuer, "openid_name": "the studio", "openid_client_secret": "secret", **settings}
    )
    app = create_app(chosen, database, lambda: SECRET)
    return TestClient(app, base_url=HOME, client=("10.0.0.7", 1), follow_redirects=False)


def authorised(address: str, subject: str) -> dict[str, str]:
    """What the provider sends back with when somebody signs in there."""
    answer = httpx.post(address, data={"sub": subject}, follow_redirects=False)
    assert answer.status_code in (302, 303), answer.text
    back = urlsplit(answer.headers["location"])
    assert f"{back.scheme}://{back.netloc}{back.path}" == HOME + BACK
    return {name: values[0] for name, values in parse_qs(back.query).items()}


def signed_in(client: TestClient, subject: str, **given: str) -> Any:
    """What the last answer of the whole flow is."""
    to = client.get(START, params=given)
    assert to.status_code == 303, to.text
    return client.get(BACK, params=authorised(to.headers["location"], subject))


@pytest.mark.slow
@one_kind
def test_who_may_come_gets_an_account_and_comes_back_to_it(database: Database, issuer: str) -> None:
    with visitor(database, issuer, openid_role="reader") as client:
        refused = signed_in(client, "kim@studio.example")
        assert (refused.status_code, "no owner&#x27;s account" in refused.text) == (403, True)
        with database.write() as tx:
            tx.accounts.add("boss", "owner", "x")
        page = client.get("/library", headers={"accept": "text/html"})
        assert "Sign in with the studio" in page.text
        (way,) = re.findall(r'href="(/login/openid[^"]*)"', page.text)
        assert parse_qs(urlsplit(way).query)["then"] == ["/library"]
        answer = signed_in(client, "kim@studio.example", then="/library")
        assert (answer.status_code, answer.headers["location"]) == (303, "/library")
        me = client.get(f"{API}/account").json()
        assert (me["name"], me["role"]) == ("kim@studio.example", "reader")
        assert FLOW_COOKIE not in client.cookies
    with database.write() as tx:
        tx.accounts.change("kim@studio.example", role="editor")
    with visitor(database, issuer) as client:
        assert signed_in(client, "kim@studio.example").status_code == 303
        assert client.get(f"{API}/account").json()["role"] == "editor"
        # No password opens it.
        for password in ("", "x" * 12):
            asked = {"name": "kim@studio.example", "password": password}
            assert client.post(f"{API}/session", json=asked).status_code == 403


@one_kind
def test_nobody_comes_without_an_invitation_unless_that_is_said(database: Database, issuer: str) -> None:
    with database.write() as tx:
        tx.accounts.add("boss", "owner", "x")
        project = tx.projects.get_or_add("dance")
        code = tx.accounts.invite("editor", "boss", timedelta(days=3), project)
    with visitor(database, issuer) as client:
        refused = signed_in(client, "lee")
        assert refused.status_code == 403
        assert "You have no invitation" in refused.text
        page = client.get("/login", params={"invitation": code}).text
        (way,) = re.findall(r'href="(/login/openid[^"]*)"', page)
        assert parse_qs(urlsplit(way).query)["invitation"] == [code]
        assert signed_in(client, "lee", invitation=code).status_code == 303
        me = client.get(f"{API}/account").json()
        assert (me["role"], me["projects"]) == ("member", [{"project": "dance", "role": "editor"}])
    with visitor(database, issuer) as client:
        assert signed_in(client, "eve", invitation=code).status_code == 403, "an invitation is for one"


@one_kind
def test_the_first_owner_may_sign_in_so(database: Database, issuer: str) -> None:
    with database.write() as tx:
        link = tx.sessions.link("local")
    with visitor(database, issuer) as client:
        assert "Sign in with the studio" in client.get("/login", params={"link": link}).text
        assert signed_in(client, "kim", link=link).status_code == 303
        assert client.get(f"{API}/account").json()["role"] == "owner"


@one_kind
def test_names_that_are_taken_and_accounts_that_are_closed_open_nothing(database: Database, issuer: str) -> None:
    with database.write() as tx:
        tx.accounts.add("kim", "owner", "x")
    with visitor(database, issuer, openid_role="editor") as client:
        refused = signed_in(client, "kim")
        assert refused.status_code == 403
        assert "is taken" in refused.text
        assert signed_in(client, "lee").status_code == 303
        with database.write() as tx:
            tx.sessions.end_all(tx.accounts.change("lee", closed="2026-01-01T00:00:00.000Z").key)
        assert client.get(f"{API}/account").status_code == 401
        refused = signed_in(client, "lee")
        assert "closed" in refused.text


@one_kind
@pytest.mark.parametrize("wrong", ["state", "cookie", "no cookie", "code", "another browser", "error"])
def test_what_was_not_begun_here_opens_nothing(database: Database, issuer: str, wrong: str) -> None:
    with visitor(database, issuer, openid_role="editor") as client:
        sent = authorised(client.get(START).headers["location"], "kim")
        if wrong == "state":
            sent["state"] += "x"
        if wrong == "cookie":
            client.cookies.set(FLOW_COOKIE, "bm8=", domain="127.0.0.1", path=START)
        if wrong == "no cookie":
            client.cookies.clear()
        if wrong == "code":
            sent["code"] = "guessed"
        if wrong == "another browser":
            # The code of somebody else, brought to a browser that began a flow of its own.
            theirs = TestClient(client.app, base_url=HOME, client=("10.0.0.9", 1), follow_redirects=False)
            theirs.get(START)
            client = theirs
        if wrong == "error":
            sent = {"error": "access_denied", "state": sent["state"]}
        answer = client.get(BACK, params=sent)
        assert answer.status_code == 403, answer.text
        assert client.get(f"{API}/account").status_code == 401
    with database.read() as tx:
        assert tx.accounts.all() == []


@one_kind
def test_it_leads_to_no_other_address(database: Database, issuer: str) -> None:
    with database.write() as tx:
        tx.accounts.add("boss", "owner", "x")
    with visitor(database, issuer, openid_role="editor") as client:
        for then in ("https://evil.example", "//evil.example", "/\\evil.example"):
            assert signed_in(client, "kim", then=then).headers["location"] == "/"


class Provider:
    """One that says what a test lets it say, in the place of HTTP."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.key, self.other = RSAKey.generate_key(2048, private=True), RSAKey.generate_key(2048, private=True)
        self.token = ""
        at = "https://provider.example"
        self.told = {"issuer": at} | {f"{name}_endpoint": f"{at}/{name}" for name in ("authorization", "token")}
        self.told["jwks_uri"] = f"{at}/keys"
        monkeypatch.setattr(openid, "_discover", lambda issuer: self.told)
        monkeypatch.setattr(openid, "_client", self._client)

    def _client(self, settings: Settings, http: Any) -> Any:
        from authlib.integrations.httpx_client import OAuth2Client

        return OAuth2Client(
            "mcml", "secret", code_challenge_method="S256", transport=asking().MockTransport(self._answer)
        )

    def _answer(self, request: Any) -> Any:
        if request.url.path == "/keys":
            return asking().Response(200, json={"keys": [self.key.as_dict(private=False)]})
        return asking().Response(200, json={"access_token": "x", "token_type": "Bearer", "id_token": self.token})

    def said(self, **other: Any) -> dict[str, Any]:
        claims = {"iss": self.told["issuer"], "aud": "mcml", "sub": "kim", "exp": int(time.time()) + 60}
        return {name: value for name, value in (claims | other).items() if value is not None}


FORGED: dict[str, dict[str, Any]] = {
    "issuer": {"iss": "https://other.example"}, "audience": {"aud": "other"}, "expired": {"exp": 1000},
    "nonce": {"nonce": "of another flow"}, "no nonce": {"nonce": None}, "no subject": {"sub": None},
    "no end": {"exp": None},
}  # fmt: skip


@one_kind
@pytest.mark.parametrize("fault", [*FORGED, "key", "none", "secret as key", "garbage", ""])
def test_only_what_the_provider_signed_for_this_flow_is_believed(
    database: Database, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    provider = Provider(monkeypatch)
    with database.write() as tx:
        tx.accounts.add("boss", "owner", "x")
    with visitor(database, "https://provider.example", openid_role="editor") as client:
        query = parse_qs(urlsplit(client.get(START).headers["location"]).query)
        assert query["code_challenge_method"] == ["S256"]
        claims = provider.said(**{"nonce": query["nonce"][0]} | FORGED.get(fault, {}))
        key = provider.other if fault == "key" else provider.key
        provider.token = jwt.encode({"alg": "RS256"}, claims, key)
        if fault in ("none", "secret as key"):
            algorithm = "none" if fault == "none" else "HS256"
            parts = [json.dumps(part).encode() for part in ({"alg": algorithm}, claims)]
            provider.token = ".".join(urlsafe_b64encode(part).rstrip(b"=").decode() for part in parts) + "."
        if fault == "garbage":
            provider.token = "not.a.token"
        answer = client.get(BACK, params={"code": "c", "state": query["state"][0]})
        assert answer.status_code == (403 if fault else 303), answer.text
        if fault:
            assert "cannot be believed" in answer.text
        assert client.get(f"{API}/account").status_code == (401 if fault else 200)


@one_kind
def test_a_provider_that_does_not_answer_is_told(database: Database) -> None:
    openid._discover.cache_clear()
    with visitor(database, "http://127.0.0.1:9") as client:
        answer = client.get(START)
        assert answer.status_code == 403
        assert "unreachable" in answer.text
    with visitor(database, "http://127.0.0.1:9", openid_issuer=None) as client:
        assert client.get(START).status_code == 404


def test_the_provider_has_an_address_that_can_be_trusted() -> None:
    with pytest.raises(ValueError, match="https"):
        Settings(openid_issuer="http://provider.example")
