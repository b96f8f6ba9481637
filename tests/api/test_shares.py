"""Links to some documents: what they show, and that they show nothing else."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import text

from mcml_service.api.authentication import SHARED
from mcml_service.app import create_app
from mcml_service.operations import all_operations
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.api.asked import API, filled, request_of
from tests.builders import SECRET, one_kind

pytestmark = one_kind
HOME = "http://127.0.0.1:8000"
SHOWN = {
    "get_frames", "get_skeleton", "get_thumbnail", "get_character", "get_rest_pose", "list_labels", "export_document",
}  # fmt: skip
"""What a link shows, said a second time."""


@dataclass
class Scene:
    keeper: TestClient
    visitor: TestClient
    stored: list[str]
    database: Database

    def share(self, **asked: Any) -> Any:
        made = self.keeper.post(f"{API}/shares", json={"name": "for them", "documents": self.stored[:1]} | asked)
        assert made.status_code == 201, made.text
        return made.json()

    def opened(self, **asked: Any) -> Any:
        answer = self.visitor.post(SHARED, json={"secret": self.share(**asked)["path"].partition("#")[2]})
        assert answer.status_code == 201, answer.text
        return answer.json()

    def see(self, path: str, document: int = 0, **query: Any) -> int:
        return self.visitor.get(f"{SHARED}/documents/{self.stored[document]}{path}", params=query).status_code


@pytest.fixture
def scene(database: Database) -> Iterator[Scene]:
    app = create_app(Settings(import_processes=1), database, lambda: SECRET)
    keeper = TestClient(app, base_url=HOME, client=("127.0.0.1", 1), headers={"authorization": f"Bearer {SECRET}"})
    with keeper:
        with database.write() as tx:
            tx.tokens.add("closes the door")
        things = filled(keeper, database, "mine", "wombat")
        visitor = TestClient(app, base_url=HOME, client=("10.0.0.7", 1), headers={"origin": HOME})
        yield Scene(keeper, visitor, things.stored, database)


@pytest.mark.slow
def test_a_link_shows_its_documents_and_nothing_else(scene: Scene) -> None:
    """Every operation, asked with the cookie of a link: below its prefix what is declared, above it nothing."""
    shown = scene.opened(formats=["bvh"])
    assert [one["id"] for one in shown["documents"]] == scene.stored[:1]
    things = filled(scene.keeper, scene.database, "other", "quokka")
    seen = set()
    for operation in all_operations():
        asked = request_of(operation, things, "quokka") if operation.address else None
        if operation.address is None or asked is None:
            continue
        for here in (scene.stored[0], things.id):
            path = operation.path.replace("{name:path}", "{name}").format(**asked.path | {"id": here})
            content = {name: value for name, value in asked.content.items() if name != "headers"}
            about = {"params": asked.query, "headers": {"if-match": "*", **asked.content.get("headers", {})}}
            above = scene.visitor.request(operation.method, API + path, **about, **content)
            assert above.status_code == 401, operation.name
            below = scene.visitor.request(operation.method, SHARED + path, **about, **content)
            assert "quokka" not in below.text, operation.name
            if operation.name not in SHOWN:
                assert below.status_code == 403, (operation.name, below.text)
            elif here == things.id:
                assert below.status_code == 404, (operation.name, below.text)
            else:
                assert below.status_code == 200, (operation.name, below.text)
                seen.add(operation.name)
    assert seen == SHOWN == {operation.name for operation in all_operations() if operation.open_to_links}


def test_exports_are_those_that_are_named_and_never_the_file_itself(scene: Scene) -> None:
    scene.opened(formats=["bvh", "htr"])
    assert (scene.see("/export", format="bvh"), scene.see("/export", format="htr")) == (200, 200)
    assert (scene.see("/export", format="c3d"), scene.see("/mcml"), scene.see("/media")) == (403, 403, 403)
    # A preset decides no format for visitors, and an export without any is refused, not given away.
    assert (scene.see("/export", **{"for": "blender"}), scene.see("/export")) == (403, 403)
    assert scene.see("/export", format="bvh", **{"for": "blender"}) == 200
    exported = scene.visitor.get(f"{SHARED}/documents/{scene.stored[0]}/export?format=bvh&original=true").content
    original = scene.keeper.get(f"{API}/documents/{scene.stored[0]}/export?format=bvh&original=false").content
    assert exported == original


def edited(scene: Scene) -> None:
    edits = {"edits": [{"do": "delete", "first": 1, "last": 1}]}
    path = f"{API}/documents/{scene.stored[0]}/frames"
    assert scene.keeper.post(path, json=edits, headers={"if-match": "*"}).status_code == 200


def test_a_link_follows_later_edits_or_stays_where_it_was(scene: Scene) -> None:
    edited(scene)
    (one,) = scene.opened(latest=True)["documents"]
    then = one["revision"]
    assert one["frames"] == 5
    assert scene.see("/skeleton", revision=then - 1) == 404, "what was before is history"
    edited(scene)
    assert scene.visitor.get(f"{SHARED}/documents/{one['id']}/skeleton").json()["frames"] == 4
    assert (scene.see("/frames", revision=then), scene.see("/frames", revision=then + 1)) == (200, 200)
    (fixed,) = scene.opened(latest=False)["documents"]
    edited(scene)
    assert fixed["frames"] == 4
    assert scene.visitor.get(f"{SHARED}/documents/{one['id']}/skeleton").json()["frames"] == 4
    assert (scene.see("/frames", revision=then + 2), scene.see("/frames", revision=then)) == (404, 404)


def test_a_link_ends(scene: Scene) -> None:
    """When it is taken back, when its time is over, when its document is deleted or goes elsewhere: at once."""
    made = scene.share()
    secret = {"secret": made["path"].partition("#")[2]}
    assert scene.visitor.post(SHARED, json=secret).status_code == 201
    assert scene.see("/frames") == 200
    change = {"if-match": "*"}
    scene.keeper.patch(f"{API}/documents/{scene.stored[0]}", json={"project": "away"}, headers=change)
    assert scene.see("/frames") == 404
    scene.keeper.patch(f"{API}/documents/{scene.stored[0]}", json={"project": "mine"}, headers=change)
    assert scene.see("/frames") == 200
    with scene.database.write() as tx:
        tx.connection.execute(text("UPDATE share SET expires = '2001-01-01T00:00:00.000Z'"))
    assert scene.see("/frames") == 401
    assert scene.visitor.post(SHARED, json=secret).status_code == 403
    made = scene.share()
    secret = {"secret": made["path"].partition("#")[2]}
    assert scene.visitor.post(SHARED, json=secret).status_code == 201
    assert [one["number"] for one in scene.keeper.get(f"{API}/shares").json()["items"]] == [made["number"]]
    assert scene.keeper.delete(f"{API}/shares/{made['number']}").status_code == 204
    assert scene.see("/frames") == 401
    assert scene.visitor.post(SHARED, json=secret).status_code == 403


def test_the_secret_is_kept_nowhere(scene: Scene, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    made = scene.share()
    path, secret = made["path"].split("#")
    assert len(secret) >= 43, "256 bits"
    assert scene.visitor.post(SHARED, json={"secret": secret}).status_code == 201
    assert scene.see("/frames") == 200
    assert secret not in caplog.text
    with scene.database.read() as tx:
        assert secret not in str(tx.connection.execute(text("SELECT * FROM share")).all())
    assert scene.visitor.get(path).headers["referrer-policy"] == "no-referrer"
    cookie = next(one for one in scene.visitor.cookies.jar if one.name == "mcml_share")
    assert (cookie.path, cookie.has_nonstandard_attr("HttpOnly")) == (SHARED, True)
    assert cookie.get_nonstandard_attr("SameSite").lower() == "strict"


def test_secrets_cannot_be_guessed(scene: Scene) -> None:
    answers = [scene.visitor.post(SHARED, json={"secret": f"guess {n}"}).status_code for n in range(12)]
    assert answers[:10] == [403] * 10
    assert answers[10:] == [429] * 2


def test_only_documents_of_one_project_that_one_may_change(scene: Scene) -> None:
    other = filled(scene.keeper, scene.database, "other", "quokka")
    refused = scene.keeper.post(f"{API}/shares", json={"name": "x", "documents": [scene.stored[0], other.id]})
    assert refused.status_code == 422
    assert "one project" in refused.json()["detail"]
    with scene.database.write() as tx:
        tx.accounts.add("boss", "owner", "x")
        reader = tx.accounts.add("reader", "member", "x")
        tx.members.put(tx.projects.get("mine"), "reader", "reader")
        token = tx.tokens.add("reads", owner=reader)
    asked = {"name": "x", "documents": scene.stored[:1]}
    headers = {"authorization": f"Bearer {token}"}
    assert scene.visitor.post(f"{API}/shares", json=asked, headers=headers).status_code == 403
