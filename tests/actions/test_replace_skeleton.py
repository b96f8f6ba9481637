"""A new file with another skeleton for a stored document: refused, or asked for; it is as if the file were imported."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import permutations

import pytest

from mcml.errors import ConflictError
from mcml.files.import_options import ImportOptions
from mcml.language.elements import to_head
from mcml_schemas.querying.queries import QueryRequest
from mcml_schemas.revisions import FileReplaced
from mcml_service.actions.editing.whole_document import add_labels, restore_revision, undo_revision
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.importing.replace_motion import read_motion, replace_motion
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import ASF, amc, bvh, c3d_file, one_kind, source, store
from tests.formats.readers.fbx_text import fbx_text
from tests.motion.bodies.made import person

FILES: dict[str, dict[str, bytes]] = {
    "chain": {"chain.bvh": bvh(7)},
    "longer chain": {"longer.bvh": bvh(12, 1, names=("Root", "Spine", "Chest", "Head"))},
    "person": {"person.bvh": person(3, 9)},
    "fbx": {"bones.fbx": fbx_text()},
    "leg": {"leg.asf": ASF, "leg.amc": amc(5)},
    "markers": {"trial.c3d": c3d_file()},
}
QUESTIONS = (
    "//bone/@name",
    "//frame/@id",
    "count(//frame_bone)",
    "count(//frame_bone[@Rx])",
    "round(1e6 * sum(//frame_bone/@Rx))",
    "//frame[position() = last()]/frame_bone/@name",
    "//frame/mo:height('Head')",
    "//header/calibration_unit",
)


def replace_by(database: Database, uuid: str, files: dict[str, bytes], **asked: bool) -> FileReplaced:
    sources = [source(name, content) for name, content in files.items()]
    new = read_motion(database, uuid, sources, ImportOptions(), Settings().file_limits)
    with database.write("ann") as tx:
        return replace_motion(tx, tx.documents.get(uuid), new, **asked)


def mcml_of(database: Database, uuid: str) -> str:
    """The document without what tells of the uploaded files and of the rate, which answers of queries show."""
    with database.read() as tx:
        text = b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions("mcml")).content).decode()
    return re.sub(
        r"<source .*?(/>|</source>)\s*|<(comment|section) .*?</\2>\s*|<(frametime|dataframe_rate)>[^<]*</\3>",
        "",
        text,
        flags=re.DOTALL,
    )


@contextmanager
def asking(database: Database) -> Iterator[Queries]:
    engine = Queries(database, Settings(cache_dir="none"))
    try:
        yield engine
    finally:
        engine.close()


def answers(engine: Queries, uuid: str) -> list[object]:
    """What the questions find in a document, without its identity."""
    found = [engine.answer(QueryRequest(q=text, document=[uuid], limit=1000)) for text in QUESTIONS]
    dumped = [each.model_dump(exclude={"explain", "warnings"}) for each in found]
    return [re.sub(r"'(document|revision|name)': [^,}]*", "", str(each)) for each in dumped]


@pytest.mark.parametrize(("before", "after"), list(permutations(FILES, 2)))
@one_kind
def test_the_document_is_as_if_the_file_were_imported(database: Database, before: str, after: str) -> None:
    uuid = store(database, FILES[before])[0]
    with database.read() as tx:
        seconds = to_head(tx.heads.document(stored := tx.documents.get(uuid)), stored.frame_time).seconds_per_frame()
    # An AMC states no rate: the document keeps its own.
    rate = {"frame_time": repr(seconds)} if after == "leg" else {}
    fresh = store(database, FILES[after], project="other", **rate)[0]
    first = mcml_of(database, uuid)
    with pytest.raises(ConflictError):
        replace_by(database, uuid, FILES[after])
    looked = replace_by(database, uuid, FILES[after], replace_skeleton=True, dry_run=True)
    assert looked.revision == 1
    assert mcml_of(database, uuid) == first
    with asking(database) as engine:
        # The columns of the first revision are there when the second is made.
        answers(engine, uuid)
        made = replace_by(database, uuid, FILES[after], replace_skeleton=True)
        assert made == looked.model_copy(update={"revision": 2})
        assert made.skeleton is not None
        assert answers(engine, uuid) == answers(engine, fresh)
    assert mcml_of(database, uuid) == mcml_of(database, fresh)
    with database.write("ann") as tx:
        undo_revision(tx, tx.documents.get(uuid), 2)
    assert mcml_of(database, uuid) == first
    with database.write("ann") as tx:
        restore_revision(tx, tx.documents.get(uuid), 2)
    assert mcml_of(database, uuid) == mcml_of(database, fresh)


def test_facts_and_labels_stay(database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(10)}, description="A fall.", properties=(("age", "23", "year"),))[0]
    with database.write("ann") as tx:
        add_labels(tx, tx.documents.get(uuid), [("jump", 3, 5), ("walk", 8, 10)])
    made = replace_by(database, uuid, FILES["longer chain"], replace_skeleton=True)
    assert made.skeleton is not None
    assert (made.skeleton.added, made.skeleton.removed, made.skeleton.changed) == (["Chest"], [], ["Head"])
    text = mcml_of(database, uuid)
    assert "<description>A fall.</description>" in text
    assert '<property name="age" value="23" unit="year"/>' in text
    with database.read() as tx:
        spans = [(span.name, span.first, span.last) for span in tx.spans.of(tx.documents.get(uuid).key)]
    assert spans == [("jump", 3, 5), ("walk", 8, 10)]


@one_kind
def test_another_unit_of_points_without_offsets_is_told(database: Database) -> None:
    trc = (
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t"
        "OrigDataStartFrame\tOrigNumFrames\n100\t100\t2\t1\t{unit}\t100\t1\t2\nFrame#\tTime\tLASI\t\t\n\t\tX1\tY1\tZ1\n\n"
        "1\t0\t1\t2\t3\n2\t0.01\t4\t5\t6\n"
    )
    uuid = store(database, {"a.trc": trc.format(unit="mm").encode()})[0]
    with pytest.raises(ConflictError, match=r"another unit of length \(m\) than the document \(mm\)"):
        replace_by(database, uuid, {"a.trc": trc.format(unit="m").encode()})
    replace_by(database, uuid, {"a.trc": trc.format(unit="m").encode()}, replace_skeleton=True)
    assert "<calibration_unit>m</calibration_unit>" in mcml_of(database, uuid)


@one_kind
def test_the_same_numbers_with_other_decimals_are_one_skeleton(database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(10)})[0]
    written = bvh(10, seed=2).replace(b"0.00 10.5 0.00", b"0.000000 10.500001 -0.000000")
    made = replace_by(database, uuid, {"a.bvh": written})
    assert (made.first, made.last, made.skeleton) == (1, 10, None)


@one_kind
def test_an_amc_alone_uses_the_skeleton_of_the_document(database: Database) -> None:
    uuid = store(database, FILES["leg"])[0]
    assert replace_by(database, uuid, {"new.amc": amc(8)}).frames == 8
