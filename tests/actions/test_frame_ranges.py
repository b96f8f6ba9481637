"""Random changes of ranges of frames equal the same changes of the XML; every revision comes back byte for byte."""

from __future__ import annotations

import copy
import io
from itertools import pairwise
from random import Random

import numpy as np
import pytest
from lxml import etree

from mcml.errors import DocumentError, NotFoundError
from mcml.language.dtd import violations
from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.actions.editing.element_edits import Deletion, ElementEdit, edit_elements
from mcml_service.actions.editing.frame_ranges import (
    delete_frames,
    insert_frames,
    move_frames,
    reverse,
    trim,
    write_values,
)
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.editing.whole_document import add_labels, restore_revision
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.actions.test_single_element import PARSER, canonical
from tests.builders import bvh, one_kind, store
from tests.edits import OTHER_SEEDS, change_element, delete_element

EXPRESSIONS = (
    "//frame[motion_name='hop']",
    "//frame_bone[@name='Spine'][@Rx > 3]",
    "//frame[position() mod 7 = 3]/frame_bone[2]/@Rz",
    "//frame[frame_bone[@name='Head']/@Ry < -4]/@id",
    "//frame[@id='12']/following-sibling::frame[2]",
    "//frame[not(motion_name)][last()]",
)


def content(database: Database, uuid: str) -> bytes:
    with database.read() as tx:
        return b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions("mcml")).content)


def motion(tree: etree._Element) -> etree._Element:
    return tree.find("motion")


def finished(tree: etree._Element, before: list[str]) -> etree._Element:
    """Counts made right, and ids that counted up made to count up again."""
    frames = motion(tree).findall("frame")
    motion(tree).find("frames").text = str(len(frames))
    numbers = [int(text) for text in before if text.lstrip("-").isdigit()]
    if len(numbers) == len(before) and all(b - a == 1 for a, b in pairwise(numbers)):
        for place, frame in enumerate(frames):
            frame.set("id", str(numbers[0] + place))
    for tag in ("num_frames",):
        for element in tree.iter(tag):
            element.text = str(len(frames))
    return tree


def changed_at_random(database: Database, seed: int, steps: int) -> None:
    chance = Random(seed)
    uuid, other = (store(database, {f"{n}.bvh": bvh(chance.choice([5, 300, 700]), seed=seed + n)})[0] for n in (0, 1))
    with database.write() as tx:
        stored = tx.documents.get(uuid)
        spans = sorted(chance.sample(range(1, stored.frames + 1), 4))
        add_labels(tx, stored, [("hop", spans[0], spans[2]), ("run", spans[1], spans[3])])
    versions = [content(database, uuid)]
    for _ in range(steps):
        tree = etree.fromstring(versions[-1], PARSER)
        frames = motion(tree).findall("frame")
        before = [frame.get("id") for frame in frames]
        count = len(frames)
        first = chance.randint(1, count)
        last = min(count, first + chance.choice([0, 1, 5, 40, 300]))
        what = chance.choice(["delete", "trim", "insert", "copy", "move", "reverse", "values", "attribute", "frame"])
        with database.write() as tx:
            stored = tx.documents.get(uuid)
            if what == "delete":
                if last - first + 1 == count:
                    continue
                delete_frames(tx, stored, first, last)
                for frame in frames[first - 1 : last]:
                    motion(tree).remove(frame)
            elif what == "trim":
                if last - first < count // 2:
                    continue
                trim(tx, stored, first, last)
                for frame in frames[: first - 1] + frames[last:]:
                    motion(tree).remove(frame)
            elif what in ("insert", "copy"):
                source = stored if what == "copy" else tx.documents.get(other)
                pool = (
                    frames
                    if what == "copy"
                    else motion(etree.fromstring(content(database, other), PARSER)).findall("frame")
                )
                a = chance.randint(1, len(pool))
                b = min(len(pool), a + chance.choice([0, 3, 260]))
                at = chance.randint(1, count + 1)
                insert_frames(tx, stored, at, source, a, b)
                start = motion(tree).index(frames[0]) + at - 1
                for place, frame in enumerate(pool[a - 1 : b]):
                    motion(tree).insert(start + place, copy.deepcopy(frame))
            elif what == "move":
                to = chance.randint(1, count + 1)
                move_frames(tx, stored, first, last, to, renumber=True)
                if not first <= to <= last + 1:
                    anchor = frames[to - 1] if to <= count else None
                    for frame in frames[first - 1 : last]:
                        motion(tree).remove(frame)
                    for frame in frames[first - 1 : last]:
                        anchor.addprevious(frame) if anchor is not None else motion(tree).append(frame)
            elif what == "reverse":
                reverse(tx, stored, first, last)
                # Names and bones go, ids stay.
                insides = [[copy.deepcopy(child) for child in frame] for frame in frames[first - 1 : last]]
                for frame, new in zip(frames[first - 1 : last], reversed(insides), strict=True):
                    for old in list(frame):
                        frame.remove(old)
                    frame.extend(new)
            elif what == "values":
                new = np.round(np.random.default_rng(seed).normal(0, 9, (last - first + 1, 2)), 3)
                try:
                    write_values(tx, stored, first, [("Spine", "Rx"), ("Root", "Ty")], new)
                except DocumentError:
                    continue
                for frame, row in zip(frames[first - 1 : last], new.tolist(), strict=True):
                    frame.find("frame_bone[@name='Spine']").set("Rx", repr(row[0]))
                    frame.find("frame_bone[@name='Root']").set("Ty", repr(row[1]))
            elif what == "attribute":
                change_element(tx, stored, f"/mcml/motion/frame[{first}]/frame_bone[2]", Change({"Rx": "1.5"}))
                frames[first - 1].findall("frame_bone")[1].set("Rx", "1.5")
            elif count > 1:
                delete_element(tx, stored, f"/mcml/motion/frame[{first}]")
                motion(tree).remove(frames[first - 1])
                before = ["gap"]
            if what not in ("attribute", "frame"):
                tx.documents.add_revision(stored, "frames", what)
        with database.read() as tx:
            made = tx.documents.get(uuid).revision != stored.revision
        if made:
            versions.append(content(database, uuid))
        else:
            assert content(database, uuid) == versions[-1], "what changes nothing makes no revision"
        if what in ("values", "attribute", "reverse"):
            before = ["same"]
        assert canonical(etree.fromstring(versions[-1], PARSER)) == canonical(finished(tree, before)), (
            what,
            first,
            last,
        )
    assert len(versions) > steps // 3
    assert violations(io.BytesIO(versions[-1])) == []
    _answers_equal(database, uuid, versions[-1])
    with database.read() as tx:
        numbers = [revision.number for revision in tx.revisions.of(tx.documents.get(uuid).key, limit=1000)]
    for version, number in zip(versions[::-1], sorted(numbers, reverse=True), strict=False):
        with database.read() as tx:
            then = tx.at_commit(tx.documents.commit_of(tx.documents.get(uuid).key, number))
            text = b"".join(export_document(then, then.documents.get(uuid), ExportOptions("mcml")).content)
        assert text == version, number
    with database.write() as tx:
        restore_revision(tx, tx.documents.get(uuid), 2)
    assert content(database, uuid) == versions[0]
    assert database.check() == []


