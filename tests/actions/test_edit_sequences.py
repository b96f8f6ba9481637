"""Random edits of a stored document equal the same edits of its XML; every revision comes back byte for byte."""

from __future__ import annotations

import io
from random import Random

import pytest
from lxml import etree

from mcml.errors import McmlError
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.editing.whole_document import restore_revision
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.storage.database import Database
from tests.actions.test_single_element import PARSER, addresses, canonical
from tests.builders import MCML, bvh, store
from tests.edits import OTHER_SEEDS, change_element, delete_element

COUNTS = b"</filename><num_segments>4</num_segments><num_frames>3</num_frames>"
FREE = b'<skeleton><bone id="7"><name>free</name></bone><bone id="8"><name>loose</name></bone>'
HAND = MCML.replace(b"</filename>", COUNTS).replace(b"<skeleton>", FREE)


def content(database: Database, uuid: str, format: str = "mcml") -> bytes:
    with database.read() as tx:
        return b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions(format)).content)


def random_change(chance: Random, element: etree._Element) -> Change | None:
    if chance.random() < 0.3:
        return None
    if element.tag == "frame_bone":
        names = chance.sample(["Tx", "Rx", "Ry", "SF", "residual"], chance.randint(1, 2))
        return Change({name: chance.choice([None, "1.5", "-0.0", "2e-300"]) for name in names})
    if element.tag == "frame":
        return Change({"id": chance.choice(["17", "a b", "x<", "-3", "007"])})
    if element.tag == "motion_name":
        return Change({}, chance.choice(["hop", "run & <jump>", "걸음"]))
    if element.tag == "name":
        return Change({}, chance.choice(["thigh", "tail", "free", "hüfte"]))
    if element.tag in ("root", "bone"):
        return Change({chance.choice(["id", "source_name"]): chance.choice(["1", "a", None])})
    return Change({}, chance.choice(["0.5", "4", "text"]))


def apply(tree: etree._Element, where: str, change: Change | None) -> None:
    """The same edit, the obvious way."""
    element = tree.xpath(where)[0]
    if change is None:
        element.getparent().remove(element)
    else:
        for name, value in change.attributes.items():
            element.attrib.pop(name, None)
            if value is not None:
                element.set(name, {"1.5": "1.5"}.get(value, value))
        if element.tag == "name" and element.getparent().tag == "bone":
            for bone in tree.iter("frame_bone"):
                if bone.get("name") == element.text:
                    bone.set("name", change.text or "")
        if change.text is not None:
            element.text = change.text
    frames = str(len(tree.findall("motion/frame")))
    bones = str(len(list(tree.iter("root", "bone"))))
    for path, count in (("motion/frames", frames), ("header/num_frames", frames), ("header/num_segments", bones)):
        if tree.find(path) is not None:
            tree.find(path).text = count


def edited_at_random(database: Database, seed: int, steps: int) -> None:
    chance = Random(seed)
    file = {"hand.mcml": HAND} if seed % 2 else {"chain.bvh": bvh(600, seed=seed)}
    uuid = store(database, file, labels=())[0]
    versions = [content(database, uuid)]
    refused = 0
    for _ in range(steps):
        tree = etree.fromstring(versions[-1], PARSER)
        where = chance.choice([place for place in addresses(tree) if place not in ("/mcml", "/mcml/motion")])
        change = random_change(chance, tree.xpath(where)[0])
        try:
            with database.write() as tx:
                change_element(tx, tx.documents.get(uuid), where, change) if change else delete_element(
                    tx, tx.documents.get(uuid), where
                )
        except McmlError:
            refused += 1
            assert content(database, uuid) == versions[-1], where
            continue
        versions.append(content(database, uuid))
        apply(tree, where, change)
        assert canonical(etree.fromstring(versions[-1], PARSER)) == canonical(tree), (where, change)
        header = content(database, uuid, "csv").splitlines()
        assert len(header) == 1 + len(tree.findall("motion/frame"))
        if chance.random() < 0.2:
            number = chance.randint(1, len(versions))
            with database.write() as tx:
                restore_revision(tx, tx.documents.get(uuid), number)
            versions.append(content(database, uuid))
            assert versions[-1] == versions[number - 1]
    assert len(versions) > steps // 4
    for number, version in enumerate(versions, 1):
        with database.read() as tx:
            then = tx.at_commit(tx.documents.commit_of(tx.documents.get(uuid).key, number))
            stored = then.documents.get(uuid)
            assert b"".join(export_document(then, stored, ExportOptions("mcml")).content) == version
    store(database, {"again.mcml": versions[-1]})
    assert database.check() == []


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), OTHER_SEEDS[:4], indirect=["kind"])
def test_random_edits(database: Database, seed: int) -> None:
    edited_at_random(database, seed, 25)


@pytest.mark.fuzz(seeds=40)
def test_random_edits_many_times(database: Database, seed: int) -> None:
    edited_at_random(database, seed, 120)


@pytest.mark.parametrize(
    ("where", "change"),
    [
        ("/mcml/header/num_frames", Change({}, "9")),
        ("/mcml/header/num_segments", Change({}, "9")),
        ("/mcml/motion/frame[1]", Change({"id": "a\x01"})),
        ("/mcml/motion/frametime", Change({}, "1_0")),
        ("/mcml/motion/frame[1]/frame_bone[1]", Change({"Rx": "１"})),
        ("/mcml/skeleton/bone[1]/name", Change({}, "a\\u{1}b")),
        ("/mcml/skeleton/bone[1]/name", Change({}, "z" * 3000)),
    ],
)
def test_edits_that_would_make_it_unreadable_are_refused(database: Database, where: str, change: Change) -> None:
    uuid = store(database, {"hand.mcml": HAND})[0]
    with pytest.raises(McmlError), database.write() as tx:
        change_element(tx, tx.documents.get(uuid), where, change)


def test_csv_quotes_and_has_every_column(database: Database) -> None:
    names = ("Hips", 'S"p,', "Head")
    uuid = store(database, {"a.bvh": bvh(2500, names=names)})[0]
    with database.write() as tx:
        where = "/mcml/motion/frame[2400]/frame_bone[2]"
        change_element(tx, tx.documents.get(uuid), where, Change({"Tz": "5"}))
    import csv

    rows = list(csv.DictReader(io.StringIO(content(database, uuid, "csv").decode())))
    assert {row['S"p,.Tz'] for row in rows} == {"", "5.0"}
    assert rows[2399]['S"p,.Tz'] == "5.0"
    empty = store(database, {"b.bvh": bvh(0)})[0]
    assert content(database, empty, "csv").startswith(b"frame,id,time,Root.Tx")
