"""What an eye asks of results: pictures, blocks of made motion, rows of arrays, a graph at another threshold."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Mapping
from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest
from fastapi.testclient import TestClient
from PIL import Image

from mcml_schemas.analyses.dance import BeatsParameters, DanceParameters, GraphParameters
from mcml_schemas.analyses.expression import ExpressionParameters
from mcml_schemas.analyses.reach import ReachParameters
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.analysis.dance.analyses import BEATS, DANCE, MOTION_GRAPH
from mcml_service.analysis.expression_space.analyses import EXPRESSION
from mcml_service.analysis.interface import Part, Parts, silent
from mcml_service.analysis.reach_blending.analyses import REACH
from mcml_service.storage.database import Database
from mcml_service.storage.work.results import BLOCK_BYTES
from tests.analysis.dance.motions import generated as dances
from tests.analysis.expression.face_motions import motions as faces
from tests.analysis.reach.reach_motions import generated as reaches
from tests.builders import one_kind

API = "/api/v1"
PAIR = [dances("groove", "a", bars=6, seed=1)[0], dances("step", "b", bars=6, seed=2, tempo=120.0)[0]]


@cache
def found(name: str) -> Parts:
    if name == "reach":
        return REACH.run(reaches()[0], ReachParameters(), silent)
    if name == "expression":
        return EXPRESSION.run(faces(noise=0.1), ExpressionParameters(), silent)
    if name == "beats":
        return BEATS.run(PAIR, BeatsParameters(), silent)
    if name == "motion-graph":
        return MOTION_GRAPH.run(PAIR, GraphParameters(), silent)
    parts = DANCE.run(PAIR, DanceParameters(bpm=118, bars=8), silent)
    return {key: part for key, part in parts.items() if part.clip is None}


def keep(database: Database, name: str, parts: Mapping[str, Part], analysis: str | None = None) -> str:
    with database.write("local") as tx:
        project = tx.projects.get_or_add("p")
        key, uuid = tx.results.add(project, analysis or name, f"a {name} & <b>", "local", [], {}, {})
        for part, about in parts.items():
            tx.results.add_part(key, part, about.kind, about.data, about.arrays)
    return uuid


@pytest.mark.slow
@pytest.mark.parametrize("name", ["reach", "beats", "motion-graph", "dance", "expression"])
@one_kind
def test_every_analysis_draws_its_results(client: TestClient, database: Database, name: str) -> None:
    uuid = keep(database, name, found(name))
    for picture in [None, *ANALYSES[name].pictures]:
        asked = {} if picture is None else {"name": picture}
        answer = client.get(f"{API}/results/{uuid}/picture", params=asked)
        assert (answer.status_code, answer.headers["content-type"]) == (200, "image/svg+xml"), answer.text[:300]
        assert "immutable" in answer.headers["cache-control"]
        root = ElementTree.fromstring(answer.content)
        words = [text for element in root.iter() if element.tag.endswith("}text") for text in [element.text or ""]]
        assert len(words) > 5
        drawn = [element for element in root.iter() if element.tag.endswith(("}path", "}use", "}image"))]
        assert len(drawn) > 10
        assert client.get(f"{API}/results/{uuid}/picture", params=asked).content == answer.content
    image = client.get(f"{API}/results/{uuid}/picture?format=png&dpi=50&width=6&height=4")
    assert Image.open(io.BytesIO(image.content)).size == (300, 200)


@pytest.mark.slow
@one_kind
def test_what_no_analysis_draws_is_drawn_by_its_kind(client: TestClient, database: Database) -> None:
    plain = {
        "way": Part("curve", {"x": {"name": "time", "unit": "s"}, "y": {"name": "far"}}, {"far": np.arange(50.0)}),
        "cloud": Part("points", {"unit": "mm"}, {"at": np.random.default_rng(1).normal(size=(30, 2))}),
        "web": Part("graph", {"nodes": [{"id": n} for n in range(4)], "edges": [{"from": 0, "to": 3}]}),
        "facts": Part("table", {"columns": [{"name": "who"}], "rows": [["ann"], [None], [True], [0.25]]}),
        "odd": Part("curve", {}),
        "inner": Part("model", {"a": 1}),
    }
    uuid = keep(database, "plain", plain, analysis="gone")
    for name in ("way", "cloud", "web", "facts", "odd"):
        answer = client.get(f"{API}/results/{uuid}/picture", params={"name": name})
        assert answer.status_code == 200, answer.text
        assert name in answer.text
    assert "ann" in client.get(f"{API}/results/{uuid}/picture?name=facts").text
    refused = client.get(f"{API}/results/{uuid}/picture?name=inner").json()
    assert refused["status"] == 404
    assert "way" in refused["remedy"]
    assert client.get(f"{API}/results/{uuid}/picture?dpi=2000").status_code == 422


@one_kind
def test_a_made_motion_arrives_as_one_block(client: TestClient, database: Database) -> None:
    uuid = keep(database, "reach", found("reach"))
    asked = {"parameters": {"attributes": {"age": 25, "height": 168, "hbp": 270}}}
    block = client.post(f"{API}/results/{uuid}/synthesize?format=block", json=asked).content
    (size,) = struct.unpack("<I", block[:4])
    assert size % 4 == 0
    head = json.loads(block[4 : 4 + size])
    positions = np.frombuffer(block[4 + size :], "<f4").reshape(head["motion"]["shape"])
    plain = client.post(f"{API}/results/{uuid}/synthesize?positions=true", json=asked).json()
    assert head["value"] == plain["value"]
    joints = np.array(plain["clip"]["positions"])
    assert np.abs(positions[:, : joints.shape[1]] + head["motion"]["origin"] - joints).max() < 1e-4
    assert len(head["motion"]["parents"]) == positions.shape[1] > joints.shape[1], "ends of chains are there too"
    assert head["motion"]["up"] == "Y"
    assert client.post(f"{API}/results/{uuid}/phases?format=block", json={"parameters": {"document": "x"}}).is_error


@one_kind
def test_rows_of_an_array(client: TestClient, database: Database) -> None:
    row = 1000
    values = np.arange(3 * BLOCK_BYTES // 8, dtype=np.float64)[: 1500 * row].reshape(-1, row)
    wide = np.arange(2 * BLOCK_BYTES // 2, dtype=np.float64).reshape(2, -1)
    part = Part("points", {}, {"at": values, "wide": wide, "none": np.empty((0, 3))})
    uuid = keep(database, "big", {"cloud": part}, analysis="gone")

    def rows(array: str, *wanted: int, **more: str) -> np.ndarray:
        asked = {"row": list(wanted), "format": "npy", **more}
        answer = client.get(f"{API}/results/{uuid}/cloud/{array}", params=asked)  # type: ignore[arg-type]
        assert answer.status_code == 200, answer.text
        return np.load(io.BytesIO(answer.content))  # type: ignore[no-any-return]

    last = len(values) - 1
    edges = [n for block in (1, 2) for n in (block * BLOCK_BYTES // (8 * row) - 1, block * BLOCK_BYTES // (8 * row))]
    for wanted in ([0], [last], [5, 3, 5], edges, [last, 0]):
        assert np.array_equal(rows("at", *wanted), values[wanted])
    assert np.array_equal(rows("wide", 1), wide[[1]]), "a row of several blocks"
    single = rows("at", 7, dtype="f4")
    assert (single.dtype, single.tolist()) == (np.dtype("<f4"), values[[7]].astype("<f4").tolist())
    answer = client.get(f"{API}/results/{uuid}/cloud/at?row={last + 1}")
    assert (answer.status_code, str(last) in answer.json()["detail"]) == (404, True)
    assert client.get(f"{API}/results/{uuid}/cloud/none?row=0").status_code == 404
    tags = {client.get(f"{API}/results/{uuid}/cloud/at?row={n}").headers["etag"] for n in range(3)}
    assert len(tags) == 3


@one_kind
def test_another_threshold_for_a_graph(client: TestClient, database: Database) -> None:
    """Two bars are in one component exactly where each can be reached from the other, by matrices of ways."""
    uuid = keep(database, "motion-graph", found("motion-graph"))
    graph = found("motion-graph")["graph"]
    count = len(graph.data["nodes"])
    distances = graph.arrays["jump_distances"]
    assert (np.diff(distances) >= 0).all()
    for threshold in (0.0, float(np.median(distances)), graph.data["threshold"], 10.0):
        answer = client.post(f"{API}/results/{uuid}/edges", json={"parameters": {"threshold": threshold}})
        assert answer.status_code == 200, answer.text
        value = answer.json()["value"]
        assert value["edges_in_all"] == len(value["edges"])
        assert all(edge["distance"] <= threshold for edge in value["edges"])
        reached = np.eye(count, dtype=bool)
        for edge in value["edges"]:
            reached[edge["first"] - 1, edge["second"] - 1] = True
        for _ in range(count.bit_length()):
            reached = reached @ reached
        components = np.array(value["components"])
        assert ((components[:, None] == components) == (reached & reached.T)).all()
        groups = {number: np.flatnonzero(components == number) for number in set(value["components"])}
        sizes = [len(groups[number]) for number in range(len(groups))]
        assert sizes == sorted(sizes, reverse=True)
        if threshold == graph.data["threshold"]:
            assert {bar for bar, component in enumerate(value["components"]) if component == 0} == set(
                np.flatnonzero(graph.arrays["kept"]).tolist()
            )
