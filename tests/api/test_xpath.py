"""XPath over HTTP: every answer equals libxml2's on the serialised documents."""

from __future__ import annotations

import io
import json
from typing import Any, TypeAlias

import pytest
from fastapi.testclient import TestClient
from lxml import etree

from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import ASF, HTR, MCML, amc, bvh, served, upload
from tests.conftest import StoreOf

pytestmark = pytest.mark.above_store

API = "/api/v1"
PARSER = etree.XMLParser(remove_blank_text=True)

FILES = {
    "b_chain.bvh": bvh(300),
    "a_hand.mcml": MCML,
    "c_leg.asf": ASF,
    "c_leg.amc": amc(4),
    "d_two.htr": HTR,
}


Trees: TypeAlias = list[tuple[str, etree._ElementTree]]


@pytest.fixture
def library(kind: str, store_of: StoreOf) -> tuple[TestClient, Trees]:
    """A small library of every format with labels, and each document as a tree, by name. For tests that only read."""
    return store_of(kind, filled)


def filled(client: TestClient) -> Trees:
    upload(client, FILES)
    for number, label in enumerate(("walk", "left-arm-abduction")):
        for item in client.get(f"{API}/documents").json()["items"]:
            frames = item["frames"]
            body = [{"name": label, "first": 1 + number, "last": max(1 + number, frames - number)}]
            address = f"{API}/documents/{item['id']}/labels"
            assert client.post(address, json=body, headers={"if-match": "*"}).status_code == 201
    trees = []
    for item in client.get(f"{API}/documents").json()["items"]:
        content = client.get(f"{API}/documents/{item['id']}/mcml").content
        trees.append((item["id"], etree.parse(io.BytesIO(content), PARSER)))
    return trees


def all_items(client: TestClient, limit: int, **parameters: object) -> list[dict[str, object]]:
    items, cursor = [], None
    while True:
        page = client.get(
            f"{API}/xpath", params=parameters | {"limit": limit} | ({"cursor": cursor} if cursor else {})
        ).json()
        items += page["items"]
        cursor = page.get("next_cursor")
        if cursor is None:
            return items


EXPRESSIONS = [
    "//frame[motion_name='walk']",
    "/mcml/motion/frame['walk'=./motion_name]",
    "/descendant::frame[child::motion_name='walk']",
    "//frame[motion_name='walk'][motion_name='left-arm-abduction']",
    "//frame[motion_name='walk' and motion_name='left-arm-abduction']",
    "//frame[motion_name='left-arm-abduction']/frame_bone[@name='Root']",
    "//frame[motion_name='left-arm-abduction']/frame_bone[2]",
    "//frame[motion_name='left-arm-abduction']/frame_bone[@name='left_up_leg']/@Rx",
    "//frame[motion_name='walk']/@id",
    "//frame[motion_name='nothing']",
    "//frame[3]",
    "//frame[motion_name='walk'][2]",
    "//frame_bone[@name='left_up_leg'][@Rx > 1]",
    "//frame[@id='2']/preceding-sibling::*",
    "//bone/descendant::bone/name",
    "//frame[position() mod 7 = 1]/motion_name[last()]",
    "//@*[. > 100]",
    "//motion_name/text()",
    "//header/* | //skeleton/*",
    "//frame[not(frame_bone[2])]",
    "//*[name()='frametime']",
]


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_nodes_are_libxml2s(library: tuple[TestClient, Trees], expression: str) -> None:
    client, trees = library
    wanted = []
    for uuid, tree in trees:
        for node in tree.xpath(expression):
            text = etree.tostring(node, method="c14n2") if isinstance(node, etree._Element) else str(node).encode()
            wanted.append((uuid, text))
    found = []
    for item in all_items(client, 7, q=expression):
        text = str(item["value"]).encode()
        if item["kind"] == "element":
            text = etree.tostring(etree.fromstring(text), method="c14n2")
        found.append((item["document"], text))
        # The address is itself an XPath that finds exactly this node.
        (node,) = dict(trees)[str(item["document"])].xpath(str(item["address"]))
        own = etree.tostring(node, method="c14n2") if isinstance(node, etree._Element) else str(node).encode()
        assert own == text
    assert found == wanted


