"""Every operation, asked by people with every role in a project about that project and about one that they do not see:
the declared answers, no word of what they may not see, and nothing changed that they may not change."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import func, select

from mcml_service.app import create_app
from mcml_service.jobs.runner import Runner
from mcml_service.operations import all_operations
from mcml_service.operations.operation import Effect, Operation, Right
from mcml_service.settings import Settings
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.database import Database
from mcml_service.storage.team.entries import PROJECT_ROLES
from tests.api.asked import API, Things, commented, filled, labelled, propose, request_of, send
from tests.builders import SECRET, one_kind
from tests.motion.bodies.made import person

CANARY = "quokka"
"""A word of everything in the project that is not seen."""

ROLES: dict[str, frozenset[Right]] = {
    "stranger": frozenset(),
    "reader": frozenset({Right.READ}),
    "editor": frozenset({Right.READ, Right.EDIT}),
    "owner": frozenset({Right.READ, Right.EDIT, Right.OWN}),
}
"""What each may do in the project that they belong to, said a second time."""


@pytest.fixture
def team(database: Database, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[dict[str, TestClient], Things, Things]]:
    """A client of each, and what "mine", where they have roles, and "theirs", where they have none, hold."""
    # Jobs that are asked for wait: what they would write is no matter of who asks.
    monkeypatch.setattr(Runner, "_take", lambda runner: None)
    app = create_app(Settings(import_processes=1), database, lambda: SECRET)
    keeper = TestClient(app, client=("127.0.0.1", 1), headers={"authorization": f"Bearer {SECRET}"})
    with keeper:
        mine, theirs = (filled(keeper, database, *each) for each in (("mine", "wombat"), ("theirs", CANARY)))
        clients = {"keeper": keeper}
        with database.write() as tx:
            boss = tx.accounts.add("boss", "owner", "x")
            for role in ROLES:
                somebody = tx.accounts.add(role, "member", "x")
                if role in PROJECT_ROLES:
                    tx.members.put(tx.projects.get("mine"), role, role)
                secret = tx.tokens.add(f"of {role}", owner=somebody)
                clients[role] = TestClient(app, client=("10.0.0.7", 1), headers={"authorization": f"Bearer {secret}"})
            secret = tx.tokens.add("limited", owner=boss, projects=[tx.projects.get("mine")])
            clients["limited"] = TestClient(app, client=("10.0.0.7", 1), headers={"authorization": f"Bearer {secret}"})
        for client in clients.values():
            # Or each request would start an event loop of its own.
            client.portal = keeper.portal
        yield clients, mine, theirs


OWN = {
    "revoke_share",
    "list_shares",
    "inspect_files",
    "get_analysis",
    "read_music",
    "get_account",
    "change_password",
    "add_token",
    "revoke_token",
}
"""Operations that ask nothing of any project."""

UNFIT = {
    "start_",
    "use_",
    "get_result_picture",
    "cancel_job",
    "apply_names",
    "undo_revision",
    "suggest_labels",
    "get_analog",
    "get_standing_trial",
    "follow_path",
    "make_skeletons",
    "get_matching_library",
}
"""Those whose example cannot be done even by who may: short clips, a result without a model."""


def state(database: Database) -> dict[str, int]:
    """How many rows there are of everything but what reading keeps."""
    kept = ("thumbnail", "request", "session", "body", "token_grant", "attempt", "presence")
    with database.read() as tx:
        return {
            table.name: tx.connection.execute(select(func.count()).select_from(table)).scalar_one()
            for table in metadata.sorted_tables
            if table.name not in kept
        }


def addressed() -> list[Operation]:
    found = [operation for operation in all_operations() if operation.address is not None]
    # What takes away comes last, and the document last of all.
    return sorted(
        found, key=lambda one: (one.method == "DELETE") + 2 * (one.name in ("delete_documents", "delete_document"))
    )


def test_every_operation_is_asked() -> None:
    things = Things("mine", ["a", "b", "c"], "d", "e", 1, 1, 1)
    for operation in addressed():
        known = request_of(operation, things, "w") is not None
        assert known or operation.name in OWN or operation.right in (Right.OPERATE, Right.OWN), operation.name


@pytest.mark.slow
@one_kind
def test_what_is_not_seen_is_not_there(team: tuple[dict[str, TestClient], Things, Things], database: Database) -> None:
    """Whoever has no role in a project learns nothing of it and changes nothing there, whatever they may elsewhere."""
    clients, _, theirs = team
    before = state(database)
    told = 0
    for operation in addressed():
        asked = request_of(operation, theirs, CANARY)
        for role in (*ROLES, "limited"):
            if asked is None or (role == "limited" and operation.right is Right.OPERATE):
                continue
            answer = send(clients[role], operation, asked)
            said = (operation.name, role, answer.status_code, answer.text[:300])
            allowed = operation.right in (ROLES[role] if role != "limited" else ROLES["owner"]) | {Right.READ}
            if not allowed:
                assert answer.status_code == 403, said
            elif asked.kind == "all":
                assert answer.status_code == 200, said
            elif operation.name in ("get_aliases", "get_colours", "get_vocabulary"):
                # As of a project that does not exist yet.
                assert answer.status_code == 200, said
            elif asked.kind == "named":
                assert answer.status_code in (403, 404), said
            elif "content" in asked.content and operation.path in ("/properties", "/labels"):
                # A line of a table.
                assert answer.status_code == 422, said
            else:
                assert answer.status_code == 404, said
            echoed = str(asked.path) + str(asked.query) + str(asked.content)
            if CANARY not in echoed:
                assert CANARY not in answer.text.lower(), said
            for number, uuid in enumerate(theirs.stored):
                assert uuid in echoed or uuid not in answer.text, (number, said)
            told += 1
    assert told > 400
    assert state(database) == before


@pytest.mark.slow
@one_kind
def test_each_role_may_in_its_project_what_is_declared(
    team: tuple[dict[str, TestClient], Things, Things], database: Database
) -> None:
    """Who may not is told so and changes nothing; the same request of who may is done."""
    clients, mine, _ = team
    roles: dict[str, frozenset[Right]] = ROLES | {"limited": ROLES["owner"]}
    done = 0
    for operation in addressed():
        if "{label}" in operation.path:
            # Edits give labels other numbers.
            mine = replace(mine, label=labelled(clients["keeper"], mine.id, f"of {operation.name}"))
        asked = request_of(operation, mine, "wombat")
        if asked is None or operation.name == "get_result_picture":
            # There is nothing to draw.
            continue
        before = state(database)
        for role, rights in roles.items():
            if role != "stranger" and operation.right not in rights:
                answer = send(clients[role], operation, asked)
                assert answer.status_code == 403, (operation.name, role, answer.text[:300])
        assert state(database) == before, operation.name
        # What reads is asked by all who may, what writes by the least of them.
        may = [role for role, rights in roles.items() if operation.right in rights]
        for role in may if operation.right is Right.READ else may[:1]:
            if "{comment}" in operation.path and role != "stranger":
                # What one's own comments may become; `tests/operations/test_comments.py` has those of others.
                mine = replace(mine, comment=commented(clients[role], mine.id, "mine"))
                asked = request_of(operation, mine, "wombat") or asked
            if "{proposal}" in operation.path and operation.effect is Effect.WRITES:
                # An applied or closed one is applied no more; `tests/operations/test_proposals.py` has those of others.
                mine = replace(mine, proposal=propose(clients[role], mine.id, "mine"))
                asked = request_of(operation, mine, "wombat") or asked
            answer = send(clients[role], operation, asked)
            unfit = any(operation.name.startswith(word) for word in UNFIT)
            assert unfit or answer.status_code < 300, (operation.name, role, answer.status_code, answer.text[:500])
            assert answer.status_code not in (401, 403, 500), (operation.name, role, answer.text[:300])
            done += answer.status_code < 300
    assert done > 120


@pytest.mark.slow
@one_kind
def test_a_document_is_seen_where_it_is_now(
    team: tuple[dict[str, TestClient], Things, Things], database: Database
) -> None:
    """Also at revisions that it had elsewhere; and who may not write to where it goes moves nothing there."""
    clients, mine, theirs = team
    one, headers = mine.id, {"if-match": "*"}
    moved = clients["editor"].patch(f"{API}/documents/{one}", json={"project": "theirs"}, headers=headers)
    assert moved.status_code == 403
    fresh = clients["editor"].patch(f"{API}/documents/{one}", json={"project": "elsewhere"}, headers=headers)
    assert fresh.status_code == 403
    assert (
        clients["keeper"].patch(f"{API}/documents/{one}", json={"project": "theirs"}, headers=headers).status_code
        == 200
    )
    for path in (f"documents/{one}", f"documents/{one}/revisions", f"documents/{one}/frames?revision=1"):
        assert clients["reader"].get(f"{API}/{path}").status_code == 404, path
    past = {"q": "count(//frame)", "document": [one], "revision": 1}
    assert clients["reader"].post(f"{API}/xpath", json=past).status_code == 404
    back = clients["keeper"].patch(f"{API}/documents/{theirs.id}", json={"project": "mine"}, headers=headers)
    assert back.status_code == 200
    assert clients["reader"].get(f"{API}/documents/{theirs.id}/frames?revision=1").status_code == 200


@pytest.mark.slow
@pytest.mark.parametrize("role", ["stranger", "reader", "limited"])
def test_questions_see_the_same_documents_as_lists(
    team: tuple[dict[str, TestClient], Things, Things], role: str
) -> None:
    """Of XPath on columns, on XML and by Saxon, in pages, and of lists from the store and from columns."""
    clients, mine, _ = team
    client = clients[role]
    wanted = set() if role == "stranger" else set(mine.stored[:2])
    for _ in range(3):
        listed: Any = client.get(f"{API}/documents", params={"limit": 1000}).json()
        assert {item["id"] for item in listed["items"]} == wanted
        assert listed["total"] == len(wanted)
        facets = client.get(f"{API}/facets").json()
        assert facets["total"] == len(wanted)
    for expression in (
        "/mcml",
        "//frame[1]",
        "//motion_name/..",
        "for $d in /mcml return $d",
        "//frame[motion_name]/..",
    ):
        answer = client.get(f"{API}/xpath", params={"q": expression, "limit": 1000})
        assert answer.status_code == 200, answer.text
        found = {item["document"] for item in answer.json()["items"]}
        assert found <= wanted, expression
        assert found == wanted or "motion_name" in expression, expression
    counted = client.get(f"{API}/xpath", params={"q": "count(//frame)"}).json()
    everywhere = clients["keeper"].get(f"{API}/xpath", params={"q": "count(//frame)"}).json()
    assert counted["value"] == 6 * len(wanted)
    assert everywhere["value"] == 24
    first = client.get(f"{API}/xpath", params={"q": "/mcml", "limit": 1}).json()
    if wanted:
        second = client.get(f"{API}/xpath", params={"q": "/mcml", "limit": 5, "cursor": first["next_cursor"]}).json()
        assert {item["document"] for item in [*first["items"], *second["items"]]} == wanted
    with_xpath = client.get(f"{API}/documents", params={"xpath": "//frame"}).json()
    assert {item["id"] for item in with_xpath["items"]} == wanted


@one_kind
def test_events_are_of_what_is_seen(team: tuple[dict[str, TestClient], Things, Things]) -> None:
    clients, mine, theirs = team
    since = {"since": "0@2000-01-01T00:00:00.000Z", "seconds": 0.1}
    heard = {role: clients[role].get(f"{API}/events", params=since).text for role in ("stranger", "reader", "keeper")}
    assert mine.id in heard["keeper"]
    assert theirs.id in heard["keeper"]
    assert mine.id in heard["reader"]
    for role in ("stranger", "reader"):
        assert CANARY not in heard[role]
        assert theirs.id not in heard[role]
        assert theirs.job not in heard[role]
    assert clients["reader"].get(f"{API}/jobs/{theirs.job}/events").status_code == 404


@one_kind
def test_a_token_of_some_projects_makes_none_of_more(team: tuple[dict[str, TestClient], Things, Things]) -> None:
    clients, _, theirs = team
    limited = clients["limited"]
    assert limited.get(f"{API}/account").json()["scope"] == "own"
    assert limited.post(f"{API}/tokens", json={"name": "more", "scope": "operate"}).status_code == 403
    assert limited.post(f"{API}/tokens", json={"name": "there", "projects": ["theirs"]}).status_code == 404
    secret = limited.post(f"{API}/tokens", json={"name": "same", "scope": "edit"}).json()["token"]
    made = TestClient(limited.app, client=("10.0.0.7", 1), headers={"authorization": f"Bearer {secret}"})
    assert made.get(f"{API}/projects").json()["items"] == ["mine"]
    assert made.get(f"{API}/documents/{theirs.id}").status_code == 404
    assert made.get(f"{API}/account").json()["projects"] == [{"project": "mine", "role": "editor"}]


@one_kind
def test_owners_of_a_project_let_people_in(team: tuple[dict[str, TestClient], Things, Things]) -> None:
    clients, mine, theirs = team
    owner, stranger = clients["owner"], clients["stranger"]
    assert stranger.get(f"{API}/documents/{mine.id}").status_code == 404
    set_ = owner.put(f"{API}/members/stranger", params={"project": "mine"}, json={"role": "reader"})
    assert {"name": "stranger", "role": "reader", "everywhere": False} in set_.json()["items"]
    assert {"name": "boss", "role": "owner", "everywhere": True} in set_.json()["items"]
    assert stranger.get(f"{API}/documents/{mine.id}").status_code == 200
    assert owner.put(f"{API}/members/nobody", params={"project": "mine"}, json={"role": "reader"}).status_code == 404
    assert owner.put(f"{API}/members/owner", params={"project": "theirs"}, json={"role": "owner"}).status_code == 404
    assert owner.delete(f"{API}/members/stranger", params={"project": "mine"}).status_code == 204
    assert stranger.get(f"{API}/documents/{mine.id}").status_code == 404
    assert owner.delete(f"{API}/members/boss", params={"project": "mine"}).status_code == 404
    assert owner.post(f"{API}/invitations", json={"role": "editor"}).status_code == 403
    made = owner.post(f"{API}/invitations", json={"role": "editor", "project": "mine"}).json()
    assert [one["project"] for one in owner.get(f"{API}/invitations").json()["items"]] == ["mine"]
    joined = {"invitation": made["code"], "name": "newcomer", "password": "four words in a row"}
    browser = TestClient(owner.app, client=("10.0.0.8", 1), headers={"origin": "http://testserver"})
    assert browser.post(f"{API}/session", json=joined).status_code == 201
    me = browser.get(f"{API}/account").json()
    assert (me["role"], me["projects"]) == ("member", [{"project": "mine", "role": "editor"}])
    files = {"file": ("new.bvh", io.BytesIO(person(7, 4)))}
    assert browser.post(f"{API}/documents", files=files, data={"project": "mine"}).status_code == 201
    assert browser.get(f"{API}/documents/{theirs.id}").status_code == 404
