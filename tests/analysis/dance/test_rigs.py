"""Dances of one motion written with other trees: what a rig has beside its body changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from mcml.formats import FORMATS
from mcml.motion.hub import walked
from mcml.motion.skeleton import Array
from mcml.testing import written
from mcml_schemas.analyses.dance import BeatsParameters, DanceParameters
from mcml_service.analysis.dance.analyses import BEATS, DANCE
from mcml_service.analysis.interface import Motion, silent
from mcml_service.demo.dance_clips import dance_clip
from tests.analysis.dance.motions import motion_of
from tests.motion.bodies.made import clip_of, named
from tests.motion.bodies.rewritten_trees import read_tree, rewrite, write_tree


def beats(motion: Motion) -> list[list[float]]:
    parts = BEATS.run([motion], BeatsParameters(), silent)
    return [[float(number) for number in row[2:4]] for row in parts["beats"].data["rows"]]


def dance(motion: Motion) -> dict[str, Array]:
    """Places (F, 3) of joints by name."""
    clip = DANCE.run([motion], DanceParameters(bpm=120, bars=6, stride=1), silent)["clip"].clip
    assert clip is not None
    places, _ = walked(clip.skeleton, clip.translations, clip.rotations)
    return {name: places[:, index] for index, name in enumerate(clip.skeleton.names)}


@pytest.mark.parametrize("way", ["children in another order", "links", "twist helpers", "root of an engine"])
def test_helpers_and_engine_roots_change_no_dance(way: str) -> None:
    made = dance_clip("groove", bars=12, seed=3)
    tree = read_tree(written(FORMATS["bvh"], made.clip)["bvh"].decode(), most=5000)
    one, two = (motion_of(named(clip_of(text.encode()))) for text in (write_tree(tree), rewrite(tree, way, 1)))
    np.testing.assert_allclose(beats(two), beats(one), atol=1e-3)
    wanted, found = dance(one), dance(two)
    size = max(np.ptp(each) for each in wanted.values())
    for name in wanted:
        np.testing.assert_allclose(found[name], wanted[name], atol=5e-3 * size, err_msg=name)
    if way == "root of an engine":
        # The root goes over the floor with the body.
        np.testing.assert_allclose(found["root"][:, ::2], wanted["Root"][:, ::2], atol=5e-3 * size)
