"""Proposed changes: a viewer proposes, others review, and an applied proposal is the direct edit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import orjson
import pytest
from fastapi.testclient import TestClient
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import select, text

from mcml_service.actions.keeping.purge_documents import purge_documents
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.core.seals import SEALS, Seal
from mcml_service.storage.database import Database
from mcml_service.storage.team.proposals import MOST_ENDED, MOST_OPEN
from mcml_service.storage.work.tables import comment
from tests.builders import SECRET, bvh, one_kind, store
from tests.operations.proposing import API, FRAMES, NAMED, SMOOTH, do, mcml, propose


@pytest.fixture
def uuid(database: Database) -> str:
    return store(database, {"walk.bvh": bvh(FRAMES)}, project="gait")[0]


@pytest.fixture
def people(database: Database, uuid: str) -> Iterator[dict[str, TestClient]]:
    """A client of each role in the project, and of another editor."""
    app = create_app(Settings(import_processes=1), database, lambda: SECRET)
    with database.write() as tx:
        tx.accounts.add("keeper", "owner", "x")
        secrets = {}
        for name, role in (("rea", "reader"), ("ed", "editor"), ("edna", "editor"), ("own", "owner")):
            somebody = tx.accounts.add(name, "member", "x")
            tx.members.put(tx.projects.get("gait"), name, role)
            secrets[name] = tx.tokens.add(f"of {name}", owner=somebody)
    with TestClient(app, client=("10.0.0.7", 1)) as first:
        clients = {
            name: TestClient(app, client=("10.0.0.7", 1), headers={"authorization": f"Bearer {secret}"})
            for name, secret in secrets.items()
        }
        for client in clients.values():
            client.portal = first.portal
        yield clients


def require_review(client: TestClient, wanted: bool = True) -> None:
    answer = client.patch(f"{API}/project", params={"project": "gait"}, json={"review_required": wanted})
    assert answer.json()["review_required"] is wanted


def test_a_proposal_is_reviewed_and_applied(client: TestClient, uuid: str) -> None:
    before = mcml(client, uuid)
    made = propose(client, uuid, {"edits": SMOOTH["edits"] | {"message": "calmer"}})
    kept = {name: made[name] for name in ("number", "state", "kind", "summary", "message", "revision", "outdated")}
    assert kept == {
        "number": 1, "state": "open", "kind": "frames", "summary": "smooth 5-30", "message": "calmer", "revision": 1,
        "outdated": False,
    }  # fmt: skip
    assert mcml(client, uuid) == before
    detail = client.get(f"{API}/documents/{uuid}/proposals/1").json()
    assert [edit["do"] for edit in detail["edits"]["edits"]] == ["smooth"]
    note = {"text": "the foot?", "first": 7, "bone": "Head", "proposal": 1}
    assert client.post(f"{API}/documents/{uuid}/comments", json=note).json()["proposal"] == 1
    client.post(f"{API}/documents/{uuid}/comments", json={"text": "about the clip"})
    assert client.post(f"{API}/documents/{uuid}/comments", json=note | {"proposal": 2}).status_code == 404
    listed = client.get(f"{API}/documents/{uuid}/comments", params={"proposal": 1}).json()["items"]
    assert [item["text"] for item in listed] == ["the foot?"]
    assert do(client, uuid, 1, "approve", revision=1).json()["state"] == "approved"
    applied = do(client, uuid, 1, "apply").json()
    assert (applied["state"], applied["applied"], applied["comments"]) == ("applied", 2, 1)
    history = client.get(f"{API}/documents/{uuid}/revisions").json()["items"]
    assert history[0]["message"] == "calmer (proposal 1 by admin, approved by admin)".replace("admin", made["author"])
    for what in ("apply", "approve", "close", "rebase"):
        assert do(client, uuid, 1, what).status_code == 409
    assert client.get(f"{API}/documents/{uuid}/proposals/1/preview").status_code == 409
    assert client.post(f"{API}/documents/{uuid}/undo", headers={"if-match": "*"}).status_code == 200
    assert mcml(client, uuid) == before
    assert client.get(f"{API}/documents/{uuid}/proposals", params={"state": "open"}).json()["items"] == []


RANGES = st.tuples(st.integers(1, 20), st.integers(0, 19)).map(lambda two: {"first": two[0], "last": two[0] + two[1]})
EDITS = st.lists(
    st.one_of(
        RANGES.map(lambda at: {"do": "delete", "first": at["first"], "last": at["first"]}),
        RANGES.map(lambda at: {"do": "reverse"} | at),
        RANGES.map(lambda at: {"do": "smooth", "ease": 2} | at),
        RANGES.map(lambda at: {"do": "insert", "at": 4} | at),
        RANGES.map(lambda at: {"do": "move", "to": 1} | at),
        RANGES.map(lambda at: {"do": "speed", "factors": [2]} | at),
        st.just({"do": "resample", "rate": 60}),
    ),
    min_size=1,
    max_size=4,
).map(lambda edits: {"edits": {"edits": edits}})
VALUES = st.lists(st.floats(-90, 90), min_size=1, max_size=5).map(
    lambda values: {"frames": [{"first": 8, "columns": ["Root.Rx"], "values": [[value] for value in values]}]}
)
ELEMENTS = st.sampled_from(
    [
        {"elements": [{"do": "change", "xpath": "//frame[3]/frame_bone[1]", "attributes": {"Rx": "12.5"}}]},
        {"elements": [{"do": "delete", "xpath": "//frame[6]"}], "document": {"description": "two"}},
        {"labels": [{"name": "hop", "first": 1, "last": 4}], "document": {"unit": "cm"}},
    ]
)
CHANGES = st.one_of(VALUES, ELEMENTS).map(lambda changes: {"changes": changes})


@pytest.mark.slow
@one_kind
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(request=st.one_of(EDITS, CHANGES), applied=st.booleans())
def test_an_applied_proposal_is_the_direct_edit(
    client: TestClient, database: Database, request: dict[str, Any], applied: bool
) -> None:
    """A closed one is none, a preview changes nothing and foretells the frames, and what cannot be made is refused."""
    one, other = (store(database, {"walk.bvh": bvh(FRAMES)}, project=name)[0] for name in ("gait", "lab"))
    before = mcml(client, other)
    kind, body = next(iter(request.items()))
    path = "frames" if kind == "edits" else "changes"
    direct = client.post(f"{API}/documents/{one}/{path}", json=body, headers={"if-match": "*"})
    proposed = client.post(f"{API}/documents/{other}/proposals", json=request, headers={"if-match": "*"})
    if direct.status_code != 200 or direct.json()["revision"] == 1:
        assert proposed.status_code == (direct.status_code if direct.status_code != 200 else 422), proposed.text
        return
    assert proposed.status_code == 201, proposed.text
    positions = {"positions": "f4"}
    preview = client.get(f"{API}/documents/{other}/proposals/1/preview", params=positions).json()
    assert preview["frames"] == direct.json()["frames"] == preview["motion"]["shape"][0]
    for run in preview["kept"]:
        assert 1 <= run["before"] <= run["before"] + run["count"] - 1 <= FRAMES
        assert 1 <= run["after"] <= run["after"] + run["count"] - 1 <= preview["frames"]
    assert mcml(client, other) == before
    if not applied:
        assert do(client, other, 1, "close").json()["state"] == "closed"
        assert mcml(client, other) == before
        return
    assert do(client, other, 1, "apply").json()["applied"] == 2
    assert mcml(client, other) == mcml(client, one)
    assert database.check(past=True) == []


@one_kind
@pytest.mark.parametrize(
    ("edits", "kept"),
    [
        ([{"do": "keep", "first": 11, "last": 30}], [(11, 1, 20)]),
        ([{"do": "smooth", "first": 5, "last": 30}], [(1, 1, 40)]),
        ([{"do": "delete", "first": 1, "last": 10}, {"do": "smooth", "first": 1, "last": 30}], [(11, 1, 30)]),
        ([{"do": "insert", "first": 1, "last": 3, "at": 21}], [(1, 1, 20), (21, 24, 20)]),
        ([{"do": "speed", "first": 11, "last": 30, "factors": [2]}], [(1, 1, 10), (31, 21, 10)]),
        ([{"do": "move", "first": 1, "last": 10, "to": 41}], [(11, 1, 30)]),
        ([{"do": "resample", "rate": 10}], []),
    ],
)
def test_a_preview_tells_which_frames_are_kept(
    client: TestClient, uuid: str, edits: list[dict[str, Any]], kept: list[tuple[int, int, int]]
) -> None:
    answer = client.post(
        f"{API}/documents/{uuid}/proposals/preview", json={"edits": {"edits": edits}}, headers={"if-match": "*"}
    )
    assert answer.status_code == 200, answer.text
    assert [(run["before"], run["after"], run["count"]) for run in answer.json()["kept"]] == kept


@pytest.mark.slow
@one_kind
def test_who_may_do_what(people: dict[str, TestClient], uuid: str) -> None:
    """Said a second time: all propose, preview and list; editors approve and apply; authors and editors close."""
    for name, client in people.items():
        for author, other in people.items():
            number = propose(other, uuid)["number"]
            assert client.get(f"{API}/documents/{uuid}/proposals/{number}/preview").status_code == 200
            edits = name != "rea"
            for what, may in (
                ("approve", edits),
                ("rebase", edits or name == author),
                ("close", edits or name == author),
            ):
                answer = do(client, uuid, number, what)
                assert (answer.status_code == 200) == may, (name, author, what, answer.text)
                assert may or answer.status_code == 403
            do(other, uuid, number, "close")
    number = propose(people["rea"], uuid)["number"]
    assert do(people["rea"], uuid, number, "apply").status_code == 403
    assert do(people["ed"], uuid, number, "apply").json()["applied"] == 2
    assert people["rea"].post(f"{API}/documents/{uuid}/frames", json=SMOOTH["edits"], headers={"if-match": "*"},
                              params={"dry_run": True}).status_code == 403  # fmt: skip


def test_a_project_that_requires_review(people: dict[str, TestClient], uuid: str) -> None:
    ed, edna, own = people["ed"], people["edna"], people["own"]
    assert ed.patch(f"{API}/project", params={"project": "gait"}, json={"review_required": True}).status_code == 403
    require_review(own)
    before, match = mcml(ed, uuid), {"if-match": "*"}
    path = f"{API}/documents/{uuid}"
    for client in (ed, own):
        for refused in (
            client.post(f"{path}/frames", json=SMOOTH["edits"], headers=match),
            client.post(f"{path}/changes", json=NAMED["changes"], headers=match),
            client.post(f"{path}/labels", json=[{"name": "hop", "first": 1, "last": 2}], headers=match),
            client.patch(path, json={"name": "run"}, headers=match),
            client.put(f"{path}/file", files={"file": ("walk.bvh", bvh(FRAMES + 1))}, headers=match),
        ):
            assert refused.status_code == 409, refused.text
            assert (refused.json()["code"], "proposals" in refused.json()["remedy"]) == ("review-required", True)
    assert ed.delete(path, headers=match).json()["code"] == "review-required"
    assert mcml(ed, uuid) == before
    dry = ed.post(f"{path}/frames", json=SMOOTH["edits"], params={"dry_run": True}, headers=match)
    assert dry.status_code == 200
    number = propose(ed, uuid)["number"]
    assert do(edna, uuid, number, "apply").json()["code"] == "review-required"
    assert do(ed, uuid, number, "approve").status_code == 403
    assert do(edna, uuid, number, "approve").json()["reviewer"] == "edna"
    assert do(ed, uuid, number, "apply").json()["applied"] == 2
    assert own.post(f"{path}/undo", headers=match).status_code == 200
    assert own.delete(path, headers=match).status_code == 204
    assert own.post(f"{path}/restore", headers=match).status_code == 200


@one_kind
def test_an_own_approval_from_before_does_not_count(people: dict[str, TestClient], uuid: str) -> None:
    number = propose(people["ed"], uuid)["number"]
    assert do(people["ed"], uuid, number, "approve").status_code == 200
    require_review(people["own"])
    assert do(people["ed"], uuid, number, "apply").status_code == 409
    assert do(people["ed"], uuid, number, "rebase").json()["state"] == "open"
    do(people["edna"], uuid, number, "approve")
    assert do(people["ed"], uuid, number, "apply").status_code == 200


@one_kind
def test_no_way_round_a_review(people: dict[str, TestClient], uuid: str, database: Database) -> None:
    """A document cannot be moved away, edited there, and brought back."""
    with database.write() as tx:
        lab = tx.projects.get_or_add("lab")
        assert lab
        tx.members.put(lab, "ed", "editor")
    require_review(people["own"])
    path = f"{API}/documents/{uuid}"
    moved = people["ed"].patch(path, json={"project": "lab"}, headers={"if-match": "*"})
    assert moved.json()["code"] == "review-required"
    changed = {"change": {"project": "lab"}, "selection": {"documents": [uuid]}}
    assert people["ed"].post(f"{API}/selections/change", json=changed).status_code == 409
    assert people["ed"].get(path).json()["project"] == "gait"
    new = people["ed"].post(f"{API}/documents", files={"file": ("b.bvh", bvh(3, seed=4))}, data={"project": "lab"})
    other = f"{API}/documents/{new.json()['documents'][0]['id']}"
    moved = people["ed"].patch(other, json={"project": "gait"}, headers={"if-match": "*"})
    assert moved.status_code == 200, "what comes in is new there, as an import"
    assert people["ed"].patch(other, json={"name": "x"}, headers={"if-match": "*"}).status_code == 409


@one_kind
@pytest.mark.parametrize(
    ("request_", "status"),
    [
        ({}, 422),
        (SMOOTH | NAMED, 422),
        ({"edits": {"edits": [{"do": "delete", "first": 1, "last": 99}]}}, 404),
        ({"changes": {}}, 422),
        ({"changes": {"elements": [{"do": "delete", "xpath": "//frame["}]}}, 422),
        ({"changes": {"labels": [{"name": "x" * 900, "first": 1, "last": 2}] * 3000}}, 413),
    ],
)
def test_what_cannot_be_proposed(client: TestClient, uuid: str, request_: dict[str, Any], status: int) -> None:
    answer = client.post(f"{API}/documents/{uuid}/proposals", json=request_, headers={"if-match": "*"})
    assert answer.status_code == status, answer.text
    assert client.get(f"{API}/documents/{uuid}/proposals").json()["items"] == []


@one_kind
def test_how_many_there_may_be(client: TestClient, database: Database, uuid: str) -> None:
    assert client.post(f"{API}/documents/{uuid}/proposals", json=SMOOTH).status_code == 428
    assert client.post(
        f"{API}/documents/{uuid}/proposals", json=SMOOTH, headers={"if-match": '"2"'}
    ).status_code == 412  # fmt: skip
    with database.write("kim") as tx:
        stored = tx.documents.get(uuid)
        for number in range(1, MOST_ENDED + 3):
            assert tx.proposals.add(stored, "frames", "{}", {}, "s", "").number == number
            tx.proposals.close(stored, number)
        numbers = [one.number for one in tx.proposals.of(stored, None, None, 1000)]
        assert numbers[0] == MOST_ENDED + 2
        assert len(numbers) == MOST_ENDED + 1
    for _ in range(MOST_OPEN):
        propose(client, uuid)
    full = client.post(f"{API}/documents/{uuid}/proposals", json=SMOOTH, headers={"if-match": "*"})
    assert (full.status_code, f"{MOST_OPEN} open" in full.json()["detail"]) == (422, True)


def test_proposals_go_with_their_document(client: TestClient, database: Database, uuid: str, tmp_path: Any) -> None:
    propose(client, uuid)
    copied = client.post(f"{API}/selections/copy", json={"selection": {"documents": [uuid]}, "project": "lab"}).json()
    other = copied["documents"][0]
    assert do(client, other, 1, "apply").json()["applied"] == 2
    assert client.get(f"{API}/documents/{uuid}/proposals/1").json()["state"] == "open"
    client.delete(f"{API}/documents/{uuid}", headers={"if-match": "*"})
    assert client.get(f"{API}/documents/{uuid}/proposals").status_code == 404
    purge_documents(database, [uuid])
    with database.read() as tx:
        assert tx.connection.execute(text("SELECT COUNT(*) FROM proposal")).scalar_one() == 1
    assert database.check(past=True) == []
    with database.write() as tx:
        tx.connection.execute(text("UPDATE proposal SET reviewer = 'kim'"))
    assert any("proposal" in fault for fault in database.check())


@one_kind
def test_each_step_is_an_event(client: TestClient, uuid: str) -> None:
    asked = {"seconds": 0, "kind": "proposal", "document": uuid}
    began = client.get(f"{API}/events", params=asked).text
    mark = began.splitlines()[0].removeprefix("id: ")
    propose(client, uuid)
    for what in ("approve", "rebase", "apply"):
        assert do(client, uuid, 1, what).status_code == 200
    propose(client, uuid, NAMED)
    do(client, uuid, 2, "close")
    text = client.get(f"{API}/events", params=asked | {"since": mark}).text
    events = [orjson.loads(line.removeprefix("data: ")) for line in text.splitlines() if line.startswith('data: {"')]
    told = [(event["what"], event["subject"], event["revision"]) for event in events]
    assert told == [
        ("add", "1", 1), ("approve", "1", 1), ("rebase", "1", 1), ("apply", "1", 2), ("add", "2", 2), ("close", "2", 2),
    ]  # fmt: skip
    assert text.count("event: proposal") == len(told)


@one_kind
def test_comments_of_older_stores_are_sound(client: TestClient, database: Database, uuid: str) -> None:
    """The checksum of a comment on no proposal is that of programs that knew no proposals."""
    client.post(f"{API}/documents/{uuid}/comments", json={"text": "look", "first": 3})
    client.post(f"{API}/documents/{uuid}/proposals", json=SMOOTH, headers={"if-match": "*"})
    client.post(f"{API}/documents/{uuid}/comments", json={"text": "look", "first": 3, "proposal": 1})
    columns = SEALS[comment].columns
    assert columns[-1] == "proposal"
    with database.read() as tx:
        rows = tx.connection.execute(select(*(comment.c[name] for name in columns), comment.c.checksum)).all()
    before = [Seal(comment, columns[:-1]).of((*row[:-2],)) == row[-1] for row in rows]
    assert before == [True, False], "a number of a proposal counts"
