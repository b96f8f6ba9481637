"""The gait of a whole project as a job: the numbers of `GET /gait`, at the revisions of its start, and as CSV."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner

from mcml_service.analysis.interface import silent
from mcml_service.cli import app
from mcml_service.jobs.worker import Refused, perform
from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, upload
from tests.laboratory.walkers import Gait, events_of, make_c3d

pytestmark = one_kind
API = "/api/v1"
GAIT = Gait(seconds=5)


def store_walk(client: TestClient, gait: Gait, name: str, *properties: str) -> str:
    content = make_c3d(gait, events_of(gait))
    form: dict[str, Any] = {"project": "lab", **({"property": list(properties)} if properties else {})}
    return str(upload(client, {name: content}, **form)["documents"][0]["id"])  # type: ignore[index]


def test_a_project_is_measured_by_command_and_written_as_csv(
    database: Database, client: TestClient, tmp_path: Path
) -> None:
    slow = replace(GAIT, stride_time=1.3)
    ids = [store_walk(client, gait, f"{gait.stride_time}.c3d", "subject==S1") for gait in (GAIT, slow)]
    upload(client, {"arm.bvh": bvh(5)}, project="lab")
    store = ["--database", str(database.url)]
    made = CliRunner().invoke(app, ["analyse", "gait", "measure", "--project", "lab", "--json", *store])
    assert made.exit_code == 0, made.output
    result = json.loads(made.output)["result"]
    answer = client.get(f"{API}/results/{result}/subjects", params={"format": "csv"})
    assert answer.headers["content-type"] == "text/csv; charset=utf-8"
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    pooled = client.get(f"{API}/gait", params={"document": ids, "quantity": "time"}).json()["own"]["parameters"]
    # A spreadsheet must not compute the subject.
    left, right = [row for row in rows if row["subject"] == "'=S1"]
    for parameter in pooled:
        for row, side in ((left, "left"), (right, "right")):
            for name, value in ((parameter["name"], "mean"), (f"{parameter['name']}_sd", "sd")):
                text = row[f"{name} ({parameter['unit']})"]
                assert (float(text) if text else None) == parameter[side][value]
    assert int(left["strides"]) == pooled[0]["left"]["n"]
    warnings = client.get(f"{API}/results/{result}/warnings", params={"format": "csv"}).text
    assert "heels, toes and hips" in warnings
    written = CliRunner().invoke(
        app, ["analyse", "gait", "table", result, "subjects", "-o", str(tmp_path / "lab.csv"), *store]
    )
    assert written.exit_code == 0, written.output
    assert (tmp_path / "lab.csv").read_bytes() == answer.content


def test_trials_are_those_of_the_revisions_of_the_start(database: Database, client: TestClient) -> None:
    uuid = store_walk(client, GAIT, "walk.c3d")
    inputs = [{"document": uuid, "revision": 1}]
    before = perform(database, "gait", inputs, {}, silent)
    cut = {"edits": [{"do": "keep", "first": 1, "last": 250}]}
    assert client.post(f"{API}/documents/{uuid}/frames", json=cut, headers={"if-match": "*"}).status_code == 200
    after = perform(database, "gait", inputs, {}, silent)
    now = perform(database, "gait", [{"document": uuid, "revision": 2}], {}, silent)
    assert not isinstance(before, Refused)
    assert not isinstance(after, Refused)
    assert not isinstance(now, Refused)
    assert before == after
    assert before["trials"] != now["trials"]


def test_labels_alone_can_be_asked_for(database: Database, client: TestClient) -> None:
    uuid = store_walk(client, GAIT, "walk.c3d")
    parts = perform(database, "gait", [{"document": uuid, "revision": 1}], {"events": "positions"}, silent)
    labelled = perform(database, "gait", [{"document": uuid, "revision": 1}], {"events": "labels"}, silent)
    assert not isinstance(parts, Refused)
    assert not isinstance(labelled, Refused)
    assert parts["trials"] != labelled["trials"]
    assert labelled["trials"].data["rows"][0][5] == pytest.approx(1.1)


def test_a_skeleton_to_retarget_to_is_refused(client: TestClient) -> None:
    uuid = store_walk(client, GAIT, "walk.c3d")
    request = {"inputs": {"project": "lab"}, "skeleton": uuid}
    answer = client.post(f"{API}/analyses/gait", json=request)
    assert answer.status_code == 422
    assert "skeleton" in answer.text
