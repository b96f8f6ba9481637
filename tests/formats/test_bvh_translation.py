"""BVH: whether positions of a root replace the OFFSET or add to it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcml.formats import FORMATS
from mcml.formats.bvh.translation import differing_translations, read_translations
from mcml.formats.format import ReadOptions, SourceFile
from mcml.motion.clip import ClipStream
from mcml.testing import read

BODY = """HIERARCHY
ROOT Hips
{
\tOFFSET %s
\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
\tJOINT Head
\t{
\t\tOFFSET %s
\t\tCHANNELS 3 Zrotation Xrotation Yrotation
\t\tEnd Site
\t\t{
\t\t\tOFFSET 0 10 0
\t\t}
\t}
\tJOINT Knee
\t{
\t\tOFFSET %s
\t\tCHANNELS 3 Zrotation Xrotation Yrotation
\t\tJOINT Foot
\t\t{
\t\t\tOFFSET %s
\t\t\tCHANNELS 3 Zrotation Xrotation Yrotation
\t\t\tEnd Site
\t\t\t{
\t\t\t\tOFFSET 0 0 10
\t\t\t}
\t\t}
\t}
}
MOTION
"""
STANDING = ("0 60 0", "0 -45 0", "0 -45 0")
Z_UP = ("0 0 60", "0 0 -45", "0 0 -45")
ALONG_X = ("60 0 0", "45 0 0", "45 0 0")
LYING = "0 90 0"
SITTING = "0 -90 0"


def bvh(offset: str, rows: list[str], bones: tuple[str, ...] = STANDING) -> bytes:
    text = BODY % (offset, *bones) + f"Frames: {len(rows)}\nFrame Time: 0.01\n"
    return (text + "".join(f"{row}\n" for row in rows)).encode()


def row(position: str, turned: str = "0 0 0", knee: str = "0 0 0") -> str:
    return f"{position} {turned} 0 0 0 {knee} 0 0 0"


def clip_of(data: bytes, translation: str = "auto") -> ClipStream:
    return read(FORMATS["bvh"], {"bvh": data}, ReadOptions(translation=translation))


def mode_of(data: bytes, joint: int = 0) -> str:
    return clip_of(data).head.skeleton.joints[joint].translation


CASES = {
    "standing where the rest pose stands": ("0 90 0", row("5 89 -161"), STANDING, "absolute"),
    "standing, added": ("0 90 0", row("3 -2 100"), STANDING, "relative"),
    "far from the origin, added": ("0 90 2400", row("0 0 0"), STANDING, "relative"),
    "crouching, added": ("0 90 0", row("3 -45 100", knee="0 180 0"), STANDING, "relative"),
    "sitting": ("0 90 0", row("0 40 30", knee="0 -90 0"), STANDING, "absolute"),
    "lying on the floor": ("0 90 0", row("0 12 0", turned=LYING), STANDING, "absolute"),
    "lying, far from the origin": ("0 90 0", row("300 10 200", turned=LYING), STANDING, "absolute"),
    "pelvis of SMPL": ("-0.2 -23 2.8", row("10 91 30"), STANDING, "absolute"),
    "pelvis of SMPL at its origin": ("-0.2 -23 2.8", row("0 0 0"), STANDING, "absolute"),
    "pelvis of SMPL, lying": ("-0.2 -23 2.8", row("10 9 30", turned=LYING), STANDING, "absolute"),
    "a small OFFSET": ("0 0.5 0", row("0 90 0"), STANDING, "absolute"),
    "another take's place": ("173 90 -518", row("0 90 -9"), STANDING, "absolute"),
    "Z up": ("0 0 90", row("50 20 88"), Z_UP, "absolute"),
    "Z up, added": ("0 0 90", row("50 20 -1"), Z_UP, "relative"),
    "Z up, sitting": ("0 0 90", row("50 20 15", turned="0 0 90"), Z_UP, "absolute"),
    "a rest pose along one axis": ("0 94 0", row("-6 87 -161", turned="90 0 0"), ALONG_X, "absolute"),
    "a rest pose along one axis, sitting": ("0 94 0", row("-6 40 -161", turned="90 0 0"), ALONG_X, "absolute"),
}


@pytest.mark.parametrize("case", CASES, ids=str)
def test_the_lowest_joint_tells_whether_positions_replace_the_offset(case: str) -> None:
    offset, frame, bones, mode = CASES[case]
    data = bvh(offset, [frame] * 3, bones)
    assert mode_of(data) == mode
    for wanted in ("absolute", "relative"):
        chosen = clip_of(data, wanted)
        assert chosen.head.skeleton.joints[0].translation == wanted
        assert not any(notice.kind == "guess" for notice in chosen.notices)


def test_an_offset_of_zero_leaves_nothing_to_guess() -> None:
    clip = clip_of(bvh("0 0 0", [row("0 90 0")]))
    assert clip.head.skeleton.joints[0].translation == "absolute"
    assert not clip.notices


def test_the_receipt_tells_both_heights_and_how_to_change_the_reading() -> None:
    said = [notice.what for notice in clip_of(bvh("0 90 0", [row("0 89 0")] * 3)).notices if notice.kind == "guess"]
    assert len(said) == 1
    for words in ("'Hips'", "(clear)", "along Y", "is 0 in the rest", "-1 in the motion", "89 if they are added"):
        assert words in said[0], said
    assert "translation=relative" in said[0]
    added = [notice.what for notice in clip_of(bvh("0 90 0", [row("0 2 0")] * 3)).notices]
    assert "are added to its OFFSET (clear)" in added[0]
    assert "translation=absolute" in added[0]
    small = [notice.what for notice in clip_of(bvh("0 0.5 0", [row("0 90 0")] * 3)).notices]
    assert "(uncertain)" in small[0]


def test_a_body_below_a_root_that_stands_still_is_read_likewise() -> None:
    def below(position: str, turned: str = "0 0 0") -> bytes:
        text = bvh("0 90 0", [], STANDING).decode().replace("ROOT Hips", "JOINT Hips")
        head, _, body = text.partition("HIERARCHY\n")
        body = body.partition("MOTION\n")[0]
        carrier = "ROOT World\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n"
        frame = f"0 0 0 {row(position, turned)}\n"
        return f"{head}HIERARCHY\n{carrier}{body}}}\nMOTION\nFrames: 1\nFrame Time: 1\n{frame}".encode()

    assert mode_of(below("0 89 0"), 1) == "absolute"
    assert mode_of(below("0 15 0", LYING), 1) == "absolute"
    assert mode_of(below("0 -1 0"), 1) == "relative"


def test_poses_from_all_over_the_motion_count() -> None:
    """Programs put poses at the origin in front, which are longer than the text that is looked at first."""
    pose, walk = [row("0.000000 0.000000 0.000000")] * 3000, [row("5.000000 89.000000 7.000000")] * 12000
    data = bvh("0 90 0", pose + walk)
    assert len("\n".join(pose)) > 1 << 16
    assert mode_of(data) == "absolute"


def test_a_document_tells_what_would_be_read_otherwise_today() -> None:
    """`sample` may hold gaps; skeletons of other conventions have nothing to choose."""
    clip = clip_of(bvh("0 90 0", [row("0 15 0", turned=LYING)] * 3), "relative")
    sample = np.concatenate([block.values for block in clip.blocks()])
    found = differing_translations(clip.head.skeleton, sample)
    assert [(reading.joint, reading.mode) for reading in found] == [(0, "absolute")]
    today = clip_of(bvh("0 90 0", [row("0 15 0", turned=LYING)] * 3))
    assert not differing_translations(today.head.skeleton, sample)
    assert not differing_translations(clip.head.skeleton, sample[:0])
    sample[1] = np.nan
    assert read_translations(clip.head.skeleton, sample)[0].mode == "absolute"
    trc = b"PathFileType\t4\t(X/Y/Z)\ta\nDataRate\tNumFrames\tNumMarkers\tUnits\n1\t1\t1\tmm\n"
    points = read(FORMATS["trc"], {"trc": trc + b"Frame#\tTime\tA\n\t\tX1\tY1\tZ1\n\n1\t0\t1\t2\t3\n"}, ReadOptions())
    assert not differing_translations(points.head.skeleton, np.ones((1, 3)))


@pytest.mark.parametrize(
    ("name", "mode"),
    [
        ("exporters/Chicken_TPOSE.bvh", "absolute"),
        ("exporters/Chicken_Walk.bvh", "absolute"),
        ("exporters/rokoko_jesse_dance.bvh", "absolute"),
        ("exporters/AV_8Walk_Meredith_HVHA_Rep1.bvh", "absolute"),
        ("dance/Gangnam-Style.bvh", "absolute"),
        ("mae_gestures/ah_throw1.bvh", "relative"),
        ("mae_gestures/ya_throw1.bvh", "relative"),
    ],
)
def test_real_files_are_read_as_they_are_meant(shared: Path, name: str, mode: str) -> None:
    with (shared / "bvh" / name).open("rb") as stream:
        clip = FORMATS["bvh"].read({"bvh": SourceFile(name, stream)}, ReadOptions())
        assert clip.head.skeleton.joints[0].translation == mode