def _answers_equal(database: Database, uuid: str, text: bytes) -> None:
    tree = etree.fromstring(text, PARSER)
    queries = Queries(database, Settings())
    try:
        for expression in EXPRESSIONS:
            items: list[str] = []
            cursor = None
            while True:
                answer = queries.answer(QueryRequest(q=expression, document=[uuid], limit=1000, cursor=cursor))
                items += [item.address for item in answer.items or [] if isinstance(item, NodeItem)]
                cursor = answer.next_cursor
                if cursor is None:
                    break
            nodes = tree.xpath(expression)
            assert len(items) == len(nodes), expression
            for address, node in zip(items, nodes, strict=True):
                (found,) = tree.xpath(address)
                same = found is node or (isinstance(found, str) and found == node)
                assert same, (expression, address)
    finally:
        queries.close()


@pytest.mark.parametrize(("kind", "seed"), OTHER_SEEDS[:4], indirect=["kind"])
def test_random_changes(database: Database, seed: int) -> None:
    changed_at_random(database, seed, 14)


@pytest.mark.fuzz(seeds=60)
def test_random_changes_many_times(database: Database, seed: int) -> None:
    changed_at_random(database, seed, 60)


@one_kind
def test_what_cannot_be_is_refused(database: Database) -> None:
    uuid, other = (
        store(database, {"a.bvh": bvh(5)})[0],
        store(database, {"b.bvh": bvh(5, names=("Hips", "LeftUpLeg"))})[0],
    )
    before = content(database, uuid)
    with database.write() as tx:
        stored, source = tx.documents.get(uuid), tx.documents.get(other)
        for first, last in ((0, 2), (4, 6), (3, 2)):
            with pytest.raises(NotFoundError):
                delete_frames(tx, stored, first, last)
        with pytest.raises(DocumentError, match="is not in this document"):
            insert_frames(tx, stored, 1, source, 1, 2)
        with pytest.raises(DocumentError, match="before frame 9"):
            insert_frames(tx, stored, 9, stored, 1, 2)
        for columns, value in (([("tail", "Rx")], 1.0), ([("Spine", "Rq")], 1.0), ([("Spine", "Rx")], np.nan)):
            with pytest.raises(DocumentError):
                write_values(tx, stored, 1, columns, np.array([[value]]))
        with pytest.raises(DocumentError, match="no such sample"):
            write_values(tx, stored, 1, [("Spine", "Tx")], np.array([[1.0]]))
    assert content(database, uuid) == before


