"""What is decided before a job runs: which clips, whether its parameters can be right, on which skeleton."""

from __future__ import annotations

from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.analysis.interface import silent
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.jobs.worker import Refused, perform
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, upload
from tests.jobs.test_jobs import wait

API = "/api/v1"

pytestmark = pytest.mark.usefixtures("lent_workers")


@pytest.fixture
def dances(database: Database) -> None:
    clips = [dance_clip("groove", tempo=tempo, bars=5, fps=30, name=f"dance_{tempo}").clip for tempo in (110, 116)]
    add_clips(database, Settings(), "dances", clips, (), "")


def start(client: TestClient, analysis: str, inputs: Any, status: int = 202, **body: Any) -> dict[str, Any]:
    answer = client.post(f"{API}/analyses/{analysis}", json={"inputs": inputs, **body})
    assert answer.status_code == status, answer.text
    found: dict[str, Any] = answer.json()
    return found


@pytest.mark.slow
@pytest.mark.usefixtures("dances")
def test_clips_that_an_analysis_made_are_left_out(client: TestClient) -> None:
    project = {"project": "dances"}
    job = start(client, "dance", project, parameters={"bpm": 112, "bars": 4})
    assert job["left_out"] == 0
    done = wait(client, job)
    assert done["state"] == "done", done
    result = client.get(f"{API}/results/{done['result']}").json()
    made = result["parts"]["clip"]["document"]
    listed = {item["id"] for item in client.get(f"{API}/documents?project=dances").json()["items"]}
    assert made in listed
    for inputs, read, left in (
        (project, listed - {made}, 1),
        ({"xpath": "//frame"}, listed - {made}, 1),
        ({**project, "include_made": True}, listed, 0),
        ({"documents": sorted(listed)}, listed, 0),
        ({"documents": [made]}, {made}, 0),
    ):
        again = start(client, "beats", inputs)
        assert {item["document"] for item in again["inputs"]} == read, inputs
        assert again["left_out"] == left, inputs
    assert wait(client, again)["state"] == "done"
    refused = start(client, "beats", {"property": ["tempo:112"]}, 422)
    assert refused["code"] == "too-few-clips"
    assert "1 that an analysis made" in refused["detail"]
    assert "include_made" in refused["remedy"]


@one_kind
@pytest.mark.usefixtures("dances")
def test_results_say_by_which_rules_they_were_made(client: TestClient) -> None:
    job = wait(client, start(client, "beats", {"project": "dances"}))
    result = client.get(f"{API}/results/{job['result']}").json()
    now = client.get(f"{API}/analyses/beats").json()["rules"]
    assert now == dict(ANALYSES["beats"].rules)
    assert {name: result["made_with"][f"rule {name}"] for name in now} == now
    assert all(analysis.rules for analysis in ANALYSES.values())


WRONG_ON_SIGHT: list[tuple[str, dict[str, Any], str]] = [
    ("dance", {"bars": 4}, "bpm-out-of-range"),
    ("dance", {"bpm": 300, "bars": 4}, "bpm-out-of-range"),
    ("dance", {"bpm": 120, "bars": 513}, "too-many-bars"),
    ("dance", {"bpm": 120, "bars": 3, "pulse": "2"}, "bars-not-divisible"),
    ("dance", {"bpm": 120, "bars": 4, "allowed": [{"document": "none"}]}, "unknown-clip"),
    ("dance", {"music": {"beats": [0.5, 1.0]}, "bars": 4}, "music-no-beats"),
    ("beats", {"clips": [{"document": "none", "source_bpm": 100}]}, "unknown-clip"),
    ("reach", {"knots": [5, 4, 9]}, "knot-order"),
    ("reach", {"times": {"none": {"t1": 1, "t2": 2, "end": 3}}}, "unknown-clip"),
    ("expression", {"markers": ["a", "b", "c"]}, "marker-sets-disjoint"),
]


@one_kind
@pytest.mark.usefixtures("dances")
def test_what_is_wrong_on_sight_is_no_job(client: TestClient) -> None:
    for analysis, parameters, code in WRONG_ON_SIGHT:
        refused = start(client, analysis, {"project": "dances"}, 422, parameters=parameters)
        assert refused["code"] == code, parameters
        assert refused["remedy"]
    assert client.get(f"{API}/jobs").json()["items"] == []


@one_kind
def test_an_unknown_analysis_is_answered_with_the_list(client: TestClient) -> None:
    for answer in (client.post(f"{API}/analyses/danse", json={}), client.get(f"{API}/analyses/danse")):
        assert answer.status_code == 404
        assert all(name in answer.json()["remedy"] for name in ANALYSES)


@pytest.mark.slow
@one_kind
@pytest.mark.usefixtures("dances")
def test_clips_of_several_skeletons_are_brought_onto_one(client: TestClient) -> None:
    """Bodies that differ are retargeted on the way; those that have the skeleton stay as they are."""
    items = client.get(f"{API}/documents?project=dances").json()["items"]
    first = items[0]["id"]
    text = client.get(f"{API}/documents/{items[1]['id']}/export?format=bvh").content
    # The same dancer with another name for a hand and longer legs.
    for name in (b"LeftForeArm", b"left_low_arm", b"LeftHand", b"left_hand"):
        text = text.replace(name, b"Strut_L" if b"rm" in name else b"Paddle_L")
    files = {"other.bvh": text}
    made: Any = upload(client, files, project="dances")
    other = made["documents"][0]["id"]
    both = {"documents": [first, other]}
    parameters = {"bpm": 112, "bars": 2}
    alone = wait(client, start(client, "dance", both, parameters=parameters))
    together = wait(client, start(client, "dance", both, parameters=parameters, skeleton=first))
    assert together["state"] == "done", together
    result = client.get(f"{API}/results/{together['result']}").json()
    clip = client.get(f"{API}/documents/{result['parts']['clip']['document']}").json()
    assert clip["skeleton"] == client.get(f"{API}/documents/{first}").json()["skeleton"]
    assert alone["state"] == "failed"
    assert alone["problem"]["code"] == "skeletons-differ"
    assert "skeleton=" in alone["problem"]["remedy"]


def test_a_skeleton_that_is_none_is_refused(client: TestClient) -> None:
    made: Any = upload(client, {"a.bvh": bvh(20)})
    uuid = made["documents"][0]["id"]
    assert start(client, "beats", {"documents": [uuid]}, 404, skeleton="none")


def test_a_job_that_waited_for_another_program_is_refused_in_words(database: Database) -> None:
    done = perform(database, "expression", [], {"tau_rule": "smallest"}, silent)
    assert isinstance(done, Refused)
    assert done.problem["code"] == "invalid-parameters"
    assert "tau_rule" in done.problem["detail"]