def test_runs_are_maximal_ranges(library: tuple[TestClient, Trees]) -> None:
    client, trees = library
    for expression in (
        "//frame[motion_name='left-arm-abduction']",
        "//frame_bone[@Rx > 2]",
        "//frame[motion_name='walk']/@id",
    ):
        runs = all_items(client, 3, q=expression, **{"as": "runs"})
        wanted = []
        for uuid, tree in trees:
            frames = tree.findall("motion/frame")
            hit = set()
            for node in tree.xpath(expression):
                node = node if isinstance(node, etree._Element) else node.getparent()
                while node.tag != "frame":
                    node = node.getparent()
                hit.add(frames.index(node) + 1)
            for position in sorted(hit):
                if wanted and wanted[-1][0] == uuid and wanted[-1][2] == position - 1:
                    wanted[-1][2] = position
                else:
                    wanted.append([uuid, position, position])
        assert [[run["document"], run["first"], run["last"]] for run in runs] == wanted


def test_scalars(library: tuple[TestClient, Trees]) -> None:
    client, trees = library

    def ask(expression: str, **more: object) -> dict[str, object]:
        return client.get(f"{API}/xpath", params={"q": expression, **more}).json()

    for expression in (
        "count(//frame[motion_name='walk'])",
        "count(//frame_bone)",
        "count(//bone)",
        "sum(//frame_bone/@Tx)",
    ):
        total = sum(tree.xpath(expression) for _, tree in trees)
        assert ask(expression)["value"] == pytest.approx(total, rel=1e-12)
        for uuid, tree in trees:
            assert ask(expression, document=uuid)["value"] == pytest.approx(tree.xpath(expression), rel=1e-12)
    each = {item["document"]: item["value"] for item in ask("string(//filename)")["items"]}
    assert each == {uuid: tree.xpath("string(//filename)") for uuid, tree in trees}
    each = {item["document"]: item["value"] for item in ask("boolean(//frame[motion_name='walk'])")["items"]}
    assert each == {uuid: tree.xpath("boolean(//frame[motion_name='walk'])") for uuid, tree in trees}
    assert ask("1 div 0")["value"] == "Infinity"
    assert ask("concat('a', 'b')") == {"type": "string", "value": "ab", "complete": True, "warnings": []}


def test_nth_counts_over_all_documents(library: tuple[TestClient, Trees]) -> None:
    client, _trees = library
    for inner in ("//frame[motion_name='walk']", "//bone/name", "//frame[motion_name='walk']/frame_bone[@name='Root']"):
        everything = all_items(client, 400, q=inner)
        for number in (1, 2, len(everything)):
            (item,) = all_items(client, 5, q=f"({inner})[{number}]")
            assert item == everything[number - 1]
        assert all_items(client, 5, q=f"({inner})[{len(everything) + 1}]") == []


@pytest.mark.slow
def test_pages_stay_as_they_were_while_others_write(client: TestClient) -> None:
    filled(client)
    expression = {"q": "//frame[motion_name='left-arm-abduction']", "limit": 2}
    before = all_items(client, 1000, q=expression["q"])
    first = client.get(f"{API}/xpath", params=expression).json()
    uuid = first["items"][0]["document"]
    for label in client.get(f"{API}/documents/{uuid}/labels").json()["items"]:
        client.delete(f"{API}/documents/{uuid}/labels/{label['id']}", headers={"if-match": "*"})
    seen, cursor = list(first["items"]), first["next_cursor"]
    while cursor:
        page = client.get(f"{API}/xpath", params=expression | {"cursor": cursor}).json()
        seen += page["items"]
        cursor = page.get("next_cursor")
    assert [item["address"] for item in seen] == [item["address"] for item in before]
    assert len(all_items(client, 1000, q=expression["q"])) < len(before)


def test_spellings_of_one_meaning_have_one_plan(client: TestClient) -> None:
    upload(client, {"a.bvh": bvh(3)})
    plans = {
        str(client.get(f"{API}/xpath", params={"q": expression, "explain": True}).json()["explain"]["plan"])
        for expression in EXPRESSIONS[:3]
    }
    assert len(plans) == 1
    assert "index" in plans.pop()


def test_synonyms_are_answered_with_a_warning(client: TestClient) -> None:
    upload(client, {"a.bvh": bvh(3)}, label="left-arm-abduction")
    answer = client.get(f"{API}/xpath", params={"q": "count(//frame[motion_name='left-arm_abduction'])"}).json()
    assert answer["value"] == 3
    assert "left-arm-abduction" in answer["warnings"][0]


