"""Who may do what: accounts and roles, invitations, passwords, tokens and their scopes, against what is declared."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import text

from mcml.errors import AccessError, ConflictError
from mcml_service import passwords
from mcml_service.app import create_app
from mcml_service.operations import all_operations
from mcml_service.operations.call import Call, Repository
from mcml_service.operations.operation import RIGHTS, Operation, Right
from mcml_service.settings import Settings
from mcml_service.storage.core.views import SCOPES, View
from mcml_service.storage.database import Database
from mcml_service.storage.team.entries import ROLES
from tests.builders import SECRET, bvh, one_kind, upload

pytestmark = pytest.mark.usefixtures("quick_hashes")

API = "/api/v1"
HOME = "http://127.0.0.1:8000"
WORDS = "four words in a row"
SHORT = "too short"
FIRST_ROLE = {"member": {Right.READ}, "reader": {Right.READ}, "editor": {Right.READ, Right.EDIT}, "owner": set(Right)}
"""What each role may do, said a second time."""


def browser(database: Database, **settings: Any) -> TestClient:
    """Somebody elsewhere, without anything; as a browser they say which page sent them."""
    app = create_app(Settings(**settings), database, lambda: SECRET)
    return TestClient(app, base_url=HOME, client=("10.0.0.7", 50_000), headers={"origin": HOME})


def with_account(database: Database, name: str, role: str) -> None:
    with database.write() as tx:
        tx.accounts.add(name, role, passwords.hash_password(WORDS, name))


@pytest.fixture
def team(database: Database) -> Iterator[dict[str, TestClient]]:
    """A browser of somebody of each role, and one of nobody."""
    clients = {}
    app = create_app(Settings(), database, lambda: SECRET)
    with TestClient(app) as entered:
        for role in reversed(ROLES):
            with_account(database, role, role)
        for role in (*ROLES, "nobody"):
            client = TestClient(app, base_url=HOME, client=("10.0.0.7", 50_000), headers={"origin": HOME})
            if role != "nobody":
                answer = client.post(f"{API}/session", json={"name": role, "password": WORDS})
                assert answer.status_code == 201, answer.text
            clients[role] = client
            # Or each request would start an event loop of its own.
            client.portal = entered.portal
        yield clients


def addressed() -> list[Operation]:
    return [operation for operation in all_operations() if operation.address is not None]


def filled(operation: Operation) -> str:
    return API + re.sub(r"\{(\w+)\}", "1", operation.path)


@pytest.mark.slow
@one_kind
def test_every_operation_answers_each_role_as_is_declared(team: dict[str, TestClient]) -> None:
    """Who lacks the right gets 403 before anything else is looked at, who has it any other answer, nobody 401."""
    told = 0
    for operation in addressed():
        assert isinstance(operation.right, Right), operation.name
        if operation.name in ("change_password",):
            continue
        for role, client in team.items():
            answer = client.request(operation.method, filled(operation), json={} if operation.method != "GET" else None)
            if role == "nobody":
                assert answer.status_code == 401, (operation.name, answer.text)
            elif operation.right in FIRST_ROLE[role]:
                assert answer.status_code not in (401, 403), (operation.name, role, answer.text)
            else:
                assert answer.status_code == 403, (operation.name, role, answer.text)
                assert answer.json()["type"] == "/docs/problems#access-error"
                told += 1
    assert told > 60


@pytest.mark.parametrize("scope", SCOPES)
@one_kind
def test_no_call_passes_by_the_one_point(database: Database, scope: str) -> None:
    """Also where no HTTP is: an operation that may not be done is refused before its function is reached."""
    repository = Repository(database, Settings())
    for operation in all_operations():
        if operation.right in RIGHTS[scope]:
            operation.allow(Call(repository, "kim", View(scope)))
            continue
        with pytest.raises(AccessError, match=operation.name):
            operation.run(Call(repository, "kim", View(scope)), {})


def test_rights_are_those_that_the_roles_say() -> None:
    assert {role: set(RIGHTS[View(scope).most]) for role, scope in ROLES.items()} == FIRST_ROLE


# -- how people come to have an account --------------------------------------------------------------------------------


def form(client: TestClient, **fields: str) -> Any:
    return client.post("/login", data=fields, follow_redirects=False)


def test_the_link_of_the_terminal_makes_the_first_owner(database: Database) -> None:
    with database.write() as tx:
        link = tx.sessions.link("local")
    with browser(database) as client:
        offered = client.get("/login", params={"link": link})
        assert "first account" in offered.text
        refused = form(client, link=link, name="kim", password=SHORT)
        assert refused.status_code == 403
        assert "10 to 256 characters" in refused.text
        assert form(client, link=link, name="kim", password=WORDS).status_code == 303
        assert client.get(f"{API}/account").json() == {
            "name": "kim", "role": "owner", "scope": "operate", "rights": ["edit", "operate", "own", "read"],
            "projects": [],
        }  # fmt: skip
        files = {"file": ("walk.bvh", bvh(3))}
        document = client.post(f"{API}/documents", files=files).json()["documents"][0]["id"]
        assert client.get(f"{API}/documents/{document}/revisions").json()["items"][0]["author"] == "kim"
    with database.write() as tx:
        second = tx.sessions.link("local")
    with browser(database) as client:
        assert "first account" not in client.get("/login", params={"link": second}).text
        assert form(client, link=second, name="eve", password=WORDS).status_code == 403
        assert form(client, link=link).status_code == 403
        assert form(client, link=second).status_code == 303


def test_an_invitation_is_for_one(team: dict[str, TestClient]) -> None:
    made = team["owner"].post(f"{API}/invitations", json={"role": "reader"}).json()
    listed = team["owner"].get(f"{API}/invitations").json()["items"]
    assert [(one["role"], one["author"]) for one in listed] == [("reader", "owner")]
    assert made["code"] not in str(listed)
    new = team["nobody"]
    assert "invited" in new.get(made["path"]).text
    assert form(new, invitation=made["code"], name="owner", password=WORDS).status_code == 403
    assert form(new, invitation=made["code"], name="lee", password=WORDS).status_code == 303
    assert new.get(f"{API}/account").json()["role"] == "reader"
    assert form(new, invitation=made["code"], name="eve", password=WORDS).status_code == 403
    assert team["owner"].get(f"{API}/invitations").json()["items"] == []
    taken = team["owner"].post(f"{API}/invitations", json={}).json()
    number = team["owner"].get(f"{API}/invitations").json()["items"][0]["number"]
    assert team["owner"].delete(f"{API}/invitations/{number}").status_code == 204
    assert team["owner"].delete(f"{API}/invitations/{number}").status_code == 404
    assert form(new, invitation=taken["code"], name="eve", password=WORDS).status_code == 403


def test_an_old_invitation_opens_nothing(database: Database, team: dict[str, TestClient]) -> None:
    made = team["owner"].post(f"{API}/invitations", json={"hours": 1}).json()
    with database.write() as tx:
        tx.connection.execute(text("UPDATE invitation SET expires = '2001-01-01T00:00:00.000Z'"))
    assert form(team["nobody"], invitation=made["code"], name="lee", password=WORDS).status_code == 403


@pytest.mark.parametrize("name", ["", "  ", "local", "a\nb", "x" * 65])
@one_kind
def test_names_are_names(team: dict[str, TestClient], name: str) -> None:
    code = team["owner"].post(f"{API}/invitations", json={}).json()["code"]
    asked = {"invitation": code, "name": name, "password": WORDS}
    assert team["nobody"].post(f"{API}/session", json=asked).status_code == 422


# -- passwords ---------------------------------------------------------------------------------------------------------


def test_only_the_password_opens(team: dict[str, TestClient]) -> None:
    nobody = team["nobody"]
    for given in ({"name": "owner", "password": "wrong words in a row"}, {"name": "nobody", "password": WORDS},
                  {"name": "owner"}, {"name": "owner", "password": ""}, {}):  # fmt: skip
        answer = nobody.post(f"{API}/session", json=given)
        assert (answer.status_code, "set-cookie" in answer.headers) == (403, False), given
    answers = [
        nobody.post(f"{API}/session", json={"name": name, "password": "x" * 12}).json() for name in ("owner", "q")
    ]
    assert answers[0]["detail"] == answers[1]["detail"]


def test_a_name_that_is_not_there_is_compared_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """So it takes as long as one that is."""
    compared: list[str] = []
    real = passwords._hasher().verify
    monkeypatch.setattr(passwords._hasher(), "verify", lambda given, kept: compared.append(kept) or real(given, kept))
    assert not passwords.opens(WORDS, None)
    assert not passwords.opens("nobody has this password", None)
    assert len(compared) == 2
    assert all(kept.startswith("$argon2id$") for kept in compared)


def test_passwords_are_kept_as_hashes_alone(database: Database, team: dict[str, TestClient]) -> None:
    with database.read() as tx:
        kept = [one.password for one in tx.accounts.all()]
    assert all(one.startswith("$argon2id$") for one in kept)
    assert len(set(kept)) == len(kept)


def test_a_new_password_ends_all_sessions(team: dict[str, TestClient], database: Database) -> None:
    editor = team["editor"]
    wrong = editor.put(f"{API}/account/password", json={"current": "no", "new": "five other words in a row"})
    assert wrong.status_code == 403
    short = editor.put(f"{API}/account/password", json={"current": WORDS, "new": SHORT})
    assert short.status_code == 422
    changed = editor.put(f"{API}/account/password", json={"current": WORDS, "new": "five other words in a row"})
    assert changed.status_code == 204
    assert editor.get(f"{API}/account").status_code == 401
    assert editor.post(f"{API}/session", json={"name": "editor", "password": WORDS}).status_code == 403
    asked = {"name": "editor", "password": "five other words in a row"}
    assert editor.post(f"{API}/session", json=asked).status_code == 201


def test_a_session_is_another_one_after_a_login(team: dict[str, TestClient]) -> None:
    """What a browser brought with it opens nothing (session fixation)."""
    nobody = team["nobody"]
    nobody.cookies.set("mcml_session", "fixed")
    nobody.post(f"{API}/session", json={"name": "reader", "password": WORDS})
    assert "fixed" not in [cookie.value for cookie in nobody.cookies.jar if cookie.domain != ""]
    other = TestClient(nobody.app, base_url=HOME, client=("10.0.0.7", 1), cookies={"mcml_session": "fixed"})
    assert other.get(f"{API}/account").status_code == 401


@pytest.mark.parametrize("origin", [None, "https://elsewhere.example", "null"])
@one_kind
def test_other_pages_write_nothing_with_a_session(team: dict[str, TestClient], origin: str | None) -> None:
    owner = team["owner"]
    del owner.headers["origin"]
    headers = {} if origin is None else {"origin": origin}
    assert owner.post(f"{API}/invitations", json={}, headers=headers).status_code == 403


# -- roles that change -------------------------------------------------------------------------------------------------


def test_another_role_holds_at_once(team: dict[str, TestClient]) -> None:
    owner, reader = team["owner"], team["reader"]
    files = {"file": ("walk.bvh", bvh(3))}
    assert reader.post(f"{API}/documents", files=files).status_code == 403
    assert owner.patch(f"{API}/accounts/reader", json={"role": "editor"}).json()["role"] == "editor"
    assert reader.post(f"{API}/documents", files=files).status_code == 201
    assert owner.patch(f"{API}/accounts/nobody", json={"role": "editor"}).status_code == 404
    roles = {one["name"]: one["role"] for one in owner.get(f"{API}/accounts").json()["items"]}
    assert roles == {"member": "member", "reader": "editor", "editor": "editor", "owner": "owner"}


def test_there_is_always_an_owner(team: dict[str, TestClient], database: Database) -> None:
    owner = team["owner"]
    for change in ({"role": "editor"}, {"closed": True}):
        assert owner.patch(f"{API}/accounts/owner", json=change).status_code == 409
    owner.patch(f"{API}/accounts/editor", json={"role": "owner"})
    assert owner.patch(f"{API}/accounts/owner", json={"closed": True}).status_code == 200
    assert owner.get(f"{API}/account").status_code == 401
    with pytest.raises(ConflictError), database.write() as tx:
        tx.accounts.change("editor", closed="2026-01-01T00:00:00.000Z")


def test_a_closed_account_opens_nothing(team: dict[str, TestClient]) -> None:
    editor, owner = team["editor"], team["owner"]
    token = editor.post(f"{API}/tokens", json={"name": "script", "scope": "edit"}).json()["token"]
    bearer = {"authorization": f"Bearer {token}"}
    other = team["nobody"]
    assert other.get(f"{API}/account", headers=bearer).json()["name"] == "editor"
    owner.patch(f"{API}/accounts/editor", json={"closed": True})
    assert editor.get(f"{API}/account").status_code == 401
    assert other.get(f"{API}/account", headers=bearer).status_code == 401
    assert other.post(f"{API}/session", json={"token": token}).status_code == 403
    assert other.post(f"{API}/session", json={"name": "editor", "password": WORDS}).status_code == 403
    owner.patch(f"{API}/accounts/editor", json={"closed": False})
    assert editor.get(f"{API}/account").status_code == 401, "sessions of before stay ended"
    assert other.get(f"{API}/account", headers=bearer).status_code == 200


# -- tokens ------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_token_may_do_no_more_than_its_scope_and_its_account(team: dict[str, TestClient]) -> None:
    editor, owner, other = team["editor"], team["owner"], team["nobody"]
    assert editor.post(f"{API}/tokens", json={"name": "all", "scope": "operate"}).status_code == 403
    reading = editor.post(f"{API}/tokens", json={"name": "reads", "scope": "read"}).json()["token"]
    writing = editor.post(f"{API}/tokens", json={"name": "writes", "scope": "edit"}).json()["token"]
    files = {"file": ("walk.bvh", bvh(3))}

    def status(token: str) -> int:
        return other.post(f"{API}/documents", files=files, headers={"authorization": f"Bearer {token}"}).status_code

    assert (status(reading), status(writing)) == (403, 201)
    owner.patch(f"{API}/accounts/editor", json={"role": "reader"})
    assert (status(reading), status(writing)) == (403, 403)
    session = other.post(f"{API}/session", json={"token": writing})
    assert session.json()["author"] == "editor"
    assert other.post(f"{API}/documents", files=files).status_code == 403


def test_tokens_are_seen_and_ended_by_their_owners(team: dict[str, TestClient], database: Database) -> None:
    for role in ("reader", "editor"):
        assert team[role].post(f"{API}/tokens", json={"name": f"of-{role}"}).status_code == 201
    with database.write() as tx:
        tx.tokens.add("nobody's")

    def names(role: str) -> list[str]:
        return [one["name"] for one in team[role].get(f"{API}/tokens").json()["items"]]

    assert names("reader") == ["of-reader"]
    assert sorted(names("owner")) == ["nobody's", "of-editor", "of-reader"]
    assert team["reader"].delete(f"{API}/tokens/of-editor").status_code == 404
    assert team["reader"].delete(f"{API}/tokens/nobody's").status_code == 404
    assert team["owner"].delete(f"{API}/tokens/of-editor").status_code == 204
    assert team["editor"].post(f"{API}/tokens", json={"name": "of-reader"}).status_code == 409
    assert team["editor"].post(f"{API}/tokens", json={"name": "reader"}).status_code == 409


def test_it_is_told_when_a_token_was_used(team: dict[str, TestClient], database: Database) -> None:
    token = team["editor"].post(f"{API}/tokens", json={"name": "script"}).json()["token"]

    def used() -> Any:
        (one,) = team["editor"].get(f"{API}/tokens").json()["items"]
        return one["used"]

    assert used() is None
    assert team["nobody"].get(f"{API}/account", headers={"authorization": f"Bearer {token}"}).status_code == 200
    first = used()
    assert first is not None
    team["nobody"].get(f"{API}/account", headers={"authorization": f"Bearer {token}"})
    assert used() == first, "once an hour is enough"
    with database.write() as tx:
        tx.connection.execute(text("UPDATE token_grant SET used = '2001-01-01T00:00:00.000Z'"))
    team["nobody"].get(f"{API}/account", headers={"authorization": f"Bearer {token}"})
    assert used() >= first


def test_a_scope_that_no_one_gave_opens_nothing(database: Database) -> None:
    with database.write() as tx:
        secret = tx.tokens.add("lab")
        tx.connection.execute(text("UPDATE token_grant SET scope = 'everything'"))
    with database.read() as tx:
        assert tx.tokens.entry(secret) is None


@one_kind
def test_one_person_on_one_machine_needs_no_account(database: Database) -> None:
    app = create_app(Settings(host="127.0.0.1"), database, lambda: SECRET)
    with TestClient(app, base_url=HOME, client=("127.0.0.1", 50_000)) as client:
        assert client.get(f"{API}/account").json()["name"] == "local"
        upload(client, {"walk.bvh": bvh(3)})
        with_account(database, "kim", "owner")
        assert client.get(f"{API}/account").status_code == 401
