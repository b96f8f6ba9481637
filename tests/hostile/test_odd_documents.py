"""Odd documents in a library of good ones: whatever is asked, nothing fails, and the good ones answer as before."""

from __future__ import annotations

from contextlib import suppress
from random import Random
from typing import Any

import pytest
from fastapi.testclient import TestClient
from hypothesis import settings

from mcml.errors import McmlError
from mcml_schemas.jobs import Selection
from mcml_service.actions.analysing.start_analysis import find_analysis, start_analysis
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.clips.derive import derive_missing
from mcml_service.jobs.runner import run_here
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests import fuzz
from tests.builders import one_kind, store
from tests.motion.bodies.made import person
from tests.odd_documents import ODD, odd_document

pytestmark = [one_kind, pytest.mark.filterwarnings("ignore::RuntimeWarning")]
API = "/api/v1"
QUESTIONS = (
    "//frame[mo:height('left_hand') > 0.5]/@id", "//frame[mo:speed('right_hand') > 1]/@id",
    "//frame[mo:acceleration('left_hand') > 1]/@id", "//frame[mo:contact('left_foot')]/@id",
    "//frame[mo:angle('left-knee-flexion') > 20]/@id", "//frame[mo:angle('left-forearm-pronation') > 2]/@id",
    "//frame[mo:angle('head-flexion') > 2]/@id", "//frame[mo:angle('pelvis-anterior-tilt') > 2]/@id",
    "//frame[mo:heading() > 0]/@id", "//frame[mo:tilt('Root', 'Head') > 10]/@id",
    "//frame[mo:position('Head', 'front', 'Root') > 0]/@id", "//frame[mo:distance('left_hand', 'Head') < 0.5]/@id",
    "//frame[mo:pose-distance('good', 3) < 1]/@id", "//frame[mo:motion-distance('good', 3, 10) < 1]/@id",
    "//frame[mo:unit() = 0.01]/@id", "//frame[mo:leg() > 0.7]/@id",
)  # fmt: skip
EXPORTS = (
    "bvh", "asf-amc", "htr", "trc", "c3d", "csv", "glb", "usd", "sto", "mot", "npz", "parquet", "arrow", "mcml",
)  # fmt: skip
EDITS = (
    {"do": "mirror", "first": 1, "last": 1}, {"do": "smooth", "first": 1, "last": 1, "seconds": 0.1},
    {"do": "resample", "rate": 77}, {"do": "crop", "first": 1, "last": 1}, {"do": "reverse", "first": 1, "last": 1},
    {"do": "fill", "first": 1, "last": 1}, {"do": "low-pass", "first": 1, "last": 1, "hertz": 6}, {"do": "unroll"},
    {"do": "despike", "first": 1, "last": 1},
    {"do": "lock-feet", "first": 1, "last": 1}, {"do": "loop", "first": 1, "last": 1},
    {"do": "pose", "first": 1, "last": 1, "handles": [{"handle": "hips", "turn": [0, 9, 0]}]},
    {"do": "pose", "first": 1, "last": 1, "handles": [{"handle": "head", "move": [0, 1, 0]}]},
)  # fmt: skip


def third(place: int) -> list[Any]:
    """Of three tests, `make test` gives each odd document to one; those of many joints or markers to the first."""
    many = [odd for odd in ODD if odd.startswith("many")]
    few = fuzz.share((odd for odd in ODD if odd not in many), 3, first=place)
    return few + (many if place == 0 else [pytest.param(odd, marks=pytest.mark.fuzz) for odd in many])


def answers(client: TestClient, good: list[str]) -> dict[str, Any]:
    """What the good documents answer, by question."""
    found: dict[str, Any] = {}
    for question in QUESTIONS:
        answer = client.get(f"{API}/xpath", params={"q": question, "limit": 1000})
        assert answer.status_code == 200, (question, answer.text)
        items = answer.json()["items"]
        found[question] = [(item["document"], item["value"]) for item in items if item["document"] in good]
    for last in (None, 12):
        asked = {"document": good[0], "first": 3, "last": last, "limit": 50}
        answer = client.post(f"{API}/search", json=asked)
        assert answer.status_code == 200, answer.text
        found[f"search {last}"] = [hit for hit in answer.json()["hits"] if hit["document"] in good]
    return found


@pytest.mark.slow
@pytest.mark.parametrize("kind_of_odd", third(0))
def test_good_documents_answer_beside_odd_ones(client: TestClient, database: Database, kind_of_odd: str) -> None:
    good = store(database, {"good.bvh": person(3)}) + store(database, {"better.bvh": person(4)})
    before = answers(client, good)
    (odd,) = store(database, ODD[kind_of_odd])
    _check_same(before, answers(client, good))
    derive_missing(database, lambda done, of: None)
    _check_same(before, answers(client, good))
    # What an odd document has no hand or head for is told by its name.
    if kind_of_odd not in ("no frames", "one frame", "two frames", "seen by turns", "seen late"):
        asked = client.post(f"{API}/search", json={"document": good[0], "first": 3})
        if odd not in {hit["document"] for hit in asked.json()["hits"]}:
            assert "'odd'" in " ".join(asked.json()["warnings"])
    if kind_of_odd in ("no labels", "no bones", "a root alone", "one joint", "many joints", "many markers"):
        asked = client.get(f"{API}/xpath", params={"q": "//frame[mo:height('left_hand') > 0.5]"})
        assert any("'odd'" in line and "left_hand" in line for line in asked.json()["warnings"])
        asked = client.get(f"{API}/xpath", params={"q": "//frame[mo:angle('left-forearm-pronation') > 2]"})
        assert any("'odd'" in line for line in asked.json()["warnings"])


