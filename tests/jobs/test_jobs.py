"""Jobs from request to result: run by real workers, followed, cancelled, retried, taken up again."""

from __future__ import annotations

import io
import json
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import httpx
import numpy as np
import pytest
from fastapi.testclient import TestClient

import mcml_service.jobs.runner
from mcml_service.actions.importing.load_demo import REACHES, add_clips
from mcml_service.demo.reach_clips import reach_clips
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.work.jobs import ENDED
from tests.builders import one_kind, served
from tests.jobs import works

pytestmark = pytest.mark.above_store

API = "/api/v1"
Client: TypeAlias = TestClient | httpx.Client
SETTINGS = Settings(job_workers=1)


def fill(database: Database) -> None:
    """Twelve reaches of six people."""
    clips = [item.clip for item in reach_clips(3, young=(2, 2, 2), old=(2, 2, 2))]
    add_clips(database, SETTINGS, REACHES, clips, (), "")


@pytest.fixture
def own_server(database: Database) -> Iterator[TestClient]:
    """With workers of its own, which may die."""
    fill(database)
    with served(database, SETTINGS) as client:
        yield client


@pytest.fixture
def server(lent_workers: None, own_server: TestClient) -> TestClient:
    return own_server


def start(server: Client, **parameters: Any) -> dict[str, Any]:
    body = {"inputs": {"project": REACHES}, "parameters": {"components": 4, **parameters}, "name": "a model"}
    answer = server.post(f"{API}/analyses/reach", json=body)
    assert answer.status_code == 202, answer.text
    job: dict[str, Any] = answer.json()
    assert answer.headers["location"] == f"{API}/jobs/{job['id']}"
    return job


def wait(server: Client, job: dict[str, Any], until: Callable[[dict[str, Any]], bool] | None = None) -> dict[str, Any]:
    """The job once it has ended, or earlier; the test's time limit ends what never comes."""
    while True:
        found: dict[str, Any] = server.get(f"{API}/jobs/{job['id']}").json()
        if found["state"] in ENDED or (until is not None and until(found)):
            return found
        time.sleep(0.05)


def instead(monkeypatch: pytest.MonkeyPatch, work: Callable[..., Any]) -> None:
    """Let workers do this, of the module `works`."""
    monkeypatch.setattr(mcml_service.jobs.runner, "work_on", work)


