"""What every answer says, and what every endpoint refuses: over all operations that the API describes."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.api.policy import DEFAULTS, NOTHING
from mcml_service.storage.database import Database
from tests.builders import bvh, description, one_kind, served, upload

DESCRIPTION = description()
PATHS = sorted(DESCRIPTION["paths"])


@pytest.fixture(scope="module")
def asked(sqlite_template: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    path = tmp_path_factory.mktemp("answers") / "store.db"
    path.write_bytes(sqlite_template.read_bytes())
    store = Database(f"sqlite:///{path}")
    with served(store) as client:
        yield client
    store.close()


def filled(path: str) -> str:
    return re.sub(r"\{[^}]*\}", "1", path)


@pytest.mark.parametrize("path", [path for path in PATHS if path.startswith("/api")])
def test_unknown_parameters_are_refused_everywhere(asked: TestClient, path: str) -> None:
    for method in DESCRIPTION["paths"][path]:
        answer = asked.request(method, filled(path), params={"unheard_of": "1"})
        assert answer.status_code == 422, method
        assert answer.json()["detail"].startswith("query.unheard_of: This endpoint has no such parameter."), method


@pytest.mark.parametrize("path", PATHS)
def test_all_methods_of_an_address_are_named(asked: TestClient, path: str) -> None:
    own = {method.upper() for method in DESCRIPTION["paths"][path]}
    for method in ("PROPFIND", "OPTIONS", *({"PUT", "PATCH", "DELETE"} - own)):
        answer = asked.request(method, filled(path))
        if answer.status_code == 405:
            allowed = set(answer.headers["allow"].split(", "))
            assert allowed >= own | ({"HEAD"} if "GET" in own else set())
            assert method not in allowed
            assert answer.json()["remedy"]
        else:
            # An address with a name in it may be another's as well.
            assert any(method.lower() in other for other in DESCRIPTION["paths"].values()), method


@pytest.mark.parametrize(
    ("path", "near"),
    [
        ("/documents?projekt=a", "project"),
        ("/documents?motion-name=a", "motion_name"),
        ("/documents/1/frames?laast=3", "last"),
        ("/documents/1/export?formatt=bvh", "format"),
        ("/xpath?queery=//frame", None),
    ],
)
def test_the_nearest_known_parameter_is_named(asked: TestClient, path: str, near: str | None) -> None:
    said = asked.get("/api/v1" + path).json()["detail"]
    assert said.endswith(f"Did you mean {near}?") if near else "Its parameters are as, cursor, document," in said


def test_unknown_fields_of_a_form_are_refused(asked: TestClient) -> None:
    files = [("file", ("a.bvh", bvh(2)))]
    answer = asked.post("/api/v1/documents", files=files, data={"labell": "walk"})
    assert answer.status_code == 422
    assert answer.json()["errors"] == [
        {"in": "body.labell", "what": "This endpoint has no such parameter. Did you mean label?"}
    ]
    assert asked.get("/api/v1/documents").json()["total"] == 0


def test_no_body_has_fields_that_are_dropped() -> None:
    """Every object in a request is refused whole where it holds a name that nobody reads; forms: see above."""
    schemas, open_ones, seen = DESCRIPTION["components"]["schemas"], set(), set()

    def walk(part: Any) -> None:
        if isinstance(part, list):
            for item in part:
                walk(item)
        elif isinstance(part, dict) and "$ref" in part:
            name = part["$ref"].rpartition("/")[2]
            if name not in seen:
                seen.add(name)
                if "properties" in schemas[name] and schemas[name].get("additionalProperties") is not False:
                    open_ones.add(name)
                walk(schemas[name])
        elif isinstance(part, dict):
            for item in part.values():
                walk(item)

    for operation in (item for path in DESCRIPTION["paths"].values() for item in path.values()):
        for kind, media in operation.get("requestBody", {}).get("content", {}).items():
            if "json" in kind:
                walk(media["schema"])
    assert len(seen) > 40
    assert open_ones == set()


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    ["/", "/docs", "/docs/problems", "/docs/assets/swagger-ui.css", "/mcml.dtd", "/healthz", "/api/v1/documents",
     "/api/v1/nothing", "/openapi.json", "/nowhere"],
)  # fmt: skip
def test_every_answer_is_guarded(asked: TestClient, path: str) -> None:
    headers = asked.get(path).headers
    for name, value in DEFAULTS:
        assert headers[name] == value or name == "content-security-policy", name
    policy = headers["content-security-policy"]
    assert policy.startswith(NOTHING)
    assert "unsafe" not in policy
    assert "*" not in policy


def test_refusals_are_guarded_too(asked: TestClient) -> None:
    for answer in (asked.get("/?a=%00"), asked.get("/", headers={"authorization": "", "host": "evil.example"})):
        assert answer.status_code in (400, 401)
        assert answer.headers["content-security-policy"] == NOTHING
        assert answer.headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize("path", ["/", "/docs", "/docs/problems"])
def test_pages_run_and_show_what_their_policy_names(asked: TestClient, path: str) -> None:
    """Whatever stands in a page between tags is named by its hash, and what it loads comes from here."""
    answer = asked.get(path)
    policy = dict(part.strip().partition(" ")[::2] for part in answer.headers["content-security-policy"].split(";"))
    for tag, directive in (("style", "style-src"), ("script", "script-src")):
        for text in re.findall(rf"<{tag}>(.*?)</{tag}>", answer.text, re.DOTALL):
            digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
            assert f"'sha256-{digest}'" in policy[directive]
    assert not re.search(r"\s(style|on\w+)=", answer.text)
    for address in re.findall(r'(?:src|href)="([^"]*)"', answer.text):
        assert address.startswith("/")
    if path == "/docs":
        assert "'self'" in policy["script-src"]
        assert policy["connect-src"] == "'self'"


@pytest.mark.slow
def test_answers_without_a_tag_get_none_when_compressed(asked: TestClient) -> None:
    for path in ("/openapi.json", "/docs/problems", "/api/v1/motion-names"):
        answer = asked.get(path, headers={"accept-encoding": "gzip"})
        assert answer.headers["content-encoding"] == "gzip", path
        assert answer.headers.get("etag") != "", path


@one_kind
@pytest.mark.parametrize("tag", ['W/"1-json"', 'W/"1"', 'W/"1-json", W/"2"'])
def test_a_weak_tag_changes_nothing(client: TestClient, tag: str) -> None:
    made: Any = upload(client, {"a.bvh": bvh(2)})
    address = f"/api/v1/documents/{made['documents'][0]['id']}"
    bone = "/elements?merge=true&xpath=/mcml/motion/frame[1]/frame_bone[1]"
    for path, body in (("", {"name": "b"}), (bone, {"attributes": {"Rx": "1"}})):
        answer = client.patch(address + path, json=body, headers={"if-match": tag})
        assert answer.status_code == 412, answer.text
        assert "weak" in answer.json()["detail"]
    assert client.get(address).json()["revision"] == 1
    both = client.patch(address, json={"name": "b"}, headers={"if-match": f'{tag}, "1-json"'})
    assert both.status_code == 200
    pairs = {"pairs": [{"source": "Root", "target": "Root"}]}
    assert client.put("/api/v1/mappings/m", json=pairs).status_code == 201
    assert client.put("/api/v1/mappings/m", json=pairs, headers={"if-match": 'W/"1"'}).status_code == 412
    assert client.delete("/api/v1/mappings/m", headers={"if-match": 'W/"1"'}).status_code == 412


@one_kind
def test_xml_says_its_encoding(client: TestClient) -> None:
    uuid = upload(client, {"산책.bvh": bvh(300)})["documents"][0]["id"]  # type: ignore[index]
    place = f"/api/v1/documents/{uuid}"
    for path in ("export", "elements", "xpath"):
        asked = {"export": {"format": "mcml"}, "elements": {"xpath": "/mcml/skeleton"}}.get(
            path, {"q": "//bone", "as": "xml"}
        )
        address = f"{place}/{path}" if path != "xpath" else "/api/v1/xpath"
        answer = client.get(address, params=asked)
        assert answer.headers["content-type"] == "application/xml; charset=utf-8", answer.text
        answer.content.decode("utf-8")
