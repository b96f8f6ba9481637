"""The gait of documents: events with their sources, parameters, cycles, and the same by every face."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner

import mcml
from mcml_service.cli import app
from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, upload
from tests.laboratory.walkers import Gait, events_of, make_c3d
from tests.motion.bodies.made import person

pytestmark = one_kind
API = "/api/v1/documents"
GAIT = Gait(seconds=5, heading=-40)


def stored(client: TestClient, content: bytes, name: str = "walk.c3d") -> str:
    return str(upload(client, {name: content})["documents"][0]["id"])  # type: ignore[index]


def gait_of(client: TestClient, uuid: str, **query: Any) -> dict[str, Any]:
    answer = client.get(f"{API}/{uuid}/gait", params=query)
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def test_events_of_a_file_are_used_with_their_exact_times(client: TestClient) -> None:
    events = sorted(events_of(GAIT))
    uuid = stored(client, make_c3d(GAIT, events, first=120))
    found = gait_of(client, uuid)
    assert [(item["side"], item["kind"]) for item in found["events"]] == [(event.side, event.kind) for event in events]
    assert [item["time"] for item in found["events"]] == pytest.approx([event.seconds for event in events], abs=1e-5)
    assert {item["source"] for item in found["events"]} == {"label"}
    assert {item["within"] for item in found["events"]} == {None}
    assert [item["frame"] for item in found["events"]] == [round(event.seconds * 100) + 1 for event in events]
    parameters = {item["name"]: item for item in found["parameters"]}
    assert parameters["stride_time"]["left"]["mean"] == pytest.approx(1.1)
    assert parameters["speed"]["right"]["mean"] == pytest.approx(1.2, abs=0.01)
    assert parameters["stance"]["unit"] == "%"
    assert parameters["stride_time"]["how"] == "from a strike to the next one of the same foot"
    assert found["clinical"]
    assert not found["running"]
    assert found["strides"][0]["values"]["step_width"] == pytest.approx(0.16, abs=0.01)


def test_exact_times_stay_where_the_start_is_cut_off(client: TestClient) -> None:
    events = sorted(events_of(GAIT))
    uuid = stored(client, make_c3d(GAIT, events, first=120))
    cut = {"edits": [{"do": "keep", "first": 41, "last": 460}]}
    assert client.post(f"{API}/{uuid}/frames", json=cut, headers={"if-match": "*"}).status_code == 200
    wanted = [event.seconds - 0.4 for event in events if 40 <= round(event.seconds * 100) < 460]
    assert [item["time"] for item in gait_of(client, uuid)["events"]] == pytest.approx(wanted, abs=1e-5)


def test_labels_of_people_are_trusted_and_the_rest_is_found(client: TestClient) -> None:
    uuid = stored(client, make_c3d(GAIT))
    found = gait_of(client, uuid)
    assert {item["source"] for item in found["events"]} == {"positions"}
    assert {item["within"] for item in found["events"]} == {0.045}
    strikes = [item for item in found["events"] if (item["side"], item["kind"]) == ("left", "strike")]
    labels = [{"name": "left-foot-strike", "first": item["frame"], "last": item["frame"] + 1} for item in strikes[:2]]
    made = client.post(f"{API}/{uuid}/labels", json=labels, headers={"if-match": "*"})
    assert made.status_code == 201
    again = gait_of(client, uuid)
    own = [item for item in again["events"] if (item["side"], item["kind"]) == ("left", "strike")]
    assert [(item["frame"], item["source"]) for item in own] == [(label["first"], "label") for label in labels]
    assert f"{len(strikes) - 2} more left strikes are in the positions" in " ".join(again["warnings"])
    assert gait_of(client, uuid, events="positions")["events"] == found["events"]
    # The revision before has no labels.
    assert gait_of(client, uuid, revision=1)["events"] == found["events"]


def test_quantities_are_cut_into_cycles_of_their_side(client: TestClient) -> None:
    uuid = stored(client, make_c3d(GAIT, events_of(GAIT)))
    found = gait_of(client, uuid, quantity=["position:LHEE,z", "height:RTOE", "distance:LHEE,RHEE", "time"])
    assert [(item["quantity"], item["side"]) for item in found["cycles"]] == [
        ("position:LHEE,z", "left"),
        ("height:RTOE", "right"),
        ("distance:LHEE,RHEE", "left"),
        ("distance:LHEE,RHEE", "right"),
        ("time", "left"),
        ("time", "right"),
    ]
    heel = found["cycles"][0]
    strides = [item for item in found["strides"] if item["side"] == "left"]
    assert (heel["n"], heel["gaps"], heel["unit"], len(heel["mean"])) == (len(strides), 0, "m", 101)
    assert heel["mean"][30] == pytest.approx(0.03, abs=0.002), "planted"
    assert heel["mean"][81] == pytest.approx(0.15, abs=0.005), "the middle of the swing"
    joints = stored(client, person(3, 300), "joints.bvh")
    (cycle,) = gait_of(client, joints, quantity=["angle:left-knee-flexion"])["cycles"]
    assert (cycle["side"], cycle["unit"]) == ("left", "deg")
    unknown = client.get(f"{API}/{uuid}/gait", params={"quantity": "height:nobody"})
    assert unknown.status_code == 404


def test_what_has_no_feet_or_no_rate_is_refused_with_a_remedy(client: TestClient) -> None:
    uuid = stored(client, bvh(5), "arm.bvh")
    answer = client.get(f"{API}/{uuid}/gait")
    assert answer.status_code == 422
    assert "Unknown: heels, toes, hips" in answer.text
    assert "Plug-in Gait" in answer.text


def test_an_unknown_unit_leaves_lengths_out(client: TestClient) -> None:
    found = gait_of(client, stored(client, make_c3d(GAIT, unit="")))
    parameters = {item["name"]: item for item in found["parameters"]}
    assert parameters["stride_length"]["left"] == {"mean": None, "sd": None, "n": 0}
    assert parameters["stride_length"]["symmetry"] is None
    assert parameters["cadence"]["left"]["n"] > 1
    assert found["belt"]["speed"] is None
    assert any("because the unit is" in warning for warning in found["warnings"])


@pytest.mark.slow
def test_contacts_of_feet_follow_events_and_labels(client: TestClient) -> None:
    gait = replace(GAIT, on_belt=True)
    uuid = stored(client, make_c3d(gait))

    def ask(xpath: str) -> dict[str, Any]:
        answer = client.get("/api/v1/xpath", params={"q": xpath})
        assert answer.status_code == 200, answer.text
        return dict(answer.json())

    planted = ask("count(//frame[mo:contact('left')])")["value"]
    known = ask("count(//frame[mo:known(mo:contact('left'))])")["value"]
    assert 0.5 < planted / known < 0.75, "although the feet move on the belt"
    flight = ask("count(//frame[not(mo:contact('left')) and not(mo:contact('right'))])")["value"]
    assert flight == 0
    event = next(item for item in gait_of(client, uuid)["events"] if (item["side"], item["kind"]) == ("left", "strike"))
    labels = [{"name": "left-foot-strike", "first": event["frame"] - 5, "last": event["frame"] - 5}]
    assert client.post(f"{API}/{uuid}/labels", json=labels, headers={"if-match": "*"}).status_code == 201
    assert ask("count(//frame[mo:contact('left')])")["value"] < planted, "one strike is left"
    stored(client, bvh(5), "arm.bvh")
    warnings = " ".join(ask("//frame[mo:contact('left')]/@id")["warnings"])
    assert "1 of 2 documents left out: no step tells mo:contact('left') ('arm')" in warnings


def test_strides_under_a_label_are_left_out(client: TestClient, tmp_path: Path) -> None:
    uuid = stored(client, make_c3d(GAIT, events_of(GAIT)))
    before = gait_of(client, uuid, quantity="time")
    strides = [stride for stride in before["strides"] if stride["side"] == "left"]
    frame = round((strides[1]["begin"] + 0.3) * 100)
    label = [{"name": "left-gait-exclude", "first": frame, "last": frame + 3}]
    assert client.post(f"{API}/{uuid}/labels", json=label, headers={"if-match": "*"}).status_code == 201
    after = gait_of(client, uuid, quantity="time")
    rejected = [stride for stride in after["strides"] if stride["rejected"]]
    assert [(stride["side"], stride["begin"], stride["rejected"]) for stride in rejected] == [
        ("left", strides[1]["begin"], "excluded by a label")
    ]
    assert "1 strides are left out of means and cycles: excluded by a label" in after["warnings"]
    assert [cycle["n"] for cycle in after["cycles"]] == [len(strides) - 1, before["cycles"][1]["n"]]
    (tmp_path / "walk.mcml").write_bytes(client.get(f"{API}/{uuid}/mcml").content)
    again = [stride for stride in mcml.read(tmp_path / "walk.mcml").measure_gait().strides if stride.rejected]
    assert [(stride.side, stride.rejected) for stride in again] == [("left", "excluded by a label")]


def test_trials_are_pooled_beside_others_and_a_normal_band(client: TestClient) -> None:
    slow, fast = replace(GAIT, stride_time=1.3), replace(GAIT, stride_time=0.95, speed=1.5)
    first, second = (stored(client, make_c3d(gait, events_of(gait)), f"{gait.speed}.c3d") for gait in (GAIT, slow))
    other = stored(client, make_c3d(fast, events_of(fast)), "fast.c3d")
    arm = stored(client, bvh(5), "arm.bvh")
    kept = client.put("/api/v1/collections/healthy", json={"documents": [first, second, arm]})
    assert kept.status_code == 201, kept.text
    query = {"quantity": ["position:LHEE,z", "time"]}
    alone = [gait_of(client, uuid, **query) for uuid in (first, second, other)]

    def ask(**chosen: Any) -> dict[str, Any]:
        answer = client.get("/api/v1/gait", params={**query, **chosen})
        assert answer.status_code == 200, answer.text
        return dict(answer.json())

    found = ask(document=[first, second], compare=other, reference="collection:healthy")
    assert found["curves"][0] == {
        "title": "position:LHEE,z", "left": "position:LHEE,z", "right": "", "positive": "", "negative": ""
    }  # fmt: skip
    values = [
        stride["values"]["stride_length"]
        for gait in alone[:2]
        for stride in gait["strides"]
        if stride["side"] == "left"
    ]
    length = next(item for item in found["own"]["parameters"] if item["name"] == "stride_length")["left"]
    assert length == {
        "mean": pytest.approx(np.mean(values)), "sd": pytest.approx(np.std(values, ddof=1)), "n": len(values)
    }  # fmt: skip
    one, two = (gait["cycles"][0] for gait in alone[:2])
    heel = found["own"]["cycles"][0]
    assert (heel["quantity"], heel["side"], heel["n"]) == ("position:LHEE,z", "left", one["n"] + two["n"])
    mean = (one["n"] * np.array(one["mean"]) + two["n"] * np.array(two["mean"])) / heel["n"]
    assert heel["mean"] == pytest.approx(mean)
    assert found["compare"]["cycles"][0]["mean"] == pytest.approx(alone[2]["cycles"][0]["mean"])
    # The same trials as the band, and one that has no gait.
    assert found["reference"]["cycles"] == found["own"]["cycles"]
    *_, unmeasured = found["reference"]["trials"]
    assert (unmeasured["name"], unmeasured["measured"], unmeasured["strides"]) == (
        "arm",
        False,
        {"left": 0, "right": 0},
    )
    assert "heels, toes and hips" in unmeasured["warnings"][0]
    assert "compare" not in ask(document=first) or ask(document=first)["compare"] is None
    lacking = client.get("/api/v1/gait", params={"document": first, "quantity": "quantity:LKneeAngles,x"}).json()
    assert lacking["own"]["trials"][0]["warnings"][-1] == "it lacks quantity:LKneeAngles,x"


def test_too_many_trials_and_unknown_ones_are_refused(client: TestClient) -> None:
    uuid = stored(client, make_c3d(GAIT))
    many = client.put("/api/v1/collections/many", json={"where": {"project": "default"}})
    assert many.status_code == 201
    assert client.get("/api/v1/gait", params={"document": "collection:many"}).status_code == 200
    for number in range(51):
        stored(client, bvh(3 + number), f"{number}.bvh")
    answer = client.get("/api/v1/gait", params={"document": "collection:many"})
    assert answer.status_code == 422
    assert "Choose 1 to 50 documents, or run the analysis `gait`" in answer.text
    assert client.get("/api/v1/gait", params={"document": [uuid, "nothing"]}).status_code == 404


@pytest.mark.slow
def test_a_report_has_every_stride_as_numbers_and_pages_to_print(
    database: Database, client: TestClient, tmp_path: Path
) -> None:
    uuid = stored(client, make_c3d(GAIT, events_of(GAIT)))
    query = {"document": uuid, "quantity": ["height:LHEE", "time"]}
    answer = client.get("/api/v1/gait/report", params={**query, "format": "csv"})
    assert answer.headers["content-disposition"].startswith('attachment; filename="walk-gait.csv"')
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    gait = gait_of(client, uuid, quantity=["height:LHEE", "time"])
    strides = [stride for stride in gait["strides"] if stride["side"] == "left"]
    lengths = [row for row in rows if row["quantity"] == "stride_length" and row["side"] == "left"]
    assert [float(row["value"]) for row in lengths] == [stride["values"]["stride_length"] for stride in strides]
    assert [row["stride"] for row in lengths] == [str(number) for number in range(1, len(strides) + 1)]
    heights = np.array([float(row["value"]) for row in rows if row["quantity"] == "height:LHEE"]).reshape(-1, 101)
    assert heights.mean(axis=0) == pytest.approx(gait["cycles"][0]["mean"])
    times = [row for row in rows if row["quantity"] == "time" and row["percent"] == "0" and row["side"] == "left"]
    assert [float(row["value"]) for row in times] == pytest.approx([stride["begin"] for stride in strides], abs=1e-6)
    pytest.importorskip("matplotlib")
    pages = client.get("/api/v1/gait/report", params=query)
    assert pages.headers["content-type"] == "application/pdf"
    assert pages.content.startswith(b"%PDF-")
    assert client.get("/api/v1/gait/report", params=query).content == pages.content
    database_option = ["--database", str(database.url)]
    path = tmp_path / "report.pdf"
    asked = ["gait", uuid, "--quantity", "height:LHEE", "--quantity", "time", "--output", str(path), *database_option]
    made = CliRunner().invoke(app, asked)
    assert made.exit_code == 0, made.output
    assert path.read_bytes() == pages.content
    shown = CliRunner().invoke(app, ["gait", uuid, "--reference", uuid, *database_option])
    assert shown.exit_code == 0, shown.output
    assert "reference: walk" in shown.output
    refused = CliRunner().invoke(app, ["gait", uuid, uuid, "--revision", "1", *database_option])
    assert refused.exit_code != 0


def test_python_and_command_say_the_same(database: Database, client: TestClient, tmp_path: Path) -> None:
    content = make_c3d(Gait(seconds=5, on_belt=True), events_of(GAIT))
    uuid = stored(client, content)
    found = gait_of(client, uuid)
    (tmp_path / "walk.c3d").write_bytes(content)
    measured = mcml.read(tmp_path / "walk.c3d").measure_gait()
    contacts = mcml.read(tmp_path / "walk.c3d").contact("left")
    assert np.array_equal(contacts, measured.contacts("left", 500), equal_nan=True)
    assert measured.summary("left", "stride_length").mean == found["parameters"][3]["left"]["mean"]
    assert list(measured.warnings) == found["warnings"]
    shown = CliRunner().invoke(app, ["gait", uuid, "--database", str(database.url), "--quantity", "height:LHEE"])
    assert shown.exit_code == 0, shown.output
    words = " ".join(shown.output.split())
    assert "walking on a belt of 1.2" in words
    assert "stride length" in words
    assert "height:LHEE left" in words
    assert "warning: lengths and speeds are those on a belt" in words
    plain = CliRunner().invoke(app, ["gait", uuid, "--database", str(database.url), "--json"])
    assert json.load(io.StringIO(plain.output))["belt"]["is_belt"]
