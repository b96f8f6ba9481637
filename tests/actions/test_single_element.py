"""Each element of a stored document can be addressed, read, changed and deleted alone (docs/decisions/0001)."""

from __future__ import annotations

import io

import pytest
from lxml import etree
from sqlalchemy import func, select

from mcml.errors import DocumentError, NotFoundError
from mcml.language.dtd import violations
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.reading.read_element import read_element
from mcml_service.storage.core.tables import track
from mcml_service.storage.database import Database
from tests.builders import ASF, MCML, amc, bvh, one_kind, store
from tests.edits import change_element, delete_element

PARSER = etree.XMLParser(remove_blank_text=True)


def serialised(database: Database, uuid: str) -> etree._Element:
    with database.read() as tx:
        export = export_document(tx, tx.documents.get(uuid), ExportOptions("mcml"))
        content = b"".join(export.content)
    assert violations(io.BytesIO(content)) == []
    return etree.fromstring(content, PARSER)


def canonical(element: etree._Element) -> bytes:
    return etree.tostring(element, method="c14n2", strip_text=True)


@pytest.fixture(params=["mcml", "bvh", "asf-amc"])
def uuid(request: pytest.FixtureRequest, database: Database) -> str:
    files = {
        "mcml": {"hand.mcml": MCML},
        "bvh": {"chain.bvh": bvh(600)},
        "asf-amc": {"leg.asf": ASF, "leg.amc": amc(3)},
    }[request.param]
    return store(database, files)[0]


def addresses(tree: etree._Element) -> list[str]:
    """Canonical addresses of every element, of a few frames only in long documents."""
    found = []
    frames = tree.findall("motion/frame")
    kept = {id(frame) for frame in (frames[:2] + frames[-1:] if len(frames) > 4 else frames)}
    for element in tree.iter():
        frame = next((node for node in (element, *element.iterancestors()) if node.tag == "frame"), None)
        if frame is not None and id(frame) not in kept:
            continue
        found.append(address(element))
    return found


def address(element: etree._Element) -> str:
    steps = []
    node = element
    while node is not None:
        parent = node.getparent()
        step = node.tag
        if parent is not None:
            same = parent.findall(node.tag)
            if len(same) > 1 or node.tag in ("frame", "frame_bone"):
                step += f"[{same.index(node) + 1}]"
        steps.append(step)
        node = parent
    return "/" + "/".join(reversed(steps))


@one_kind
def test_every_element_is_read_alone(database: Database, uuid: str) -> None:
    tree = serialised(database, uuid)
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        for where in addresses(tree):
            wanted = tree.xpath(where)[0]
            if wanted.tag in ("mcml", "motion"):
                continue
            got = etree.fromstring(read_element(tx, stored, where), PARSER)
            assert canonical(got) == canonical(wanted), where
            for name, value in wanted.attrib.items():
                assert read_element(tx, stored, f"{where}/@{name}").decode() == value


@pytest.mark.slow
@one_kind
def test_every_element_is_deleted_alone_or_refused(database: Database, uuid: str) -> None:
    tree = serialised(database, uuid)
    deleted = refused = 0
    for where in addresses(tree):
        before = serialised(database, uuid)
        target = before.xpath(where)[0]
        if target.tag in ("mcml", "motion"):
            continue
        try:
            with database.write() as tx:
                delete_element(tx, tx.documents.get(uuid), where)
        except DocumentError:
            refused += 1
            assert canonical(serialised(database, uuid)) == canonical(before)
            continue
        deleted += 1
        parent = target.getparent()
        parent.remove(target)
        if target.tag == "frame":
            count = before.find("motion/frames")
            count.text = str(int(count.text) - 1)
        assert canonical(serialised(database, uuid)) == canonical(before), where
        with database.write() as tx:
            stored = tx.documents.get(uuid)
            from mcml_service.actions.editing.whole_document import restore_revision

            restore_revision(tx, stored, stored.revision - 1)
        assert canonical(serialised(database, uuid)) == canonical(tree), f"restored after {where}"
    assert deleted > 5
    # What the definition or a frame needs cannot go alone: header, skeleton, frames, names, the bones frames name.
    assert refused > 4


