"""A motion in the mirror: every joint stands where the mirror shows the other side's; twice is no change."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import ConversionError
from mcml.motion.clip import ClipStream, FrameBlock, full_shape
from mcml.motion.edits.mirroring import mirrored, own_plane
from mcml.motion.frames import joined
from mcml.motion.hub import HubReader, walked
from mcml.motion.rotation_vectors import angle_between
from mcml.motion.sides import Sagittal, is_left, partners, sagittal
from mcml.motion.skeleton import Array, Convention, Joint, Skeleton
from mcml.motion.units import reading_of
from tests import fuzz
from tests.builders import assign
from tests.formats.test_real_files import opened
from tests.poses import global_positions, rest_height

REAL = {
    "asfamc/cmu02/02_lf_01.amc": 0.02,
    "bvh/bandai/dataset-1_bow_old_001.bvh": 0.01,
    "bvh/bandai/dataset-1_walk_happy_001.bvh": 0.01,
    "bvh/dance/131_01.bvh": 0.03,
    "bvh/exporters/AV_8Walk_Meredith_HVHA_Rep1.bvh": 1e-9,
    "htr/xbot_walking.HTR": 0.025,
}
"""How far joints may miss their image, in heights: no body is quite symmetric, and bones keep their lengths."""


def named(clip: ClipStream) -> ClipStream:
    return replace(clip, head=replace(clip.head, skeleton=assign(clip.head.skeleton)))


def image(points: Array, plane: Sagittal) -> Array:
    return points - 2 * ((points - plane.point) @ plane.normal)[..., None] * plane.normal


def body(offsets: dict[str, tuple[str, list[float]]]) -> Skeleton:
    names = list(offsets)
    return Skeleton(
        tuple(
            Joint(
                name, names.index(parent) if parent else -1, name, Convention.LISTED,
                (() if parent else ("Tx", "Ty", "Tz")) + ("Rz", "Rx", "Ry"), "ZXY",
                offset=(repr(place[0]), repr(place[1]), repr(place[2])), translation="" if parent else "absolute",
            )
            for name, (parent, place) in offsets.items()
        )
    )  # fmt: skip


SYMMETRIC = body(
    {
        "Root": ("", [0.0, 0, 0]),
        "waist": ("Root", [0, 2.0, 0.1]),
        "left_up_arm": ("waist", [1.5, 3, 0.2]),
        "left_hand": ("left_up_arm", [4.0, -0.5, 0.3]),
        "right_up_arm": ("waist", [-1.5, 3, 0.2]),
        "right_hand": ("right_up_arm", [-4.0, -0.5, 0.3]),
        "left_up_leg": ("Root", [1.0, -0.5, 0.0]),
        "left_foot": ("left_up_leg", [0.3, -8.0, 0.5]),
        "right_up_leg": ("Root", [-1.0, -0.5, 0.0]),
        "right_foot": ("right_up_leg", [-0.3, -8.0, 0.5]),
    }
)


def block_of(skeleton: Skeleton, values: Array) -> FrameBlock:
    columns = skeleton.columns()
    return FrameBlock(values, columns, (full_shape(columns),), np.arange(len(values), dtype=np.int64))


@given(seed=st.integers(0, 100_000))
def test_a_symmetric_body_is_mirrored_exactly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    block = block_of(SYMMETRIC, rng.uniform(-180, 180, (5, len(SYMMETRIC.columns()))))
    normal = rng.normal(size=3)
    plane = Sagittal(normal / np.linalg.norm(normal), rng.normal(size=3))
    once = mirrored(SYMMETRIC, block, plane)
    other = [SYMMETRIC.names.index(swapped(name)) for name in SYMMETRIC.names]
    expected = image(global_positions(SYMMETRIC, block), plane)[:, other]
    assert np.abs(global_positions(SYMMETRIC, once.block) - expected).max() < 1e-9
    assert once.shortfall.notices(SYMMETRIC) == []


def swapped(name: str) -> str:
    if name.startswith("left"):
        return name.replace("left", "right")
    return name.replace("right", "left")


@pytest.mark.parametrize("name", REAL)
def test_real_bodies_are_nearly_their_image(shared: Path, name: str) -> None:
    clip = named(opened(shared / name))
    skeleton, reading, block = clip.head.skeleton, reading_of(clip.head), joined(clip.blocks())
    positions = global_positions(skeleton, block, reading)
    hub = HubReader(skeleton, reading).read(block)
    plane = own_plane(skeleton, hub.translations, hub.rotations, np.eye(3)[1], reading)
    edited = mirrored(skeleton, block, plane, reading=reading)
    after = global_positions(skeleton, edited.block, reading)
    height = rest_height(skeleton, reading=reading) if "bandai" not in name else np.ptp(positions[0, :, 1])
    missed = np.abs(after - image(positions, plane)[:, partners(skeleton)]).max()
    assert missed < REAL[name] * height
    # The default plane is the one of the first frame.
    assert np.array_equal(mirrored(skeleton, block, reading=reading).block.values, edited.block.values)


@pytest.mark.parametrize("name", REAL)
def test_twice_is_no_change(shared: Path, name: str) -> None:
    clip = named(opened(shared / name))
    skeleton, reading, block = clip.head.skeleton, reading_of(clip.head), joined(clip.blocks())
    twice = mirrored(skeleton, mirrored(skeleton, block, reading=reading).block, reading=reading)
    before, after = (HubReader(skeleton, reading).read(part) for part in (block, twice.block))
    assert angle_between(before.rotations, after.rotations).max() < 1e-8
    size = np.abs(before.translations).max()
    assert np.abs(before.translations - after.translations).max() < 1e-9 * size


@fuzz.examples(30)
@given(seed=st.integers(0, 100_000))
def test_sides_with_axes_of_their_own(seed: int) -> None:
    """A rig whose right side is built along opposite axes, turned at rest any way it likes."""
    rng = np.random.default_rng(seed)
    rig = body(
        {
            "Root": ("", [0.0, 0, 0]),
            "left_up_leg": ("Root", [-2.0, -6.0, 0]),
            "left_low_leg": ("left_up_leg", [39.0, 0, 0]),
            "left_foot": ("left_low_leg", [0.0, 12.0, 30.0]),
            "right_up_leg": ("Root", [-2.0, 6.0, 0]),
            "right_low_leg": ("right_up_leg", [-39.0, 0, 0]),
            "right_foot": ("right_low_leg", [0.0, -30.0, 12.0]),
        }
    )
    block = block_of(rig, rng.uniform(-180, 180, (4, len(rig.columns()))))
    plane = Sagittal(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    once = mirrored(rig, block, plane)
    other = [rig.names.index(swapped(name)) for name in rig.names]
    expected = image(global_positions(rig, block), plane)[:, other]
    assert np.abs(global_positions(rig, once.block) - expected).max() < 1e-4
    twice = mirrored(rig, once.block, plane).block
    before, after = (HubReader(rig).read(part) for part in (block, twice))
    assert angle_between(before.rotations, after.rotations).max() < 1e-9


def test_markers_and_their_gaps_change_sides() -> None:
    labels = ("LASI", "RASI", "C7")
    skeleton = Skeleton(
        tuple(Joint(name, -1, name, Convention.MARKER, ("Tx", "Ty", "Tz"), translation="absolute") for name in labels)
    )
    values = np.array([[1.0, 2, 3, -1.5, 2, 3, 0.2, 5, 3], [np.nan] * 3 + [-1.0, 2, 3, 0, 5, 3]])
    full = full_shape(skeleton.columns())
    shapes = (full, ((0, 0), *full[1:]))
    block = FrameBlock(values, skeleton.columns(), shapes, np.array([4, 5]), np.array([0, 1]))
    plane = Sagittal(np.array([1.0, 0, 0]), np.zeros(3))
    after = mirrored(skeleton, block, plane).block
    expected = np.array([[1.5, 2, 3, -1.0, 2, 3, -0.2, 5, 3], [1.0, 2, 3] + [np.nan] * 3 + [0, 5, 3]])
    assert np.array_equal(after.values, expected, equal_nan=True)
    assert after.shape_of is not None
    assert dict(after.shapes[int(after.shape_of[1])]) == {0: 7, 1: 0, 2: 7}
    assert list(after.ids) == [4, 5]


def test_which_joint_is_the_other_sides() -> None:
    names = ["Hips", "Bip01 L Thigh", "Bip01 R Thigh", "lfoot", "rfoot", "lowerback", "Hand_L", "Hand_R", "armL",
             "armR", "LeftToe", "RightToe", "root", "LFIN", "RFIN", "leftover"]  # fmt: skip
    skeleton = Skeleton(
        tuple(Joint(name, 0 if place else -1, name, Convention.LISTED) for place, name in enumerate(names))
    )
    other = [names[int(place)] for place in partners(skeleton)]
    assert other == ["Hips", "Bip01 R Thigh", "Bip01 L Thigh", "rfoot", "lfoot", "lowerback", "Hand_R", "Hand_L",
                     "armR", "armL", "RightToe", "LeftToe", "root", "RFIN", "LFIN", "leftover"]  # fmt: skip
    sides = {names[i]: is_left(skeleton, i, int(p)) for i, p in enumerate(partners(skeleton)) if p != i}
    assert {name for name, left in sides.items() if left} == {
        "Bip01 L Thigh",
        "lfoot",
        "Hand_L",
        "armL",
        "LeftToe",
        "LFIN",
    }


def test_a_body_without_sides_must_be_told_where_it_faces() -> None:
    skeleton = body({"Root": ("", [0.0, 0, 0]), "Head": ("Root", [0.0, 5, 0])})
    block = block_of(skeleton, np.array([[1.0, 2, 3, 10, 20, 30, 5, 5, 5]]))
    with pytest.raises(ConversionError):
        mirrored(skeleton, block)
    hub = HubReader(skeleton).read(block)
    pose = walked(skeleton, hub.translations, hub.rotations)[0][0]
    plane = sagittal(skeleton, pose, np.eye(3)[1], np.eye(3)[2])
    assert plane.normal.tolist() == [1.0, 0.0, 0.0]
    after = global_positions(skeleton, mirrored(skeleton, block, plane).block)
    assert np.abs(after[0] - image(pose, plane)).max() < 1e-9
