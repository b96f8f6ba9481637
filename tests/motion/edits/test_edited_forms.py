"""One motion in several conventions and trees, edited: joints stand in the same places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcml.motion.carriers import carriers
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import convert
from mcml.motion.edits.looping import close_loop
from mcml.motion.edits.mirroring import mirrored
from mcml.motion.frames import joined
from mcml.motion.hub import HubReader
from mcml.motion.skeleton import Array, Convention
from mcml.motion.units import reading_of
from tests.builders import assign
from tests.formats.test_real_files import opened
from tests.motion.bodies.made import clip_of, named, person
from tests.motion.bodies.rewritten_trees import REWRITES, add_fingers, read_tree, rewrite, write_tree
from tests.poses import global_positions

FORMS = (Convention.FIXED, Convention.BASE)
REAL = (
    "bvh/bandai/dataset-1_walk_normal_001.bvh",
    "bvh/exporters/rokoko_jesse_dance.bvh",
    "bvh/exporters/mixamo_freebvh.bvh",
)


def places(clip: ClipStream) -> dict[str, Array]:
    """(n, 3) of each joint in the mirror but the root, by its name in the source: in ASF the root is where hips are."""
    skeleton, reading = assign(clip.head.skeleton), reading_of(clip.head)
    made = mirrored(skeleton, joined(clip.blocks()), reading=reading)
    positions = global_positions(skeleton, made.block, reading)
    return {joint.source_name: positions[:, index] for index, joint in enumerate(skeleton.joints) if index}


def compare(clip: ClipStream, form: Convention) -> None:
    compare_places(places(clip), places(convert(clip, form)))


def compare_places(wanted: dict[str, Array], found: dict[str, Array]) -> None:
    shared = [name for name in wanted if name in found]
    assert len(shared) >= len(wanted) - 1
    size = max(np.ptp(each) for each in wanted.values())
    for name in shared:
        np.testing.assert_allclose(found[name], wanted[name], atol=1e-4 * size, err_msg=name)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("form", FORMS)
def test_made_bodies(form: Convention, seed: int) -> None:
    compare(named(clip_of(person(seed, 20))), form)


@pytest.mark.parametrize("name", REAL)
@pytest.mark.parametrize("form", FORMS)
def test_real_bodies(shared: Path, form: Convention, name: str) -> None:
    compare(opened(shared / name), form)


@pytest.mark.parametrize("way", [*REWRITES][:-1])
def test_other_trees(way: str) -> None:
    tree = read_tree(person(2, 20).decode())
    add_fingers(tree)
    wanted = places(named(clip_of(write_tree(tree).encode())))
    for seed in range(2):
        compare_places(wanted, places(named(clip_of(rewrite(tree, way, seed).encode()))))


@pytest.mark.parametrize("way", [*REWRITES][:-1])
def test_cuts_and_travel_of_other_trees(way: str) -> None:
    """Where a loop is cut, and who moves the body."""
    tree = read_tree(person(2, 60).decode())
    loops, ways = [], []
    for text in (write_tree(tree), rewrite(tree, way, 0), rewrite(tree, way, 1)):
        skeleton, block = (clip := named(clip_of(text.encode()))).head.skeleton, joined(clip.blocks())
        loop = close_loop(skeleton, block, 1 / 60, 0.1, 0.3)
        loops.append((loop.first, loop.last))
        ways.append(skeleton.names[carriers(skeleton, HubReader(skeleton).read(block).translations)[0]])
    assert loops[0] == loops[1] == loops[2]
    assert ways == ["Root"] * 3


def test_a_link_that_turns_on_one_side_alone() -> None:
    """The same places as without it, whichever side has the link, and twice is no change."""
    tree = read_tree(person(4, 20).decode())
    plain = places(named(clip_of(write_tree(tree).encode())))
    thigh = next(node for node in tree.root.walk() if node.name == "left_up_leg")
    pelvis = next(node for node in tree.root.walk() if thigh in node.children)
    # The rotations of the thigh are the link's.
    link = tree.still("left_link", thigh.offset, thigh)
    link.values, link.channels, thigh.values = thigh.values, list(thigh.channels), np.zeros_like(thigh.values)
    thigh.offset = [0.0, 0.0, 0.0]
    pelvis.children[pelvis.children.index(thigh)] = link
    clip = named(clip_of(write_tree(tree).encode()))
    compare_places(plain, places(clip))
    skeleton, once = clip.head.skeleton, joined(clip.blocks())
    for _ in range(2):
        once = mirrored(skeleton, once).block
    before, after = (
        global_positions(skeleton, block, reading_of(clip.head)) for block in (joined(clip.blocks()), once)
    )
    np.testing.assert_allclose(after, before, atol=1e-6)
