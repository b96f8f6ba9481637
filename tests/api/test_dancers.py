"""A dance of several dancers: made, read, exported, and made from Python."""

from __future__ import annotations

import pytest
from fastapi.testclient import TestClient

from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import one_kind
from tests.jobs.test_jobs import wait

API = "/api/v1"
pytestmark = [one_kind, pytest.mark.usefixtures("lent_workers")]


@pytest.fixture
def dances(database: Database) -> str:
    clips = [dance_clip("groove", tempo=tempo, bars=8, name=f"dance_{tempo}").clip for tempo in (110, 120)]
    add_clips(database, Settings(), "dances", clips, (), "")
    return "dances"


@pytest.mark.slow
def test_three_dancers_are_one_clip(client: TestClient, dances: str) -> None:
    parameters = {"bpm": 116, "bars": 6, "stage": 5.0, "dancers": {"count": 3, "mode": "canon"}}
    body = {"inputs": {"project": dances}, "parameters": parameters}
    done = wait(client, client.post(f"{API}/analyses/dance", json=body).json())
    assert done["state"] == "done", done
    result = client.get(f"{API}/results/{done['result']}").json()
    document = result["parts"]["clip"]["document"]
    rows = result["parts"]["dancers"]["data"]["rows"]
    assert [row[1] for row in rows] == pytest.approx([4 * 60 / 116 * dancer for dancer in range(3)])
    metrics = dict(result["parts"]["metrics"]["data"]["rows"])
    assert metrics["dancers"] == 3
    assert metrics["least_distance"] > 0
    assert metrics["outside_stage"] == 0
    written = client.get(f"{API}/documents/{document}/export", params={"format": "bvh"})
    assert written.status_code == 200
    assert written.text.count("ROOT ") == 3
    again = client.post(f"{API}/documents", files={"file": ("three.bvh", written.content)})
    assert again.status_code == 201, again.text
    names = [bone["name"] for bone in client.get(f"{API}/documents/{document}").json()["bones"]]
    assert [name for name in names if name.endswith(":Root")] == ["dancer1:Root", "dancer2:Root", "dancer3:Root"]
    query = {"q": "max(//frame/mo:speed('dancer2:Root'))", "as": "json", "document": [document]}
    speed = client.post(f"{API}/xpath", json=query)
    assert speed.status_code == 200, speed.text
    assert 0.05 < float(speed.json()["value"]) < 5


@pytest.mark.parametrize("wish", [{"count": 1}, {"count": 7}, {"count": 2, "delay": 9}, {"count": 2, "mode": "alone"}])
def test_dancers_out_of_range_are_refused(client: TestClient, dances: str, wish: dict[str, object]) -> None:
    body = {"inputs": {"project": dances}, "parameters": {"bpm": 116, "bars": 6, "dancers": wish}}
    assert client.post(f"{API}/analyses/dance", json=body).status_code == 422


def test_a_canon_longer_than_the_dance_is_refused_at_once(client: TestClient, dances: str) -> None:
    parameters = {"bpm": 116, "bars": 4, "dancers": {"count": 3, "mode": "canon", "delay": 2}}
    answer = client.post(f"{API}/analyses/dance", json={"inputs": {"project": dances}, "parameters": parameters})
    assert (answer.status_code, answer.json()["code"]) == (422, "canon-too-long")
    assert "4 bars after the first" in answer.json()["detail"]
