"""Whole projects as files: nothing is lost, equal projects are equal files, and what is broken changes nothing."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from random import Random
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import func, select, text

from mcml.errors import ConflictError, DamageError, McmlError
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.keeping.move_project import export_project, import_project
from mcml_service.settings import Settings
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.database import Database
from tests.api.asked import API, filled
from tests.builders import ASF, HTR, MCML, SECRET, TRC, amc, bvh, c3d_file, one_kind, served, store

EMPTY: dict[str, bytes] = {}


def fill(database: Database, seed: int) -> None:
    """A project "mine" with documents of every format, edits, a deleted one, and what projects keep; and another."""
    with served(database) as client:
        filled(client, database, "mine", "wombat")
        filled(client, database, "theirs", "quokka")
        one = client.get(f"{API}/documents", params={"project": "theirs", "limit": 1}).json()["items"][0]["id"]
        moved = client.patch(f"{API}/documents/{one}", json={"project": "mine"}, headers={"if-match": "*"})
        assert moved.status_code == 200, moved.text
    files = {"a.bvh": bvh(600, seed), "leg.asf": ASF, "leg.amc": amc(4), "h.htr": HTR, "m.mcml": MCML, "t.trc": TRC}
    stored = store(database, files | {"p.c3d": c3d_file(), "none.bvh": bvh(0)}, project="mine")
    random = Random(seed)
    with served(database) as client:
        done = sum(edited(client, random.choice(stored), random) for _ in range(24))
    assert done > 8


def edited(client: TestClient, uuid: str, random: Random) -> bool:
    """One edit at random, if it can be made."""
    here, change = f"{API}/documents/{uuid}", {"if-match": "*"}
    number = random.randint(1, 4)
    renamed = {"do": "change", "xpath": "//frame[1]", "attributes": {"id": str(900 + number)}}
    aged = [{"name": "age", "value": str(number), "unit": "year"}]
    path, body = random.choice(
        [
            ("frames", {"edits": [{"do": "delete", "first": number, "last": number}]}),
            ("frames", {"edits": [{"do": "reverse", "first": 1, "last": number}]}),
            ("frames", {"edits": [{"do": "insert", "at": 1, "frames": 2}]}),
            ("labels", [{"name": random.choice(["hop", "turn"]), "first": 1, "last": number}]),
            (
                "elements/batch",
                {"edits": [renamed]},
            ),
            (
                "",
                {
                    "description": f"take {number}",
                    "properties": aged,
                },
            ),
            ("undo", None),
        ]
    )
    method = "PATCH" if path == "" else "POST"
    answer = client.request(method, f"{here}/{path}".rstrip("/"), json=body, headers=change)
    assert answer.status_code < 500, answer.text
    return answer.status_code < 300


def exported(database: Database, project: str = "mine") -> bytes:
    with database.read() as tx:
        return b"".join(export_project(tx, project))


def brought(database: Database, content: bytes, name: str | None = None) -> tuple[str, int]:
    return import_project(database, io.BytesIO(content), Settings(), "kim", name)


def histories(database: Database, project: str) -> list[Any]:
    """Of each document, by what it is called: every revision with its text, and the files that it came of."""
    found = []
    with database.read() as tx:
        key = tx.projects.get(project)
        for document, uuid, _ in tx.documents.everything():
            stored = tx.documents.get(uuid, deleted=True)
            if stored.project_key != key:
                continue
            told = []
            for revision in tx.revisions.of(document, limit=1000):
                then = tx.at_commit(revision.commit)
                at = then.documents.find(uuid)
                text = None if at is None else b"".join(export_document(then, at, ExportOptions("mcml")).content)
                told.append(
                    (revision.number, revision.operation, revision.message, revision.author, revision.time, text)
                )
            uploads = [(one.part, one.file_name, one.sha256) for one in tx.uploads.of(document)]
            gone = tx.documents.find(uuid) is None
            found.append((stored.name, gone, told, uploads, tx.documents.receipt(document), tx.media.of(document)))
    return sorted(found, key=str)


def without_keys(told: list[Any]) -> list[Any]:
    """Without the key of an upload, which is the store's own."""
    return [(*one[:5], one[5] and (one[5].file_name, one[5].offset, one[5].sha256)) for one in told]


