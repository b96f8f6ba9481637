"""MOT and STO: angles and times as a plain reader of OpenSim's tables finds them."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mcml.errors import ConversionError
from mcml.formats import FORMATS, WRITERS
from mcml.formats.opensim.angles import OPPOSITES, all_columns
from mcml.language import motion_names
from mcml.motion.bodies.calibration import calibrate
from mcml.motion.bodies.clip_body import body_of, quantity_values
from mcml.motion.bodies.quantities import asked_quantity
from mcml.motion.bodies.turned_angles import turned_angle
from mcml.motion.clip import ClipStream
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import Convention
from mcml.motion.units import reading_of
from mcml.testing import read
from tests.builders import TRC
from tests.formats.scenes.clips import CLIPS, cut, hostile, without_joints
from tests.formats.scenes.reading import stating
from tests.formats.test_real_files import opened
from tests.motion.bodies.made import clip_of, named, person, positions_of
from tests.motion.bodies.made import stance as stance_of_pose

UP = {"global_axis_of_gravity": "Y"}


def table(clip: ClipStream, format: str = "mot") -> tuple[dict[str, str], list[str], np.ndarray]:
    """(head, labels, rows), as OpenSim's reader takes a file apart: `key=value` up to `endheader`, then columns."""
    text = b"".join(WRITERS[format].write(clip, format)).decode()
    head, _, body = text.partition("\nendheader\n")
    said = dict(match.groups() for line in head.split("\n") if (match := re.fullmatch(r"\s*(\w+)\s*=\s*(.+)", line)))
    assert "=" not in head.split("\n")[0]
    labels, *rows = body.rstrip("\n").split("\n")
    values = np.array([[float(cell) for cell in row.split("\t")] for row in rows])
    values = values.reshape(len(rows), len(labels.split("\t")))
    assert said["inDegrees"] == "yes"
    assert (int(said["nRows"]), int(said["nColumns"])) == values.shape
    return said, labels.split("\t"), values


@pytest.mark.parametrize("format", ["mot", "sto"])
@pytest.mark.parametrize("convention", [Convention.LISTED, Convention.FIXED, Convention.BASE])
def test_angles_are_those_of_questions(format: str, convention: Convention) -> None:
    clip = stating(clip_of(person(7, 90), convention), **UP)
    _, labels, values = table(clip, format)
    body = body_of(clip.head, clip.blocks())
    names = {column.title: column for column in all_columns()}
    between = [label for label in labels[1:] if not names[label].turned]
    assert len(between) >= 17
    for label in between:
        wanted = quantity_values(clip, body, asked_quantity(f"angle:{names[label].name}"))
        np.testing.assert_allclose(values[:, labels.index(label)], wanted, rtol=0, atol=1e-6, equal_nan=True)
    times = np.arange(90) * float(clip.head.frame_time or 0)
    np.testing.assert_allclose(values[:, 0], times, rtol=0, atol=1e-6)
    _compare_turned(clip, labels, values)


def _compare_turned(clip: ClipStream, labels: list[str], values: np.ndarray) -> None:
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    calibration = calibrate(clip.head, positions_of(clip))
    walker = Walker(skeleton, reading)
    poses = [walker.poses(block) for block in clip.blocks()]
    positions, rotations = (np.concatenate(parts) for parts in zip(*poses, strict=True))
    at = calibration.reference
    pose = None if at is None else (positions[at], rotations[at])
    stance = stance_of_pose(skeleton, pose, reading)
    turned = [column for column in all_columns() if column.turned and column.title in labels]
    assert len(turned) >= 15
    for column in turned:
        wanted = turned_angle(column.name, skeleton, rest_of(skeleton, reading), stance, rotations)
        np.testing.assert_allclose(values[:, labels.index(column.title)], wanted, rtol=0, atol=1e-6)


def test_a_knee_by_hand() -> None:
    """Three points of a leg and the thigh's line to the left, which is X at rest."""
    clip = clip_of(person(2, 30))
    _, labels, values = table(clip)
    names = clip.head.skeleton.names
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    places, turned = (np.concatenate(each) for each in zip(*map(walker.poses, clip.blocks()), strict=True))
    hip, knee, ankle = (names.index(f"left_{part}") for part in ("up_leg", "low_leg", "foot"))
    for frame in range(30):
        thigh = Rotation.from_quat(turned[frame, hip])
        along, shank = places[frame, knee] - places[frame, hip], places[frame, ankle] - places[frame, knee]
        front = np.cross(thigh.apply([1.0, 0.0, 0.0]), -along)
        front /= np.linalg.norm(front)
        wanted = np.degrees(np.arctan2(-shank @ front, shank @ along / np.linalg.norm(along)))
        # Positions are rounded to a tenth of a millimetre before.
        assert values[frame, labels.index("knee_flexion_l")] == pytest.approx(wanted, abs=0.03)
    assert values[:, labels.index("knee_flexion_l")].min() < 0


