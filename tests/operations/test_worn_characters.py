"""Characters of the library: listed, put on clips, exported, and seen by those alone who may read both."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from sqlalchemy import update
from typer.testing import CliRunner

import mcml
from mcml.motion.skin import Character
from mcml_service.cli import app
from mcml_service.storage.core.tables import upload as uploads
from mcml_service.storage.database import Database
from tests.builders import TRC, bvh, store, upload
from tests.formats.readers.fbx_text import Skin, fbx_text
from tests.formats.readers.skinned_files import tube
from tests.formats.scenes.reading import read_glb
from tests.motion.bodies.made import person

API = "/api/v1"


@pytest.fixture
def figure(tmp_path: Path) -> bytes:
    """Our own figure as a file, in metres: the character of a person who walks."""
    source = tmp_path / "person.bvh"
    source.write_bytes(person(2, 3))
    (path,) = mcml.convert(source, tmp_path / "figure.glb", character="own")
    return path.read_bytes()


def store_files(client: TestClient, **files: bytes) -> list[str]:
    names = {name.replace("_", "."): content for name, content in files.items()}
    return [upload(client, {name: content})["documents"][0]["id"] for name, content in names.items()]


def frames(client: TestClient, document: str, **asked: Any) -> np.ndarray:
    answer = client.get(f"{API}/documents/{document}/frames", params={"format": "block", "dtype": "f8", **asked})
    assert answer.status_code == 200, answer.text
    shape = [int(part) for part in answer.headers["x-mcml-shape"].split(",")]
    return np.frombuffer(answer.content, "<f8").reshape(shape)


def test_a_clip_moves_the_mesh_of_another_document(client: TestClient, figure: bytes) -> None:
    """The mesh, moved by the frames of the answer, is where the exported file has it, and as large as the clip's body
    once it is divided by the scale."""
    walk, avatar = store_files(client, walk_bvh=person(3, 12), figure_glb=figure)
    found = client.get(f"{API}/documents/{walk}/character", params={"character": avatar}).json()
    assert (found["document"], found["revision"], found["reason"]) == (avatar, 1, None)
    assert any("joints matched" in note for note in found["notes"])
    mesh = found["mesh"]
    made = Character(
        np.array(mesh["points"]).reshape(-1, 3),
        np.zeros((len(mesh["points"]) // 3, 3)),
        np.array(mesh["triangles"]).reshape(-1, 3),
        np.array(mesh["joints"]).reshape(-1, 4),
        np.array(mesh["weights"]).reshape(-1, 4),
        np.array(mesh["bind_positions"]),
        np.array(mesh["bind_rotations"]),
    )
    assert len(mesh["colours"]) == len(mesh["points"])
    positions, rotations = (frames(client, walk, character=avatar, space=space) for space in ("positions", "rotations"))
    moved = made.move(positions, rotations)
    exported = client.get(f"{API}/documents/{walk}/export", params={"format": "glb", "character": avatar})
    assert exported.status_code == 200, exported.text
    assert np.abs(read_glb(exported.content).body() - moved).max() < 2e-4
    own = frames(client, walk, space="positions")
    assert np.ptp(moved[0], axis=0).max() / found["scale"] == pytest.approx(np.ptp(own[0], axis=0).max(), rel=0.25)
    hips = positions[:, 0] / found["scale"] - own[:, 0]
    assert np.abs(hips - hips[0]).max() < 0.02 * np.ptp(own[0], axis=0).max(), "it travels with the clip"


def test_windows_and_steps_are_those_of_the_whole_motion(client: TestClient, figure: bytes) -> None:
    walk, avatar = store_files(client, walk_bvh=person(3, 30), figure_glb=figure)
    whole = frames(client, walk, character=avatar, space="positions")
    assert len(whole) == 30
    assert (frames(client, walk, character=avatar, space="positions", first=5, last=9) == whole[4:9]).all()
    assert (frames(client, walk, character=avatar, space="positions", step=7) == whole[::7]).all()
    tips = frames(client, walk, character=avatar, space="positions", tips=True)
    assert (tips[:, : whole.shape[1]] == whole).all()
    page = client.get(f"{API}/documents/{walk}/frames", params={"character": avatar})
    assert (page.status_code, page.json()["detail"]) == (
        422,
        "A character has channels, positions and rotations alone.",
    )


def test_a_clip_of_the_same_rig_moves_it_as_it_is(client: TestClient, figure: bytes) -> None:
    (avatar,) = store_files(client, figure_glb=figure)
    found = client.get(f"{API}/documents/{avatar}/character", params={"character": avatar}).json()
    assert (found["scale"], found["notes"]) == (1.0, [])
    for space in ("positions", "rotations"):
        assert (frames(client, avatar, character=avatar, space=space) == frames(client, avatar, space=space)).all()


def test_characters_are_listed_once_with_their_vertices(client: TestClient, figure: bytes) -> None:
    takes = tube(3, 1)
    takes.model["animations"].append({**takes.model["animations"][0], "name": "Again"})
    _, avatar, *_ = store_files(client, walk_bvh=person(1, 3), figure_glb=figure, plain_glb=plain_glb())
    assert len(upload(client, {"tube.glb": takes.data()})["documents"]) == 2
    found = client.get(f"{API}/characters").json()
    assert [(item["name"], item["vertices"]) for item in found["items"]] == [
        ("figure", len(read_glb(figure).body()[0])),
        ("tube#Move", 40),
    ]
    assert found["items"][0]["document"] == avatar
    assert found["unread"] == 0
    client.delete(f"{API}/documents/{avatar}", headers={"if-match": "*"})
    assert [item["name"] for item in client.get(f"{API}/characters").json()["items"]] == ["tube#Move"]


def plain_glb() -> bytes:
    """A skeleton without a mesh."""
    made = tube(3, 2)
    made.model["nodes"][-1].pop("mesh")
    return made.data()


def test_an_fbx_file_is_a_character(client: TestClient) -> None:
    skin = Skin([(0, 90, 0), (5, 100, 0), (0, 120, 5), (-5, 120, 0)], [(0, 1, 2), (0, 2, 3)], [1, 0.5, 0, 0])
    takes, still, plain = store_files(
        client, takes_fbx=fbx_text(skin=skin), still_fbx=fbx_text(takes=(), skin=skin), plain_fbx=fbx_text()
    )
    listed = client.get(f"{API}/characters").json()["items"]
    assert [(item["document"], item["vertices"]) for item in listed] == [(still, 4), (takes, 4)]
    found = client.get(f"{API}/documents/{takes}/character", params={"character": still}).json()
    assert (found["document"], found["scale"]) == (still, 1.0)
    mesh = found["mesh"]
    made = Character(
        np.array(mesh["points"]).reshape(-1, 3), np.zeros((4, 3)), np.array(mesh["triangles"]).reshape(-1, 3),
        np.array(mesh["joints"]).reshape(-1, 4), np.array(mesh["weights"]).reshape(-1, 4),
        np.array(mesh["bind_positions"]), np.array(mesh["bind_rotations"]),
    )  # fmt: skip
    moved = made.move(*(frames(client, takes, character=still, space=space) for space in ("positions", "rotations")))
    # The hips move along x by 1 and turn about z by 9 degrees a frame; the spine keeps its place on them.
    turn, way = np.deg2rad(9 * np.arange(11)), np.arange(11.0)
    for vertex, (x, y) in ((0, (0, -10)), (1, (5, 0)), (3, (-5, 20))):
        placed = way + x * np.cos(turn) - y * np.sin(turn), 100 + x * np.sin(turn) + y * np.cos(turn)
        assert moved[:, vertex, :2] == pytest.approx(np.stack(placed, axis=1), abs=1e-5)
    refused = client.get(f"{API}/documents/{takes}/character", params={"character": plain}).json()
    assert "no file with a skinned mesh" in refused["reason"]
    exported = client.get(f"{API}/documents/{takes}/export", params={"format": "glb", "character": still})
    # Metres in glTF.
    assert np.abs(read_glb(exported.content).body() - moved / 100).max() < 1e-4


def test_files_of_earlier_versions_are_looked_into_once(
    client: TestClient, database: Database, figure: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    from mcml_service.actions.reading import list_characters

    store_files(client, figure_glb=figure, plain_glb=plain_glb())
    with database.write("test") as tx:
        tx.run(update(uploads).values(vertices=None))
    monkeypatch.setattr(list_characters, "MOST_FILES", 1)
    first = client.get(f"{API}/characters").json()
    assert ([item["name"] for item in first["items"]], first["unread"]) == (["figure"], 1)
    monkeypatch.setattr(list_characters, "MOST_FILES", 2)
    assert client.get(f"{API}/characters").json()["unread"] == 0
    monkeypatch.setattr(list_characters, "_count", lambda *_: pytest.fail("it was looked into before"))
    assert [item["name"] for item in client.get(f"{API}/characters").json()["items"]] == ["figure"]


def test_refusals_say_why(client: TestClient, figure: bytes) -> None:
    walk, chain, points, avatar = store_files(
        client, walk_bvh=person(1, 4), chain_bvh=bvh(3), points_trc=TRC, figure_glb=figure
    )

    def reason(document: str, character: str) -> str:
        found = client.get(f"{API}/documents/{document}/character", params={"character": character}).json()
        assert found["mesh"] is None
        return str(found["reason"])

    assert "joints of the clip are known in the character" in reason(chain, avatar)
    assert "no pelvis with both hips" in reason(points, avatar)
    assert reason(walk, chain) == "'chain' has no character: no file with a skinned mesh."
    path = f"{API}/documents/{walk}/export"
    assert client.get(path, params={"format": "bvh", "character": avatar}).status_code == 415
    assert client.get(path, params={"format": "glb", "character": chain}).status_code == 422
    missing = client.get(path, params={"format": "glb", "character": "0" * 32})
    assert missing.status_code == 404


def test_both_documents_must_be_readable(client: TestClient, database: Database, figure: bytes) -> None:
    """A token of one project neither lists nor wears a character of another."""
    walk = upload(client, {"walk.bvh": person(1, 4)}, project="mine")["documents"][0]["id"]
    avatar = upload(client, {"figure.glb": figure}, project="theirs")["documents"][0]["id"]
    with database.write() as tx:
        boss = tx.accounts.add("boss", "owner", "x")
        keys = {name: [tx.projects.get(name)] for name in ("mine", "theirs")}
        mine = tx.tokens.add("mine", owner=boss, projects=keys["mine"])
        both = tx.tokens.add("both", owner=boss, projects=keys["mine"] + keys["theirs"])
    asked = {"character": avatar}
    for secret, status, names in ((mine, 404, []), (both, 200, ["figure"])):
        headers = {"authorization": f"Bearer {secret}"}
        listed = client.get(f"{API}/characters", headers=headers).json()
        assert [item["name"] for item in listed["items"]] == names
        for path, more in (
            ("character", {}),
            ("frames", {"format": "block", "space": "positions"}),
            ("export", {"format": "glb"}),
        ):
            answer = client.get(f"{API}/documents/{walk}/{path}", params={**asked, **more}, headers=headers)
            assert answer.status_code == status, (path, answer.text[:200])
            assert status == 200 or "figure" not in answer.text


def test_an_edited_skeleton_no_longer_fits_its_mesh(client: TestClient, figure: bytes) -> None:
    walk, avatar = store_files(client, walk_bvh=person(1, 4), figure_glb=figure)
    offset = "/mcml/skeleton/bone/bone[1]/position"
    change = {"do": "change", "xpath": offset, "text": "9 9 9"}
    answer = client.post(
        f"{API}/documents/{avatar}/elements/batch", json={"edits": [change]}, headers={"if-match": "*"}
    )
    assert answer.status_code == 200, answer.text
    found = client.get(f"{API}/documents/{walk}/character", params={"character": avatar}).json()
    assert found["reason"].startswith("The skeleton of the character was edited")


def test_on_the_command_line(database: Database, tmp_path: Path, figure: bytes) -> None:
    store(database, {"walk.bvh": person(1, 6)})
    store(database, {"figure.glb": figure})
    address = database.dialect.engine.url.render_as_string(hide_password=False)
    listed = CliRunner().invoke(app, ["characters", "--json", "--database", address])
    assert [item["name"] for item in json.loads(listed.output)["items"]] == ["figure"]
    target = tmp_path / "walk.glb"
    asked = ["export", "walk", "--format", "glb", "--character", "figure", "-o", str(target), "--database", address]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0, done.output
    assert len(read_glb(target.read_bytes()).body()[0]) == len(read_glb(figure).body()[0])
