"""C3D: against another reader, in a process that may die, and back."""

from __future__ import annotations

import random
import tempfile
from pathlib import Path

import ezc3d
import numpy as np
import pytest

from mcml.errors import ConversionError, FormatError, LimitError, McmlError
from mcml.formats import FORMATS
from mcml.formats.c3d.quantities import kept_quantities
from mcml.formats.format import Limits, ReadOptions
from mcml.language.joint_names import named
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, full_shape
from mcml.motion.conventions.convert import convert
from mcml.motion.markers import marker_skeleton
from mcml.motion.skeleton import Convention
from mcml.testing import frames, read, written
from tests.builders import bvh, c3d_file
from tests.c3d_writer import c3d_bytes, texts

C3D = FORMATS["c3d"]
NOT_READ_BY_EZC3D = {
    "Dance.c3d", "Eb015si.c3d", "Eb015sr.c3d", "bad_parameter_section.c3d", "badParameterOffset.c3d", "mocap36.c3d",
}  # fmt: skip
"""One has an OFFSET that is no whole number, two are of MIPS machines, three have damaged parameters."""

MISREAD_BY_EZC3D = {"type1.C3D"}
"""ezc3d believes ANALOG:USED (0) and not the header (6 samples a frame), so it loses its place."""

EMPTY = "Empty.c3d"


def clip_of(content: bytes, limits: Limits | None = None) -> ClipStream:
    return read(C3D, {"c3d": content}, ReadOptions(limits=limits or Limits()))


def table(clip: ClipStream) -> tuple[np.ndarray, np.ndarray]:
    """(points (F, M, 3), residuals (F, M)), NaN where missing; residuals 0 where the clip has none."""
    blocks = list(clip.blocks())
    values = np.concatenate([block.values for block in blocks]).reshape(
        sum(map(len, blocks)), len(clip.head.skeleton), -1
    )
    residuals = values[..., 3] if values.shape[2] == 4 else np.where(np.isnan(values[..., 0]), np.nan, 0.0)
    return values[..., :3], residuals


def test_keeps_what_the_file_says() -> None:
    clip = clip_of(c3d_file())
    assert clip.head.skeleton.names == ("marker 0", "marker 1", "marker 2")
    assert clip.head.skeleton.joints[0].channels == ("Tx", "Ty", "Tz", "residual")
    assert clip.head.fields["dataframe_rate"] == "120"
    assert clip.head.fields["calibration_unit"] == "mm"
    (block,) = clip.blocks()
    assert block.ids.tolist() == list(range(11, 17))  # type: ignore[union-attr]
    assert block.values[0, 3] == 1.5
    missing = [shape for shape in block.shapes if any(not bits for _, bits in shape)]
    assert missing
    assert any("1 analog channels stay in the file" in notice.what for notice in clip.notices)


@pytest.mark.parametrize(
    ("descriptions", "names"),
    [
        (("R.Knee", "R.Knee.Medial", "Left"), ("R.Knee", "R.Knee.Medial", "LKNE")),
        (("knee", "knee", "Left"), ("RKNE", "RKNE#2", "LKNE")),
        (("knee", "", "Left"), ("RKNE", "RKNE#2", "LKNE")),
        (("LKNE", "inner", ""), ("RKNE", "RKNE#2", "LKNE")),
        (("knee",), ("RKNE", "RKNE#2", "LKNE")),
    ],
)
def test_descriptions_are_names_of_points_of_one_label(descriptions: tuple[str, ...], names: tuple[str, ...]) -> None:
    labels = ["RKNE", "RKNE", "LKNE"]
    content = c3d_bytes(
        np.arange(18.0).reshape(2, 3, 3),
        labels=labels,
        parameters={"POINT:LABELS": texts(*labels), "POINT:DESCRIPTIONS": texts(*descriptions)},
    )
    clip = clip_of(content)
    skeleton, _ = named(clip.head.skeleton)
    assert clip.head.skeleton.names == skeleton.names == names
    assert [joint.source_name for joint in skeleton.joints] == labels
    (told,) = [notice for notice in clip.notices if "RKNE" in notice.what]
    assert told.kind == ("note" if "descriptions" in told.what else "warning")
    assert ("descriptions" in told.what) is (names[0] != "RKNE")
    again = clip_of(written(C3D, clip)["c3d"])
    assert [joint.source_name for joint in again.head.skeleton.joints] == labels