def test_no_column_is_the_opposite_of_another() -> None:
    titles = [column.title for column in all_columns()]
    assert len(set(titles)) == len(titles)
    assert {"knee_flexion_r", "leg_abduction_l", "trunk_right_lateral_flexion", "wrist_flexion_l"} <= set(titles)
    assert not any(
        title.endswith(f"_{word.replace('-', '_')}{side}")
        for title in titles
        for word in OPPOSITES
        for side in ("", "_l", "_r")
    )
    known = {(part.name, movement) for part in motion_names.parts().values() for movement in part.movements}
    assert {(part, movement) for part, movement in (_said(column.name) for column in all_columns())} <= known


def _said(name: str) -> tuple[str, str]:
    name = re.sub("^(left|right)-", "", name)
    part = max((item for item in motion_names.parts() if name.startswith(f"{item}-")), key=len)
    return part, name.removeprefix(f"{part}-")


def test_what_takes_the_up_axis_is_left_out_where_it_is_not_stated() -> None:
    clip = clip_of(person(7, 20))
    _, labels, values = table(clip)
    upright = {column.title for column in all_columns() if column.upright}
    assert not upright & set(labels)
    assert any("states no up axis" in notice.what for notice in clip.notices)
    told = stating(clip_of(person(7, 20)), **UP)
    _, more, others = table(told)
    assert len(set(more) & upright) > 10
    assert not any("up axis" in notice.what for notice in told.notices)
    for label in labels:
        np.testing.assert_array_equal(values[:, labels.index(label)], others[:, more.index(label)])


@pytest.mark.slow
def test_a_clip_that_comes_in_blocks_has_the_same_angles() -> None:
    parts, whole = (stating(clip, **UP) for clip in (CLIPS["many frames"](), clip_of(person(5, 1500))))
    for one, other in zip(table(parts), table(whole), strict=True):
        assert np.array_equal(one, other, equal_nan=True) if isinstance(one, np.ndarray) else one == other


def test_gaps_are_nan() -> None:
    clip = clip_of(person(1, 10))
    joint = clip.head.skeleton.names.index("left_up_leg")
    column = clip.head.skeleton.columns().index((joint, 3))

    def blocks():  # type: ignore[no-untyped-def]
        for block in clip.blocks():
            values = block.values.copy()
            values[4, column] = np.nan
            yield replace(block, values=values)

    torn = ClipStream(clip.head, blocks, 10, [])
    _, labels, values = table(torn)
    assert np.flatnonzero(np.isnan(values[:, labels.index("knee_flexion_l")])).tolist() == [4]
    assert np.isfinite(values[:, labels.index("knee_flexion_r")]).all()
    assert any("written as nan" in notice.what for notice in torn.notices)


def test_empty_clips_and_hostile_names() -> None:
    _, labels, values = table(cut(clip_of(person(1)), 0))
    assert values.shape == (0, len(labels))
    assert len(labels) > 10
    _, labels, values = table(cut(clip_of(person(1)), 1), "sto")
    assert values.shape == (1, len(labels))
    clip = hostile()
    said, _, values = table(clip)
    assert said["nRows"] == "5"
    assert b"".join(WRITERS["mot"].write(hostile(), "mot")).count(b"endheader\n") == 1


def test_what_has_no_angles_or_times_is_refused() -> None:
    with pytest.raises(ConversionError, match="no angle"):
        table(CLIPS["chain"]())
    with pytest.raises(ConversionError, match="no angle"):
        table(without_joints())
    with pytest.raises(ConversionError, match="markers have no angles"):
        table(read(FORMATS["trc"], {"trc": TRC}))
    clip = clip_of(person(1))
    with pytest.raises(ConversionError, match="how fast frames follow"):
        table(clip.with_head(replace(clip.head, frame_time=None)))
    with pytest.raises(ConversionError, match="beyond the largest"):
        table(clip.with_head(replace(clip.head, frame_time="1e307")))


@pytest.mark.parametrize(
    "name", ["bvh/bandai/dataset-1_bow_old_001.bvh", "asfamc/cmu16/run_veer_left_16_48.amc", "htr/xbot_walking.HTR"]
)
def test_real_bodies_have_angles(shared: Path, name: str) -> None:
    clip = named(opened(shared / name))
    clip = clip.with_head(replace(clip.head, frame_time=clip.head.frame_time or "0.0083333"))
    _, labels, values = table(stating(clip, **UP))
    knee = values[:, labels.index("knee_flexion_l")]
    assert -10 <= knee.min() < 40 < knee.max() < 160 or "bow" in name
    told = stating(clip, **UP)
    body = body_of(told.head, told.blocks())
    first = 1 if body.calibration.leaps else 0
    wanted = quantity_values(told, body, asked_quantity("angle:left-knee-flexion"))
    np.testing.assert_allclose(knee[first:], wanted[first:], rtol=0, atol=1e-6)
