"""The whole way of a question, from text to pages, against libxml2 on the exported documents."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from random import Random
from typing import Any

import pytest
from lxml import etree

from schemas.queries import NodeItem, QueryRequest, RunItem, ScalarItem
from service.actions.change_document import add_labels
from service.actions.edit_element import Change, change_element, delete_element
from service.actions.export_motion import ExportOptions, export_document
from service.errors import McmlError
from service.settings import Settings
from service.storage.database import Database
from service.xpath.parse import parse
from service.xpath.run import Queries
from service.xpath.tree import type_of
from service.xpath.worker import Addresses, describe
from tests.builders import ASF, HTR, MCML, amc, bvh, store
from tests.xpath.test_xpath_projection import expression

FILES: list[dict[str, bytes]] = [
    {"e_chain.bvh": bvh(12)},
    {"b_hand.mcml": MCML},
    {"c_leg.asf": ASF, "c_leg.amc": amc(4)},
    {"d_two.htr": HTR},
    {"a_empty.bvh": bvh(0)},
]
EDITS: list[tuple[str, Change | None]] = [
    ("/mcml/motion/frame[2]", None),
    ("/mcml/motion/frame[1]/frame_bone[2]", None),
    ("/mcml/motion/frame[2]/frame_bone[1]/@Rx", None),
    ("/mcml/motion/frame[1]/frame_bone[1]", Change({"Tz": "7", "SF": "2"})),
    ("/mcml/motion/frame[1]", Change({"id": "x1"})),
    ("/mcml/skeleton/bone/name", Change({}, "renamed")),
]
NAMES = ["walk", "bar-1", "left-arm-abduction", "left-leg-flexion", "nothing"]
BONES = ["Root", "left_up_leg", "Spine", "lfemur", "renamed", "nothing"]


def planned(random: Random) -> str:
    """Expressions of the kinds that people ask and plans answer."""
    frames = random.choice(["//frame", "/mcml/motion/frame", "/descendant::frame", "//motion/frame", "mcml//frame"])
    for _ in range(random.randint(0, 2)):
        name, other = random.choice(NAMES), random.choice(NAMES)
        frames += random.choice([
            f"[motion_name='{name}']", f"['{name}'=./motion_name]", f"[motion_name='{name}' or motion_name='{other}']",
            f"[motion_name='{name}' and motion_name='{other}']", f"[motion_name[.='{name}']]", "[2]", "[position()=3]",
            f"[motion_name/text()='{name}']", "[motion_name]", "[last()]", f"[not(motion_name='{name}')]",
        ])  # fmt: skip
    if random.random() < 0.2:
        frames = f"({frames})[{random.randint(1, 4)}]"
    bone = random.choice(["", "", "/frame_bone", "//frame_bone", "/*"])
    if bone in ("/frame_bone", "//frame_bone"):
        bone += random.choice(["", "[2]", f"[@name='{random.choice(BONES)}']", f"['{random.choice(BONES)}'=@name]"])
        bone += random.choice(["", "", "/@Rx", "/@name", "/@*", "[@Rx > 1]", "/@Tz"])
    text = frames + (bone or random.choice(["", "/@id", "/motion_name"]))
    return random.choice(["{}", "{}", "{}", "({})[3]", "count({})", "boolean({})", "count(({})[2])"]).format(text)


@pytest.fixture
def library(database: Database) -> Iterator[tuple[Queries, list[tuple[str, Any]]]]:
    """Every format, labelled, each once as it is and once edited; and their trees in order of the answer."""
    random = Random(1)
    for edited in (False, True):
        for files in FILES:
            uuid = store(database, files, labels=())[0]
            with database.write() as tx:
                stored = tx.documents.get(uuid)
                ranges = [sorted((random.randint(1, stored.frames), random.randint(1, stored.frames))) for _ in "abc"
                          if stored.frames]  # fmt: skip
                add_labels(tx, stored, [(random.choice(NAMES[:3]), *ends) for ends in ranges])
            for where, change in EDITS if edited else ():
                try:
                    with database.write() as tx:
                        stored = tx.documents.get(uuid)
                        change_element(tx, stored, where, change) if change else delete_element(tx, stored, where)
                except McmlError:
                    continue
    parser = etree.XMLParser(remove_blank_text=True)
    trees = []
    with database.read() as tx:
        from service.storage.documents import DocumentFilter

        for stored in tx.documents.page(DocumentFilter(), after=None, limit=100):
            content = b"".join(export_document(tx, stored, ExportOptions("mcml")).content)
            trees.append((stored.uuid, etree.parse(io.BytesIO(content), parser)))
    engine = Queries(database, Settings())
    yield engine, trees
    engine.close()


def pages(engine: Queries, text: str, uuids: list[str], limit: int, form: str) -> tuple[str, Any, list[Any]]:
    """(type, value, items of all pages)."""
    items: list[Any] = []
    cursor = None
    while True:
        request = QueryRequest(q=text, document=uuids, limit=limit, cursor=cursor, **{"as": form})
        answer = engine.answer(request)
        assert len(answer.items or []) <= limit or answer.type not in ("nodes", "runs")
        items += answer.items or []
        cursor = answer.next_cursor
        if cursor is None:
            return answer.type, answer.value, items


def expected(text: str, trees: list[tuple[str, Any]]) -> list[tuple[str, Any]]:
    """Of each document its value, or (address, canonical XML or text) of each node."""
    result = []
    for uuid, tree in trees:
        value: Any = tree.xpath(text)
        if isinstance(value, list):
            addresses = Addresses()
            value = [tuple(describe(node, addresses)) for node in value]
        result.append((uuid, value))
    return result


def plain(kind: str, value: str) -> str:
    if kind != "element":
        return value
    return etree.tostring(etree.fromstring(value), method="c14n2").decode()


def compare(engine: Queries, trees: list[tuple[str, Any]], text: str, random: Random) -> str:
    """Way of the query; asserts that the answer is libxml2's."""
    chosen = trees if random.random() < 0.3 else [random.choice(trees)]
    uuids = [] if chosen is trees else [chosen[0][0]]
    query = parse(text)
    if "namespace" in text or text.startswith("("):
        chosen = [random.choice(trees)]
        uuids = [chosen[0][0]]
    try:
        wanted = expected(query.text, chosen)
    except etree.XPathError:
        return "refused"
    if type_of(query.tree) != "nodes":
        kind, value, items = pages(engine, text, uuids, 100, "json")
        found = {item.document: item.value for item in items if isinstance(item, ScalarItem)}
        if value is not None and len(chosen) > 1 and text.startswith(("count(", "sum(")):
            total = sum(one for _, one in wanted)
            assert value == pytest.approx(total, nan_ok=True) or value == "NaN", text
            return kind
        for uuid, one in wanted:
            got = found.get(uuid, value)
            if isinstance(one, float) and not math.isfinite(one):
                one = "NaN" if math.isnan(one) else "Infinity" if one > 0 else "-Infinity"
            assert got == one, (text, uuid)
        return kind
    nodes = [(uuid, *node) for uuid, value in wanted for node in value]
    limit = random.choice([1, 2, 5, 13, 1000]) if len(nodes) < 40 else random.choice([60, 500, 1000])
    _, _, items = pages(engine, text, uuids, limit, "json")
    got = [(i.document, i.kind, i.address, plain(i.kind, i.value)) for i in items if isinstance(i, NodeItem)]
    got = [item for item in got if item[1] != "document"]
    assert got == [(u, k, a, plain(k, v)) for u, k, a, v in nodes], text
    inside = [(uuid, address) for uuid, _, address, _ in nodes]
    if inside and all(address.startswith("/mcml/motion/frame[") for _, address in inside):
        _, _, runs = pages(engine, text, uuids, limit, "runs")
        hit = {(uuid, int(address.split("[")[1].split("]")[0])) for uuid, address in inside}
        covered = [(r.document, n) for r in runs if isinstance(r, RunItem) for n in range(r.first, r.last + 1)]
        assert len(covered) == len(set(covered)), text
        assert set(covered) == hit, text
        assert not any((r.document, r.last + 1) in hit for r in runs if isinstance(r, RunItem)), text
    return "nodes"


def campaign(library: tuple[Queries, list[tuple[str, Any]]], seed: int, count: int) -> None:
    engine, trees = library
    random = Random(seed)
    ways: dict[str, int] = {}
    for number in range(count):
        text = planned(random) if number % 2 else expression(random)
        way = compare(engine, trees, text, random)
        ways[way] = ways.get(way, 0) + 1
    assert ways["nodes"] > count // 3
    assert len(engine.evaluator._idle) <= 2


def test_answers_are_libxml2s(library: tuple[Queries, list[tuple[str, Any]]]) -> None:
    campaign(library, 11, 400)


@pytest.mark.fuzz
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("seed", range(20, 24))
def test_answers_are_libxml2s_many_times(library: tuple[Queries, list[tuple[str, Any]]], seed: int) -> None:
    campaign(library, seed, 3000)
