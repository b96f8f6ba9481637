"""What projects call joints, and documents that get the names of today."""

from __future__ import annotations

from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml.files import shared_skeleton
from mcml.motion.rigs.recognise import UNKNOWN, Recognition
from tests.builders import MCML, TRC, bvh, upload

API = "/api/v1"
RIG = ("Becken", "Wirbel", "LeftUpLeg", "Neck", "Neck1", "Haupt")


def names(client: TestClient, uuid: object, revision: int | None = None) -> list[str]:
    asked = {} if revision is None else {"revision": revision}
    return [bone["name"] for bone in client.get(f"{API}/documents/{uuid}", params=asked).json()["bones"]]


def stored(client: TestClient, project: str = "gait") -> object:
    return upload(client, {"walk.bvh": bvh(5, names=RIG)}, project=project)["documents"][0]["id"]  # type: ignore[index]


def test_a_project_adds_aliases(client: TestClient) -> None:
    address, asked = f"{API}/aliases", {"project": "gait"}
    assert client.get(address, params=asked).json() == {
        "project": "gait", "version": 0, "author": "", "changed": "", "items": [],
    }  # fmt: skip
    before = stored(client)
    table = [{"source": "becken", "name": "Root"}, {"source": "WIRBEL", "name": "waist"}]
    made = client.put(address, params=asked, json={"items": table})
    assert (made.status_code, made.headers["etag"], made.json()["items"]) == (200, '"1"', table)
    assert names(client, stored(client))[:2] == ["Root", "waist"]
    # Other projects, and what was stored before, keep their names.
    assert names(client, stored(client, "other"))[:2] == ["Becken", "Wirbel"]
    assert names(client, before)[:2] == ["Becken", "Wirbel"]
    table[1] = {"source": "Wirbel", "name": "torso7"}
    assert client.put(address, params=asked, json={"items": table}).status_code == 428
    old = client.put(address, params=asked, json={"items": table}, headers={"if-match": '"7"'})
    assert old.status_code == 412
    changed = client.put(address, params=asked, json={"items": table}, headers={"if-match": '"1"'})
    assert changed.json()["version"] == 2
    assert client.get(address, params=asked).json() == changed.json()
    assert client.delete(address, params=asked).status_code == 428
    assert client.delete(address, params=asked, headers={"if-match": "*"}).status_code == 204
    assert client.get(address, params=asked).json()["version"] == 0
    assert client.delete(address, params={"project": "nowhere"}).status_code == 404


@pytest.mark.parametrize(
    ("items", "what"),
    [
        ([("a", "left_uparm")], "Did you mean 'left_up_arm'"),
        ([("a", "tail of a cat")], "lists all 53"),
        ([("L Arm", "Root"), ("l_arm", "waist")], "the same name"),
        ([("--", "Root")], "no name of a joint"),
    ],
)
def test_aliases_that_make_no_sense_are_refused(client: TestClient, items: list[tuple[str, str]], what: str) -> None:
    body = {"items": [{"source": source, "name": name} for source, name in items]}
    answer = client.put(f"{API}/aliases", json=body)
    assert answer.status_code == 422
    assert what in f"{answer.json()['detail']} {answer.json()['remedy']}"
    assert client.get(f"{API}/aliases").json()["version"] == 0


def test_names_of_a_document_written_by_hand_stay(client: TestClient) -> None:
    done = upload(client, {"hand.mcml": MCML.replace(b"left_up_leg", b"LeftUpLeg").replace(b"Root", b"Hips")})
    url = f"{API}/documents/{done['documents'][0]['id']}"  # type: ignore[index]
    assert client.post(f"{url}/names", headers={"if-match": "*"}).json()["items"] == []


