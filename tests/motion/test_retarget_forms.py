"""A motion retargeted is the same in every convention, and for every tree, that source and target are written in."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from mcml.motion.clip import ClipStream
from mcml.motion.frames import joined
from mcml.motion.retargeting.bone_mapping import suggest_matches
from mcml.motion.retargeting.retarget import retarget
from mcml.motion.skeleton import Array, Convention
from mcml.motion.units import reading_of
from tests.motion.bodies.made import clip_of, named, person
from tests.motion.bodies.rewritten_trees import REWRITES, add_fingers, read_tree, rewrite, write_tree
from tests.poses import global_positions

FORMS = (Convention.LISTED, Convention.FIXED, Convention.BASE)


@cache
def body(seed: int, scale: float, form: Convention) -> ClipStream:
    """A person with names of MCML's, whose bones have other lengths and directions at rest than another seed's."""
    chance = np.random.default_rng(seed)

    def shift(line: str) -> str:
        if "OFFSET" not in line:
            return line
        numbers = np.array(line.split()[1:], float)
        shifted = numbers + chance.normal(0, 0.12 * np.linalg.norm(numbers), 3)
        return f"OFFSET {' '.join(f'{number:.6f}' for number in shifted)}"

    lines = person(seed, 24, scale=scale).decode().split("\n")
    return named(clip_of("\n".join(map(shift, lines)).encode(), form))


def places(source: ClipStream, target: ClipStream) -> dict[str, Array]:
    """(n, 3) of each joint of the target that has a name of MCML's, under the motion of the source."""
    one, two = source.head.skeleton, target.head.skeleton
    made = retarget(
        one, joined(source.blocks()), two, suggest_matches(one, two), 1 / 60,
        reading=reading_of(source.head), target_reading=reading_of(target.head),
        target_block=joined(target.blocks()),
    )  # fmt: skip
    positions = global_positions(two, made.block, reading_of(target.head))
    return {joint.name: positions[:, index] for index, joint in enumerate(two.joints) if joint.mapped}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("other", FORMS)
def test_the_joints_stand_in_the_same_places(form: Convention, other: Convention, seed: int) -> None:
    wanted = places(body(seed, 1.0, Convention.LISTED), body(seed + 7, 1.3, Convention.LISTED))
    found = places(body(seed, 1.0, form), body(seed + 7, 1.3, other))
    shared = wanted.keys() & found.keys()
    assert {"Root", "Head", "left_hand", "right_foot", "waist"} <= shared
    size = max(np.ptp(each) for each in wanted.values())
    for name in shared:
        np.testing.assert_allclose(found[name], wanted[name], atol=1e-5 * size, err_msg=name)


@pytest.mark.parametrize("side", ["source", "target"])
@pytest.mark.parametrize("way", REWRITES)
def test_the_joints_stand_in_the_same_places_for_every_tree(way: str, side: str) -> None:
    trees = [read_tree(person(seed, 24, scale=scale).decode()) for seed, scale in ((3, 1.0), (9, 1.3))]
    for tree in trees:
        add_fingers(tree)
    one, two = (named(clip_of(write_tree(tree).encode())) for tree in trees)
    wanted = places(one, two)
    size = max(np.ptp(each) for each in wanted.values())
    for seed in range(2):
        made = named(clip_of(rewrite(trees[side == "target"], way, seed).encode()))
        found = places(made, two) if side == "source" else places(one, made)
        assert found.keys() >= wanted.keys()
        for name in wanted:
            np.testing.assert_allclose(found[name], wanted[name], atol=1e-5 * size, err_msg=name)
