"""Thumbnails of documents: made at import, by revisions that move something, on demand in older stores; in lists."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from sqlalchemy import text

from mcml_service.actions.reading import make_thumbnail
from mcml_service.actions.reading.make_thumbnail import read_thumbnail
from mcml_service.storage.database import Database
from tests import thumbnails as mt1
from tests.builders import TRC, bvh, c3d_file, store, upload

pytestmark = pytest.mark.above_store

API = "/api/v1/documents"
LASTING = "private, max-age=31536000, immutable"


def kept(database: Database) -> list[tuple[int, int]]:
    with database.read() as tx:
        return [(row[0], row[1]) for row in tx.connection.execute(text("SELECT revision, length(data) FROM thumbnail"))]


def shown(client: TestClient, uuid: str, **asked: object) -> bytes:
    answer = client.get(f"{API}/{uuid}/thumbnail", params=asked)  # type: ignore[arg-type]
    assert answer.status_code == 200, answer.text
    return answer.content


def listed(client: TestClient, also: str = "thumbnail,labels,passport") -> list[dict[str, Any]]:
    items: list[dict[str, Any]] = client.get(API, params={"with": also}).json()["items"]
    return items


def test_imports_make_pictures(database: Database, client: TestClient) -> None:
    uuid = store(database, {"walk.bvh": bvh(600, names=[f"joint {n}" for n in range(40)])})[0]
    ((revision, size),) = kept(database)
    answer = client.get(f"{API}/{uuid}/thumbnail?revision=1")
    assert (revision, size) == (1, len(answer.content))
    assert answer.headers["cache-control"] == LASTING
    picture = mt1.read(answer.content)
    assert (picture.loop.shape, picture.scrub.shape, len(picture.bones)) == ((32, 32, 2), (16, 32, 2), 31)
    with database.read() as tx:
        again = read_thumbnail(tx, tx.documents.get(uuid))
        assert again is not None
        assert again.data == answer.content, "from the store it is the same"
        assert database.check() == []


def test_a_revision_that_moves_something_has_a_picture_of_its_own(database: Database, client: TestClient) -> None:
    uuid = store(database, {"walk.bvh": bvh(30)})[0]
    label = [{"name": "walk", "first": 1, "last": 3}]
    assert client.post(f"{API}/{uuid}/labels", json=label, headers={"if-match": "*"}).status_code == 201
    assert shown(client, uuid, revision=2) == shown(client, uuid, revision=1)
    assert [number for number, _ in kept(database)] == [1], "a name moves nothing"
    edits = {"edits": [{"do": "keep", "first": 20, "last": 22}]}
    assert client.post(f"{API}/{uuid}/frames", json=edits, headers={"if-match": "*"}).status_code == 200
    assert shown(client, uuid) != shown(client, uuid, revision=2)
    assert [number for number, _ in sorted(kept(database))] == [1, 3]
    assert shown(client, uuid, revision=3) == shown(client, uuid)


def test_stores_of_before_get_them_when_they_are_asked(database: Database, client: TestClient) -> None:
    first, second = store(database, {"a.bvh": bvh(30)}), store(database, {"b.bvh": bvh(30, seed=1)})
    before = [shown(client, uuid) for uuid in (*first, *second)]
    with database.write() as tx:
        tx.connection.execute(text("DELETE FROM thumbnail"))
    assert [base64.b64decode(item["thumbnail"]) for item in listed(client)] == before
    assert len(kept(database)) == 2
    assert database.check() == []


def test_cards_say_what_is_known_and_what_is_a_guess(client: TestClient) -> None:
    uuid = str(upload(client, {"hand.trc": TRC}, label="wave:2-3")["documents"][0]["id"])  # type: ignore[index]
    (card,) = listed(client)
    assert card["labels"] == [{"name": "wave", "first": 2, "last": 3}]
    passport = {**card["passport"], "rate": round(card["passport"]["rate"])}
    assert passport == {
        "unit": "mm", "metres": 0.001, "up": "Z", "rate": 120, "joints": 3, "markers": True, "guessed": ["up"],
    }  # fmt: skip
    assert mt1.read(base64.b64decode(card["thumbnail"])).markers
    stated = client.patch(f"{API}/{uuid}", json={"up": "Y"}, headers={"if-match": "*"})
    assert stated.status_code == 200
    (card,) = listed(client)
    assert (card["passport"]["up"], card["passport"]["guessed"]) == ("Y", [])
    (plain,) = client.get(API).json()["items"]
    assert (plain["thumbnail"], plain["labels"], plain["passport"]) == (None, None, None)
    assert client.get(API, params={"with": "everything"}).status_code == 422


def test_of_long_clips_the_loop_is_looked_at_again(
    database: Database, client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    head, _, rows = bvh(3000).partition(b"Frame Time: 0.0083333\n")
    still = rows.split(b"\n")[0].split()
    waved = [[*still[:3], *[b"%.4f" % angle] * 9] for angle in 40 * np.sin(np.arange(500) * 6 * np.pi / 120)]
    content = b"\n".join(
        [head + b"Frame Time: 0.0083333", *map(b" ".join, [still] * 1400 + waved + [still] * 1100), b""]
    )
    whole = store(database, {"walk.bvh": content})[0]
    monkeypatch.setattr(make_thumbnail, "MOST_POSES", 100)
    long = store(database, {"again.bvh": content})[0]
    assert len(kept(database)) == 1, "not while it is imported"
    for uuid in (whole, long):
        across = mt1.read(shown(client, uuid)).loop[:, -1, 0]
        turns = np.count_nonzero(np.diff(np.sign(np.diff(across))))
        assert turns >= 12, "three times a second"


def test_a_range_is_the_picture_of_a_clip_of_these_frames_alone(database: Database, client: TestClient) -> None:
    head, time, rows = bvh(400).partition(b"Frame Time: 0.0083333\n")
    frames = rows.splitlines()
    alone = head.replace(b"Frames: 400", b"Frames: 120") + time + b"\n".join([*frames[100:220], b""])
    whole, part = store(database, {"walk.bvh": bvh(400)})[0], store(database, {"part.bvh": alone})[0]
    before = kept(database)
    assert shown(client, whole, first=101, last=220) == shown(client, part)
    assert kept(database) == before, "it is not stored"
    assert mt1.read(shown(client, whole, first=150, last=150)).loop.shape[0] == 1
    assert shown(client, whole, first=1) == shown(client, whole, last=400) == shown(client, whole)
    for wrong in ({"first": 401}, {"first": 9, "last": 8}, {"last": 401}):
        answer = client.get(f"{API}/{whole}/thumbnail", params=wrong)
        assert (answer.status_code, "a document of 400 frames" in answer.text) == (404, True)


def test_nothing_to_draw(client: TestClient) -> None:
    uuid = str(upload(client, {"a.bvh": bvh(0)})["documents"][0]["id"])  # type: ignore[index]
    assert mt1.read(shown(client, uuid)).loop.shape[0] == 1, "its rest pose"
    assert client.get(f"{API}/none/thumbnail").status_code == 404


def test_pictures_go_with_their_document(database: Database, client: TestClient) -> None:
    from mcml_service.actions.keeping.purge_documents import purge_documents

    purge_documents(database, store(database, {"walk.bvh": bvh(30)}))
    assert kept(database) == []


def test_real_clips_are_within_a_pixel(shared: Path) -> None:
    """95 of 100 joints of the loop, at 160 pixels height, between poses too."""
    import mcml
    from mcml_service.actions.reading.make_thumbnail import _Drawing, poses_of

    files = sorted((shared / "bvh/bandai").glob("*walk*.bvh"))[:3]
    assert files
    for file in files:
        motion = mcml.read(file)
        clip = motion._clip
        poses = poses_of(clip.head)
        for block in clip.blocks():
            poses.add(block)
        drawing = _Drawing(poses, poses.step * (motion.frame_time or 0))
        thumbnail = drawing.thumbnail()
        assert thumbnail is not None
        picture = mt1.read(thumbnail.data)
        start, end = drawing.window
        times = np.arange(start, end, 1 / 24)
        at = (times - start) / (end - start) * (len(picture.loop) - 1)
        spline = _catmull_rom(picture.loop, at)
        true = make_thumbnail.poses_at(drawing.positions, drawing.spacing, times)
        middle = make_thumbnail.poses_at(drawing.points, drawing.spacing, np.array([start + (end - start) * 16 / 31]))
        view = make_thumbnail.view_of(
            drawing.skeleton, drawing.figure, middle[0], make_thumbnail.axis_of(drawing.facts["up"])
        )
        flat = true @ view.T
        flat[..., 0] -= (make_thumbnail.carried(drawing.figure, true) @ view[0])[:, None]
        drawn, real = (values - values[:, :1] for values in (spline, np.stack([flat[..., 0], -flat[..., 1]], axis=-1)))
        scale = np.ptp(drawn[..., 1]) / np.ptp(real[..., 1])
        away = np.linalg.norm(drawn - real * scale, axis=-1) * 160
        assert np.quantile(away, 0.95) < 1.5, file.name


def _catmull_rom(poses: np.ndarray, at: np.ndarray) -> np.ndarray:
    k = np.minimum(at.astype(int), len(poses) - 2)
    t = (at - k)[:, None, None]
    p = [poses[np.clip(k + step, 0, len(poses) - 1)] for step in (-1, 0, 1, 2)]
    return 0.5 * (
        2 * p[1]
        + (p[2] - p[0]) * t
        + (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3]) * t**2
        + (3 * p[1] - p[0] - 3 * p[2] + p[3]) * t**3
    )


def test_clips_of_many_joints_are_drawn_when_somebody_looks(
    database: Database, client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(make_thumbnail, "MOST_AT_IMPORT", 50)
    monkeypatch.setattr(make_thumbnail, "MOST_PLACES", 600)
    uuid = store(database, {"many.c3d": c3d_file(frames=400, points=60)})[0]
    assert kept(database) == []
    picture = mt1.read(shown(client, uuid))
    assert picture.loop.shape[1] == 48
