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
def test_rest_poses_of_nothing_are_refused(which: str) -> None:
    """Where joints are comes with the motion: at rest all stand in one point."""
    bodies = [clip_of(person(3)), clip_of(floating(4))]
    (source, block), (target, _) = map(whole, bodies if which == "target" else bodies[::-1])
    with pytest.raises(ConversionError, match=f"rest pose of the {which} does not show"):
        retarget(source, block, target, suggest_matches(source, target), 1 / 60)


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
    small = tuple(replace(joint, offset=("0", "0.1", "0")) if joint.parent >= 0 else joint for joint in source.joints)
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
    if degrees > 45:
        with pytest.raises(ConversionError, match=r"hips would point 90 degrees elsewhere.*connector"):
            retarget(source, block, target, matches, 0.02)
        return
    made = retarget(source, block, target, matches, 0.02)
    told = [notice.what for notice in made.report.notices(source, target) if "hips point" in notice.what]
    assert bool(told) == (degrees > 10)
