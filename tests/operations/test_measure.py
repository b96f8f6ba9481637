"""Quantities measured in many frame ranges: against the numbers of frames, by every face, and refusals."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner

import mcml
from mcml.numerics.curves import normalise_range
from mcml_service.actions.measuring import choose_ranges, measure_clips
from mcml_service.cli import app
from mcml_service.storage.database import Database
from mcml_service.xpath.limits import Limits
from tests.builders import bvh, one_kind, upload
from tests.conftest import StoreOf
from tests.laboratory.walkers import Gait, events_of, make_c3d
from tests.motion.bodies.made import person

pytestmark = one_kind
API = "/api/v1"
KNEE, SPEED, HEIGHT = "angle:left-knee-flexion", "speed:right_hand", "height:left_foot"


def fill(client: TestClient) -> list[str]:
    """Six people, of whom two belong to a project of their own, with labels."""
    made: Any = upload(client, {f"p{seed}.bvh": person(seed, 90 + seed) for seed in range(6)}, unit="cm")
    ids = [str(item["id"]) for item in made["documents"]]
    for place, uuid in enumerate(ids):
        labels = [{"name": "reach", "first": 5 + 20 * number, "last": 24 + 20 * number} for number in range(3)]
        labels += [{"name": "strike", "first": frame, "last": frame} for frame in (10, 30 + place, 55)]
        assert client.post(f"{API}/documents/{uuid}/labels", json=labels, headers={"if-match": "*"}).status_code == 201
    return ids


@pytest.fixture
def people(store_of: StoreOf, kind: str) -> tuple[TestClient, list[str]]:
    return store_of(kind, fill)


def ask(client: TestClient, **request: Any) -> dict[str, Any]:
    answer = client.post(f"{API}/measure", json=request)
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def file_of(client: TestClient, **request: Any) -> bytes:
    answer = client.post(f"{API}/measure", json=request)
    assert answer.status_code == 200, answer.text
    return answer.content


def samples(client: TestClient, uuid: str, quantity: str) -> np.ndarray:
    answer = client.get(f"{API}/documents/{uuid}/frames", params={"quantity": quantity, "format": "npz"})
    assert answer.status_code == 200, answer.text
    values: np.ndarray = np.load(io.BytesIO(answer.content))["values"][:, 0]
    return values


def test_figures_and_curves_are_those_of_the_frames(people: tuple[TestClient, list[str]]) -> None:
    client, ids = people
    asked = {"selection": {"documents": ids}, "quantities": [KNEE, SPEED, HEIGHT], "curves": True, "cycles": ["reach"]}
    found = ask(client, **asked)
    assert (found["total_ranges"], found["total_groups"], found["documents"]) == (54, 3, 6)
    known = {(uuid, text): samples(client, uuid, text) for uuid in ids for text in (KNEE, SPEED, HEIGHT)}
    for row in found["ranges"]:
        values = known[row["document"], row["quantity"]][row["first"] - 1 : row["last"]]
        assert (row["minimum"], row["maximum"]) == (values.min(), values.max())
        assert row["range"] == values.max() - values.min()
        assert row["mean"] == pytest.approx(values.mean())
        assert row["sd"] == pytest.approx(values.std(ddof=1))
        assert row["max_frame"] == row["first"] + values.argmax()
        assert row["max_time"] == pytest.approx((row["max_frame"] - 1) / 60, rel=1e-4)
        assert row["seconds"] == pytest.approx(19 / 60, rel=1e-4)
        expected = np.interp(np.linspace(0, 19, 101), np.arange(20), values)
        assert row["curve"] == pytest.approx(expected.tolist(), abs=1e-9)
    for group in found["groups"]:
        rows = [row for row in found["ranges"] if row["quantity"] == group["quantity"]]
        curves = np.array([row["curve"] for row in rows])
        assert group["ranges"] == len(rows) == 18
        assert group["mean_curve"] == pytest.approx(curves.mean(axis=0).tolist())
        assert group["sd_curve"] == pytest.approx(curves.std(axis=0, ddof=1).tolist())
        assert group["count"] == [18] * 101
        peaks = [row["maximum"] for row in rows]
        assert group["maximum"] == pytest.approx({"mean": np.mean(peaks), "sd": np.std(peaks, ddof=1)})


def test_the_odd_clip_is_first_and_every_group_has_its_own(client: TestClient) -> None:
    files = {f"w{n}.c3d": make_c3d(Gait(seconds=4, width=0.16 + 0.002 * n)) for n in range(6)}
    files["odd.c3d"] = make_c3d(Gait(seconds=4, width=0.4))
    made: Any = upload(client, files)
    ids = [item["id"] for item in made["documents"]]
    found = ask(client, selection={"documents": ids}, quantities=["distance:LHEE,RHEE"], by=["side"])
    assert found["ranges"][0]["name"] == "odd"
    assert found["ranges"][0]["outlier"]
    assert found["ranges"][0]["score"] > 3.5
    assert found["groups"][0]["outliers"] == sum(row["outlier"] for row in found["ranges"])
    each = ask(client, selection={"documents": ids}, quantities=["distance:LHEE,RHEE"], by=["clip"])
    assert (each["total_groups"], [row["score"] for row in each["ranges"]]) == (7, [None] * 7)
    assert "7 of 7 groups have no scores: fewer than four ranges." in each["warnings"]


def test_ranges_are_of_a_query_a_label_or_strides(people: tuple[TestClient, list[str]]) -> None:
    client, ids = people
    chosen = {"documents": ids[:2]}
    queried = ask(client, selection=chosen, query="//frame[motion_name='reach'][position() > 8]", quantities=[HEIGHT])
    runs = client.get(
        f"{API}/xpath",
        params={"q": "//frame[motion_name='reach'][position() > 8]", "document": ids[:2], "as": "runs"},
    ).json()["items"]
    assert [(row["document"], row["first"], row["last"]) for row in queried["ranges"]] == [
        (run["document"], run["first"], run["last"]) for run in runs
    ]
    every = ask(client, query="//frame[motion_name='reach']", quantities=[HEIGHT])
    assert every["documents"] == 6, "a query alone asks all clips"
    cycles = ask(client, selection=chosen, cycles=["strike"], quantities=[HEIGHT])
    assert [(row["first"], row["last"], row["label"]) for row in cycles["ranges"]] == [
        (10, 30, "strike"), (30, 55, "strike"), (10, 31, "strike"), (31, 55, "strike"),
    ]  # fmt: skip
    both = ask(client, selection=chosen, cycles=["strike", "reach"], quantities=[HEIGHT], by=["label"])
    assert [group["group"] for group in both["groups"]] == [{"label": "strike"}, {"label": "reach"}]
    none = ask(client, selection=chosen, cycles=["hop"], quantities=[HEIGHT])
    assert none["ranges"] == []
    assert none["warnings"] == ["Left out: no complete cycle of hop (2 of 2 clips: 'p0', 'p1')."]


def test_ranges_of_a_query_are_in_the_order_of_its_answer(client: TestClient) -> None:
    """That of names, which is not that in which clips were imported."""
    for name in ("last", "middle", "first"):
        upload(client, {f"{name}.bvh": person(1, 20)})
    found = ask(client, query="//frame[@id > 5]", quantities=[HEIGHT])
    assert [row["name"] for row in found["ranges"]] == ["first", "last", "middle"]


def test_strides_are_those_of_gait(client: TestClient) -> None:
    gait = Gait(seconds=6)
    made: Any = upload(client, {"walk.c3d": make_c3d(gait, sorted(events_of(gait)))})
    uuid = made["documents"][0]["id"]
    asked = {"selection": {"documents": [uuid]}, "strides": True, "curves": True}
    found = ask(client, **asked, quantities=["position:LHEE,z", "distance:LHEE,RHEE"])
    measured = client.get(f"{API}/documents/{uuid}/gait", params={"quantity": ["position:LHEE,z"]}).json()
    strides = [item for item in measured["strides"] if not item["rejected"]]
    heel = [row for row in found["ranges"] if row["quantity"] == "position:LHEE,z"]
    assert {row["side"] for row in heel} == {"left"}
    assert len(heel) == sum(item["side"] == "left" for item in strides) > 2
    both = [row for row in found["ranges"] if row["quantity"] == "distance:LHEE,RHEE"]
    assert len(both) == len(strides)
    assert {json.dumps(group["group"]) for group in found["groups"]} == {'{"side": "left"}', '{"side": "right"}'}
    (group,) = [group for group in found["groups"] if group["quantity"] == "position:LHEE,z"]
    assert group["mean_curve"] == pytest.approx(measured["cycles"][0]["mean"], abs=0.002), "splines there, lines here"
    values = samples(client, uuid, "position:LHEE,z")
    ends = [(item["begin"] * 100, item["end"] * 100) for item in strides if item["side"] == "left"]
    for row, (begin, end) in zip(sorted(heel, key=lambda row: row["first"]), ends, strict=True):
        assert row["curve"] == pytest.approx(normalise_range(values, begin, end).tolist(), abs=1e-9)


def test_what_is_missing_and_guessed_is_told(client: TestClient) -> None:
    made: Any = upload(client, {"p0.bvh": person(0, 90)}, unit="cm")
    ids = [made["documents"][0]["id"]]
    made = upload(client, {"arm.bvh": bvh(5)})
    arm = made["documents"][0]["id"]
    found = ask(client, selection={"documents": [ids[0], arm]}, quantities=[SPEED, "position:Root,x", KNEE])
    warnings = " ".join(found["warnings"])
    assert "Left out of speed:right_hand: There is no bone 'right_hand'" in warnings
    assert "Left out of position:Root,x: the unit of length is not known" in warnings
    assert "(1 of 2 clips: 'arm')" in warnings
    assert {row["name"] for row in found["ranges"]} == {"p0"}
    floor = ask(client, selection={"documents": ids[:1]}, quantities=[HEIGHT])
    assert any("height:left_foot depends on a guessed" in warning for warning in floor["warnings"])
    sure = ask(client, selection={"documents": ids[:1]}, quantities=[HEIGHT], guesses="no")
    assert sure["ranges"] == []
    assert any(warning.startswith("Left out of height:left_foot: a guessed") for warning in sure["warnings"])


def test_missing_samples_stay_missing(client: TestClient) -> None:
    made: Any = upload(client, {"walk.c3d": make_c3d(Gait(seconds=3))})
    uuid = made["documents"][0]["id"]
    labels = [{"name": "part", "first": 1, "last": 200}]
    assert client.post(f"{API}/documents/{uuid}/labels", json=labels, headers={"if-match": "*"}).status_code == 201
    # Contacts of a walker are unknown before the first event.
    values = samples(client, uuid, "contact:left")[:200]
    assert 0 < np.isnan(values).sum() < 200
    (row,) = ask(client, selection={"documents": [uuid]}, quantities=["contact:left"], cycles=["part"], curves=True)[
        "ranges"
    ]
    assert row["missing"] == np.isnan(values).sum()
    assert row["mean"] == pytest.approx(np.nanmean(values))
    expected = normalise_range(values, 0, 199)
    assert [value is None for value in row["curve"]] == np.isnan(expected).tolist()


def test_tables_and_arrays_are_the_answer(people: tuple[TestClient, list[str]]) -> None:
    client, ids = people
    asked = {"selection": {"documents": ids}, "quantities": [KNEE, SPEED], "cycles": ["reach"], "by": ["clip"]}
    found = ask(client, **asked, curves=True)
    table = list(csv.DictReader(io.StringIO(file_of(client, **asked, **{"as": "csv"}).decode())))
    assert [(row["document"], row["quantity"], int(row["first"])) for row in table] == [
        (row["document"], row["quantity"], row["first"]) for row in found["ranges"]
    ]
    assert [float(row["maximum"]) for row in table] == [row["maximum"] for row in found["ranges"]]
    arrays = np.load(io.BytesIO(file_of(client, **asked, **{"as": "npz"})))
    assert arrays["curves"].tolist() == [row["curve"] for row in found["ranges"]]
    assert arrays["group_mean"].tolist() == [group["mean_curve"] for group in found["groups"]]
    assert arrays["group_quantity"][arrays["group_of"]].tolist() == [row["quantity"] for row in found["ranges"]]
    assert arrays["warnings"].tolist() == found["warnings"]
    points = list(csv.DictReader(io.StringIO(file_of(client, **asked, table="curves", **{"as": "csv"}).decode())))
    assert len(points) == 101 * len(table)
    assert [float(point["value"]) for point in points[:101]] == found["ranges"][0]["curve"]
    groups = list(csv.DictReader(io.StringIO(file_of(client, **asked, table="groups", **{"as": "csv"}).decode())))
    assert [float(point["mean"]) for point in groups[:101]] == found["groups"][0]["mean_curve"]
    assert groups[0]["clip"] == found["groups"][0]["group"]["clip"]
    parquet = pytest.importorskip("pyarrow.parquet")
    read = parquet.read_table(io.BytesIO(file_of(client, **asked, **{"as": "parquet"}))).to_pylist()
    assert [row["mean"] for row in read] == [row["mean"] for row in found["ranges"]]
    empty = file_of(client, **asked | {"cycles": ["hop"]}, **{"as": "csv"}).decode().splitlines()
    assert len(empty) == 1, "the names of the columns alone"


def test_requests_that_make_no_sense_or_too_much_are_refused(
    people: tuple[TestClient, list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    client, ids = people
    chosen = {"documents": ids}

    def refused(status: int, **request: Any) -> str:
        answer = client.post(f"{API}/measure", json=request)
        assert answer.status_code == status, answer.text
        return answer.text

    assert "No clips are selected" in refused(422, quantities=[KNEE])
    assert "No documents are selected" in refused(422, selection={}, quantities=[KNEE])
    assert "there is no quantity 'girth'" in refused(422, selection=chosen, quantities=["girth:Root"])
    assert "query and strides both choose" in refused(422, query="//frame", strides=True, quantities=[KNEE])
    refused(422, selection=chosen, quantities=[])
    refused(422, selection=chosen, quantities=[KNEE] * 41)
    refused(422, selection=chosen, quantities=[KNEE], by=["colour"])
    refused(422, selection=chosen, quantities=[KNEE], by=["property:" + "x" * 201])
    assert "node set" in refused(422, selection=chosen, query="count(//frame)", quantities=[KNEE])
    refused(404, selection={"documents": ["01a1fd5b-63fa-7af5-9027-3f8ccdfe4736"]}, quantities=[KNEE])
    monkeypatch.setattr(choose_ranges, "MOST_ROWS", 11)
    assert "Narrow the selection" in refused(413, selection=chosen, quantities=[KNEE, SPEED])
    assert "Narrow the selection" in refused(413, selection=chosen, quantities=[KNEE], query="//frame[@id mod 3 = 0]")
    assert "Narrow the selection" in refused(413, selection=chosen, quantities=[KNEE], cycles=["reach"])
    monkeypatch.setattr(choose_ranges, "MOST_ROWS", 50)
    monkeypatch.setattr(measure_clips, "MOST_GROUPS", 5)
    assert "more than 5 groups" in refused(413, selection=chosen, quantities=[KNEE], by=["clip"])


def test_a_request_that_takes_too_long_ends_with_a_remedy(
    people: tuple[TestClient, list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    client, ids = people
    monkeypatch.setattr(Limits, "over", property(lambda limits: True))
    answer = client.post(f"{API}/measure", json={"selection": {"documents": ids}, "quantities": [KNEE]})
    assert answer.status_code == 422, answer.text
    assert "Measure fewer clips or quantities at a time" in answer.text


def test_an_answer_says_that_it_is_cut(people: tuple[TestClient, list[str]]) -> None:
    client, ids = people
    found = ask(client, selection={"documents": ids}, quantities=[KNEE], cycles=["reach"], limit=4)
    assert (len(found["ranges"]), found["total_ranges"]) == (4, 18)
    assert any("The last 14 of 18 rows are not shown" in warning for warning in found["warnings"])


def test_the_command_and_python_measure_the_same(database: Database, tmp_path: Path) -> None:
    repo = mcml.open(database.url)
    for seed in range(4):
        path = tmp_path / f"p{seed}.bvh"
        path.write_bytes(person(seed, 60))
        repo.import_(path, unit="cm", property=[f"age={20 + seed % 2} year"], project="gait")
    measures = repo.measure(KNEE, SPEED, project="gait", by=["property:age"])
    assert (measures.total_ranges, measures.total_groups) == (8, 4)
    assert {group.group["property:age"] for group in measures.groups} == {"20", "21"}
    assert all(row.curve is not None and len(row.curve) == 101 for row in measures.ranges)
    some = repo.measure(KNEE, documents=repo.documents()[:2])
    assert some.documents == 2
    base = ["measure", "--database", database.url, "--project", "gait", "--quantity", KNEE, "--quantity", SPEED]
    runner = CliRunner()
    told = runner.invoke(app, [*base, "--by", "property:age", "--json"])
    assert told.exit_code == 0, told.output
    rows = json.loads(told.stdout)["ranges"]
    assert [row["maximum"] for row in rows] == [row.maximum for row in measures.ranges]
    table = runner.invoke(app, base)
    assert table.exit_code == 0, table.output
    assert KNEE in table.stdout
    for name in ("rows.csv", "rows.npz"):
        written = runner.invoke(app, [*base, "-o", str(tmp_path / name)])
        assert written.exit_code == 0, written.output
    assert len(list(csv.DictReader((tmp_path / "rows.csv").open()))) == 8
    assert np.load(tmp_path / "rows.npz")["curves"].shape == (8, 101)
    assert isinstance(runner.invoke(app, [*base, "-o", str(tmp_path / "rows.txt")]).exception, Exception)


@pytest.mark.slow
def test_trials_of_a_laboratory(shared: Path, client: TestClient) -> None:
    files = sorted((shared / "lab").glob("*.c3d"))[:6]
    for file in files:
        upload(client, {file.name: file.read_bytes()})
    found = ask(client, query="//frame[@id]", quantities=["angle:left-knee-flexion", "time"])
    assert found["documents"] > 0
    for row in found["ranges"]:
        assert row["minimum"] <= row["mean"] <= row["maximum"]
        values = samples(client, row["document"], row["quantity"])[row["first"] - 1 : row["last"]]
        assert (row["minimum"], row["maximum"]) == (np.nanmin(values), np.nanmax(values))
