"""Real files of many programs: they leave as they came, and keep every position in the other formats."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from mcml.errors import FormatError
from mcml.formats import FORMATS, find_format
from mcml.formats.format import ReadOptions, SourceFile
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import convert
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import Convention
from mcml.motion.units import reading_of
from mcml.testing import read, written
from tests.poses import rest_height

NOT_MOTION = {"lfs_pointer.bvh", "ramsden_htr_output.htr", "16_11.amc"}
CONVERTED = (
    "bvh/bandai/dataset-1_walk_angry_001.bvh",
    "bvh/dance/131_01.bvh",
    "bvh/dance/A_test.bvh",
    "bvh/exporters/AV_8Walk_Meredith_HVHA_Rep1.bvh",
    "bvh/exporters/Chicken_Walk.bvh",
    "bvh/exporters/bvh_test1.bvh",
    "bvh/exporters/cmu_daz_walk.bvh",
    "bvh/exporters/fair_dab.bvh",
    "bvh/exporters/ipi_studio.bvh",
    "bvh/exporters/secondlife_hug.bvh",
    "bvh/edge/rotation_first_root.bvh",
    "bvh/mae_gestures/ah_throw1.bvh",
    "asfamc/cmu02/02_crlf_01.amc",
    "asfamc/edge/sample.amc",
    "asfamc/hdm05_reach/HDM_bd_grabHighR_001_120.amc",
    "htr/egnaro_skel_anim.htr",
    "htr/maya_tail_export.htr",
    "htr/xbot_walk_f_mixamo.com.htr",
    "htr/xbot_walking.HTR",
)


def files_of(path: Path) -> tuple[str, dict[str, bytes]]:
    """(format, bytes by part) of a file; an AMC with the ASF whose name begins like its own."""
    data = path.read_bytes()
    format, part = find_format(path.name, data[:4096])
    files = {part: data}
    if part == "amc":
        skeletons = sorted(path.parent.glob("*.asf"))
        stem = path.stem.lower()
        fitting = [item for item in skeletons if stem.startswith(item.stem.lower())]
        skeleton = fitting[-1] if fitting else min(skeletons, key=lambda item: _unlike(item.stem.lower(), stem))
        files = {"asf": skeleton.read_bytes(), "amc": data}
    return format.name, files


def _unlike(one: str, other: str) -> int:
    return -next((place for place, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), len(one))


def opened(path: Path) -> ClipStream:
    name, files = files_of(path)
    return read(FORMATS[name], files)


def table(clip: ClipStream) -> np.ndarray:
    return np.concatenate([block.values for block in clip.blocks()])


def positions(clip: ClipStream) -> np.ndarray:
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    return np.concatenate([walker.poses(block)[0] for block in clip.blocks()])


@pytest.mark.slow
@pytest.mark.parametrize(("folder", "count"), [("bvh", 99), ("asfamc", 61), ("htr", 7), ("trc", 11), ("trc_facial", 2)])
def test_every_file_leaves_with_the_same_bits(shared: Path, folder: str, count: int) -> None:
    checked = 0
    for path in sorted((shared / folder).rglob("*.*")):
        if path.name in NOT_MOTION or path.suffix.lower() == ".asf" or path.parts[-3:-1] == ("trc", "malformed"):
            continue
        name, files = files_of(path)
        clip = read(FORMATS[name], files)
        again = read(FORMATS[name], written(FORMATS[name], clip))
        assert again.head == clip.head, path
        assert np.array_equal(table(again).view(np.int64), table(clip).view(np.int64)), path
        checked += 1
    assert checked == count


def test_files_that_are_no_motion_are_refused(shared: Path) -> None:
    for name in NOT_MOTION:
        path = next(shared.rglob(name))
        with pytest.raises(FormatError) as error:
            table(opened(path))
        assert len(error.value.what) > 10


def test_values_agree_with_plain_python(shared: Path) -> None:
    """Reading against split() and float()."""
    for name in ("bvh/bandai/dataset-1_bow_old_001.bvh", "bvh/exporters/Chicken_Walk.bvh", "bvh/dance/131_01.bvh"):
        text = (shared / name).read_text()
        numbers = text[text.index("Frame Time") :].split()[3:]
        found = table(opened(shared / name)).reshape(-1)
        expected = np.array([float(number) for number in numbers])
        assert np.array_equal(found.view(np.int64), expected.view(np.int64))


@pytest.mark.parametrize("name", CONVERTED)
def test_positions_stay_in_every_other_format(shared: Path, name: str) -> None:
    clip = opened(shared / name)
    if clip.head.seconds_per_frame() is None:
        # AMC has no rate, and files of markers do not go without one.
        clip = clip.with_head(replace(clip.head, frame_time="0.0083333"))
    # Nor does TRC go without a unit.
    clip = clip.with_head(replace(clip.head, fields={"calibration_unit": "mm"} | clip.head.fields))
    before = positions(clip)
    height = rest_height(clip.head.skeleton, reading=reading_of(clip.head))
    names = clip.head.skeleton.names
    for format in FORMATS.values():
        if format.name == clip.head.format:
            continue
        converted = convert(replace(clip, notices=[]), format.convention)
        target = converted.head.skeleton.names
        # Writing and reading keeps the order of the joints, whatever becomes of their names.
        after = positions(read(format, written(format, converted)))[:, [target.index(joint) for joint in names]]
        moved = {joint for joint in names if any(f"where {joint!r} does" in n.what for n in converted.notices)}
        kept = [index for index in range(len(names)) if not (moved and index == 0)]
        # C3D holds numbers in single precision.
        single = np.abs(before).max() * 2.0**-24 if format.name == "c3d" else 0.0
        assert np.abs(after - before)[:, kept].max() < 1e-6 * height + single, format.name


def test_a_figure_whose_joints_slide_is_not_for_asf(shared: Path) -> None:
    clip = opened(shared / "bvh/exporters/perception_neuron_milad.bvh")
    converted = convert(clip, Convention.FIXED)
    assert any("20 joints stand still instead, by at most 8.83" in notice.what for notice in converted.notices)
    kept = convert(clip, Convention.FIXED, keep_translations=True)
    names = kept.head.skeleton.names
    after = positions(kept)[:, [names.index(name) for name in clip.head.skeleton.names]]
    assert np.abs(after - positions(clip)).max() < 1e-9


def test_two_programs_agree_where_the_joints_of_one_walk_are(shared: Path) -> None:
    """One base pose with orientations, one without; other axes, other names: the same figure at the first frame."""
    one, other = opened(shared / "htr/xbot_walking.HTR"), opened(shared / "htr/xbot_walk_mixamo.com.htr")
    places = {joint.source_name.removeprefix("mixamorig:"): i for i, joint in enumerate(one.head.skeleton.joints)}
    common = [places[joint.source_name] for joint in other.head.skeleton.joints]
    first, second = pdist(positions(one)[0][common]), pdist(positions(other)[0])
    apart = second > 1e-6
    assert np.abs(first[apart] / second[apart] - 1).max() < 1e-5


def test_acclaim_positions_are_those_of_the_usual_formula(shared: Path) -> None:
    """The walk that public ASF readers show: C M C^-1 from the root down, ends of bones, inches times 0.45."""
    clip = opened(shared / "asfamc/cmu02/02_lf_01.amc")
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    block = next(iter(clip.blocks()))
    tips = walker.tips(block)
    names = [
        clip.head.skeleton.joints[joint].name for joint in [joint for joint, _ in rest_of(clip.head.skeleton).tips]
    ]
    assert names == ["ltoes", "rtoes", "head", "lfingers", "lthumb", "rfingers", "rthumb"]
    metres = tips * 0.0254 / 0.45
    height = metres[:, names.index("head"), 1] - metres[:, :2, 1].min(axis=1)
    assert 1.5 < height.min() < height.max() < 2.0
    feet = metres[:, :2, 1].min(axis=1)
    # One foot is always on the floor.
    assert np.ptp(feet) < 0.1


def test_a_long_file_is_read_in_bounded_memory(shared: Path, tmp_path: Path) -> None:
    """60 MB of motion: what is held at a time is a block, not the clip."""
    import tracemalloc

    text = (shared / "bvh/exporters/rokoko_jesse_dance.bvh").read_text()
    head, rows = text[: text.index("Frames:")], text[text.index("-6.2023") :].rstrip("\n") + "\n"
    path = tmp_path / "long.bvh"
    with path.open("w") as file:
        file.write(f"{head}Frames: {1007 * 41}\nFrame Time: 0.01\n")
        for _ in range(41):
            file.write(rows)
    assert path.stat().st_size > 58_000_000
    with path.open("rb") as stream:
        tracemalloc.start()
        clip = FORMATS["bvh"].read({"bvh": SourceFile("long.bvh", stream)}, ReadOptions())
        frames = sum(len(block) for block in clip.blocks())
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert frames == 1007 * 41
    assert peak < 20_000_000
