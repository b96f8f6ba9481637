"""The gait of documents: events with their sources, parameters, cycles, and the same by every face."""

from __future__ import annotations

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