@pytest.mark.parametrize("seed", range(4))
def test_leaves_with_the_same_numbers(seed: int) -> None:
    clip = clip_of(c3d_file(frames=40, points=5, seed=seed))
    again = clip_of(written(C3D, clip)["c3d"])
    assert frames(again) == frames(clip)
    assert again.head.skeleton == clip.head.skeleton
    assert again.head.fields == clip.head.fields


def test_many_labels_go_on_in_labels2() -> None:
    names = [f"marker{number}" for number in range(600)]
    clip = ClipStream(
        ClipHead("trc", marker_skeleton(names), {"dataframe_rate": "100"}),
        lambda: iter([FrameBlock(np.ones((2, 1800)), columns, (full_shape(columns),), np.arange(1, 3))]),
        2,
    )
    columns = clip.head.skeleton.columns()
    again = clip_of(written(C3D, clip)["c3d"])
    assert again.head.skeleton.names == tuple(names)
    assert ezc3d_points(written(C3D, clip)["c3d"])[0].shape == (2, 600, 3)


def test_more_frames_than_a_word_counts_leave() -> None:
    count = 66_000
    names = marker_skeleton(["marker"])
    values = np.random.default_rng(5).normal(0, 300, (count, 3)).astype(np.float32).astype(np.float64)
    clip = ClipStream(
        ClipHead("trc", names, {"dataframe_rate": "100"}),
        lambda: iter([FrameBlock(values, names.columns(), (full_shape(names.columns()),), np.arange(7, count + 7))]),
        count,
    )
    content = written(C3D, clip)["c3d"]
    again = clip_of(content)
    assert again.frames == count
    assert not again.notices
    assert np.array_equal(table(again)[0].reshape(count, 3), values)
    assert next(again.blocks()).ids[0] == 7


def test_single_precision_is_said() -> None:
    body = convert(read(FORMATS["bvh"], {"bvh": bvh(5)}), Convention.MARKER)
    clip = clip_of(written(C3D, body)["c3d"])
    assert any("single precision" in notice.what for notice in body.notices)
    exact = np.concatenate([block.values for block in body.blocks()]).reshape(5, -1, 3)
    assert np.array_equal(table(clip)[0], exact.astype(np.float32).astype(np.float64))
    # A reader of other makers understands what was written.
    assert np.array_equal(ezc3d_points(written(C3D, body)["c3d"])[0], table(clip)[0])


def test_no_frames_no_file() -> None:
    with pytest.raises(ConversionError, match="without frames"):
        written(C3D, convert(read(FORMATS["bvh"], {"bvh": bvh(0)}), Convention.MARKER))


def ezc3d_points(content: bytes) -> tuple[np.ndarray, np.ndarray, object]:
    """(points (F, M, 3) NaN where missing, camera and residual bytes as one word, parameters) by ezc3d."""
    with tempfile.NamedTemporaryFile(suffix=".c3d") as file:
        file.write(content)
        file.flush()
        found = ezc3d.c3d(file.name)
    points = found["data"]["points"][:3].transpose(2, 1, 0).copy()
    points[np.isnan(points).any(axis=2)] = np.nan
    return points, found["data"]["meta_points"], found["parameters"]["POINT"]


def real(shared: Path) -> list[Path]:
    return [path for path in sorted((shared / "c3d").rglob("*")) if path.suffix.lower() == ".c3d"]


def test_every_real_file_against_ezc3d(shared: Path) -> None:
    compared, unlike = 0, set()
    for path in real(shared):
        if path.name in NOT_READ_BY_EZC3D | {EMPTY}:
            continue
        clip = clip_of(path.read_bytes())
        points, residuals = table(clip)
        other, meta, about = ezc3d_points(path.read_bytes())
        if path.name in MISREAD_BY_EZC3D:
            continue
        # ezc3d gives quantities such as angles among the points.
        stated = [label.strip() for label in about["LABELS"]["value"]]  # type: ignore[index]
        quantities = {quantity.label for quantity in kept_quantities(clip.head.sources[0].sections)}
        markers = [place for place in range(other.shape[1]) if [*stated, *[""] * 999][place] not in quantities]
        other, meta = other[:, markers], {name: values[:, markers] for name, values in meta.items()}
        assert points.shape == other.shape, path.name
        # Whole numbers times a scale: ezc3d multiplies in double precision, the file's own is single.
        assert np.allclose(points, other, rtol=3e-7, atol=0, equal_nan=True), path.name
        labels = [joint.source_name for joint in clip.head.skeleton.joints]
        assert labels == [label for label in stated if label not in quantities][: len(labels)], path.name
        assert float(clip.head.fields["dataframe_rate"]) == pytest.approx(about["RATE"]["value"][0], rel=1e-7)  # type: ignore[index]
        # The fourth word of a point is camera bits and residual. ezc3d takes the two bytes the other way round (those
        # of Optotrak.c3d are 1 and 127, of scale 7.87: a residual of 999), and keeps seven bits of the residual.
        scale = abs(about["SCALE"]["value"][0])  # type: ignore[index]
        bits = meta["camera_masks"].transpose(2, 1, 0)  # type: ignore[index]
        low = (bits * 2 ** np.arange(7)).sum(axis=2) * scale
        seen = ~np.isnan(residuals)
        if np.allclose(residuals[seen], low[seen], rtol=1e-6):
            compared += 1
        else:
            unlike.add(path.name)
    assert compared >= 12
    assert unlike <= {"HDM_dg_06-03_03_120.c3d"}