@pytest.mark.slow
def test_a_model_is_fitted_used_and_deleted(server: TestClient, database: Database) -> None:
    job = start(server)
    # The runner is woken before the answer is read, and may have been quicker.
    assert job["state"] in {"waiting", "running"}
    assert len(job["inputs"]) == 12
    done = wait(server, job)
    assert (done["state"], done["share"], done["stage"], done["attempt"]) == ("done", 1.0, "done", 1)
    result = server.get(f"{API}/results/{done['result']}").json()
    assert result["inputs"] == job["inputs"]
    assert result["parameters"]["components"] == 4
    assert set(result["made_with"]) == {"mcml-repository", "numpy", "scipy", "rule fit"}
    assert {"synthesize", "phases"} <= set(result["operations"])
    name, part = next((name, part) for name, part in result["parts"].items() if part["arrays"])
    array = next(iter(part["arrays"]))
    assert server.get(f"{API}/results/{result['id']}/{name}").json() == part
    values = np.load(io.BytesIO(server.get(f"{API}/results/{result['id']}/{name}/{array}?format=npy").content))
    assert list(values.shape) == part["arrays"][array]["shape"]
    rows = server.get(f"{API}/results/{result['id']}/{name}/{array}", params={"first": 1, "rows": 2}).json()
    assert np.array_equal(np.array(rows["values"], dtype=values.dtype), values[1:3])

    wish = {"parameters": {"attributes": {"age": 40, "height": 172, "hbp": 320}}}
    use = f"{API}/results/{result['id']}/synthesize"
    first = server.post(use, json=wish)
    assert first.status_code == 200, first.text
    assert first.json()["clip"]["frames"] == first.json()["value"]["frames"]
    assert "document" not in first.json()
    shown = server.post(use, params={"positions": True}, json=wish).json()["clip"]
    assert np.array(shown["positions"]).shape == (shown["frames"], len(shown["joints"]), 3)
    points = np.load(io.BytesIO(server.post(use, params={"format": "npy"}, json=wish).content))
    assert np.allclose(points, shown["positions"], atol=1e-3)
    file = server.post(use, params={"format": "bvh"}, json=wish)
    assert file.content.startswith(b"HIERARCHY")

    saved = server.post(use, json=wish | {"save": True, "name": "reach at 40", "project": "made"}).json()
    document = server.get(f"{API}/documents/{saved['document']}").json()
    assert (document["name"], document["project"], document["frames"]) == ("reach at 40", "made", len(points))
    record = json.loads(next(item["value"] for item in document["properties"] if item["name"] == "provenance"))
    assert (record["result"], record["sources"]) == (result["id"], job["inputs"])
    exported = server.get(f"{API}/documents/{saved['document']}/export", params={"format": "bvh"}).content
    assert exported.count(b"\n") == file.content.count(b"\n")
    positions = server.get(
        f"{API}/documents/{saved['document']}/frames", params={"format": "npy", "space": "positions"}
    ).content
    assert np.allclose(np.load(io.BytesIO(positions)), points, atol=1e-3)

    assert [item["id"] for item in server.get(f"{API}/results").json()["items"]] == [result["id"]]
    assert server.delete(f"{API}/results/{result['id']}").status_code == 204
    assert server.post(use, json=wish).status_code == 404
    assert server.get(f"{API}/results").json()["items"] == []
    assert server.get(f"{API}/jobs/{job['id']}").json()["state"] == "done"
    assert database.check() == []


def test_progress_arrives_as_events(server: TestClient) -> None:
    job = start(server)
    kinds, shares = [], []
    with server.stream("GET", f"{API}/jobs/{job['id']}/events") as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        for line in stream.iter_lines():
            if line.startswith("event: "):
                kinds.append(line.removeprefix("event: "))
            elif line.startswith("data: "):
                shares.append(json.loads(line.removeprefix("data: "))["share"])
    assert kinds[-1] == "end"
    assert set(kinds[:-1]) == {"progress"}
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@one_kind
def test_what_does_not_fit_is_said_before_the_job(server: TestClient) -> None:
    def refused(body: dict[str, Any], name: str = "reach") -> dict[str, Any]:
        answer = server.post(f"{API}/analyses/{name}", json=body)
        assert 400 <= answer.status_code < 500
        problem: dict[str, Any] = answer.json()
        return problem

    assert refused({"inputs": {}})["code"] == "nothing-selected"
    assert refused({"inputs": {"project": "nothing"}})["status"] == 404
    assert refused({"inputs": {"documents": ["nobody"]}})["status"] == 404
    assert refused({"inputs": {"project": REACHES, "property": ["age:200.."]}})["code"] == "too-few-clips"
    assert "components" in refused({"inputs": {"project": REACHES}, "parameters": {"components": 0}})["detail"]
    assert "wrong" in refused({"inputs": {"project": REACHES}, "parameters": {"wrong": 1}})["detail"]
    assert refused({"inputs": {"project": REACHES}}, "nothing")["status"] in (404, 405)
    assert server.get(f"{API}/jobs").json()["items"] == []


@one_kind
def test_what_only_the_analysis_can_see_fails_the_job(server: TestClient) -> None:
    failed = wait(server, start(server, attributes=["shoe"]))
    assert failed["state"] == "failed"
    assert failed["problem"]["code"]
    assert failed["problem"]["remedy"]
    assert server.get(f"{API}/results").json()["items"] == []


@one_kind
def test_selections_by_property_and_xpath(server: TestClient) -> None:
    young = {"inputs": {"project": REACHES, "property": ["age:..40"]}, "parameters": {}}
    assert len(server.post(f"{API}/analyses/reach", json=young).json()["inputs"]) == 6
    some = {"inputs": {"xpath": "//property[@name='subject'][@value='S02']"}}
    assert len(server.post(f"{API}/analyses/beats", json=some).json()["inputs"]) == 2


