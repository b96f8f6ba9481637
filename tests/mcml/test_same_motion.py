"""One motion in several formats, units, axes and trees: every question about the body has the same answer."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from mcml.errors import McmlError
from mcml.files.motion import Motion, convert, read
from mcml.motion.bodies.limb_angles import angle_names
from mcml.motion.skeleton import Array
from tests.motion.bodies.made import person
from tests.motion.bodies.rewritten_trees import REWRITES, Tree, add_fingers, read_tree, rewrite, write_tree

JOINTS = ("Head", "left_hand", "right_foot", "Root")
ACTIVITIES = ("walk", "run", "turn left", "jump", "wave", "sit")
WRITTEN: dict[str, dict[str, str]] = {
    "glb": {"to": "glb"},
    "usd": {"to": "usd"},
    "htr": {"to": "htr"},
    "asf": {"to": "asf-amc"},
    "bvh in metres": {"for_": "blender"},
    "unreal": {"for_": "unreal"},
    "maya": {"for_": "maya"},
}
STEP = 3e-4
"""Metres: positions are rounded to 1/10,000 of a leg, and formats have fewer digits."""
DEGREES = 0.15


def answers(motion: Motion) -> Iterator[tuple[str, str, Array | str]]:
    """(kind, question, answer or error)."""
    asked: list[tuple[str, str, Callable[[], Array]]] = []
    for joint in JOINTS:
        asked += [
            ("height", f"height of {joint}", partial(motion.height, joint)),
            ("speed", f"speed of {joint}", partial(motion.speed, joint)),
            ("acceleration", f"acceleration of {joint}", partial(motion.acceleration, joint)),
        ]
        asked += [
            ("position", f"{axis} of {joint}", partial(motion.position, joint, axis, "Root"))
            for axis in ("front", "left", "up")
        ]
    asked += [("angle", name, partial(motion.angle, name)) for name in angle_names()]
    asked += [("is", f"contact {side}", partial(motion.contact, side)) for side in ("left", "right", "left_hand")]
    asked += [("is", name, partial(motion.activity, name)) for name in ACTIVITIES]
    for kind, question, ask in asked:
        try:
            yield kind, question, np.asarray(ask(), dtype=float)
        except McmlError as error:
            yield kind, question, error.what


def compare(path: Path, folder: Path, form: str, **stated: str) -> None:
    written = convert(path, folder / "made", **stated, **WRITTEN[form])
    before = read(path, **stated)
    # ASF and AMC state no rate.
    compare_answers(before, read(written, frame_time=before.frame_time if form == "asf" else None))


def compare_answers(before: Motion, after: Motion) -> None:
    for (kind, question, ours), (_, _, theirs) in zip(answers(before), answers(after), strict=True):
        if isinstance(ours, str) or isinstance(theirs, str):
            assert ours == theirs, question
            continue
        if kind == "angle":
            theirs = ours + (theirs - ours + 180) % 360 - 180
        rate = 1 / (before.frame_time or 1.0)
        allowed = {"angle": DEGREES, "speed": STEP * rate, "acceleration": 2 * STEP * rate**2, "is": 0.0}
        np.testing.assert_allclose(theirs, ours, atol=allowed.get(kind, STEP), err_msg=question)


@pytest.mark.parametrize("form", WRITTEN)
@pytest.mark.parametrize("seed", range(3))
def test_answers_are_those_of_the_original(tmp_path: Path, seed: int, form: str) -> None:
    (tmp_path / "a.bvh").write_bytes(person(seed, 60))
    compare(tmp_path / "a.bvh", tmp_path, form, unit="cm", up="Y")


@pytest.mark.parametrize("way", REWRITES)
def test_answers_do_not_depend_on_the_tree(tmp_path: Path, way: str) -> None:
    tree = read_tree(person(1, 60).decode())
    add_fingers(tree)
    compare_trees(tree, way, tmp_path)


def compare_trees(tree: Tree, way: str, folder: Path) -> None:
    (folder / "one.bvh").write_text(write_tree(tree))
    before = read(folder / "one.bvh")
    for seed in range(3):
        (folder / "two.bvh").write_text(rewrite(tree, way, seed))
        compare_answers(before, read(folder / "two.bvh"))


REAL = ["rokoko_jesse_dance", "mixamo_freebvh", "blender_walk01", "mocapbank_crlf"]


@pytest.mark.slow
@pytest.mark.parametrize("way", REWRITES)
@pytest.mark.parametrize("name", [*REAL, "cmu_jumping_jacks", "olympe_root"])
def test_answers_about_real_files_do_not_depend_on_the_tree(shared: Path, tmp_path: Path, name: str, way: str) -> None:
    tree = read_tree((shared / f"bvh/exporters/{name}.bvh").read_text(), most=100)
    compare_trees(tree, way, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("form", WRITTEN)
@pytest.mark.parametrize("name", REAL)
def test_answers_about_real_files_are_those_of_the_original(shared: Path, tmp_path: Path, name: str, form: str) -> None:
    compare(shared / f"bvh/exporters/{name}.bvh", tmp_path, form)