def test_documents_that_exist_get_the_names_of_today(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    """As an earlier version of the program named them, which did not know the rig."""
    rig = ("Becken", "Wirbel", "LeftUpLeg", "LeftLeg", "LeftFoot", "Haupt")
    with monkeypatch.context() as patch:
        patch.setattr(shared_skeleton, "recognise_clip", lambda _: Recognition((), UNKNOWN))
        done = upload(client, {"walk.bvh": bvh(5, names=rig)}, project="gait")
    before = done["documents"][0]["id"]  # type: ignore[index]
    old = names(client, before)
    assert old == list(rig)
    url = f"{API}/documents/{before}"
    exported = client.get(f"{url}/export", params={"format": "bvh", "original": False}).content
    values = client.get(f"{url}/frames", params={"format": "npy"}).content
    table = {"items": [{"source": "Becken", "name": "Root"}]}
    client.put(f"{API}/aliases", params={"project": "gait"}, json=table)
    wanted = [
        {"source": "Becken", "before": "Becken", "after": "Root"},
        {"source": "LeftUpLeg", "before": "LeftUpLeg", "after": "left_up_leg"},
        {"source": "LeftLeg", "before": "LeftLeg", "after": "left_low_leg"},
        {"source": "LeftFoot", "before": "LeftFoot", "after": "left_foot"},
    ]
    dry = client.post(f"{url}/names", params={"dry_run": True}).json()
    assert dry == {"document": before, "revision": 1, "items": wanted}
    assert names(client, before) == old
    assert client.post(f"{url}/names").status_code == 428
    made = client.post(f"{url}/names", headers={"if-match": '"1"'}).json()
    assert made == {"document": before, "revision": 2, "items": wanted}
    assert names(client, before) == ["Root", "Wirbel", "left_up_leg", "left_low_leg", "left_foot", "Haupt"]
    # Only names change, also for XPath; the files' own names stay.
    found = client.get(f"{API}/xpath", params={"q": "count(//frame_bone[@name='left_foot'])"}).json()
    assert found["value"] == 5
    assert client.get(f"{url}/export", params={"format": "bvh", "original": False}).content == exported
    assert client.get(f"{url}/frames", params={"format": "npy"}).content == values
    mcml = client.get(f"{url}/mcml").text
    assert 'source_name="LeftFoot"' in mcml
    # Once is enough, and undo takes it back.
    assert client.post(f"{url}/names", headers={"if-match": "*"}).json()["items"] == []
    assert client.get(url).json()["revision"] == 2
    assert client.post(f"{url}/undo", headers={"if-match": "*"}).status_code == 200
    assert names(client, before) == old
    assert names(client, before, 2)[3:5] == ["left_low_leg", "left_foot"]


def test_joints_get_names_that_a_person_chooses(client: TestClient) -> None:
    rig = ("Becken", "Wirbel", "LeftUpLeg", "LeftLeg", "LeftFoot", "Haupt")
    done = upload(client, {"walk.bvh": bvh(5, names=rig)}, project="gait")
    document = done["documents"][0]["id"]  # type: ignore[index]
    url = f"{API}/documents/{document}"
    old = names(client, document)
    values = client.get(f"{url}/frames", params={"format": "npy"}).content

    def put(match: str = "*", **choices: Any) -> Any:
        items = [{"joint": joint, "name": name} for joint, name in choices.pop("items").items()]
        return client.put(f"{url}/names", json={"items": items, **choices}, headers={"if-match": match})

    # A name that another joint has goes to the chosen one; the other has the name of its file again.
    taken = next(name for name in old if name == "left_foot")
    made = put(items={"Wirbel": "waist", "left_low_leg": taken}, remember=True).json()
    assert made["revision"] == 2
    assert [(item["source"], item["after"]) for item in made["items"]] == [
        ("Wirbel", "waist"), ("LeftLeg", "left_foot"), ("LeftFoot", "LeftFoot"),
    ]  # fmt: skip
    now = names(client, document)
    assert [now[index] for index in (1, 3, 4)] == ["waist", "left_foot", "LeftFoot"]
    bones = client.get(f"{url}/skeleton").json()["bones"]
    assert [(bone["mapped"], bone["confidence"]) for bone in bones][1] == (True, None)
    assert bones[4]["mapped"] is False
    assert client.get(f"{url}/frames", params={"format": "npy"}).content == values
    found = client.get(f"{API}/xpath", params={"q": "count(//frame_bone[@name='waist'])"}).json()
    assert found["value"] == 5
    # Remembered for later imports of the project.
    table = client.get(f"{API}/aliases", params={"project": "gait"}).json()
    assert [(item["source"], item["name"]) for item in table["items"]] == [
        ("Wirbel", "waist"), ("LeftLeg", "left_foot"),
    ]  # fmt: skip
    again = upload(client, {"again.bvh": bvh(6, names=rig)}, project="gait")
    assert names(client, again["documents"][0]["id"])[1] == "waist"  # type: ignore[index]
    # Nothing to do is no revision; the name of the file comes back; undo takes names back.
    assert put(items={"waist": "waist"}).json() == {"document": document, "revision": 2, "items": []}
    assert [item["after"] for item in put(items={"waist": None}).json()["items"]] == ["Wirbel"]
    assert client.post(f"{url}/undo", headers={"if-match": "*"}).status_code == 200
    assert names(client, document)[1] == "waist"
    assert put('"1"', items={"waist": None}).status_code == 412


@pytest.mark.parametrize(
    ("items", "what"),
    [
        ([("Tail", "Root")], "no joint 'Tail'"),
        ([("Hips", "waste")], "Did you mean 'waist'"),
        ([("Hips", "waist"), ("Neck", "waist")], "chosen for two joints"),
    ],
)
def test_names_that_make_no_sense_are_refused(client: TestClient, items: list[tuple[str, str]], what: str) -> None:
    rig = ("Hips", "Neck", "LeftUpLeg", "LeftLeg", "LeftFoot", "Haupt")
    done = upload(client, {"walk.bvh": bvh(5, names=rig)})
    document = done["documents"][0]["id"]  # type: ignore[index]
    present = dict(zip(rig, names(client, document), strict=True))
    body = {"items": [{"joint": present.get(joint, joint), "name": name} for joint, name in items]}
    answer = client.put(f"{API}/documents/{document}/names", json=body, headers={"if-match": "*"})
    assert answer.status_code == 422
    assert what in f"{answer.json()['detail']} {answer.json()['remedy']}"
    assert client.get(f"{API}/documents/{document}").json()["revision"] == 1


def test_markers_keep_their_names(client: TestClient) -> None:
    done = upload(client, {"points.trc": TRC})
    document = done["documents"][0]["id"]  # type: ignore[index]
    marker = names(client, document)[0]
    body = {"items": [{"joint": marker, "name": "Root"}]}
    answer = client.put(f"{API}/documents/{document}/names", json=body, headers={"if-match": "*"})
    assert "Markers and blend shapes keep" in answer.json()["remedy"]
