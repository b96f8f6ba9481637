"""Real files: people are complete, what is none has no names, and clips of a skeleton share one recognition."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mcml.errors import McmlError
from mcml.motion.clip import ClipStream
from mcml.motion.rigs.recognise import NOBODY, PERSON, recognise
from mcml.motion.rigs.skeletons import recognise_clip, rig_of
from tests.formats.test_real_files import opened
from tests.motion.rigs.rig_builder import CORE

NO_HEAD = {"video2bvh_cxk.bvh"}
"""Their files name no joint of a head."""
NO_BODIES = {
    "Chicken_TPOSE.bvh", "full_precision_frame_time.bvh", "rotation_first_root.bvh", "sinusoidal.bvh",
    "test_simple.bvh",
}  # fmt: skip
"""A bird, and files of two to four joints."""


def clips(folder: Path) -> Iterator[tuple[str, ClipStream]]:
    """One BVH of each tree of names."""
    seen = set()
    for path in sorted(folder.rglob("*.bvh")):
        try:
            clip = opened(path)
        except McmlError:
            continue
        key = tuple((joint.source_name, joint.parent) for joint in clip.head.skeleton.joints)
        if key not in seen:
            seen.add(key)
            yield path.name, clip


def test_people_in_bvh_are_complete(shared: Path) -> None:
    for name, clip in clips(shared / "bvh"):
        found = recognise_clip(clip)
        if name in NO_BODIES:
            assert found.joints == (), name
            continue
        assert found.verdict == PERSON, name
        missing = set(CORE) - {each.name for each in found.joints}
        assert missing == ({"Head"} if name in NO_HEAD else set()), name
        assert not any("left" in sentence for sentence in found.told), name


def test_a_creature_with_four_arms_is_no_person(shared: Path) -> None:
    found = recognise_clip(opened(shared / "htr" / "egnaro_skel_anim.htr"))
    assert (found.verdict, found.reason) == (NOBODY, "it has more than two arms")


def test_names_taken_away_leave_no_wrong_side(shared: Path) -> None:
    """By tree and rest pose alone four of five joints are named, and nearly all of these rightly."""
    right = wrong = missing = 0
    for _, clip in clips(shared / "bvh"):
        rig = rig_of(clip.head.skeleton)
        named = {each.joint: each.name for each in recognise(rig).joints if each.name in CORE}
        if len(named) < 12:
            continue
        bare = replace(rig, names=[f"j{number}" for number in range(len(rig))])
        found = {each.joint: each.name for each in recognise(bare).joints if each.name in CORE}
        right += sum(named.get(joint) == name for joint, name in found.items())
        wrong += sum(named.get(joint) != name for joint, name in found.items())
        missing += len(named.keys() - found.keys())
        sides = {joint: name.partition("_")[0] for joint, name in named.items() if "_" in name}
        assert all(sides.get(joint, name.partition("_")[0]) == name.partition("_")[0]
                   for joint, name in found.items() if "_" in name)  # fmt: skip
    assert right / (right + wrong) > 0.95
    assert right / (right + missing) > 0.7


def test_frames_are_read_once_for_the_clips_of_a_skeleton(shared: Path) -> None:
    clip = opened(shared / "bvh" / "bandai" / "dataset-1_bow_angry_001.bvh")
    first = clip.head.skeleton.joints[0]
    other = replace(clip.head.skeleton, joints=(replace(first, source_name="mover"), *clip.head.skeleton.joints[1:]))
    reads: list[int] = []

    def counted() -> ClipStream:
        def blocks() -> Iterator:  # type: ignore[type-arg]
            reads.append(1)
            return clip.blocks()

        return ClipStream(replace(clip.head, skeleton=replace(other)), blocks, clip.frames)

    assert recognise_clip(counted()) == recognise_clip(counted())
    assert reads == [1]


@pytest.mark.parametrize("far", [1e200, np.inf])
def test_places_that_are_no_numbers_count_as_no_lengths(far: float, shared: Path) -> None:
    skeleton = opened(shared / "bvh" / "dance" / "A_test.bvh").head.skeleton
    far_off = replace(skeleton.joints[3], offset=(str(far), "0", "0"))
    rig = rig_of(replace(skeleton, joints=(*skeleton.joints[:3], far_off, *skeleton.joints[4:])))
    assert not rig.has_lengths
    assert {each.name for each in recognise(rig).joints} >= set(CORE)