def counts(database: Database) -> dict[str, int]:
    with database.read() as tx:
        return {
            table.name: tx.connection.execute(select(func.count()).select_from(table)).scalar_one()
            for table in metadata.sorted_tables
        }


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1])
def test_a_project_goes_to_another_store_and_back(database: Database, tmp_path: Path, seed: int) -> None:
    fill(database, seed)
    first = exported(database)
    assert first == exported(database)
    other = Database(f"sqlite:///{tmp_path}/other.db")
    other.migrate()
    store(other, {"before.bvh": bvh(5)}, project="before")
    name, documents = brought(other, first)
    assert (name, documents) == ("mine", 11)
    assert other.check(past=True) == []
    assert exported(other) == first, "export, import, export are equal"
    assert without_keys(histories(other, "mine")) == without_keys(histories(database, "mine"))
    # Beside what is there: ids become others, all else stays.
    assert brought(database, exported(other), "mine again") == ("mine again", 11)
    assert database.check(past=True) == []
    assert without_keys(histories(database, "mine again")) == without_keys(histories(database, "mine"))
    with database.read() as tx:
        kept = tx.saved.collection("mine again/wombat").content["documents"]
        assert tx.documents.get(kept[0]).project == "mine again"
        key = tx.projects.get("mine again")
        named = tx.mappings.page("mine again", None, 10)
        assert [one.name for one in named] == ["wombat"]
        assert tx.aliases.of("mine again").pairs == (("wombat", "Root"),)
        words = tx.saved.get("vocabulary", "mine again", "").content["items"]
        assert words == [{"name": "wombat", "description": "wombat"}]
        assert tx.projects.name(key) == "mine again"
    # Work goes on in it.
    store(other, {"after.bvh": bvh(3)}, project="mine")
    with served(other) as client:
        listed = client.get(f"{API}/documents", params={"project": "mine", "limit": 100}).json()["items"]
        edits = {"edits": [{"do": "delete", "first": 1, "last": 1}]}
        one = next(item["id"] for item in listed if item["name"] == "a")
        path = f"{API}/documents/{one}/frames"
        assert client.post(path, json=edits, headers={"if-match": "*"}).status_code == 200
        undone = client.post(f"{API}/documents/{one}/undo", headers={"if-match": "*"})
        assert undone.status_code == 200, undone.text
    assert other.check(past=True) == []
    other.close()


def test_a_file_of_a_program_with_fewer_channels_is_read(database: Database) -> None:
    store(database, {"a.bvh": bvh(600, 3)}, project="mine")
    changed = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(exported(database))) as archive,
        zipfile.ZipFile(changed, "w") as older,
    ):
        for name in archive.namelist():
            content = archive.read(name)
            if name == "rows/track.jsonl":
                rows = [json.loads(line) for line in content.splitlines()]
                content = b"".join(
                    json.dumps({key: row[key] for key in row if not key.endswith("_weight")}).encode() + b"\n"
                    for row in rows
                )
            older.writestr(name, content.replace(b"residual weight", b"residual"))
    assert brought(database, changed.getvalue(), "again") == ("again", 1)
    assert database.check() == []
    assert without_keys(histories(database, "again")) == without_keys(histories(database, "mine"))


def test_a_file_of_a_program_without_proposals_is_read(database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(30, 3)}, project="mine")[0]
    with database.write("kim") as tx:
        tx.comments.add(tx.documents.get(uuid), 1, "look", 3, 3, None)
    changed = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(exported(database))) as archive,
        zipfile.ZipFile(changed, "w") as older,
    ):
        for name in archive.namelist():
            content = archive.read(name)
            if name == "rows/comment.jsonl":
                row = json.loads(content)
                assert row.pop("proposal") is None
                content = json.dumps(row).encode() + b"\n"
            if name == "manifest.json":
                about = json.loads(content)
                assert about["rows"].pop("proposal") == 0
                content = json.dumps(about).encode()
            if name != "rows/proposal.jsonl":
                older.writestr(name, content)
    assert brought(database, changed.getvalue(), "again") == ("again", 1)
    assert database.check() == []


@pytest.mark.slow
def test_it_holds_what_people_can_read(database: Database) -> None:
    fill(database, 2)
    with zipfile.ZipFile(io.BytesIO(exported(database))) as archive:
        names = archive.namelist()
        about = json.loads(archive.read("manifest.json"))
        texts = [archive.read(name) for name in names if name.startswith("mcml/")]
        assert bvh(600, 2) in [archive.read(name) for name in names if name.startswith("files/")]
        rows = b"".join(archive.read(name) for name in names if name.startswith("rows/"))
    assert about["rows"]["document"] == 11
    assert len(texts) == 10, "what is deleted is in the rows alone"
    assert all(text.startswith(b"<?xml") for text in texts)
    assert b"sha256$" not in rows
    assert b"argon2" not in rows
    # What moved away from the other project is here, all else of it is not.
    assert rows.count(b"quokka") > 0
    assert not any(name in ("account.jsonl", "token.jsonl", "session.jsonl") for name in names)


@pytest.mark.slow
def test_what_is_damaged_is_not_moved(database: Database) -> None:
    fill(database, 3)
    with database.write() as tx:
        tx.connection.execute(text("UPDATE bone SET name = 'tail' WHERE bone = 1"))
    with pytest.raises(DamageError):
        exported(database)


