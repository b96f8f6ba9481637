"""One motion in several conventions, mirrored: joints stand in the same places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import convert
from mcml.motion.edits.mirroring import mirrored
from mcml.motion.frames import joined
from mcml.motion.skeleton import Array, Convention
from mcml.motion.units import reading_of
from tests.builders import assign
from tests.formats.test_real_files import opened
from tests.motion.bodies.made import clip_of, named, person
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
    wanted, found = places(clip), places(convert(clip, form))
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
