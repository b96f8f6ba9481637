"""Documents of any length a window at a time: children of elements, lines of text, places of words."""

from __future__ import annotations

from typing import Any

import pytest
from fastapi.testclient import TestClient
from lxml import etree

from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import ASF, amc, bvh, served, store, upload
from tests.conftest import StoreOf

pytestmark = pytest.mark.above_store

API = "/api/v1/documents"
FILES = [{"walk.bvh": bvh(700)}, {"leg.asf": ASF, "leg.amc": amc(5)}]


def fill(client: TestClient) -> list[str]:
    more: dict[str, Any] = {"description": "Two lines,\none after the other.", "property": ["age=23 year"]}
    found = [str(upload(client, files, **more)["documents"][0]["id"]) for files in FILES]  # type: ignore[index]
    for uuid, spans in zip(found, ([(3, 300), (4, 4), (690, 700)], [(2, 3)]), strict=True):
        labels = [{"name": f"walk {a}", "first": a, "last": b} for a, b in spans]
        done = client.post(f"{API}/{uuid}/labels", json=labels, headers={"if-match": "*"})
        assert done.status_code == 201
        gone = client.delete(
            f"{API}/{uuid}/elements",
            params={"xpath": "/mcml/motion/frame[5]/frame_bone[2]"},
            headers={"if-match": "*"},
        )
        assert gone.status_code == 200
    return found


@pytest.fixture
def filled(kind: str, store_of: StoreOf) -> tuple[TestClient, list[str]]:
    return store_of(kind, fill)


def page(client: TestClient, uuid: str, **asked: object) -> dict[str, Any]:
    answer = client.get(f"{API}/{uuid}/children", params=asked)  # type: ignore[arg-type]
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


@pytest.mark.parametrize("number", [0, 1])
def test_the_tree_is_that_of_the_document(filled: tuple[TestClient, list[str]], number: int) -> None:
    """Opened from the top, window by window, it has the elements, and every address finds the one that it names."""
    client, uuids = filled
    whole = etree.fromstring(client.get(f"{API}/{uuids[number]}/mcml").content)
    opened = 0
    stack = ["/mcml"]
    while stack and opened < 120:
        address = stack.pop(0)
        (element,) = whole.xpath(address)
        found = page(client, uuids[number], address=address, limit=1000)
        assert found["total"] == len(element)
        for item, child in zip(found["items"], element, strict=True):
            assert (item["name"], item["attributes"], item["children"]) == (child.tag, dict(child.attrib), len(child))
            assert item["text"] == (child.text or "" if not len(child) else "")
            assert whole.xpath(item["address"]) == [child]
            stack += [item["address"]] * (item["children"] > 0)
        opened += 1


def test_windows_of_children(filled: tuple[TestClient, list[str]]) -> None:
    client, (uuid, _) = filled
    whole = page(client, uuid, address="/mcml/motion", limit=1000)
    assert (whole["total"], len(whole["items"])) == (702, 702)
    for first, limit in ((1, 2), (2, 3), (300, 5), (700, 100), (703, 10)):
        some = page(client, uuid, address="/mcml/motion", first=first, limit=limit)
        assert (some["total"], some["items"]) == (702, whole["items"][first - 1 :][:limit])
    assert page(client, uuid)["items"][-1]["address"] == "/mcml/motion"
    assert page(client, uuid, first=2, limit=1)["items"] == page(client, uuid)["items"][1:2]
    assert page(client, uuid, address="/mcml/motion/frame[1]/frame_bone[1]")["total"] == 0
    for wrong in ("/mcml/motion/frame[701]", "/mcml/header/nothing", "//frame"):
        assert client.get(f"{API}/{uuid}/children", params={"address": wrong}).status_code == 404


@pytest.mark.parametrize("pretty", [False, True])
@pytest.mark.parametrize("number", [0, 1])
def test_windows_of_text_are_lines_of_the_whole(
    filled: tuple[TestClient, list[str]], number: int, pretty: bool
) -> None:
    client, uuids = filled
    address = f"{API}/{uuids[number]}/mcml"
    lines = client.get(address, params={"pretty": pretty}).text.split("\n")[:-1]
    frames = len(page(client, uuids[number], address="/mcml/motion", limit=1000)["items"]) - 1 - (number == 0)
    head = client.get(address, params={"pretty": pretty, "part": "head", "revision": 1})
    assert "immutable" in head.headers["cache-control"]
    for first, last in ((0, 0), (1, 1), (3, 5), (4, frames), (frames, frames)):
        asked = {"part": "frames", "first": first, "last": last} if first else {"part": "head"}
        answer = client.get(address, params={"pretty": pretty, **asked})
        start, count, total = (int(answer.headers[f"x-mcml-{name}"]) for name in ("first-line", "lines", "total-lines"))
        assert total == len(lines)
        assert answer.text.split("\n")[:-1] == lines[start - 1 :][:count], asked
        assert answer.text.count("\n") == count
    assert client.get(address, params={"part": "frames", "first": 1000}).status_code == 404


@pytest.mark.parametrize("pretty", [False, True])
@pytest.mark.parametrize(
    "text", ["age", "one after", "walk 4", 'name="Head"', "<frame id=", "</motion>", "<mcml", "zzz", "frametime", "e"]
)
def test_text_is_found_line_by_line(filled: tuple[TestClient, list[str]], text: str, pretty: bool) -> None:
    client, (uuid, _) = filled
    content = client.get(f"{API}/{uuid}/mcml", params={"pretty": pretty}).content
    lines = content.decode().split("\n")[:-1]
    whole = etree.fromstring(content)
    at, found = 1, []
    while len(found) < 12:
        asked = {"text": text, "from": at, "pretty": pretty}
        place = client.get(f"{API}/{uuid}/find", params=asked).json()["place"]
        if place is None:
            break
        line = lines[place["line"] - 1]
        assert line.index(text) + 1 == place["column"]
        (element,) = whole.xpath(place["address"])
        assert place["text"] in line
        written = etree.tostring(element).decode()
        assert text.rstrip("=") in written or text in lines[0] + lines[1] + lines[-2], (place, written[:200])
        frame = place["frame"]
        assert (frame is None) == ("/frame[" not in place["address"])
        found.append(place["line"])
        at = place["line"] + 1
    assert found == [number for number, line in enumerate(lines, start=1) if text in line][: len(found)]
    assert len(found) == 12 or at > max(found, default=0)


def test_looking_ends_when_its_time_is_up(database: Database) -> None:
    uuid = store(database, {"walk.bvh": bvh(3000)})[0]
    with served(database, Settings(query_seconds=1e-9)) as client:
        seen = []
        at: int | None = 1
        while at is not None and len(seen) < 9:
            answer = client.get(f"{API}/{uuid}/find", params={"text": "zzz", "from": at}).json()
            seen.append(at)
            assert answer["place"] is None
            at = answer["next"]
    assert at is None, "it gets to the end all the same"
    assert len(seen) == 3