@pytest.mark.slow
def test_copies_have_the_whole_history(database: Database) -> None:
    """Also where an equal skeleton is, and of many at once; the copy and what it is of go on by themselves."""
    fill(database, 6)
    with served(database) as client:
        asked = {"selection": {"project": "mine"}, "project": "copies"}
        made = client.post(f"{API}/selections/copy", json=asked)
        assert made.status_code == 201, made.text
        again = client.post(f"{API}/selections/copy", json=asked | {"project": "mine"})
        assert len(again.json()["documents"]) == len(made.json()["documents"]) == 10
        assert database.check(past=True) == []
        own = {str(one): one for one in without_keys(histories(database, "copies"))}
        there = [str(one) for one in without_keys(histories(database, "mine"))]
        assert all(there.count(one) >= 2 for one in own)
        copy = made.json()["documents"][0]
        before = without_keys(histories(database, "mine"))
        edits = {"edits": [{"do": "reverse", "first": 1, "last": 2}]}
        for path, body in (("frames", edits), ("undo", None)):
            answer = client.post(f"{API}/documents/{copy}/{path}", json=body, headers={"if-match": "*"})
            assert answer.status_code == 200, answer.text
        assert without_keys(histories(database, "mine")) == before
    assert database.check(past=True) == []


@pytest.mark.slow
@one_kind
def test_what_is_broken_or_taken_changes_nothing(database: Database) -> None:
    """Members that lack, are cut, hold other values or other types, one at a time at random."""
    fill(database, 4)
    whole = exported(database)
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    before = counts(database)
    with pytest.raises(ConflictError, match="There is a project 'mine'"):
        brought(database, whole)
    random, refused, kept = Random(5), 0, 0
    for number in range(60):
        content = changed(random, dict(members))
        try:
            name, _ = brought(database, content, f"try {number}")
        except McmlError:
            refused += 1
            assert counts(database) == before
        else:
            # What was changed was a number that may be another, such as a time or a name.
            kept += 1
            assert exported(database, name)
            before = counts(database)
    assert database.check(past=True) == []
    assert refused > 25
    for content in (
        b"",
        b"PK\x03\x04 no zip",
        zip_of(EMPTY),
        zip_of({"manifest.json": b"{}"}),
        whole[: len(whole) // 2],
    ):
        with pytest.raises(McmlError):
            brought(database, content, "other")
    assert counts(database) == before


def zip_of(members: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def changed(random: Random, members: dict[str, bytes]) -> bytes:
    name = random.choice([name for name in members if name.startswith("rows/") or random.random() < 0.1])
    what = random.choice(["gone", "cut", "value", "value", "value", "column", "twice"])
    lines = members[name].split(b"\n")[:-1]
    if what == "gone":
        del members[name]
    elif what == "cut" or not name.startswith("rows/") or not lines:
        members[name] = members[name][: random.randrange(len(members[name]) + 1)]
    else:
        place = random.randrange(len(lines))
        row = json.loads(lines[place])
        column = random.choice(list(row))
        if what == "value":
            row[column] = random.choice([None, 7, -1, 2**70, "text", True, 1.5, [], {}, "AAAA", row[column]])
        elif what == "column":
            row["more"] = row.pop(column)
        lines[place : place + 1] = [json.dumps(row).encode()] * (2 if what == "twice" else 1)
        members[name] = b"\n".join([*lines, b""])
    return zip_of(members)


@one_kind
def test_a_zip_that_unpacks_to_too_much_is_refused(database: Database) -> None:
    store(database, {"a.bvh": bvh(5)}, project="mine")
    with zipfile.ZipFile(io.BytesIO(exported(database))) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    members["rows/commit.jsonl"] = b" " * (50 << 20)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    with pytest.raises(McmlError, match="more than the limits"):
        brought(database, buffer.getvalue(), "other")


@one_kind
def test_owners_of_a_project_export_it_and_owners_of_the_repository_import(database: Database) -> None:
    store(database, {"a.bvh": bvh(5)}, project="mine")
    store(database, {"a.bvh": bvh(5)}, project="theirs")
    with database.write() as tx:
        tx.accounts.add("boss", "owner", "x")
        owner, editor = (tx.accounts.add(name, "member", "x") for name in ("owner", "editor"))
        for person in (owner, editor):
            tx.members.put(tx.projects.get("mine"), person.name, person.name)
        tokens = {one.name: tx.tokens.add(one.name + "s", owner=one) for one in (owner, editor)}
        headers = {name: {"authorization": f"Bearer {token}"} for name, token in tokens.items()}
    with served(database) as keeper:
        client = TestClient(keeper.app, client=("10.0.0.7", 1))

        def asked(who: str, project: str) -> Any:
            return client.get(f"{API}/projects/export", params={"project": project}, headers=headers[who])

        file = asked("owner", "mine")
        assert file.status_code == 200
        assert "mine.project.zip" in file.headers["content-disposition"]
        assert (asked("owner", "theirs").status_code, asked("editor", "mine").status_code) == (404, 403)
        sent = {"files": {"file": ("mine.project.zip", file.content)}, "data": {"name": "copy"}}
        assert client.post(f"{API}/projects", headers=headers["owner"], **sent).status_code == 403
        made = keeper.post(f"{API}/projects", headers={"authorization": f"Bearer {SECRET}"}, **sent)
        assert made.json() == {"project": "copy", "documents": 1}
