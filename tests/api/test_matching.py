"""Motion matching over stored clips: documents that follow paths, the library for programs, and the command."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner

from mcml.formats import FORMATS
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.resizing import turn_up
from mcml.motion.matching.paths import Path
from mcml_service.cli import app
from mcml_service.demo import body
from mcml_service.storage.database import Database
from tests.builders import one_kind
from tests.motion.matching.curved_walks import curved_walk

API = "/api/v1"
PATH = [[1.0, 1.0], [5.0, 1.0], [5.0, 5.0]]
TURNS = (0.0, 60.0, -60.0)
WALKS = {"project": "walks", "unit": "cm"}

pytestmark = one_kind


def store(client: TestClient, name: str, clip: ClipStream, **data: str) -> str:
    content = b"".join(FORMATS["bvh"].write(clip, "bvh"))
    answer = client.post(f"{API}/documents", files=[("file", (f"{name}.bvh", content))], data=data)
    assert answer.status_code == 201, answer.text
    return str(answer.json()["documents"][0]["id"])


@pytest.fixture
def walks(client: TestClient) -> list[str]:
    """Clips of one skeleton: straight, to the left, to the right."""
    return [
        store(client, f"walk {turn:g}", curved_walk(turn, heading=40.0 * place), **WALKS, label="walk")
        for place, turn in enumerate(TURNS)
    ]


def follow(client: TestClient, **request: Any) -> dict[str, Any]:
    answer = client.post(
        f"{API}/motion-matching/path", json={"selection": {"project": "walks"}, "path": PATH, **request}
    )
    assert answer.status_code in (200, 201), answer.text
    made: dict[str, Any] = answer.json()
    return made


def roots(client: TestClient, uuid: str) -> np.ndarray:
    """(n, 3) positions of the root in cm."""
    answer = client.get(
        f"{API}/documents/{uuid}/frames", params={"space": "positions", "bone": "Root", "format": "npy"}
    )
    return np.asarray(np.load(io.BytesIO(answer.content)))[:, 0]


def test_the_stored_motion_follows_the_path(client: TestClient, walks: list[str]) -> None:
    made = follow(client, name="corner", speed=1.2)
    assert made["complete"]
    assert made["metres"] == pytest.approx(8, abs=0.8)
    assert made["left_out"] == []
    assert {segment["document"] for segment in made["composition"]} <= set(walks)
    places = roots(client, made["document"])[:, [0, 2]] / 100
    path = Path.through(np.array(PATH))
    apart = np.linalg.norm(path.places[:, None] - places, axis=2)
    # Hips sway by 2 cm beside the way of the body; corners are rounded.
    assert apart.min(axis=0).max() < made["distance"]["largest"] + 0.06
    assert made["distance"]["largest"] < 0.5
    assert np.linalg.norm(places[0] - PATH[0]) < 0.1
    assert np.linalg.norm(places[-1] - PATH[-1]) < 0.9
    steps = np.linalg.norm(np.diff(roots(client, made["document"]), axis=0), axis=1)
    assert steps.max() < 2.5 * 120 / body.RATE
    document = client.get(f"{API}/documents/{made['document']}").json()
    assert (document["name"], document["frames"]) == ("corner", made["frames"])
    labels = client.get(f"{API}/documents/{made['document']}/labels").json()["items"]
    assert {label["name"] for label in labels} == {"walk"}


@pytest.mark.slow
def test_the_composition_can_be_made_again(client: TestClient, walks: list[str]) -> None:
    made = follow(client)
    again = client.post(f"{API}/compose", json={"segments": made["composition"], "style": "inertial"}).json()
    assert again["frames"] == made["frames"]
    assert roots(client, again["document"]) == pytest.approx(roots(client, made["document"]), abs=1e-9)


def test_a_preview_stores_nothing(client: TestClient, walks: list[str]) -> None:
    before = client.get(f"{API}/documents").json()
    made = follow(client, preview=True)
    assert "document" not in made
    assert made["frames"] > 200
    assert client.get(f"{API}/documents").json() == before


@pytest.mark.slow
def test_documents_that_are_left_out_are_told(client: TestClient, walks: list[str]) -> None:
    other = store(client, "tall", body.clip("tall", 200.0, *body.walk(200.0, 3.0, 1.0, 6.0)), **WALKS)
    short = store(client, "short", curved_walk(0.0, seconds=0.03), **WALKS)
    reasons = {one["document"]: one["reason"] for one in follow(client, preview=True)["left_out"]}
    assert "another skeleton" in reasons.pop(other)
    assert "short" in reasons.pop(short)
    assert not reasons
    # Its own skeleton is asked for: the others are left out.
    alone = follow(client, preview=True, skeleton=other)
    assert {segment["document"] for segment in alone["composition"]} == {other}
    assert len(alone["left_out"]) == 4


@pytest.mark.slow
def test_an_end_that_is_not_reached_is_told(client: TestClient, walks: list[str]) -> None:
    made = follow(
        client,
        selection={"documents": walks[:1]},
        path=[[0, 0], [0, 30], [5, 30], [0, 25], [5, 20]],
        steering=0,
        preview=True,
        speed=2.0,
    )
    assert not made["complete"]
    assert any("was not reached" in notice for notice in made["notices"])


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        ({"path": [[0, 0], [0, 0]]}, "0 m long"),
        ({"path": [[0, 0], [9000, 0]]}, "9000 m long"),
        ({"path": [[0, 0]]}, "path"),
        ({"path": [[0, 0], [0, float("1e300")]]}, "path"),
        ({"selection": {}}, "selected"),
        ({"speed": 0}, "speed"),
    ],
)
def test_what_cannot_be_followed(client: TestClient, walks: list[str], request_: dict[str, Any], words: str) -> None:
    answer = client.post(
        f"{API}/motion-matching/path", json={"selection": {"project": "walks"}, "path": PATH, **request_}
    )
    assert answer.status_code == 422, answer.text
    assert words in answer.text
    assert answer.headers["content-type"].startswith("application/problem+json")


def test_no_usable_clip(client: TestClient) -> None:
    store(client, "short", curved_walk(0.0, seconds=0.05), **WALKS)
    answer = client.post(f"{API}/motion-matching/path", json={"selection": {"project": "walks"}, "path": PATH})
    assert answer.status_code == 422
    assert "short" in answer.json()["detail"]


def test_the_library_for_programs(client: TestClient, walks: list[str]) -> None:
    asked = {"selection": {"project": "walks"}}
    facts = client.post(f"{API}/motion-matching/library", json=asked).json()
    answer = client.post(f"{API}/motion-matching/library", json=asked, params={"format": "npy"})
    rows = np.load(io.BytesIO(answer.content))
    assert rows.shape == (facts["rows"], 31)
    assert [clip["document"] for clip in facts["clips"]] == sorted(walks)
    assert (facts["up"], facts["axes"], facts["rate"], facts["ahead"]) == ("Y", "ZX", 30.0, [10, 20, 30])
    assert facts["clips"][-1]["last"] == facts["rows"] - 1
    for clip in facts["clips"]:
        own = rows[clip["first"] : clip["last"] + 1]
        frames = np.round(np.arange(len(own)) / facts["rate"] / clip["seconds_per_frame"]).astype(int)
        places = roots(client, clip["document"])[frames] / 100
        # The way of the body is the smoothed one of the hips, which are 3 cm beside the root at most.
        assert own[:, 27:29] == pytest.approx(places[:, [2, 0]], abs=0.04)
        ahead = own[:, 4:6] / np.array(facts["scales"][4:6], np.float32)
        turn = own[:, 29]
        step = own[30:, 27:29] - own[:-30, 27:29]
        local = np.stack(
            [
                np.cos(turn[:-30]) * step[:, 0] + np.sin(turn[:-30]) * step[:, 1],
                np.cos(turn[:-30]) * step[:, 1] - np.sin(turn[:-30]) * step[:, 0],
            ],
            axis=1,
        )
        assert ahead[:-30] == pytest.approx(local, abs=1e-4)
        assert own[:-10, 30].all()
        assert not own[-10:, 30].any()


@pytest.mark.slow
def test_a_place_is_that_of_a_seam(client: TestClient, walks: list[str]) -> None:
    """A segment at the rotation and shift that an aligned seam tells lies where the aligned one lay."""
    pieces = [{"document": walks[0], "first": 1, "last": 100}, {"document": walks[1], "first": 50, "last": 200}]
    aligned = client.post(f"{API}/compose", json={"segments": pieces}).json()
    (seam,) = aligned["seams"]
    pieces[1]["place"] = {"degrees": seam["degrees"], "shift": seam["shift"]}
    placed = client.post(f"{API}/compose", json={"segments": pieces, "align": False}).json()
    assert placed["frames"] == aligned["frames"]
    assert roots(client, placed["document"]) == pytest.approx(roots(client, aligned["document"]), abs=1e-6)
    first = client.post(
        f"{API}/compose", json={"segments": [pieces[0] | {"place": {"degrees": 90, "shift": [10, 0, 0]}}]}
    ).json()
    plain, turned = roots(client, walks[0])[:100], roots(client, first["document"])
    expected = np.stack([plain[:, 2] + 10, plain[:, 1], -plain[:, 0]], axis=1)
    assert turned == pytest.approx(expected, abs=1e-6)


def test_an_axis_up_that_no_file_states_is_that_of_the_body(client: TestClient) -> None:
    """Clips with Z up that do not say so are aligned about Z, as if they said so."""
    made = []
    for number, stated in enumerate(({}, {"up": "Z"})):
        pieces = [
            store(client, f"{number} {turn:g}", turn_up(curved_walk(turn, heading=20 * turn), "Y", "Z"), **stated)
            for turn in (0.0, 5.0)
        ]
        segments = [{"document": piece, "first": 30, "last": 120} for piece in pieces]
        composed = client.post(f"{API}/compose", json={"segments": segments}).json()
        made.append(roots(client, composed["document"]))
        assert abs(composed["seams"][0]["degrees"]) > 20
        assert any("Z is taken" in notice for notice in composed["notices"]) is not bool(stated)
    assert made[0] == pytest.approx(made[1], abs=1e-6)
    assert np.ptp(made[0][:, 2]) < 10


@pytest.mark.slow
def test_the_command(database: Database, walks: list[str]) -> None:
    where = ["--all-of", "walks", "--database", str(database.url)]
    run = CliRunner().invoke(app, ["follow", "0,0", "3,0", "3,3", "--name", "corner", "--speed", "1.2", *where])
    assert run.exit_code == 0, run.output
    assert "made  corner" in run.output
    assert "of the path at 1.20 m/s" in run.output
    wrong = CliRunner().invoke(app, ["follow", "0;0", "3,0", *where])
    assert wrong.exit_code == 2
    assert "not two numbers" in wrong.output
