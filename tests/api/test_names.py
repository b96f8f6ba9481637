"""Names in every script, of every length, with every character: stored and found, or refused; never half of both."""

from __future__ import annotations

import random
import unicodedata

import pytest
from fastapi.testclient import TestClient

from mcml.language.dtd import violations
from mcml_service.settings import Settings
from tests.builders import MCML, bvh, one_kind, upload

pytestmark = pytest.mark.above_store

API = "/api/v1"
WALK = "걸음"
NFD = unicodedata.normalize("NFD", WALK)
HANGUL = "".join(chr(random.Random(1).randrange(0xAC00, 0xD7A3)) for _ in range(1024))


def test_both_ways_to_write_a_name_are_one(client: TestClient) -> None:
    assert NFD != WALK
    content = MCML.replace(b"walk", NFD.encode())
    upload(client, {f"{NFD}.bvh": bvh(5)}, project=NFD, label=NFD)
    upload(client, {"hand.mcml": content}, project=WALK)
    assert client.get(f"{API}/projects").json()["items"] == [WALK]
    for name in (WALK, NFD):
        for query in ({"q": name}, {"motion_name": name, "q": name}, {"project": name, "q": name}):
            found = client.get(f"{API}/documents", params=query).json()["items"]
            assert [item["name"] for item in found] == ["hand", WALK], (
                "the one by its motion name, the other by its own"
            )
        asked = {"q": f"count(//frame[motion_name='{name}'])", "project": name}
        assert client.get(f"{API}/xpath", params=asked).json()["value"] == 7
    assert [item["name"] for item in client.get(f"{API}/motion-names").json()["items"]][-1] == WALK


def test_names_are_found_as_they_are_written(client: TestClient) -> None:
    upload(client, {"ÄRGER_50%.bvh": bvh(2)})
    for query in ("ÄRGER", "rger_50%", "RGER", "ärger".upper(), "%"):
        assert client.get(f"{API}/documents", params={"q": query}).json()["total"] == 1, query
    assert client.get(f"{API}/documents", params={"q": "R_ER"}).json()["total"] == 0


TEXTS = {
    "nul": "a\0b",
    "control": "a\x01b",
    "escape": "a\\u{D800}b\\u{41}",
    "long": HANGUL,
    "blank": " ",
    "quote": "'\"",
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_document_stays_readable_whatever_it_is_called(client: TestClient, text: str) -> None:
    done = upload(client, {"a.bvh": bvh(3)})
    address = f"{API}/documents/{done['documents'][0]['id']}"  # type: ignore[index]
    file = [("file", ("a.bvh", bvh(3)))]
    for field in ("name", "project", "label", "description", "unit", "up", "frame_time", "encoding", "skeleton"):
        assert client.post(f"{API}/documents", files=file, data={field: text}).status_code in (201, 404, 422), field
    assert client.post(f"{API}/documents", files=file, data={"property": f"{text}={text}"}).status_code in (201, 422)
    changes: list[dict[str, object]] = [
        {field: text} for field in ("name", "project", "description", "unit", "up", "frame_time")
    ]
    changes.append({"properties": [{"name": text[:256], "value": text, "unit": text[:64]}]})
    for change in changes:
        answer = client.patch(address, json=change, headers={"if-match": "*"})
        assert answer.status_code in (200, 422), (change, answer.text)
        if answer.status_code == 200 and "description" in change:
            assert client.get(address).json()["description"] == text.strip()
    labels = [{"name": text[:1024], "first": 1, "last": 2}]
    assert client.post(f"{address}/labels", json=labels, headers={"if-match": "*"}).status_code in (201, 422)
    for item in client.get(f"{API}/documents").json()["items"]:
        for path in ("", "/labels", "/frames", "/export?format=bvh&original=false", "/export?format=csv"):
            assert client.get(f"{API}/documents/{item['id']}{path}").status_code == 200
        assert violations(client.get(f"{API}/documents/{item['id']}/mcml").content) == []


PLACES = ("left_up_leg", "walk", "hand.mcml")


@pytest.mark.parametrize("text", ["\\u{0}", "\\u{D800}", "\\u{A}", "\\u{1}", "y" * 3000, HANGUL])
def test_uploaded_mcml_is_stored_readable_or_refused(client: TestClient, text: str) -> None:
    filename = b"</filename>"
    documents = [MCML.replace(place.encode(), f"a{text}b".encode()) for place in PLACES]
    documents += [
        MCML.replace(filename, f'{filename.decode()}<property name="{text}" value="{text}" unit="{text}"/>'.encode()),
        MCML.replace(filename, f"{filename.decode()}<description>{text}</description>".encode()),
        MCML.replace(b'version="1.0">', f'version="{text}">'.encode()),
        MCML.replace(b'id="5"', f'id="{text}"'.encode()),
    ]
    for document in documents:
        answer = client.post(f"{API}/documents", files=[("file", ("x.mcml", document))])
        assert answer.status_code in (201, 422), answer.text
        if answer.status_code == 201:
            address = f"{API}/documents/{answer.json()['documents'][0]['id']}"
            for path in ("", "/frames?format=npy", "/export?format=csv", "/export?format=htr"):
                assert client.get(address + path).status_code == 200, path
            again = client.post(f"{API}/documents", files=[("file", ("x.mcml", client.get(f"{address}/mcml").content))])
            assert again.status_code == 201


@one_kind
@pytest.mark.parametrize("time", ["1_0", "１", "1e-320", "0." + "0" * 80 + "1", "0x1", "nan", "1e9", ""])
def test_times_that_are_none_are_refused(client: TestClient, time: str) -> None:
    done = upload(client, {"a.bvh": bvh(3)})
    address = f"{API}/documents/{done['documents'][0]['id']}"  # type: ignore[index]
    answer = client.patch(address, json={"frame_time": time}, headers={"if-match": "*"})
    assert answer.status_code == 422
    rate = MCML.replace(b"</filename>", f"</filename><dataframe_rate>{time}</dataframe_rate>".encode())
    for document in (MCML.replace(b"0.0333", time.encode()), rate):
        answer = client.post(f"{API}/documents", files=[("file", ("x.mcml", document))])
        assert answer.status_code in (201, 422)
        assert client.get(f"{API}/documents").status_code == 200


@pytest.mark.slow
@one_kind
def test_more_bones_than_the_limit_are_refused(client: TestClient) -> None:
    bones = "".join(f"<bone><name>b{number}</name></bone>" for number in range(Settings().max_joints))
    document = MCML.replace(b"</skeleton>", f"{bones}</skeleton>".encode())
    answer = client.post(f"{API}/documents", files=[("file", ("x.mcml", document))])
    assert answer.status_code == 422
    assert "joints" in answer.json()["detail"]


def test_questions_with_nul_find_nothing(client: TestClient) -> None:
    for body in ({"q": "//a", "project": "a\0"}, {"q": "//a", "document": ["a\0"]}):
        assert client.post(f"{API}/xpath", json=body).status_code in (404, 422)


def test_labels_keep_their_ends(client: TestClient) -> None:
    file = [("file", ("a.bvh", bvh(3)))]
    assert client.post(f"{API}/documents", files=file, data={"label": "walk:0-2"}).status_code == 422
    assert client.post(f"{API}/documents", files=file, data={"label": "walk:2-0"}).status_code == 422