def test_six_encodings_of_one_trial_are_alike(shared: Path) -> None:
    tables = [table(clip_of(path.read_bytes())) for path in sorted((shared / "c3d/encodings").glob("*.c3d"))]
    assert len(tables) == 6
    points, residuals = tables[0]
    for other, others in tables[1:]:
        # Whole numbers and floats of three makes of machine; one part in 16 million is single precision.
        assert np.allclose(points, other, rtol=1.2e-7, atol=1e-4, equal_nan=True)
        assert np.allclose(residuals, others, rtol=1e-6, equal_nan=True)


@pytest.mark.slow
def test_real_files_leave_with_the_same_numbers(shared: Path) -> None:
    checked = 0
    for path in real(shared):
        if path.name != EMPTY and path.stat().st_size < 400_000:
            clip = clip_of(path.read_bytes())
            assert frames(clip_of(written(C3D, clip)["c3d"])) == frames(clip), path.name
            checked += 1
    assert checked >= 9


def test_every_real_file_gives_all_its_frames(shared: Path) -> None:
    """Whatever header and parameters say: what fits the file's size, as others who read these files found it."""
    expected = {
        "HDM_dg_06-03_03_120.c3d": (202, 44), "kinematics_tennis_serve_2players.c3d": (599, 78), "MyCube.c3d": (1, 14),
        "mocap36.c3d": (1380, 36), "nick_freeform_001.c3d": (1101, 53), "Dance.c3d": (499, 40), "shd01.c3d": (237, 27),
        "FP_Type3.c3d": (2, 34), "Optotrak.c3d": (29, 54), "TESTBPI.c3d": (450, 26), "type1.C3D": (296, 28),
        "badParameterOffset.c3d": (111, 41), "bad_parameter_section.c3d": (332, 45), "duplicate_labels.c3d": (1050, 48),
        "parameterOverflow.c3d": (101, 106),
        **{f"Eb015{kind}.c3d": (450, 26) for kind in ("pi", "pr", "si", "sr", "vi", "vr")},
    }  # fmt: skip
    found = {path.name: path for path in real(shared) if path.name != EMPTY}
    assert set(found) == set(expected)
    for name, path in found.items():
        assert table(clip_of(path.read_bytes()))[0].shape == (*expected[name], 3), name


def test_an_empty_file_is_refused(shared: Path) -> None:
    with pytest.raises(FormatError, match="the header of a C3D alone has 512") as caught:
        clip_of(next(path for path in real(shared) if path.name == EMPTY).read_bytes())
    assert caught.value.at is not None
    assert caught.value.at.file


def test_a_file_cut_anywhere_is_refused_or_shorter() -> None:
    whole = c3d_file(frames=60)
    chance = random.Random(3)
    for end in [0, 1, 100, 511, 512, *sorted(chance.sample(range(512, len(whole)), 12))]:
        try:
            clip = clip_of(whole[:end])
        except FormatError:
            continue
        assert len(frames(clip)) <= 60
        if len(frames(clip)) < 60:
            assert any("these count" in notice.what for notice in clip.notices)


def test_any_byte_may_be_wrong() -> None:
    whole = c3d_file()
    chance = random.Random(4)
    for _ in range(25):
        spoilt = bytearray(whole)
        for _ in range(6):
            spoilt[chance.randrange(2, 1400)] = chance.randrange(256)
        try:
            frames(clip_of(bytes(spoilt)))
        except McmlError:
            continue


def test_limits() -> None:
    content = c3d_file()
    for limits in (Limits(joints=2), Limits(frames=3), Limits(name=3)):
        with pytest.raises(LimitError):
            clip_of(content, limits)