def test_attributes_are_changed_alone(database: Database, uuid: str) -> None:
    tree = serialised(database, uuid)
    where = next(address(bone) for bone in tree.iter("frame_bone") if bone.get("Rx") is not None)
    for value in ("-12.125", "-0.0", "1e-300", "5"):
        with database.write() as tx:
            change_element(tx, tx.documents.get(uuid), where, Change({"Rx": value}))
        tree.xpath(where)[0].set("Rx", {"5": "5.0"}.get(value, value))
        assert canonical(serialised(database, uuid)) == canonical(tree)
    with database.write() as tx:
        change_element(tx, tx.documents.get(uuid), where, Change({"Rx": None, "Tz": "7.5"}))
    changed = tree.xpath(where)[0]
    del changed.attrib["Rx"]
    changed.set("Tz", "7.5")
    assert canonical(serialised(database, uuid)) == canonical(tree)


def test_names_ids_and_texts_are_changed_alone(database: Database) -> None:
    uuid = store(database, {"hand.mcml": MCML})[0]
    changes = {
        "/mcml/motion/frame[2]/motion_name[2]": Change({}, "hop"),
        "/mcml/motion/frame[3]": Change({"id": "b7"}),
        "/mcml/motion/frametime": Change({}, "0.025"),
        "/mcml/header/filename": Change({}, "other.mcml"),
        "/mcml/skeleton/bone": Change({"id": "9"}),
        "/mcml/root": Change({"position": "1 2 3"}),
    }
    tree = serialised(database, uuid)
    for where, change in changes.items():
        with database.write() as tx:
            change_element(tx, tx.documents.get(uuid), where, change)
        element = tree.xpath(where)[0]
        for name, value in change.attributes.items():
            element.set(name, value or "")
        if change.text is not None:
            element.text = change.text
        assert canonical(serialised(database, uuid)) == canonical(tree), where


def test_renaming_a_bone_renames_its_frames(database: Database) -> None:
    uuid = store(database, {"hand.mcml": MCML})[0]
    with database.write() as tx:
        change_element(tx, tx.documents.get(uuid), "/mcml/skeleton/bone/name", Change({}, "thigh"))
    tree = serialised(database, uuid)
    assert {bone.get("name") for bone in tree.iter("frame_bone")} == {"Root", "thigh"}


@pytest.mark.parametrize(
    ("where", "change"),
    [
        ("/mcml/motion/frame[1]/frame_bone[1]", Change({"Rx": "nan"})),
        ("/mcml/motion/frame[1]/frame_bone[1]", Change({"Rx": "1_0"})),
        ("/mcml/motion/frame[1]/frame_bone[1]", Change({"name": "x"})),
        ("/mcml/motion/frame[1]/frame_bone[1]", Change({}, "text")),
        ("/mcml/motion/frames", Change({}, "9")),
        ("/mcml/motion/frametime", Change({}, "soon")),
        ("/mcml/skeleton/bone/name", Change({}, "Root")),
        ("/mcml/header", Change({"nonsense": "1"})),
    ],
)
@one_kind
def test_nonsense_is_refused(database: Database, where: str, change: Change) -> None:
    uuid = store(database, {"hand.mcml": MCML})[0]
    before = canonical(serialised(database, uuid))
    with pytest.raises(DocumentError) as caught, database.write() as tx:
        change_element(tx, tx.documents.get(uuid), where, change)
    assert caught.value.what
    assert canonical(serialised(database, uuid)) == before


@one_kind
def test_nothing_is_not_found(database: Database) -> None:
    uuid = store(database, {"hand.mcml": MCML})[0]
    for where in (
        "/mcml/motion/frame[9]",
        "/mcml/motion/frame[1]/frame_bone[3]",
        "/mcml/header/nope",
        "/mcml/header/@x",
    ):
        with pytest.raises(NotFoundError), database.read() as tx:
            read_element(tx, tx.documents.get(uuid), where)


def test_one_value_rewrites_one_track(database: Database) -> None:
    uuid = store(database, {"long.bvh": bvh(2000)})[0]
    with database.write() as tx:
        stored = change_element(
            tx, tx.documents.get(uuid), "/mcml/motion/frame[700]/frame_bone[2]", Change({"Rx": "1.25"})
        )
        commit = tx.commit
    with database.read() as tx:
        rows = tx.connection.execute(
            select(func.count(), func.sum(func.length(track.c.data))).where(track.c.from_commit == commit)
        ).one()
        assert tx.connection.execute(select(func.count()).where(track.c.to_commit == commit)).scalar() == 1
    assert rows[0] == 1
    assert rows[1] < 10_000
    assert stored.revision == 2
