"""Documents over HTTP: upload, list, read, change, conditional requests, history."""

from __future__ import annotations

import io
import zipfile
from typing import get_args

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml_service.operations.documents import Sort
from tests.builders import ASF, HTR, MCML, TRC, amc, bvh, upload

API = "/api/v1"


def only(client: TestClient, files: dict[str, bytes], **form: object) -> str:
    (document,) = upload(client, files, **form)["documents"]
    return document["id"]


def test_upload_answers_a_receipt_and_the_location(client: TestClient) -> None:
    answer = client.post(
        f"{API}/documents",
        files=[("file", ("walk.bvh", bvh(40)))],
        data={
            "label": ["walk", "left arm_abduction:3-9"],
            "property": ["age=23 year", "take=calm"],
            "unit": "cm",
            "up": "Y",
        },
    )
    assert answer.status_code == 201
    (document,) = answer.json()["documents"]
    assert answer.headers["location"] == f"{API}/documents/{document['id']}"
    receipt = document["receipt"]
    assert (receipt["frames"], receipt["joints"], receipt["channels"]) == (40, 3, 12)
    assert receipt["frame_rate"]["seconds"] == 0.0083333
    assert receipt["unit"] == {"value": "cm", "stated": True, "why": "the header says so"}
    found = client.get(answer.headers["location"]).json()
    assert [(item["name"], item["first"], item["last"]) for item in found["labels"]] == [
        ("walk", 1, 40),
        ("left-arm-abduction", 3, 9),
    ]
    assert found["properties"][0] == {"name": "age", "value": "23", "unit": "year"}
    assert found["unit"] == "cm"
    assert found["original"] is True


def test_unit_and_rate_are_never_assumed(client: TestClient) -> None:
    (document,) = upload(client, {"leg.asf": ASF, "leg.amc": amc()})["documents"]
    receipt = document["receipt"]
    assert receipt["frame_rate"]["seconds"] is None
    assert receipt["unit"]["value"] is None
    assert "frame_time" in receipt["frame_rate"]["why"]
    assert client.get(f"{API}/documents/{document['id']}").json()["duration"] is None


def test_amc_finds_its_asf(client: TestClient) -> None:
    other = ASF.replace(b":name leg", b":name other")
    done = upload(
        client,
        {"leg.asf": ASF, "take_01.amc": amc(), "other.asf": other, "other_02.amc": amc().replace(b"leg.asf", b"x")},
    )
    names = {document["name"]: document["receipt"]["frames"] for document in done["documents"]}
    assert names == {"take_01": 2, "other_02": 2}
    first = done["documents"][0]["id"]
    alone = client.post(f"{API}/documents", files=[("file", ("x.amc", amc()))])
    assert alone.status_code == 422
    assert "skeleton" in alone.json()["detail"]
    helped = upload(client, {"x.amc": amc(3)}, skeleton=first)
    assert helped["documents"][0]["receipt"]["frames"] == 3


