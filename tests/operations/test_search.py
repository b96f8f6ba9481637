"""What is most like a pose or a motion, against a look at everything; asked by documents, by files and by positions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.motion.bodies.poses import NEEDS, at_rate, motion_distances, pose_distances
from mcml.motion.skeleton import Array, Convention
from mcml_service.storage.database import Database
from tests.builders import TRC, bvh, one_kind, store
from tests.conftest import StoreOf
from tests.motion.bodies.made import PARTS, person
from tests.xpath.motion_twin import Document, read_documents
from tests.xpath.test_motion_functions import files_of

SEARCH = "/api/v1/search"
ALMOST = 1e-5
LEGS = [name for name in PARTS if name == "Root" or name.endswith(("leg", "foot"))]


def fill(client: Any) -> list[Document]:
    """People of several formats and rates, some of whom lack joints, one of whose rate nobody knows, and what cannot be
    compared."""
    database: Database = client.app.state.repository.database
    store(database, {"a.bvh": person(1, 90), "b.bvh": person(2, 40, 1 / 30), "c.bvh": person(3, 70)})
    store(database, files_of(Convention.FIXED, "d", person(4, 50)))
    store(database, files_of(Convention.BASE, "e", person(5, 60, 1 / 30)))
    armless = person(6, 80).replace(b"left_low_arm", b"tail").replace(b"neck1", b"hat")
    store(database, {"f.bvh": armless, "none.bvh": bvh(0), "few.bvh": bvh(9), "t.trc": TRC})
    return read_documents(database)


@pytest.fixture
def library(kind: str, store_of: StoreOf) -> tuple[TestClient, list[Document]]:
    """For tests that only read."""
    return store_of(kind, fill)


@pytest.fixture
def client(library: tuple[TestClient, list[Document]]) -> TestClient:
    return library[0]


@pytest.fixture
def documents(library: tuple[TestClient, list[Document]]) -> list[Document]:
    return library[1]


def alike(client: TestClient, **asked: Any) -> Any:
    answer = client.post(SEARCH, json=asked)
    assert answer.status_code == 200, answer.text
    return answer.json()


def nearest(distances: Array, around: int) -> list[tuple[float, int]]:
    """(distance, frame from 1) one after the other, each with its neighbours left out."""
    left = [value if np.isfinite(value) else np.inf for value in distances]
    found = []
    while left and min(left) < np.inf:
        at = left.index(min(left))
        found.append((left[at], at + 1))
        left[max(0, at + 1 - around) : at + around] = [np.inf] * len(left[max(0, at + 1 - around) : at + around])
    return found


def by_a_look_at_all(documents: list[Document], asked: Document, first: int, last: int | None, limit: int) -> list[Any]:
    rows = []
    motion = asked.features[first - 1 : last or first]
    for one in documents:
        seconds = one.body.frame_time
        if not len(one.features) or asked.body.frame_time is None or (seconds is None and last is not None):
            continue
        # A pose is a pose at any rate: where it is not known, hits are as far from each other as at 30 a second.
        seconds = seconds or 1 / 30
        if last is None:
            distances, apart = pose_distances(one.features, motion)[:, 0], 1.0
        else:
            other = motion if seconds == asked.body.frame_time else at_rate(motion, asked.body.frame_time, seconds)
            distances, apart = motion_distances(one.features, other), len(motion) * asked.body.frame_time
        rows += [(value, one.uuid, end) for value, end in nearest(distances, max(1, round(apart / seconds)))]
    return sorted(rows)[:limit]


@pytest.mark.parametrize(("name", "first", "last"), [("a", 30, None), ("f", 7, None), ("e", 11, 30), ("f", 20, 60)])
@pytest.mark.parametrize("limit", [1, 12])
def test_hits_are_those_of_a_look_at_all(
    client: TestClient, documents: list[Document], name: str, first: int, last: int | None, limit: int
) -> None:
    (asked,) = (one for one in documents if one.name == name)
    found = alike(client, document=asked.uuid, first=first, last=last, limit=limit)
    wanted = by_a_look_at_all(documents, asked, first, last, limit)
    assert [(hit["document"], hit["last"]) for hit in found["hits"]] == [(uuid, end) for _, uuid, end in wanted]
    np.testing.assert_allclose(
        [hit["distance"] for hit in found["hits"]], [value for value, _, _ in wanted], atol=ALMOST
    )
    assert found["frames"] == (last or first) - first + 1
    assert ("neck1" in found["joints"]) == (name != "f")
    assert f"{3 if last is None else 4} of 9 documents left out" in found["warnings"][0]
    if last is None:
        assert all(hit["first"] == hit["last"] for hit in found["hits"])


def test_a_hit_is_where_the_motion_is(client: TestClient, documents: list[Document]) -> None:
    """From its first frame on a stretch is as like the motion as is said, and no part of it would do."""
    (asked,) = (one for one in documents if one.name == "c")
    by_id = {one.uuid: one for one in documents}
    motion = asked.features[9:40]
    found = alike(client, document=asked.uuid, first=10, last=40, limit=9)["hits"]
    assert (found[0]["document"], found[0]["first"], found[0]["last"]) == (asked.uuid, 10, 40)
    for hit in found:
        own = by_id[hit["document"]]
        seconds = own.body.frame_time or 0
        other = motion if seconds == asked.body.frame_time else at_rate(motion, asked.body.frame_time or 0, seconds)
        within = motion_distances(own.features[hit["first"] - 1 : hit["last"]], other)
        assert within[-1] == pytest.approx(hit["distance"], abs=ALMOST)
        later = motion_distances(own.features[hit["first"] : hit["last"]], other)
        assert not later[-1] < hit["distance"] - ALMOST


def places(document: Document, frames: slice) -> Array:
    """(frames, joints, 3) of all joints of PARTS, in steps."""
    stretch = document.body.stretch(NEEDS)
    return np.stack([stretch.at(name) for name in NEEDS], axis=1)[frames]


def turned(points: Array, degrees: float) -> Array:
    """About the axis Y."""
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    x, y, z = points.transpose(2, 0, 1)
    return np.stack([x * cosine + z * sine, y, z * cosine - x * sine], axis=2)


@pytest.mark.parametrize(("frames", "up"), [(slice(20, 21), None), (slice(20, 60), "Y")])
@one_kind
def test_positions_find_their_body_however_it_stands(
    client: TestClient, documents: list[Document], frames: slice, up: str | None
) -> None:
    own = documents[0]
    points = turned(places(own, frames), 130) * 3.5 + [1000, 0, 50]
    listed = [[None if np.isnan(point).any() else point.tolist() for point in frame] for frame in points]
    asked = {"joints": list(NEEDS), "positions": listed, "seconds_per_frame": own.body.frame_time, "up": up}
    best = alike(client, **asked, limit=1)["hits"][0]
    assert (best["document"], best["first"], best["last"]) == (own.uuid, frames.start + 1, frames.stop)
    assert best["distance"] < 1e-3
    without = [name for name in NEEDS if "arm" not in name and "hand" not in name]
    fewer = [[frame[NEEDS.index(name)] for name in without] for frame in listed]
    found = alike(client, **{**asked, "joints": without, "positions": fewer}, limit=1)
    assert found["hits"][0]["document"] == own.uuid
    assert not any("hand" in name for name in found["joints"])


@one_kind
def test_a_file_that_is_not_stored_is_asked(client: TestClient, documents: list[Document]) -> None:
    before = client.get("/api/v1/documents").json()["total"]
    files = [("file", one) for one in files_of(Convention.BASE, "new", person(2, 40, 1 / 30)).items()]
    fields = {"first": 5, "last": 30, "limit": 2, "within": [documents[1].uuid, documents[2].uuid]}
    answer = client.post(f"{SEARCH}/file", files=files, data=fields)
    assert answer.status_code == 200, answer.text
    best = answer.json()["hits"][0]
    assert (best["document"], best["first"], best["last"]) == (documents[1].uuid, 5, 30)
    assert best["distance"] < 1e-3
    assert client.get("/api/v1/documents").json()["total"] == before


POINTS = [[[0, 1, 2]] * len(LEGS)]


@pytest.mark.parametrize(
    ("asked", "status", "words"),
    [
        ({}, 422, "either `document`"),
        ({"document": "A", "positions": POINTS, "joints": LEGS}, 422, "either `document`"),
        ({"document": "nobody"}, 404, "no document nobody"),
        ({"document": "A", "first": 91}, 404, "a clip of 90 frames"),
        ({"document": "A", "first": 9, "last": 3}, 404, "Frames 9 to 3"),
        ({"document": "NONE"}, 404, "a clip of 0 frames"),
        ({"document": "FEW"}, 422, "shows no pose"),
        ({"document": "A", "revision": 7}, 404, "revision"),
        ({"document": "A", "within": ["nobody"]}, 404, "nobody"),
        ({"document": "A", "project": "nobody's"}, 404, "nobody's"),
        ({"joints": LEGS, "positions": [[[0, 1, 2]]]}, 422, "each frame of `positions`"),
        ({"joints": LEGS, "positions": POINTS * 2}, 422, "seconds_per_frame"),
        ({"joints": LEGS[1:], "positions": [POINTS[0][1:]]}, 422, "A pose needs the positions of Root"),
        ({"joints": LEGS[:-1] + LEGS[:1], "positions": POINTS}, 422, "needs the positions"),
        ({"joints": [*LEGS, "Root"], "positions": [[*POINTS[0], None]]}, 422, "named twice"),
        ({"joints": LEGS, "positions": POINTS, "up": "Q"}, 422, "Unknown axis"),
        ({"joints": LEGS, "positions": POINTS}, 422, "shows no pose"),
        ({"joints": LEGS, "positions": [[None] * len(LEGS)]}, 422, "shows no pose"),
        ({"document": "A", "limit": 0}, 422, "limit"),
    ],
)
@one_kind
def test_what_cannot_be_asked_is_told(
    client: TestClient, documents: list[Document], asked: dict[str, Any], status: int, words: str
) -> None:
    ids = {one.name.upper(): one.uuid for one in documents}
    asked = {name: ids.get(value, value) if name == "document" else value for name, value in asked.items()}
    answer = client.post(SEARCH, json=asked)
    assert answer.status_code == status, answer.text
    assert words in answer.text


@one_kind
def test_files_that_cannot_be_asked_are_told(client: TestClient, documents: list[Document]) -> None:
    files = [("file", (f"{name}.bvh", person(1, 9))) for name in "ab"]
    for sent, fields, words in (
        (files, {}, "hold 2 clips"),
        (files[:1], {"first": 10}, "a clip of 9 frames"),
        (files[:1], {"first": 200_000}, "first 100,000 frames"),
        ([("file", ("x.bvh", b"HIERARCHY"))], {}, "x.bvh"),
        ([("file", ("x.bvh", bvh(3)))], {}, "shows no pose"),
    ):
        answer = client.post(f"{SEARCH}/file", files=sent, data=fields)
        assert 400 <= answer.status_code < 500
        assert words in answer.text, answer.text