def test_one_value_writes_one_track(database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(2000)})[0]
    with database.write() as tx:
        stored = tx.documents.get(uuid)
        assert write_values(tx, stored, 700, [("Spine", "Rx")], np.array([[1.5]])) == 1
        assert write_values(tx, stored, 700, [("Spine", "Rx")], np.array([[1.5]])) == 0


def test_ids_with_a_gap_stay_whatever_is_left_in_between(database: Database) -> None:
    """A move and a trim are two steps: ids that count up only between them did not before."""

    def ids(uuid: str) -> list[int]:
        with database.read() as tx:
            return [int(number) for number in tx.tracks.frame_ids(tx.documents.get(uuid).key, 1, 5)]

    def gapped(gap: int) -> str:
        uuid = store(database, {"a.bvh": bvh(6)})[0]
        with database.write() as tx:
            delete_element(tx, tx.documents.get(uuid), f"/mcml/motion/frame[{gap}]")
        return uuid

    moved, kept, deleted = gapped(3), gapped(5), gapped(3)
    with database.write() as tx:
        move_frames(tx, tx.documents.get(moved), 1, 2, 6, renumber=True)
        trim(tx, tx.documents.get(kept), 2, 4)
        edits = [ElementEdit(f"/mcml/motion/frame[{place}]", Deletion(renumber=True)) for place in (1, 2, 4)]
        edit_elements(tx, tx.documents.get(deleted), edits)
    assert ids(moved) == [4, 5, 6, 1, 2]
    assert ids(kept) == [2, 3, 4]
    assert ids(deleted) == [4, 6]


def test_names_go_with_frames_that_are_turned_round(database: Database) -> None:
    uuid = store(database, {"walk.bvh": bvh(20)})[0]
    with database.write() as tx:
        stored = tx.documents.get(uuid)
        add_labels(tx, stored, [("walk", 1, 10), ("run", 4, 6), ("wave", 6, 20)])
    with database.read() as tx:
        document = tx.documents.get(uuid)
        before = {span.name: (span.first, span.last) for span in tx.spans.of(document.key)}
        values = np.concatenate([block.values for block in tx.tracks.blocks(document.key, 1, 20)])
    with database.write() as tx:
        reverse(tx, tx.documents.get(uuid), 3, 12)
    with database.read() as tx:
        document = tx.documents.get(uuid)
        spans = [(span.name, span.first, span.last) for span in tx.spans.of(document.key)]
        after = np.concatenate([block.values for block in tx.tracks.blocks(document.key, 1, 20)])
    # One label where it was one, two where the end of the turned frames cuts it.
    assert sorted(spans) == [("run", 9, 11), ("walk", 1, 2), ("walk", 5, 12), ("wave", 3, 9), ("wave", 13, 20)]
    for name, (first, last) in before.items():
        named = {row.tobytes() for row in values[first - 1 : last]}
        now = {row.tobytes() for _, a, b in (s for s in spans if s[0] == name) for row in after[a - 1 : b]}
        assert now == named, name
    with database.write() as tx:
        reverse(tx, tx.documents.get(uuid), 3, 12)
    with database.read() as tx:
        assert {s.name: (s.first, s.last) for s in tx.spans.of(tx.documents.get(uuid).key)} == before


@pytest.mark.parametrize("renumber", [True, False])
@pytest.mark.parametrize("frames", [1, 2, 5, 300])
@one_kind
def test_a_frame_goes_as_an_element_as_it_goes_as_a_range(database: Database, frames: int, renumber: bool) -> None:
    """Labels on both sides touch afterwards, or end with the frame; a document may be left without frames."""
    chance = Random(frames)
    labels = [("hop", 1, max(1, frames // 2)), ("hop", frames // 2 + 1, frames), ("run", frames, frames)]
    for place in sorted({1, frames, chance.randint(1, frames)}):
        files = {f"{n}.bvh": bvh(frames, seed=7) for n in (0, 1)}
        kept = []
        for number, uuid in enumerate(store(database, files)):
            with database.write() as tx:
                add_labels(tx, tx.documents.get(uuid), labels)
            try:
                with database.write() as tx:
                    stored = tx.documents.get(uuid)
                    if number:
                        edits = [ElementEdit(f"/mcml/motion/frame[{place}]", Deletion(renumber=renumber))]
                        edit_elements(tx, stored, edits)
                    else:
                        delete_frames(tx, stored, place, place, renumber=renumber)
                        tx.documents.add_revision(stored, "frames")
            except DocumentError as error:
                kept.append(str(error))
            with database.read() as tx:
                spans = [(span.name, span.first, span.last) for span in tx.spans.of(tx.documents.get(uuid).key)]
            kept.append((spans, motion(etree.fromstring(content(database, uuid), PARSER)).findall("frame")))
        half = len(kept) // 2
        for one, other in zip(kept[:half], kept[half:], strict=True):
            if isinstance(one, str):
                assert one == other
                continue
            assert one[0] == other[0]
            assert list(map(canonical, one[1])) == list(map(canonical, other[1]))