@pytest.mark.slow
def test_a_running_job_is_cancelled(server: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    instead(monkeypatch, works.endless)
    job = start(server)
    waiting = start(server)
    assert wait(server, job, lambda found: found["stage"] == "for ever")["share"] == 0.5
    assert server.delete(f"{API}/jobs/{waiting['id']}").json()["state"] == "cancelled"
    assert server.delete(f"{API}/jobs/{job['id']}").status_code == 202
    assert wait(server, job)["state"] == "cancelled"
    assert server.get(f"{API}/results").json()["items"] == []


@pytest.mark.slow
@one_kind
def test_a_worker_that_does_not_listen_is_killed(own_server: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mcml_service.jobs.runner, "KILL_SECONDS", 0.5)
    instead(monkeypatch, works.deaf)
    job = start(own_server)
    wait(own_server, job, lambda found: found["stage"] == "deaf")
    own_server.delete(f"{API}/jobs/{job['id']}")
    assert wait(own_server, job)["state"] == "cancelled"
    monkeypatch.undo()
    assert wait(own_server, start(own_server))["state"] == "done"


@one_kind
@pytest.mark.fuzz  # Long: in `make test` a team's worker is lost (test_team).
def test_a_lost_worker_is_replaced(own_server: TestClient, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    instead(monkeypatch, partial(works.dying, 1, str(tmp_path / "marks")))
    done = wait(own_server, start(own_server))
    assert done["state"] == "done"
    assert own_server.get(f"{API}/results/{done['result']}/numbers").json()["data"] == {"value": 1}


@one_kind
@pytest.mark.fuzz  # Long: in `make test` beside another job (test_host_workers).
def test_a_job_that_kills_its_workers_is_given_up(
    own_server: TestClient, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    instead(monkeypatch, partial(works.dying, 99, str(tmp_path / "marks")))
    failed = wait(own_server, start(own_server))
    assert failed["state"] == "failed"
    assert "died" in failed["problem"]["detail"]
    assert "MCML_JOB_MEMORY_MIB" in failed["problem"]["remedy"]
    monkeypatch.undo()
    assert wait(own_server, start(own_server))["state"] == "done"


@pytest.mark.slow
@pytest.mark.usefixtures("lent_workers")
def test_a_job_whose_server_was_killed_is_taken_up(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    fill(database)
    with database.read() as tx:
        inputs = [
            {"document": item.uuid, "revision": 1}
            for item in tx.documents.page(DocumentFilter(project=REACHES), after=None, limit=100)
        ]
    with database.write() as tx:
        # As a server leaves it that is killed in the middle: running, its lease not yet over.
        monkeypatch.setattr("mcml_service.storage.work.jobs.LEASE_SECONDS", 0.5)
        uuid = tx.jobs.add(
            tx.projects.get(REACHES), "reach", "a model", "kim", inputs, {"components": 4}, runner="a dead one"
        )
    monkeypatch.undo()
    with served(database, SETTINGS) as server:
        done = wait(server, {"id": uuid})
    assert (done["state"], done["attempt"], done["owner"]) == ("done", 2, "kim")


@pytest.mark.slow
def test_a_server_that_stops_leaves_its_jobs(
    database: Database, kind: str, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    """It kills the worker, be it its own or one of a team, which goes on."""
    if kind == "postgresql":
        request.getfixturevalue("lent_workers")
    fill(database)
    instead(monkeypatch, works.endless)
    with served(database, SETTINGS) as server:
        job = start(server)
        wait(server, job, lambda found: found["stage"] == "for ever")
    monkeypatch.undo()
    with database.read() as tx:
        assert (tx.jobs.get(job["id"]).state, tx.jobs.get(job["id"]).attempt) == ("waiting", 0)
    request.getfixturevalue("lent_workers")
    with served(database, SETTINGS) as server:
        assert wait(server, job)["state"] == "done"
