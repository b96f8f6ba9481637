"""Repairs that somebody asked for: what they do, that they do nothing unasked, and that the file is kept as it came."""

from __future__ import annotations

from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml.formats.repairs import split_numbers, whole_frames
from tests.builders import ASF, amc, bvh

API = "/api/v1"


def send(client: TestClient, files: dict[str, bytes], **form: object) -> Any:
    parts = [("file", (name, content)) for name, content in files.items()]
    return client.post(f"{API}/documents", files=parts, data=form)


def glued() -> bytes:
    head, mark, rows = bvh(4).partition(b"Frame Time: 0.0083333\n")
    first, second, *rest = rows.split(b"\n")
    numbers = second.split(b" ")
    place = next(n for n in range(1, len(numbers)) if numbers[n].startswith(b"-"))
    numbers[place - 1 : place + 1] = [numbers[place - 1] + numbers[place]]
    return head + mark + b"\n".join([first, b" ".join(numbers), *rest])


def test_numbers_that_touch_are_set_apart_when_asked(client: TestClient) -> None:
    refused = send(client, {"a.bvh": glued()})
    assert refused.status_code == 422
    assert (refused.json()["code"], refused.json()["details"]) == ("repairable", {"repairs": ["split-numbers"]})
    assert refused.json()["where"]["line"]
    made = send(client, {"a.bvh": glued()}, repair="split-numbers")
    assert made.status_code == 201, made.text
    document = made.json()["documents"][0]
    told = [notice["what"] for notice in document["receipt"]["notices"] if notice["kind"] == "repair"]
    assert told == ["1 numbers that touched the one before them were set apart"]
    address = f"{API}/documents/{document['id']}/export?format=bvh"
    assert client.get(address).content == bvh(4), "it says what is stored"
    assert not client.get(f"{API}/documents/{document['id']}").json()["original"]


@pytest.mark.parametrize("cut", [30, 200])
def test_whole_frames_of_a_motion_that_ends_early(client: TestClient, cut: int) -> None:
    content = bvh(9)[:-cut]
    refused = send(client, {"a.bvh": content})
    assert refused.status_code == 422
    assert refused.json()["details"] == {"repairs": ["whole-frames"]}
    made = send(client, {"a.bvh": content}, repair="whole-frames")
    assert made.status_code == 201, made.text
    frames = made.json()["documents"][0]["receipt"]["frames"]
    assert 0 < frames < 9
    exported = client.get(f"{API}/documents/{made.json()['documents'][0]['id']}/export?format=bvh").content
    assert exported.splitlines()[-frames:] == bvh(9).splitlines()[-9:][:frames]


def test_the_last_frame_of_an_amc(client: TestClient) -> None:
    content = amc(5)[:-4]
    made = send(client, {"leg.asf": ASF, "leg.amc": content}, repair="whole-frames")
    assert made.json()["documents"][0]["receipt"]["frames"] == 4


@pytest.mark.parametrize("files", [{"a.bvh": bvh(5)}, {"leg.asf": ASF, "leg.amc": amc(3)}])
def test_what_is_whole_is_not_touched(client: TestClient, files: dict[str, bytes]) -> None:
    made = send(client, files, repair=["split-numbers", "whole-frames"])
    document = made.json()["documents"][0]
    assert not [one for one in document["receipt"]["notices"] if one["kind"] == "repair"]
    assert client.get(f"{API}/documents/{document['id']}").json()["original"]


def test_bytes_to_bytes() -> None:
    assert (
        split_numbers("bvh", b"Frame Time: 0.1\n1.0-2 3e-5 -4 5.-6\n")[0] == b"Frame Time: 0.1\n1.0 -2 3e-5 -4 5. -6\n"
    )
    assert split_numbers("bvh", b"JOINT a1-2\nFrame Time: 0.1\n")[1] == ""
    assert split_numbers("amc", b"#1-2\n1\nbone1-2 0.5-0.25\n")[0] == b"#1-2\n1\nbone1-2 0.5 -0.25\n"
    assert split_numbers("htr", b"1-2") == (b"1-2", "")
    assert whole_frames("asf", b"x") == (b"x", "")
    assert whole_frames("bvh", b"CHANNELS 2 a b\nFrames: 3\nFrame Time: 1\n1 2\n3 4")[0].endswith(
        b"Frames: 1\nFrame Time: 1\n1 2\n"
    )


def test_other_faults_offer_nothing(client: TestClient) -> None:
    refused = send(client, {"a.bvh": bvh(3).replace(b"ROOT", b"ROT")})
    assert refused.status_code == 422
    assert "details" not in refused.json()
    assert send(client, {"a.bvh": bvh(3)}, repair="magic").status_code == 422