def test_xml_answers_hold_the_nodes(client: TestClient) -> None:
    upload(client, {"a.mcml": MCML})
    answer = client.get(f"{API}/xpath", params={"q": "//frame[2] | //@Ty", "as": "xml"})
    assert answer.headers["content-type"] == "application/xml; charset=utf-8"
    root = etree.fromstring(answer.content)
    assert [result.get("address") for result in root][1] == "/mcml/motion/frame[2]"
    assert root[1][0].tag == "frame"


@pytest.mark.parametrize(
    ("expression", "column"),
    [
        ("//frame[", 9),
        ("//frame[motion_name='x'", 21),
        ("frame(", None),
        ("nonsense(1)", 1),
        ("//a b", None),
        ("1 +", 4),
    ],
)
def test_errors_have_a_column_and_a_hint(client: TestClient, expression: str, column: int | None) -> None:
    answer = client.get(f"{API}/xpath", params={"q": expression})
    assert answer.status_code == 422
    problem = answer.json()
    assert problem["detail"]
    if column is not None:
        assert abs(problem["where"]["column"] - column) <= 1


def test_hostile_expressions_end_within_the_limit(database: Database) -> None:
    settings = Settings(query_seconds=2, query_memory_mib=400)
    with served(database, settings) as client:
        upload(client, {"a.bvh": bvh(2000)})
        for expression in (
            "//*//*//*//*//*[.//*[.//*]]/following::*[preceding::*]",
            "count(//*[count(//*[count(//*) > 1]) > 1])",
            "(" * 300 + "1" + ")" * 300,
            "|".join(["//frame"] * 900),
            "//frame[" * 90 + "1" + "]" * 90,
            "x" * 10_001,
            "string(//frame[9223372036854775808])",
        ):
            answer = client.get(f"{API}/xpath", params={"q": expression})
            assert answer.status_code in (200, 422), (expression[:60], answer.text[:200])
            assert client.get("/healthz").status_code == 200
        assert client.get(f"{API}/xpath", params={"q": "count(//frame)"}).json()["value"] == 2000


def test_too_much_is_refused_with_what_to_narrow(database: Database) -> None:
    with served(database, Settings(query_elements=1000)) as client:
        upload(client, {"a.bvh": bvh(600)}, label="walk")
        refused = client.get(f"{API}/xpath", params={"q": "/mcml"})
        assert refused.status_code == 422
        assert "Export the document" in refused.json()["remedy"]
        (document,) = client.get(f"{API}/documents").json()["items"]
        for text in ("/mcml | /mcml/motion", "//motion | //mcml"):
            edited = client.patch(
                f"{API}/documents/{document['id']}/elements",
                params={"xpath": text},
                json={"attributes": {"version": "1.0"}},
                headers={"if-match": "*"},
            )
            assert "more than one node" in edited.json()["detail"]
        streamed = client.get(f"{API}/xpath", params={"q": "/mcml", "as": "xml"})
        assert streamed.content.count(b"<frame id=") == 600
        assert client.get(f"{API}/xpath", params={"q": "count(//frame[motion_name='walk'])"}).json()["value"] == 600


def test_a_page_of_large_documents_is_short(database: Database) -> None:
    """Whole documents share the room of a page; what has none left is on the next one."""
    with served(database, Settings(query_elements=1000)) as client:
        upload(client, {f"{name}.bvh": bvh(100) for name in "abcde"})
        for text in ("/mcml", "/mcml/motion | //source"):
            pages, cursor = [], None
            while True:
                page = client.get(
                    f"{API}/xpath", params={"q": text, "limit": 4, **({"cursor": cursor} if cursor else {})}
                )
                pages.append(page.json()["items"])
                cursor = page.json().get("next_cursor")
                if cursor is None:
                    break
            whole = [sum("<frames>" in item["value"] for item in page) for page in pages]
            assert sum(whole) == 5
            assert max(whole) == 2
            lines = client.get(f"{API}/xpath", params={"q": text, "as": "ndjson"}).text.splitlines()
            assert [json.loads(line) for line in lines] == [item for page in pages for item in page]


