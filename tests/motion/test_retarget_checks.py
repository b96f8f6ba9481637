"""Motions that cannot be right on another skeleton are refused, with the reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcml.errors import ConversionError
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.frames import joined
from mcml.motion.retargeting.bone_mapping import suggest_matches
from mcml.motion.retargeting.retarget import retarget
from mcml.motion.skeleton import Skeleton
from tests.clips.test_references import floating
from tests.motion.bodies.made import PARTS, clip_of, person
from tests.poses import global_positions


def whole(clip: ClipStream) -> tuple[Skeleton, FrameBlock]:
    return clip.head.skeleton, joined(clip.blocks())


@pytest.mark.parametrize("which", ["motion", "target"])
def test_bodies_without_a_rest_pose_are_known_by_their_motion(which: str) -> None:
    """Where joints are comes with the motion: at rest all stand in one point."""
    bodies = [clip_of(person(3)), clip_of(floating(4))]
    (source, block), (target, frames) = map(whole, bodies if which == "target" else bodies[::-1])
    matches = suggest_matches(source, target)
    made = retarget(source, block, target, matches, 1 / 60, target_block=frames)
    limbs = [bone.mean for bone in made.report.bones if bone.leads]
    assert np.median(limbs) < 0.5
    assert all(line.mean < 5 for line in made.report.parts if line.what in ("hips", "shoulders"))
    # Bones have the lengths that they have in the motion of the target.
    there, own = (global_positions(target, each) for each in (made.block, frames))
    for end, joint in enumerate(target.joints):
        if joint.parent >= 0 and joint.name.endswith(("_low_leg", "_foot", "_low_arm")):
            lengths = [np.median(np.linalg.norm(at[:, end] - at[:, joint.parent], axis=1)) for at in (there, own)]
            assert lengths[0] == pytest.approx(lengths[1], rel=0.02)
    if which == "target":
        with pytest.raises(ConversionError, match="rest pose of the target does not show"):
            retarget(source, block, target, matches, 1 / 60)


def test_on_itself_such_a_motion_stays_as_it_is() -> None:
    source, block = whole(clip_of(floating(4)))
    made = retarget(source, block, source, suggest_matches(source, source), 1 / 60).block
    np.testing.assert_allclose(global_positions(source, made), global_positions(source, block), atol=1e-6)


@pytest.mark.parametrize("part", ["legs", "all but a few"])
def test_some_bones_without_length_are_refused_too(part: str) -> None:
    source, block = whole(clip_of(person(3)))
    gone = ("_low_leg", "_foot") if part == "legs" else ("_leg", "_foot", "_arm", "_hand", "_toes")
    flat = tuple(
        replace(joint, offset=("0", "0", "0")) if joint.name.endswith(gone) else joint for joint in source.joints
    )
    target = replace(source, joints=flat)
    for one, other in ((source, target), (target, source)):
        with pytest.raises(ConversionError, match="does not show the body"):
            retarget(one, block, other, suggest_matches(one, other), 1 / 60)


def test_a_rest_pose_of_another_size_than_the_motion_is_refused() -> None:
    source, block = whole(clip_of(floating(4)))
    small = tuple(replace(joint, offset=("0", "2", "0")) if joint.parent >= 0 else joint for joint in source.joints)
    target = whole(clip_of(person(3)))[0]
    rig = replace(source, joints=small)
    with pytest.raises(ConversionError, match="of another body"):
        retarget(rig, block, target, suggest_matches(rig, target), 1 / 60)


def connected(degrees: float) -> ClipStream:
    """A person whose legs hang from a connector that has no name of MCML, and is turned about the vertical."""
    parts = {name: part for name, part in PARTS.items() if "_leg" not in name and "_foot" not in name}
    parts = {name: part for name, part in parts.items() if "_toes" not in name}
    parts["connector"] = ("Root", (0, 0, 0))
    for name, (above, offset) in PARTS.items():
        if name not in parts:
            parts[name] = ("connector" if above == "Root" else above, offset)
    order: list[str] = []
    lines = ["HIERARCHY"]

    def add(name: str, depth: int) -> None:
        above, offset = parts[name]
        order.append(name)
        lines.append(f"{'JOINT' if above else 'ROOT'} {name}\n{{\nOFFSET {' '.join(map(str, offset))}")
        lines.append(f"CHANNELS {'3' if above else '6 Xposition Yposition Zposition'} Zrotation Xrotation Yrotation")
        children = [child for child, (parent, _) in parts.items() if parent == name]
        for child in children:
            add(child, depth + 1)
        if not children:
            lines.append("End Site\n{\nOFFSET 0 -3 2\n}")
        lines.append("}")

    add("Root", 0)
    row = [0.0, 95.0, 0.0] + [
        degrees if name == "connector" and axis == 2 else 0.0 for name in order for axis in range(3)
    ]
    text = " ".join(map(str, row))
    lines += ["MOTION", "Frames: 3", "Frame Time: 0.02", text, text, text]
    return clip_of(("\n".join(lines) + "\n").encode())


@pytest.mark.parametrize("degrees", [0.0, 25.0, 90.0])
def test_hips_that_a_joint_without_a_match_turns(degrees: float) -> None:
    (source, block), (target, _) = whole(connected(degrees)), whole(clip_of(person(3)))
    assert "connector" in source.names
    matches = suggest_matches(source, target)
    made = retarget(source, block, target, matches, 0.02)
    # Turned about the bone of the pelvis, which leans a little: exact but for that.
    assert {line.what: line.mean for line in made.report.parts}["hips"] < 0.1 * max(degrees, 1e-6)
    # Back again, the connector turns the hips.
    back = retarget(target, made.block, source, suggest_matches(target, source), 0.02)
    assert all(line.mean < 1e-6 for line in back.report.parts)
    places = [global_positions(source, each) for each in (block, back.block)]
    left, right = (source.names.index(f"{side}_up_leg") for side in ("left", "right"))
    lines = [at[:, left] - at[:, right] for at in places]
    assert np.abs(lines[0] - lines[1]).max() < 0.11 * np.abs(lines[0]).max()


@pytest.mark.parametrize("degrees", [25.0, 90.0])
def test_hips_that_nothing_can_turn(degrees: float) -> None:
    """The joints of the target keep all but one axis: lines that point far elsewhere are told, or refused."""
    (source, block), (whole_target, _) = whole(connected(degrees)), whole(clip_of(person(3)))
    stiff = tuple(
        replace(
            joint,
            channels=tuple(channel for channel in joint.channels if channel not in ("Rx", "Ry")),
            rotation_order="Z",
        )
        if joint.name == "Root"
        else joint
        for joint in whole_target.joints
    )
    target = replace(whole_target, joints=stiff)
    matches = suggest_matches(source, target)
    if degrees > 45:
        with pytest.raises(ConversionError, match=r"hips would point 90 degrees elsewhere.*connector"):
            retarget(source, block, target, matches, 0.02)
        return
    made = retarget(source, block, target, matches, 0.02)
    assert [notice.what for notice in made.report.notices(source, target) if "hips point" in notice.what]
