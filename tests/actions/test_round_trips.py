"""X -> store -> X with the kept uploads deleted, and unedited documents byte for byte."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from mcml.errors import ConversionError, NotFoundError
from mcml.files.convert_files import convert_files
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.language.dtd import violations
from mcml.motion.clip import ClipStream, FrameBlock
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.actions.reading.read_element import read_element
from mcml_service.clips.read_clip import read_clip
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests import fuzz
from tests.builders import ASF, HTR, MCML, TRC, amc, bvh, c3d_file, store
from tests.conftest import shared_folder
from tests.edits import change_element, delete_element

SMALL = {
    "bvh": {"chain.bvh": bvh(700)},
    "asf-amc": {"leg.asf": ASF, "leg.amc": amc(5)},
    "htr": {"two.htr": HTR},
    "trc": {"hand.trc": TRC},
    "c3d": {"hand.c3d": c3d_file()},
}


def blocks(clip: ClipStream) -> tuple[np.ndarray, list[object], list[str]]:
    """(values, shape of every frame, ids) of a whole clip, columns in a fixed order."""
    found: list[FrameBlock] = list(clip.blocks())
    columns = sorted({column for block in found for column in block.columns})
    values, shapes, ids = [], [], []
    for block in found:
        place = {column: index for index, column in enumerate(block.columns)}
        whole = np.full((len(block), len(columns)), np.nan)
        for index, column in enumerate(columns):
            if column in place:
                whole[:, index] = block.values[:, place[column]]
        values.append(whole)
        numbers = [0] * len(block) if block.shape_of is None else block.shape_of.tolist()
        shapes += [block.shapes[number] for number in numbers]
        ids += [str(item) for item in block.ids]
    return (np.concatenate(values) if values else np.empty((0, 0))), shapes, ids


def assert_same_clip(one: ClipStream, other: ClipStream) -> None:
    """Every number bit-equal, hierarchy, channel order, limits, header and names equal."""
    strip = {"filename"}
    assert {k: v for k, v in one.head.fields.items() if k not in strip} == {
        k: v for k, v in other.head.fields.items() if k not in strip
    }
    assert one.head.frame_time == other.head.frame_time
    for a, b in zip(one.head.skeleton.joints, other.head.skeleton.joints, strict=True):
        for field in ("source_name", "parent", "channels", "rotation_order", "offset", "direction", "length", "axis",
                      "axis_order", "limits", "bodymass", "cofmass", "id", "end_sites", "convention"):  # fmt: skip
            assert getattr(a, field) == getattr(b, field), (a.name, field)
    assert one.head.skeleton.in_declared_order() == other.head.skeleton.in_declared_order()
    (values, shapes, ids), (values2, shapes2, ids2) = blocks(one), blocks(other)
    assert values.view(np.int64).tobytes() == values2.view(np.int64).tobytes()
    assert shapes == shapes2
    assert ids == ids2


def read(format_name: str, files: dict[str, bytes]) -> ClipStream:
    by_part = {}
    for name, content in files.items():
        part = FORMATS[format_name].sniff(name, content[:4096])
        assert part is not None
        by_part[part] = SourceFile(name, io.BytesIO(content))
    return FORMATS[format_name].read(by_part, ReadOptions())


def round_trip(database: Database, format_name: str, files: dict[str, bytes]) -> None:
    (uuid,) = store(database, files)
    parts = [part.name for part in FORMATS[format_name].parts]
    named = {FORMATS[format_name].sniff(name, content[:4096]): content for name, content in files.items()}
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        for part in parts:
            assert b"".join(export_document(tx, stored, ExportOptions(part)).content) == named[part]
    with database.write() as tx:
        tx.uploads.forget(stored.key)
    written = {}
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        for part in parts:
            export = export_document(tx, stored, ExportOptions(part))
            written[export.file_name] = b"".join(export.content)
        mcml = b"".join(export_document(tx, stored, ExportOptions("mcml")).content)
    assert violations(io.BytesIO(mcml)) == []
    original = read(format_name, files)
    assert_same_clip(read(format_name, written), original)
    # And through MCML text: export it, upload it, export the source format from that.
    (again,) = store(database, {"again.mcml": mcml})
    with database.read() as tx:
        stored = tx.documents.get(again)
        second = {}
        for part in parts:
            export = export_document(tx, stored, ExportOptions(part))
            second[export.file_name] = b"".join(export.content)
        assert b"".join(export_document(tx, stored, ExportOptions("mcml")).content) == mcml
    assert_same_clip(read(format_name, second), original)


@pytest.mark.parametrize("format_name", list(SMALL))
def test_small_files(database: Database, format_name: str) -> None:
    round_trip(database, format_name, SMALL[format_name])


def test_a_skeleton_alone_leaves_as_it_came(database: Database) -> None:
    (uuid,) = store(database, {"leg.asf": ASF})
    for original in (True, False):
        with database.read() as tx:
            stored = tx.documents.get(uuid)
            export = export_document(tx, stored, ExportOptions("asf-amc", original=original))
            assert export.file_name.endswith(".asf")
            content = b"".join(export.content)
            if original:
                assert content == ASF
            assert_same_clip(read("asf-amc", {"leg.asf": content}), read("asf-amc", {"leg.asf": ASF}))
            with pytest.raises(ConversionError, match="without frames"):
                b"".join(export_document(tx, stored, ExportOptions("amc")).content)
    with convert_files([SourceFile("leg.asf", io.BytesIO(ASF))], "asf-amc", FileLimits()) as converted:
        assert list(converted.files) == [".asf"]


def test_a_document_may_lack_its_version(database: Database) -> None:
    bare = MCML.replace(b' version="1.0">', b">", 1)
    assert b"<mcml>" in bare
    (uuid,) = store(database, {"hand.mcml": bare})
    with database.read() as tx:
        mcml = b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions("mcml")).content)
        assert b"<mcml>" in mcml
        assert violations(io.BytesIO(mcml)) == []
        with pytest.raises(NotFoundError):
            read_element(tx, tx.documents.get(uuid), "/mcml/@version")
    with database.write() as tx:
        change_element(tx, tx.documents.get(uuid), "/mcml", Change({"version": "1.0"}))
    with database.write() as tx:
        assert read_element(tx, tx.documents.get(uuid), "/mcml/@version") == b"1.0"
        delete_element(tx, tx.documents.get(uuid), "/mcml/@version")
    with database.read() as tx:
        assert b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions("mcml")).content) == mcml


def real_files() -> list[tuple[str, list[Path]]]:
    folder = shared_folder()
    if folder is None:
        return []
    chosen: list[tuple[str, list[Path]]] = []
    for pattern in (
        "bvh/edge/*.bvh",
        "bvh/exporters/*.bvh",
        "bvh/dance/1*.bvh",
        "bvh/bandai/*run*.bvh",
        "bvh/mae_gestures/a*.bvh",
    ):
        chosen += [("bvh", [path]) for path in sorted(folder.glob(pattern))]
    chosen += [("htr", [path]) for path in sorted(folder.glob("htr/*.[hH]*"))]
    pairs = {
        "asfamc/cmu02/02_crlf.asf": ["asfamc/cmu02/02_crlf_01.amc"],
        "asfamc/cmu16/16.asf": ["asfamc/cmu16/16_12.amc"],
        "asfamc/cmu_misc/zombie.asf": ["asfamc/cmu_misc/zombie.amc"],
        "asfamc/edge/sample.asf": ["asfamc/edge/sample.amc"],
        "asfamc/hdm05_reach/HDM_bd.asf": ["asfamc/hdm05_reach/HDM_bd_grabHighR_001_120.amc"],
        "asfamc/hdm05_triple/HDM_dg.asf": ["asfamc/hdm05_triple/HDM_dg_06-03_03_120.amc"],
    }
    chosen += [("asf-amc", [folder / asf, folder / amc]) for asf, amcs in pairs.items() for amc in amcs]
    return chosen


REAL = real_files()


@pytest.mark.skipif(not REAL, reason="the real capture files are not here (set MCML_SHARED to their folder)")
@pytest.mark.parametrize("sample", fuzz.share(REAL, 2), ids=lambda sample: sample[1][-1].name)
def test_real_files(sqlite_template: Path, tmp_path: Path, sample: tuple[str, list[Path]]) -> None:
    # One database suffices: what differs between them is below the rows, and tested on small files.
    import shutil

    shutil.copy(sqlite_template, tmp_path / "store.db")
    database = Database(f"sqlite:///{tmp_path / 'store.db'}")
    format_name, paths = sample
    round_trip(database, format_name, {path.name: path.read_bytes() for path in paths})
    database.close()


def test_ranges_are_frames_of_the_whole(database: Database) -> None:
    (uuid,) = store(database, {"chain.bvh": bvh(900)})
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        whole, _, ids = blocks(read_clip(tx, stored).clip)
        for first, last in ((1, 1), (256, 257), (100, 800), (900, 900)):
            part, _, part_ids = blocks(read_clip(tx, stored, first=first, last=last).clip)
            assert np.array_equal(part, whole[first - 1 : last])
            assert part_ids == ids[first - 1 : last]


def test_labels_do_not_break_byte_identity_and_restore_regains_it(database: Database) -> None:
    from mcml_service.actions.editing.whole_document import add_labels, change_document, restore_revision

    content = bvh(20)
    (uuid,) = store(database, {"chain.bvh": content})

    def export() -> bytes:
        with database.read() as tx:
            return b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions("bvh")).content)

    with database.write() as tx:
        add_labels(tx, tx.documents.get(uuid), [("walk", 1, 20)])
    with database.write() as tx:
        change_document(tx, tx.documents.get(uuid), unit="cm", description="a chain")
    assert export() == content
    with database.write() as tx:
        change_document(tx, tx.documents.get(uuid), frame_time="0.5")
    assert export() == content.replace(b"0.0083333", b"0.5")
    with database.write() as tx:
        restore_revision(tx, tx.documents.get(uuid), 1)
    assert export() == content


def test_equal_files_are_kept_once_and_named(database: Database) -> None:
    content = bvh(5)
    (first,) = store(database, {"a.bvh": content})
    result = import_files(database, [SourceFile("b.bvh", io.BytesIO(content))], ImportOptions(), Settings())
    assert result.documents[0].receipt["twins"] == [first]
    again = import_files(
        database, [SourceFile("c.bvh", io.BytesIO(content))], ImportOptions(on_duplicate="skip"), Settings()
    )
    assert again.documents[0].skipped
    assert again.documents[0].uuid == first
    with database.read() as tx:
        assert tx.connection.exec_driver_sql("SELECT COUNT(*) FROM upload").scalar() == 1
