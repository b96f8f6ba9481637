"""Standing trials of a store: their measures, and walking trials that take them as properties."""

from __future__ import annotations

import re

import pytest
from fastapi.testclient import TestClient

from mcml_service.storage.database import Database
from tests.builders import one_kind, upload
from tests.laboratory.gait_files import LENGTHS, STANDING, WALKING, gait_file, stand, two_people, walk
from tests.laboratory.test_virtual_markers import person, without

pytestmark = one_kind

API = "/api/v1/documents"
STATIC = gait_file(stand(), LENGTHS)


@pytest.fixture
def trials(client: TestClient) -> list[str]:
    """Ids of a standing trial and of two walking ones."""
    files = {"static": STATIC, **{f"walk{n}": gait_file(walk(poses=WALKING, way=40.0 + n), LENGTHS) for n in (1, 2)}}
    return [upload(client, {f"{name}.c3d": content})["documents"][0]["id"] for name, content in files.items()]


def knee(client: TestClient, document: str) -> float:
    """Degrees of varus of the left knee in the first frame."""
    asked = {"quantity": "quantity:LKneeAngles,y", "first": 1, "last": 1, "format": "csv"}
    answer = client.get(f"{API}/{document}/frames", params=asked)
    assert answer.status_code == 200, answer.text
    return float(answer.text.splitlines()[1].rpartition(",")[2])


def use(client: TestClient, standing: str, *documents: str, **more: object) -> dict[str, object]:
    body = {"selection": {"documents": documents}, **more}
    answer = client.post(f"{API}/{standing}/standing-trial", json=body)
    assert answer.status_code == 200, answer.text
    found: dict[str, object] = answer.json()
    return found


def test_measures_of_a_standing_trial_have_units_and_sources(client: TestClient, trials: list[str]) -> None:
    found = client.get(f"{API}/{trials[0]}/standing-trial").json()
    by_name = {item["name"]: item for item in found["measures"]}
    assert by_name["LThighRotation"]["source"] == "medial knee marker"
    assert by_name["LThighRotation"]["value"] == pytest.approx(0.12, abs=1e-4)
    assert (by_name["LKneeWidth"]["value"], by_name["LKneeWidth"]["unit"]) == (100.0, "mm")
    assert any("a standing trial" in note for note in found["notes"])


def test_walking_trials_take_them_and_undo_takes_them_back(client: TestClient, trials: list[str]) -> None:
    before = [knee(client, walking) for walking in trials[1:]]
    items = use(client, trials[0], *trials[1:])["items"]
    assert isinstance(items, list)
    assert [(item["id"], item["revision"]) for item in items] == [(walking, 2) for walking in sorted(trials[1:])]
    assert "gait LThighRotation" in items[0]["measures"]
    for walking, was in zip(trials[1:], before, strict=True):
        assert knee(client, walking) == pytest.approx(WALKING["L"].knee[1], abs=0.01)
        assert abs(was - WALKING["L"].knee[1]) > 0.5
    client.post(f"{API}/{trials[1]}/undo", json={"revision": 2}, headers={"if-match": "*"})
    assert knee(client, trials[1]) == before[0]
    again = use(client, trials[0], trials[2])["items"]
    assert isinstance(again, list)
    assert (again[0]["revision"], again[0]["measures"]) == (2, [])


def test_all_trials_are_changed_or_none(client: TestClient, trials: list[str]) -> None:
    (other,) = upload(client, {"bones.bvh": (b"HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition "
                                             b"Zposition\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 1\n"
                                             b"Frame Time: 0.1\n0 0 0\n")})["documents"]  # fmt: skip
    body = {"selection": {"documents": [trials[1], other["id"]]}}
    answer = client.post(f"{API}/{trials[0]}/standing-trial", json=body)
    assert answer.status_code == 422
    assert "no markers of a pelvis" in answer.json()["detail"]
    assert client.get(f"{API}/{trials[1]}").json()["revision"] == 1


def test_a_walk_is_no_standing_trial(client: TestClient, trials: list[str]) -> None:
    answer = client.get(f"{API}/{trials[1]}/standing-trial")
    assert answer.status_code == 422
    assert "move by more than 100 mm" in answer.json()["detail"]
    assert "stands still" in answer.json()["remedy"]


def test_several_people_are_asked_for_by_name(client: TestClient, trials: list[str]) -> None:
    people = two_people()
    markers = {f"{name}:{label}": place for name, (own, _) in people.items() for label, place in own.items()}
    both = upload(client, {"both.c3d": gait_file(markers, {}, subjects=list(people))})["documents"][0]["id"]
    answer = client.post(f"{API}/{trials[0]}/standing-trial", json={"selection": {"documents": [both]}})
    assert answer.status_code == 422
    assert re.search("subject.*Anna, Bert", answer.json()["remedy"])
    (item,) = use(client, trials[0], both, subject="Anna")["items"]  # type: ignore[misc]
    assert "gait Anna LThighRotation" in item["measures"]


def test_the_original_leaves_as_it_came(client: TestClient, trials: list[str], database: Database) -> None:
    use(client, trials[0], trials[1])
    exported = client.get(f"{API}/{trials[1]}/export", params={"format": "c3d"})
    assert exported.content == gait_file(walk(poses=WALKING, way=41.0), LENGTHS)


def test_virtual_markers_are_listed_and_given(client: TestClient) -> None:
    ids = [
        upload(client, {f"{name}.c3d": gait_file(markers, {})})["documents"][0]["id"]
        for name, markers in (("static", person(STANDING)), ("walk", without(person(WALKING, way=40.0), "Med", "Lat")))
    ]
    told = client.get(f"{API}/{ids[0]}/standing-trial").json()
    virtual = {item["name"]: item["carriers"] for item in told["virtual"]}
    assert virtual["LKneeLateral"] == ["L.Thigh.Upper", "L.Thigh.Front", "L.Thigh.Rear"]
    (item,) = use(client, ids[0], ids[1])["items"]  # type: ignore[misc]
    assert "gait RAnkleMedial" in item["measures"]
    assert item["notes"] == []
    found = client.get("/api/v1/xpath", params={"q": "count(//frame[mo:quantity('LKneeAngles', 'x') > 20])"}).json()
    assert found["value"] == 30