@pytest.mark.parametrize(
    ("text", "warning"),
    [
        ("//frame[motion_name='wlak']", "no motion name here is 'wlak'; did you mean 'walk'?"),
        ("//frame[motion_name[.='wlak']]/@id", "no motion name here is 'wlak'; did you mean 'walk'?"),
        ("//motion_name['no-such' = text()]", "no motion name here is 'no-such'"),
        ("//bone[name='LeftUpLeg']", "no bone here is named 'LeftUpLeg'; did you mean 'left_up_leg'?"),
        ("//frame_bone[@name='LeftUpLeg']/@Rx", "no bone here is named 'LeftUpLeg'; did you mean 'left_up_leg'?"),
        ("count(//frame[not(motion_name != 'wlak')])", "no motion name here is 'wlak'; did you mean 'walk'?"),
        ("//frame[motion_name='walk' or @id='wlak']", None),
        ("//bone[name='left_up_leg']", None),
        ("//property[@name='nothing']", None),
        ("//frame['walk'=motion_name]", None),
    ],
)
def test_names_that_do_not_occur_are_told(library: tuple[TestClient, object], text: str, warning: str | None) -> None:
    client, _ = library
    for _ in range(2):
        answer = client.get(f"{API}/xpath", params={"q": text}).json()
        assert answer["warnings"] == ([] if warning is None else [warning])


def test_names_are_told_for_the_documents_that_are_asked(client: TestClient) -> None:
    hand, chain = (document["id"] for document in upload(client, {"a.mcml": MCML, "b.bvh": bvh(3)})["documents"])
    for asked, wanted in (([hand], 0), ([chain], 1), ([hand, chain], 0), ([], 0)):
        answer = client.get(f"{API}/xpath", params={"q": "//bone[name='left_up_leg']", "document": asked}).json()
        assert len(answer["warnings"]) == wanted
    client.delete(f"{API}/documents/{hand}", headers={"if-match": "*"})
    answer = client.get(f"{API}/xpath", params={"q": "//bone[name='left_up_leg']"}).json()
    assert answer["warnings"] == ["no bone here is named 'left_up_leg'"]


def test_namespace_nodes_have_addresses_that_find_them(library: tuple[TestClient, object]) -> None:
    client, trees = library
    asked = {"document": trees[0][0]}
    for text in ("//namespace::*", "//frame_bone/namespace::*", "//motion_name/namespace::node()[last()]"):
        items = all_items(client, 500, q=text, **asked)
        assert len({item["address"] for item in items}) == len(items) > 0
        for item in items[:3] + items[-3:]:
            (found,) = all_items(client, 5, q=item["address"], **asked)
            assert found == item


@pytest.mark.parametrize(
    ("method", "path", "sent"),
    [
        ("POST", "/labels", {"json": {"name": "a", "xpath": "//frame", "document": ["a"] * 10_001}}),
        ("GET", "/xpath", {"params": {"q": "1" * 10_001}}),
    ],
)
def test_what_a_model_refuses_is_a_problem(client: TestClient, method: str, path: str, sent: dict[str, Any]) -> None:
    answer = client.request(method, API + path, **sent)
    assert answer.status_code == 422
    problem = answer.json()
    assert problem["type"] == "/docs/problems#invalid-request"
    assert problem["errors"]


def test_many_documents_are_asked_at_once(client: TestClient) -> None:
    (made,) = upload(client, {"a.bvh": bvh(3)})["documents"]
    many = [made["id"]] * 5000
    some = {"q": "count(//frame)", "document": many[:1100]}
    assert client.get(f"{API}/xpath", params=some).json()["value"] == 3
    assert client.post(f"{API}/xpath", json=some | {"document": many}).json()["value"] == 3
    body = {"name": "a", "xpath": "//frame", "document": many}
    assert client.post(f"{API}/labels", json=body).status_code == 200


@pytest.mark.parametrize(
    "text",
    ["//frame[1000000000000]", "//frame[position()=99999999999999999999]", "(//frame)[99999999999999999999]",
     "//frame[-1]", "//frame[1e300]", "//frame[1 div 0]"],
)  # fmt: skip
def test_positions_that_no_frame_has(library: tuple[TestClient, object], text: str) -> None:
    client, _ = library
    answer = client.get(f"{API}/xpath", params={"q": text})
    assert answer.json()["items"] == []


def test_what_ends_for_its_time_shows_the_plan_and_the_limit(database: Database) -> None:
    with served(database, Settings(query_seconds=0.5)) as client:
        upload(client, {"a.bvh": bvh(3)})
        text = f"//frame[matches('{'a' * 60}!', '^(a+)+$') and . is .]"
        problem = client.get(f"{API}/xpath", params={"q": text, "explain": "true"}).json()
    assert problem["code"] == "query-timeout"
    assert "0.5 s, the limit" in problem["detail"]
    assert problem["details"]["explain"]["plan"] == ["the documents as trees, one after the other, whole"]