def zipped(files: list[tuple[str, bytes]]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, content in files:
            archive.writestr(name, content)
    return packed.getvalue()


def test_skeletons_of_equal_name_are_kept_apart_by_their_folders(client: TestClient) -> None:
    shin = ASF.replace(b"6.9833", b"5.5")
    files = [("one/leg.asf", ASF), ("one/leg.amc", amc(2)), ("two/leg.asf", shin), ("two/leg.amc", amc(3))]
    done = upload(client, {"all.zip": zipped(files)})
    assert done["problems"] == []
    kept = {
        document["receipt"]["frames"]: client.get(
            f"{API}/documents/{document['id']}/export", params={"format": "asf"}
        ).content
        for document in done["documents"]
    }
    assert kept == {2: ASF, 3: shin}


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("folders", [("one", "two"), ("", ""), ("takes", "takes")])
def test_skeletons_of_equal_name_are_not_guessed(client: TestClient, folders: tuple[str, str]) -> None:
    files = [(f"{folder}/leg.asf".lstrip("/"), ASF) for folder in folders] + [("takes/leg.amc", amc())]
    done = upload(client, {"all.zip": zipped(files)})
    (problem,) = done["problems"]
    assert problem["file"] == "takes/leg.amc"
    assert "2 skeletons are called leg.asf" in problem["problem"]["detail"]
    assert [document["receipt"]["frames"] for document in done["documents"]] == [0, 0]


def test_zip_of_everything_and_one_bad_file(client: TestClient) -> None:
    files = [("a/walk.bvh", bvh(4)), ("a/leg.asf", ASF), ("a/leg.amc", amc()), ("two.htr", HTR), ("hand.mcml", MCML)]
    files += [("bad.bvh", bvh(4)[:-30]), ("__MACOSX/._walk.bvh", b"\0\1")]
    done = upload(client, {"all.zip": zipped(files)})
    assert {document["name"] for document in done["documents"]} == {"walk", "leg", "two", "hand"}
    (problem,) = done["problems"]
    assert problem["file"] == "bad.bvh"
    assert problem["problem"]["status"] == 422


def test_nothing_is_stored_of_a_refused_file(client: TestClient) -> None:
    answer = client.post(f"{API}/documents", files=[("file", ("bad.bvh", bvh(9).replace(b"Frames: 9", b"Frames: 10")))])
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["where"]["file"] == "bad.bvh"
    assert client.get(f"{API}/documents").json()["total"] == 0


def test_list_filters_and_pages(client: TestClient) -> None:
    for number in range(5):
        only(
            client,
            {f"walk_{number}.bvh": bvh(3, seed=number)},
            property=f"age={20 + number} year",
            label=f"walk-{number}",
        )
    only(client, {"two.htr": HTR}, project="lab")
    assert client.get(f"{API}/documents", params={"q": "WALK_"}).json()["total"] == 5
    ages = client.get(f"{API}/documents", params={"property": "age:21..23"}).json()
    assert [item["name"] for item in ages["items"]] == ["walk_1", "walk_2", "walk_3"]
    named = client.get(f"{API}/documents", params={"motion_name": "walk-4"}).json()
    assert [item["name"] for item in named["items"]] == ["walk_4"]
    assert client.get(f"{API}/documents", params={"project": "lab"}).json()["items"][0]["format"] == "htr"
    for sort in ("name", "newest"):
        seen, cursor = [], None
        while True:
            page = client.get(
                f"{API}/documents", params={"limit": 2, "sort": sort} | ({"cursor": cursor} if cursor else {})
            ).json()
            seen += [item["name"] for item in page["items"]]
            cursor = page["next_cursor"]
            if cursor is None:
                break
        names = ["two", *(f"walk_{n}" for n in range(5))]
        assert seen == (names if sort == "name" else ["two", *reversed(names[1:])])
    assert client.get(f"{API}/documents", params={"cursor": "nonsense"}).status_code == 422


def pages(client: TestClient, **asked: object) -> list[str]:
    """Names on all pages of two."""
    seen: list[str] = []
    cursor: str | None = ""
    while cursor is not None:
        given = {"limit": 2, **asked} | ({"cursor": cursor} if cursor else {})
        page = client.get(f"{API}/documents", params=given)  # type: ignore[arg-type]
        assert page.status_code == 200, page.text
        seen += [item["name"] for item in page.json()["items"]]
        cursor = page.json()["next_cursor"]
    return seen


@pytest.mark.slow
def test_lists_have_any_order(client: TestClient) -> None:
    still = bvh(9).replace(b"Frame Time: 0.0083333", b"Frame Time: 0")
    only(client, {"still.bvh": still}, project="b")
    ids = {name: only(client, {f"{name}.bvh": bvh(frames)}, project="c") for name, frames in (("long", 8), ("Mid", 4))}
    only(client, {"even.bvh": bvh(4)}, project="a")
    only(client, {"hand.trc": TRC}, project="a")
    by_frames = ["Mid", "even", "hand", "long", "still"]
    assert pages(client, sort="frames") == by_frames
    assert pages(client, sort="-frames") == ["still", "long", "Mid", "even", "hand"], "equal ones by name"
    assert pages(client, sort="duration")[-1] == pages(client, sort="-duration")[-1] == "still", "unknown ones last"
    assert pages(client, sort="-duration")[0] == "long"
    assert pages(client, sort="project") == ["even", "hand", "still", "Mid", "long"]
    assert pages(client, sort="-format") == ["hand", "Mid", "even", "long", "still"]
    assert pages(client, sort="-name") == ["still", "long", "hand", "even", "Mid"]
    assert pages(client, sort="-created")[0] == "hand"
    client.patch(f"{API}/documents/{ids['Mid']}", json={"description": "x"}, headers={"if-match": "*"})
    assert pages(client, sort="-modified")[0] == pages(client, sort="-revision")[0] == "Mid"
    for sort in get_args(Sort):
        assert sorted(pages(client, sort=sort)) == sorted(by_frames)
        assert pages(client, sort=sort, q="a 0.3") == pages(client, sort=sort, format="nothing") == []


def test_a_cursor_goes_on_where_its_document_was(client: TestClient) -> None:
    ids = {name: only(client, {f"{name}.bvh": bvh(frames)}) for frames, name in enumerate("abcde", 1)}
    asked = {"sort": "-frames", "limit": 2}
    first = client.get(f"{API}/documents", params=asked).json()
    assert [item["name"] for item in first["items"]] == ["e", "d"]
    client.delete(f"{API}/documents/{ids['d']}", headers={"if-match": "*"})
    rest = client.get(f"{API}/documents", params=asked | {"cursor": first["next_cursor"]}).json()
    assert ([item["name"] for item in rest["items"]], rest["total"]) == (["c", "b"], 4)
    for other in ("frames", "-revision", "-duration", "name", "newest"):
        wrong = client.get(f"{API}/documents", params={"sort": other, "cursor": first["next_cursor"]})
        assert wrong.status_code == 422
        assert wrong.json()["remedy"]
    assert client.get(f"{API}/documents", params={"sort": "colour"}).status_code == 422


def test_writes_need_the_revision_that_was_read(client: TestClient) -> None:
    uuid = only(client, {"walk.bvh": bvh(4)})
    address = f"{API}/documents/{uuid}"
    assert client.patch(address, json={"name": "x"}).status_code == 428
    tag = client.get(address).headers["etag"]
    done = client.patch(address, json={"name": "x", "description": "d"}, headers={"if-match": tag})
    assert done.status_code == 200
    assert done.json()["revision"] == 2
    assert client.patch(address, json={"name": "y"}, headers={"if-match": tag}).status_code == 412
    assert client.get(address, headers={"if-none-match": done.headers["etag"]}).status_code == 304
    assert client.get(address).json()["name"] == "x"
    assert client.patch(address, json={"nonsense": 1}, headers={"if-match": "*"}).status_code == 422


@pytest.mark.slow
def test_delete_hides_and_restore_brings_back(client: TestClient) -> None:
    uuid = only(client, {"walk.bvh": bvh(4)})
    address = f"{API}/documents/{uuid}"
    assert client.delete(address, headers={"if-match": '"1"'}).status_code == 204
    assert client.get(address).status_code == 404
    assert client.get(f"{API}/documents").json()["total"] == 0
    assert client.post(f"{address}/restore", headers={"if-match": "*"}).status_code == 200
    assert client.get(address).json()["frames"] == 4
    operations = [item["operation"] for item in client.get(f"{address}/revisions").json()["items"]]
    assert operations == ["restore", "delete", "import"]


def test_deleted_documents_are_listed_in_pages(client: TestClient) -> None:
    uuids = [only(client, {f"{name}.bvh": bvh(2 + number)}) for number, name in enumerate("abcd")]
    for uuid in uuids[:3]:
        client.delete(f"{API}/documents/{uuid}", headers={"if-match": "*"}).raise_for_status()
    first = client.get(f"{API}/documents", params={"deleted": True, "limit": 2}).json()
    rest = client.get(f"{API}/documents", params={"deleted": True, "cursor": first["next_cursor"]}).json()
    assert ([item["id"] for item in first["items"] + rest["items"]], first["total"]) == (uuids[:3], 3)
    assert rest["next_cursor"] is None
    found = client.get(f"{API}/documents", params={"deleted": True, "q": "B"}).json()
    assert ([item["id"] for item in found["items"]], found["total"]) == ([uuids[1]], 1)
    assert [item["id"] for item in client.get(f"{API}/documents").json()["items"]] == uuids[3:]
    client.post(f"{API}/documents/{uuids[0]}/restore", headers={"if-match": "*"}).raise_for_status()
    assert client.get(f"{API}/documents", params={"deleted": True}).json()["total"] == 2


def test_any_revision_can_be_read_and_restored(client: TestClient) -> None:
    uuid = only(client, {"walk.bvh": bvh(4)}, label="walk")
    address = f"{API}/documents/{uuid}"
    label = client.get(f"{address}/labels").json()["items"][0]["id"]
    assert client.delete(f"{address}/labels/{label}", headers={"if-match": "*"}).status_code == 204
    added = client.post(f"{address}/labels", json=[{"name": "hop", "first": 2, "last": 3}], headers={"if-match": "*"})
    assert added.status_code == 201
    names = {
        n: [i["name"] for i in client.get(f"{address}/labels", params={"revision": n}).json()["items"]]
        for n in (1, 2, 3)
    }
    assert names == {1: ["walk"], 2: [], 3: ["hop"]}
    assert b"walk" in client.get(f"{address}/mcml", params={"revision": 1}).content
    assert client.post(f"{address}/restore", params={"revision": 1}, headers={"if-match": "*"}).json()["revision"] == 4
    assert [item["name"] for item in client.get(f"{address}/labels").json()["items"]] == ["walk"]
    assert client.get(f"{address}/labels", params={"revision": 9}).status_code == 404


def test_impossible_names_are_refused_with_the_possible_one(client: TestClient) -> None:
    uuid = only(client, {"walk.bvh": bvh(4)})
    body = [{"name": "left-shoulder-abduction", "first": 1, "last": 2}]
    answer = client.post(f"{API}/documents/{uuid}/labels", json=body, headers={"if-match": "*"})
    assert answer.status_code == 422
    assert "left-arm-abduction" in answer.json()["remedy"]
    assert client.get(f"{API}/documents/{uuid}").json()["revision"] == 1


def test_frames_as_numbers(client: TestClient) -> None:
    uuid = only(client, {"walk.bvh": bvh(600)})
    address = f"{API}/documents/{uuid}/frames"
    page = client.get(address, params={"first": 255, "limit": 4, "bone": ["Root", "Head"]}).json()
    assert [item["frame"] for item in page["items"]] == [255, 256, 257, 258]
    assert set(page["items"][0]["values"]) == {"Root", "Head"}
    following = client.get(address, params={"cursor": page["next_cursor"], "limit": 2}).json()
    assert [item["frame"] for item in following["items"]] == [259, 260]
    answer = client.get(address, params={"format": "npy", "first": 10, "last": 500, "step": 7})
    array = np.load(io.BytesIO(answer.content))
    columns = answer.headers["x-mcml-columns"].split(",")
    assert array.shape == (71, 12)
    row = client.get(address, params={"first": 17, "limit": 1}).json()["items"][0]
    assert array[1, columns.index("Head.Rx")] == row["values"]["Head"]["Rx"]
    positions = np.load(io.BytesIO(client.get(address, params={"format": "npy", "space": "positions"}).content))
    assert positions.shape == (600, 3, 3)
    assert np.allclose(np.linalg.norm(positions[:, 1] - positions[:, 0], axis=1), 10.5)
    assert client.get(address, params={"bone": "tail"}).status_code == 404
    assert client.get(address, params={"first": 601}).status_code == 404


@pytest.mark.parametrize("target", ["bvh", "asf-amc", "asf", "amc", "htr", "mcml", "csv"])
def test_exports_have_names_and_content(client: TestClient, target: str) -> None:
    uuid = only(client, {"걷기 1.bvh": bvh(5)})
    answer = client.get(f"{API}/documents/{uuid}/export", params={"format": target})
    assert answer.status_code == 200
    assert len(answer.content) > 50
    assert "filename*=UTF-8''%EA%B1%B7%EA%B8%B0" in answer.headers["content-disposition"]


def test_unknown_things_are_problems(client: TestClient) -> None:
    uuid = only(client, {"walk.bvh": bvh(5)})
    for address, status in (
        (f"{API}/documents/{uuid}/export?format=fbx", 415),
        (f"{API}/documents/nope", 404),
        (f"{API}/nope", 404),
        (f"{API}/documents?limit=0", 422),
        (f"{API}/documents/{uuid}/export?format=bvh&unit=m", 422),
    ):
        answer = client.get(address)
        assert answer.status_code == status, address
        assert answer.headers["content-type"] == "application/problem+json"
        assert answer.json()["detail"]


def test_inspect_stores_nothing(client: TestClient) -> None:
    answer = client.post(f"{API}/inspect", files=[("file", ("walk.bvh", bvh(5))), ("file", ("bad.bvh", b"HIERARCHY"))])
    assert answer.status_code == 200
    assert answer.json()["clips"][0]["receipt"]["frames"] == 5
    assert answer.json()["problems"][0]["file"] == "bad.bvh"
    assert client.get(f"{API}/documents").json()["total"] == 0


def test_what_a_target_cannot_hold_is_said(client: TestClient) -> None:
    uuid = only(client, {"leg.asf": ASF, "leg.amc": amc(3)})
    answer = client.get(f"{API}/documents/{uuid}/export", params={"format": "bvh", "frame_time": "0.01"})
    assert "limits" in answer.headers["x-mcml-notices"]
    assert client.get(f"{API}/documents/{uuid}/export", params={"format": "asf"}).headers.get("x-mcml-notices") is None


def test_a_new_file_replaces_the_frames_over_http(client: TestClient) -> None:
    old, new = bvh(20), bvh(25)
    uuid = upload(client, {"a.bvh": old})["documents"][0]["id"]  # type: ignore[index]
    address = f"/api/v1/documents/{uuid}/file"
    looked = client.put(address, files={"file": ("b.bvh", new)}, data={"dry_run": "true"})
    assert looked.status_code == 200
    assert (looked.json()["frames_before"], looked.json()["frames"], looked.json()["revision"]) == (20, 25, 1)
    assert client.put(address, files={"file": ("b.bvh", new)}).status_code == 428
    made = client.put(address, files={"file": ("b.bvh", new)}, headers={"If-Match": '"1"'})
    assert (made.status_code, made.json()["revision"]) == (200, 2)
    assert client.get(f"/api/v1/documents/{uuid}/export?format=bvh").content.count(b"\n") > old.count(b"\n")
    assert client.get(f"/api/v1/documents/{uuid}/export?format=original").content == old
    refused = client.put(address, files={"file": ("c.bvh", bvh(3, names=("Root",)))}, headers={"If-Match": '"2"'})
    assert refused.status_code == 409
    assert "joints" in refused.json()["detail"]
