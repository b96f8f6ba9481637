"""The space of expressions over HTTP: built, walked, refined, played, extended."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml_service.actions.analysing.use_result import Results
from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.demo.face_takes import EXPRESSIONS, face_takes
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import one_kind
from tests.jobs.test_jobs import wait

API = "/api/v1"

pytestmark = [pytest.mark.usefixtures("lent_workers"), pytest.mark.above_store]


def use(client: TestClient, result: str, operation: str, **parameters: Any) -> dict[str, Any]:
    saving = {key: parameters.pop(key) for key in ("save", "name") if key in parameters}
    answer = client.post(f"{API}/results/{result}/{operation}", json={"parameters": parameters, **saving})
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


@pytest.mark.slow
def test_from_takes_to_an_animation(client: TestClient, database: Database) -> None:
    takes = [take.clip for take in face_takes(2, expressions=EXPRESSIONS[:3], every_marker=5, fps=30)]
    add_clips(database, Settings(), "faces", takes[:2], (), "")
    body = {"inputs": {"project": "faces"}, "parameters": {}}
    done = wait(client, client.post(f"{API}/analyses/expression", json=body).json())
    assert done["state"] == "done", done
    space = done["result"]
    parts = client.get(f"{API}/results/{space}").json()["parts"]
    assert {"space", "map", "levels", "links", "tau"} <= set(parts)
    points = use(client, space, "points")["value"]
    level = use(client, space, "level", level=0)["value"]
    assert len(level["candidates"]) >= 2
    ends = [{key: level["candidates"][place][key] for key in ("document", "frame")} for place in (0, -1)]
    assert use(client, space, "neighbours", level=0, **ends[0])["value"]
    near = {item["id"] for item in use(client, space, "neighbours", level=0, **ends[0])["value"]["neighbours"]}
    far = next(item for item in level["candidates"][1:] if item["id"] not in near)
    asked = {"level": 0, "keys": [ends[0], {key: far[key] for key in ("document", "frame")}]}
    refused = client.post(f"{API}/results/{space}/path", json={"parameters": asked})
    assert (refused.status_code, refused.json()["code"]) == (422, "not-linked")
    chain = refused.json()["details"]["suggestion"]
    assert [chain[0], chain[-1]] == asked["keys"]
    assert use(client, space, "path", level=0, keys=chain)["result"]
    walked = use(client, space, "path", level=0, keys=ends, auto_route=True)
    path = walked["result"]
    assert client.get(f"{API}/results", params={"parent": space}).json()["items"][0]["id"] == path
    finer = use(client, path, "refine", level=2, auto=True)
    assert finer["result"] not in (None, path)
    assert finer["value"]["length_mm"] <= 1.1 * walked["value"]["length_mm"] + 1e-6
    played = use(client, finer["result"], "playback", fps=30, save=True, name="from face to face")
    document = client.get(f"{API}/documents/{played['document']}").json()
    assert document["name"] == "from face to face"
    assert document["frames"] == played["clip"]["frames"]
    for format in ("trc", "c3d", "mcml"):
        exported = client.get(f"{API}/documents/{document['id']}/export", params={"format": format})
        assert exported.status_code == 200
    first = np.load(io.BytesIO(client.get(f"{API}/documents/{document['id']}/frames?format=npy").content))[0]
    assert np.isfinite(first).all()

    add_clips(database, Settings(), "more", takes[2:], (), "")
    grown = {"inputs": {"project": "more"}, "extends": space}
    done = wait(client, client.post(f"{API}/analyses/expression", json=grown).json())
    assert done["state"] == "done", done
    found = client.get(f"{API}/results/{done['result']}").json()
    assert (found["parent"], len(found["inputs"])) == (space, 3)
    more = use(client, done["result"], "points")["value"]
    assert len(more["x"]) > len(points["x"])
    assert more["x"][: len(points["x"])] == points["x"], "what was there stays where it is"
    # An old path still walks in the space it was made in.
    assert use(client, path, "playback", fps=30)["clip"]["frames"] > 1


@one_kind
def test_what_cannot_be_extended(client: TestClient, database: Database) -> None:
    add_clips(database, Settings(), "faces", [face_takes(2, every_marker=10, fps=30)[0].clip], (), "")
    unknown = {"inputs": {"project": "faces"}, "extends": "nothing"}
    assert client.post(f"{API}/analyses/expression", json=unknown).status_code == 404
    other = {"inputs": {"project": "faces"}, "extends": "nothing"}
    assert client.post(f"{API}/analyses/beats", json=other).status_code == 422, "beats cannot grow"


@one_kind
def test_a_misplaced_parameter_is_named(client: TestClient) -> None:
    keys = [{"document": "a", "frame": 1}]
    for body in ({"keys": keys}, {"keys": keys, "parameters": {"keys": keys}}, {"save": True}):
        answer = client.post(f"{API}/results/no-such/path", json=body)
        assert answer.status_code == 422
        places = {error["in"] for error in answer.json()["errors"]}
        assert places == {f"body.{name}" for name in ("keys", "parameters") if (name in body) == (name == "keys")}


@one_kind
def test_versions_of_a_path_share_the_space(client: TestClient, database: Database) -> None:
    takes = [take.clip for take in face_takes(3, expressions=EXPRESSIONS[:2], every_marker=8, fps=24)]
    add_clips(database, Settings(), "faces", takes, (), "")
    done = wait(client, client.post(f"{API}/analyses/expression", json={"inputs": {"project": "faces"}}).json())
    space = done["result"]
    level = use(client, space, "level", level=0)["value"]
    keys = [{key: level["candidates"][place][key] for key in ("document", "frame")} for place in (0, -1)]
    path = use(client, space, "path", level=0, keys=keys, auto_route=True)["result"]
    versions = [path]
    for level in (1, 2):
        versions.append(use(client, versions[-1], "refine", level=level, auto=True)["result"])
    results = client.app.state.repository.results  # type: ignore[attr-defined]
    warm = [use(client, uuid, "playback", fps=24)["value"] for uuid in versions]
    # Started anew, the last version first: whatever is not ready is read, once.
    cold = Results(database, Settings())
    assert [cold.use(uuid, "playback", {"fps": 24}, author="").answer.value.length_mm for uuid in versions[::-1]] == [
        value["length_mm"] for value in warm[::-1]
    ]
    for kept in (results, cold):
        assert len({id(kept._prepare(uuid)[1].positions) for uuid in [*versions, space]}) == 1
    grown = {"inputs": {"project": "faces"}, "extends": path}
    refused = client.post(f"{API}/analyses/expression", json=grown)
    assert refused.json()["code"] == "not-extendable"
