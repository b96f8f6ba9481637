"""The first account is an owner's, and nothing closes a repository before there is one."""

from __future__ import annotations

from datetime import timedelta
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import text

from mcml.errors import ConflictError
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.team.entries import ROLES
from tests.api.test_accounts import API, HOME, SHORT, WORDS, browser, form, team
from tests.builders import SECRET, one_kind, served

pytestmark = pytest.mark.usefixtures("quick_hashes")

__all__ = ["team"]


def keeper(database: Database) -> TestClient:
    """Somebody at the server's own machine, without anything, as a browser there."""
    app = create_app(Settings(host="127.0.0.1", login="auto"), database, lambda: SECRET)
    return TestClient(app, base_url=HOME, client=("127.0.0.1", 50_000), headers={"origin": HOME})


def kept(database: Database) -> dict[str, str]:
    with database.read() as tx:
        return {one.name: one.role for one in tx.accounts.all()}


FIRST_STEPS = [
    *(("/invitations", {"role": role}) for role in ROLES),
    ("/invitations", {"role": "owner", "project": "dance"}),
    *(("/tokens", {"name": "farm", "scope": scope}) for scope in ("read", "edit", "operate")),
]


@pytest.mark.parametrize(("path", "asked"), FIRST_STEPS)
@one_kind
def test_nothing_closes_a_repository_before_it_has_an_owner(
    database: Database, path: str, asked: dict[str, Any]
) -> None:
    with database.write() as tx:
        tx.projects.get_or_add("dance")
    with served(database) as client:
        refused = client.post(f"{API}{path}", json=asked)
        assert refused.status_code == 409, refused.text
        assert "your own account first" in refused.json()["remedy"]
        assert client.get(f"{API}/account").status_code == 200
        made = client.post(f"{API}/accounts", json={"name": "kim", "password": WORDS})
        assert (made.status_code, made.json()["role"]) == (201, "owner")
        assert client.post(f"{API}{path}", json=asked).status_code == 201


@pytest.mark.parametrize("role", ["member", "reader", "editor"])
def test_the_first_account_is_an_owners_whoever_makes_it(database: Database, role: str) -> None:
    with pytest.raises(ConflictError, match="no owner's account"), database.write() as tx:
        tx.accounts.add("lee", role, "x")
    assert kept(database) == {}


@one_kind
def test_an_invitation_of_before_opens_nothing_without_an_owner(database: Database) -> None:
    """As of a store that was invited into before this rule."""
    with database.write() as tx:
        tx.accounts.add("kim", "owner", "x")
        code = tx.accounts.invite("editor", "kim", timedelta(hours=1))
        tx.connection.execute(text("DELETE FROM account"))
    with browser(database) as client:
        refused = form(client, invitation=code, name="lee", password=WORDS)
        assert (refused.status_code, "your own account first" in refused.text) == (403, True)
    assert kept(database) == {}


@one_kind
def test_there_is_one_first_owner(team: dict[str, TestClient]) -> None:
    asked = {"name": "second", "password": WORDS}
    assert team["owner"].post(f"{API}/accounts", json=asked).status_code == 409
    assert team["editor"].post(f"{API}/accounts", json=asked).status_code == 403
    assert team["nobody"].post(f"{API}/accounts", json=asked).status_code == 401


@one_kind
@pytest.mark.parametrize("asked", [{"name": "kim", "password": SHORT}, {"name": "local", "password": WORDS}])
def test_the_first_account_has_a_name_and_a_password(database: Database, asked: dict[str, str]) -> None:
    with served(database) as client:
        assert client.post(f"{API}/accounts", json=asked).status_code == 422
    assert kept(database) == {}


@one_kind
def test_a_browser_at_the_machine_makes_the_first_account(database: Database) -> None:
    with keeper(database) as client:
        assert client.post(f"{API}/invitations", json={}).status_code == 409
        asked = {"name": "kim", "password": WORDS}
        foreign = client.post(f"{API}/accounts", json=asked, headers={"origin": "https://elsewhere.example"})
        assert foreign.status_code == 403
        assert client.post(f"{API}/accounts", json=asked).status_code == 201
        assert client.get(f"{API}/account").status_code == 401
        assert client.post(f"{API}/session", json=asked).status_code == 201
        assert client.get(f"{API}/account").json()["role"] == "owner"
        assert client.post(f"{API}/invitations", json={}).status_code == 201


def test_a_store_that_lost_its_owner_gets_one_by_the_link_of_the_terminal(database: Database) -> None:
    """Stores whose only account is a guest's were possible before."""
    with database.write() as tx:
        tx.accounts.add("lee", "owner", "x")
        tx.connection.execute(text("UPDATE account SET role = 'editor'"))
        link = tx.sessions.link("local")
    with browser(database) as client:
        assert "first account" in client.get("/login", params={"link": link}).text
        assert form(client, link=link, name="kim", password=WORDS).status_code == 303
    assert kept(database) == {"kim": "owner", "lee": "editor"}
