"""C3D: points that are no places are kept, and are no markers."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mcml.formats import FORMATS
from mcml.formats.c3d.format import quantity_labels
from mcml.formats.c3d.quantities import kept_quantities
from mcml.formats.format import ReadOptions, SourceFile
from mcml.language.elements import from_head
from mcml.language.reader import read_document
from mcml.language.writer import write_document
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.testing import read, written
from tests.c3d_writer import Value, c3d_bytes

LABELS = ["LASI", "LKneeAngles", "RASI", "LKneePower", "CentreOfMass", "Subject:LHipMoment", "Own", "Strange"]
POINTS = np.random.default_rng(1).normal(0, 100, (5, len(LABELS), 3)).astype(np.float32).astype(np.float64)


def texts(*words: str) -> Value:
    longest = max(map(len, words))
    return -1, (longest, len(words)), "".join(word.ljust(longest) for word in words).encode()


TYPED: dict[str, Value | None] = {
    "POINT:TYPE_GROUPS": texts(
        "ANGLES", "ANGLE", "MODELED_MARKERS", "MODELED_MARKER", "STRAINS", "STRAIN", "BONES", "BONE"
    ),
    "POINT:ANGLES": (-1, (11,), b"LKneeAngles"),
    "POINT:POWERS": texts("LKneePower"),
    "POINT:POWER_UNITS": texts("W/kg"),
    "POINT:MOMENTS": texts("LHipMoment"),
    "POINT:MODELED_MARKERS": texts("CentreOfMass"),
    "POINT:STRAINS": texts("Strange"),
    "POINT:STRAIN_UNITS": texts("%"),
    "POINT:BONES": texts("Own"),
    "POINT:BONE_UNITS": texts("mm"),
}


def clip_of(parameters: dict[str, Value | None], fourth: np.ndarray | None = None) -> ClipStream:
    data = c3d_bytes(POINTS, fourth, labels=LABELS, parameters=parameters, first=91)
    return read(FORMATS["c3d"], {"c3d": data}, ReadOptions())


def test_typed_points_are_no_markers() -> None:
    clip = clip_of(TYPED)
    assert [joint.source_name for joint in clip.head.skeleton.joints] == ["LASI", "RASI", "CentreOfMass", "Own"]
    [block] = list(clip.blocks())
    assert block.values.reshape(5, 4, 3).tolist() == POINTS[:, [0, 2, 4, 6]].tolist()
    kept = kept_quantities(clip.head.sources[0].sections)
    assert [(item.group, item.label, item.unit) for item in kept] == [
        ("ANGLES", "LKneeAngles", "deg"),
        ("MOMENTS", "Subject:LHipMoment", ""),
        ("POWERS", "LKneePower", "W/kg"),
        ("STRAINS", "Strange", "%"),
    ]
    assert kept[0].samples is not None
    assert kept[0].samples[:, :3].tolist() == POINTS[:, 1].tolist()
    assert {item.first for item in kept} == {91}
    said = next(notice.what for notice in clip.notices if "quantities" in notice.what)
    assert said.startswith("1 ANGLES, 1 MOMENTS, 1 POWERS, 1 STRAINS are quantities, not markers")


@pytest.mark.parametrize("group", ["ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS"])
def test_old_files_have_no_list_of_types(group: str) -> None:
    clip = clip_of({f"POINT:{group}": texts("LKneeAngles"), f"POINT:{group}2": texts("LKneePower")})
    assert "LKneeAngles" not in clip.head.skeleton.names
    assert [item.label for item in kept_quantities(clip.head.sources[0].sections)] == ["LKneeAngles", "LKneePower"]


def test_points_that_nobody_calls_quantities_are_markers() -> None:
    assert len(clip_of({}).head.skeleton) == len(LABELS)


def test_c3d_holds_them_again_whatever_frames_are_left() -> None:
    fourth = np.zeros((5, len(LABELS)))
    fourth[2, 1], fourth[3, 1] = -1, 7
    clip = clip_of(TYPED, fourth)
    whole = read(FORMATS["c3d"], written(FORMATS["c3d"], clip), ReadOptions())
    assert whole.head.sources[0].sections == clip.head.sources[0].sections
    assert whole.head.skeleton == clip.head.skeleton
    [block] = list(clip.blocks())
    part = ClipStream(clip.head, lambda: iter([_last(block, 3)]), 3)
    again = read(FORMATS["c3d"], written(FORMATS["c3d"], part), ReadOptions())
    [angles, *_] = kept_quantities(again.head.sources[0].sections)
    assert angles.first == 93
    assert angles.samples is not None
    assert angles.samples[:, 3].tolist() == [-1, 7, 0]
    assert angles.samples[1, :3].tolist() == POINTS[3, 1].tolist()


def _last(block: FrameBlock, count: int) -> FrameBlock:
    return replace(block, values=block.values[-count:], ids=block.ids[-count:])


def test_another_rate_leaves_them_out() -> None:
    clip = clip_of(TYPED)
    slower = clip.with_head(replace(clip.head, fields=clip.head.fields | {"dataframe_rate": "50"}))
    again = read(FORMATS["c3d"], written(FORMATS["c3d"], slower), ReadOptions())
    assert kept_quantities(again.head.sources[0].sections) == []
    assert any("another frame rate" in notice.what for notice in slower.notices)


def test_a_document_keeps_them_and_other_formats_do_not() -> None:
    clip = clip_of(TYPED)
    names = [joint.name for joint in clip.head.skeleton.joints]
    document = b"".join(write_document(from_head(clip.head), 5, None, clip.blocks(), names))
    again = read_document(io.BytesIO(document)).clip
    assert again.head.sources[0].sections == clip.head.sources[0].sections
    trc = b"".join(FORMATS["trc"].write(clip, "trc"))
    assert b"CentreOfMass" in trc
    assert b"KneeAngles" not in trc


def test_a_file_of_quantities_alone_has_no_markers() -> None:
    clip = clip_of({"POINT:ANGLES": texts(*LABELS)})
    assert len(clip.head.skeleton) == 0
    assert sum(len(block) for block in clip.blocks()) == 5
    assert any("no markers" in notice.what for notice in clip.notices)


def test_quantities_that_are_too_long_stay_in_the_kept_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mcml.formats.c3d.quantities.MOST_TEXT", 100)
    clip = clip_of(TYPED)
    assert kept_quantities(clip.head.sources[0].sections) == []
    assert any("the kept file has them" in notice.what for notice in clip.notices)


def test_sections_of_other_kinds_are_passed_over() -> None:
    odd = [("POINT:SCALE", "-1"), ("POINT:ANGLES a", "x"), ("POINT:ANGLES b", "1 100\n1 2"), ("other", "1 100")]
    assert kept_quantities(odd) == []


@pytest.mark.parametrize("name", ["s4_am_gait04.c3d", "hc030a05.c3d", "mh0222_bp06.c3d", "treadmill_events.c3d"])
def test_files_of_laboratories(shared: Path, name: str) -> None:
    with (shared / "lab" / name).open("rb") as stream:
        clip = FORMATS["c3d"].read({"c3d": SourceFile(name, stream)}, ReadOptions())
        labels = quantity_labels(stream)
        assert "LKneeAngles" in labels
        assert not {joint.source_name for joint in clip.head.skeleton.joints} & set(labels)
        data = b"".join(FORMATS["c3d"].write(clip, "c3d"))
    again = read(FORMATS["c3d"], {"c3d": data}, ReadOptions())
    kept = [section for section in clip.head.sources[0].sections[2:] if section[0] != "FORCE_PLATFORM:CORNERS"]
    assert list(again.head.sources[0].sections[2:]) == kept