@pytest.mark.slow
@pytest.mark.parametrize("frame_time", [1e-9, 1e-6, 1e5])
def test_a_frame_time_that_cannot_be_stops_no_comparison(
    client: TestClient, database: Database, frame_time: float
) -> None:
    """A motion of a tenth of a second would have millions of its frames."""
    good = store(database, {"good.bvh": person(3)}) + store(database, {"better.bvh": person(4)})
    before = answers(client, good)
    store(database, {"odd.bvh": person(5, 60, frame_time)})
    _check_same(before, answers(client, good))


@pytest.mark.slow
@pytest.mark.parametrize("kind_of_odd", third(1))
def test_nothing_fails_at_an_odd_document(client: TestClient, database: Database, kind_of_odd: str) -> None:
    good = store(database, {"good.bvh": person(3)})[0]
    (odd,) = store(database, ODD[kind_of_odd])
    _ask_everything(client, odd, good, kind_of_odd.startswith("many"))


@pytest.mark.parametrize("kind_of_odd", third(2))
def test_analyses_of_odd_documents_end_with_a_reason(database: Database, kind_of_odd: str) -> None:
    own = Settings()
    store(database, {"good.bvh": person(3, 120)})
    store(database, ODD[kind_of_odd])
    queries = Queries(database, own)
    for analysis in ANALYSES.values():
        parameters = {"bpm": 100} if analysis.name == "dance" else {}
        made = find_analysis(analysis.name)
        try:
            uuid = start_analysis(
                database, queries, own, made, Selection(project="default"), parameters, author="a", runner="r"
            )
            with database.read() as tx:
                job = tx.jobs.get(uuid)
            run_here(database, own, job, "r", lambda stage, share: None)
        except McmlError:
            continue
        with database.read() as tx:
            ended = tx.jobs.get(uuid)
        assert ended.state == "done" or ended.problem["status"] < 500, ended
    queries.close()


@pytest.mark.fuzz(seeds=6)
def test_odd_documents_that_chance_makes(client: TestClient, database: Database, seed: int) -> None:
    """50 of them in one library: nothing fails, and the good documents answer as before."""
    chance = Random(seed)
    good = store(database, {"good.bvh": person(3)}) + store(database, {"better.bvh": person(4)})
    before = answers(client, good)
    count = 50 if settings.get_current_profile_name() == "fuzz" else 6
    stored = []
    while len(stored) < count:
        with suppress(McmlError):
            stored += store(database, odd_document(chance))
    _check_same(before, answers(client, good))
    for odd in stored:
        _ask_everything(client, odd, good[0], chance.random() < 0.8)
    _check_same(before, answers(client, good))


def _check_same(before: dict[str, Any], now: dict[str, Any]) -> None:
    """Answers of the good ones are as before; of hits so many are told as are among the nearest of all."""
    for question, found in now.items():
        wanted = before[question]
        if not question.startswith("search"):
            assert found == wanted, question
            continue
        for one, other in zip(found, wanted, strict=False):
            # Distances come from an index in single precision, made over all documents.
            assert one == {**other, "distance": pytest.approx(other["distance"], abs=1e-6)}, question


def _ask_everything(client: TestClient, odd: str, good: str, long: bool) -> None:
    """Ask for all that a document has; long: a document for which that takes long, so less of it."""
    of = f"/documents/{odd}"
    both = [odd, good]
    asked: list[tuple[str, str, dict[str, Any]]] = [
        ("GET", path, {}) for path in (
            "/documents", "/facets", "/skeletons", of, f"{of}/thumbnail", f"{of}/calibration", f"{of}/skeleton",
            f"{of}/rest", f"{of}/labels", f"{of}/labels/suggested", f"{of}/children", f"{of}/mcml",
            f"{of}/revisions", f"{of}/frames",
        )
    ]  # fmt: skip
    for name in EXPORTS[::5] if long else EXPORTS:
        asked.append(("GET", f"{of}/export", {"params": {"format": name}}))
        asked.append(("POST", "/exports", {"json": {"format": name, "documents": both}}))
    for quantity in ("time", "height:left_hand", "speed:left_hand", "contact:left_foot", "angle:left-knee-flexion",
                     "angle:left-forearm-pronation", "heading", "position:Head,left,Root"):  # fmt: skip
        asked.append(("GET", f"{of}/frames", {"params": {"quantity": quantity, "format": "csv"}}))
    asked += [("POST", "/search", {"json": {"document": odd, "first": 1}})]
    asked += [("POST", f"/documents/{a}/retarget", {"json": {"target": b, "name": "x"}}) for a, b in (both, both[::-1])]
    asked += [
        # Few frames: of a millionth of a second they become many.
        ("POST", "/compose", {"json": {"name": "x", "segments": [{"document": one, "last": 3} for one in each]}})
        for each in (both, both[::-1], [odd, odd])
    ]
    asked += [("POST", f"{of}/split", {"json": {"at": [2]}})]
    asked += [
        ("POST", f"{of}/frames", {"json": {"edits": [edit]}, "headers": {"if-match": "*"}})
        for edit in EDITS[: 1 if long else None]
    ]
    asked += [
        ("PATCH", f"{of}/calibration", {"json": change, "headers": {"if-match": "*"}})
        for change in ({"floor": 0.0}, {"up": "Z"}, {"reference": "1"}, {"reference": "rest"}, {"leaps": True})
    ]
    asked += [("POST", f"{of}/names", {}), ("GET", f"{of}/calibration", {}), ("GET", of, {})]
    for method, path, said in asked:
        answer = client.request(method, f"{API}{path}", **said)
        assert answer.status_code < 500, (method, path, said, answer.text)
    for question in QUESTIONS[5:9]:
        assert client.get(f"{API}/xpath", params={"q": question}).status_code == 200
