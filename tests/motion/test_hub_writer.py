"""Channels made of rotations and translations: what was read comes back; what no channel holds is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from mcml.motion.clip import ClipStream, FrameBlock, full_shape
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import HubWriter, Known, angles_of
from mcml.motion.rotation_vectors import angle_between, from_vector, to_vector, twist
from mcml.motion.rotations import from_euler
from mcml.motion.skeleton import Array, Convention, Joint, Skeleton
from mcml.motion.units import reading_of
from tests import fuzz
from tests.formats.test_real_files import opened
from tests.motion.random_clips import ORDERS, random_clip

CONVENTIONS = [Convention.LISTED, Convention.FIXED, Convention.BASE]


def read_and_written(clip: ClipStream) -> tuple[Array, Array, HubWriter]:
    """(values read, values written, the writer), block by block."""
    reading = reading_of(clip.head)
    reader, writer = HubReader(clip.head.skeleton, reading), HubWriter(clip.head.skeleton, reading)
    before, after = [], []
    for block in clip.blocks():
        hub = reader.read(block)
        before.append(hub.values)
        after.append(writer.write(hub.translations, hub.rotations, hub.scales))
    return np.vstack(before), np.vstack(after), writer


def block_of(skeleton: Skeleton, values: Array) -> FrameBlock:
    columns = skeleton.columns()
    return FrameBlock(values, columns, (full_shape(columns),), np.arange(len(values), dtype=np.int64))


@pytest.mark.parametrize("convention", CONVENTIONS)
@given(seed=st.integers(0, 100_000), moving=st.booleans(), radians=st.booleans())
def test_what_was_read_means_the_same_when_written(
    convention: Convention, seed: int, moving: bool, radians: bool
) -> None:
    clip = random_clip(convention, seed, moving=moving, radians=radians and convention is not Convention.LISTED)
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    before, after, writer = read_and_written(clip)
    one = HubReader(skeleton, reading).read(block_of(skeleton, before))
    other = HubReader(skeleton, reading).read(block_of(skeleton, after))
    assert angle_between(one.rotations, other.rotations).max() < 1e-9
    assert np.abs(one.translations - other.translations).max() < 1e-9
    assert np.array_equal(one.scales, other.scales)
    assert writer.shortfall.angles.max() < 1e-9
    assert writer.shortfall.lengths.max() < 1e-9
    assert writer.shortfall.notices(skeleton) == []


@given(seed=st.integers(0, 100_000))
def test_angles_go_on_from_block_to_block(seed: int) -> None:
    """Angles that begin within a quarter turn and never leap come back as they are, past whole turns too."""
    rng = np.random.default_rng(seed)
    joint = Joint("j", -1, "j", Convention.LISTED, ("Rz", "Rx", "Ry"), "ZXY")
    skeleton = Skeleton((joint,))
    values = np.cumsum(np.vstack([rng.uniform(-30, 30, 3), rng.uniform((-4, -9, -14), (14, 9, 4), (200, 3))]), axis=0)
    values[:, 1] = 60 * np.sin(values[:, 1] / 60)
    hub = HubReader(skeleton).read(block_of(skeleton, values))
    writer = HubWriter(skeleton)
    parts = [
        writer.write(hub.translations[start:end], hub.rotations[start:end]) for start, end in ((0, 7), (7, 8), (8, 201))
    ]
    written = np.vstack(parts)
    written += np.round((values[0] - written[0]) / 360) * 360
    assert np.abs(written - values).max() < 1e-8


@pytest.mark.parametrize("name", ["asfamc/cmu02/02_lf_01.amc", "bvh/bandai/dataset-1_bow_old_001.bvh",
                                  "htr/xbot_walking.HTR", "htr/egnaro_skel_anim.htr", "trc/Anto.trc"])  # fmt: skip
def test_real_files_lose_nothing(shared: Path, name: str) -> None:
    clip = opened(shared / name)
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    before, after, writer = read_and_written(clip)
    one = HubReader(skeleton, reading).read(block_of(skeleton, before))
    other = HubReader(skeleton, reading).read(block_of(skeleton, after))
    assert angle_between(one.rotations, other.rotations).max() < 1e-9
    assert np.abs(one.translations - other.translations).max() < 1e-9 * max(1.0, np.abs(before).max())
    assert writer.shortfall.notices(skeleton) == []


@pytest.mark.parametrize("letters", ["X", "Y", "Z", "XY", "YX", "YZ", "ZY", "ZX", "XZ"])
@fuzz.examples(6)
@given(seed=st.integers(0, 100_000))
def test_fewer_channels_come_as_near_as_they_can(letters: str, seed: int) -> None:
    """Against SciPy's search for the nearest rotation that the channels can say."""
    rng = np.random.default_rng(seed)
    wanted = Rotation.random(random_state=rng)
    angles = angles_of(wanted.as_quat()[None], letters)[0]

    def distance(guess: Array) -> float:
        return float((Rotation.from_euler(letters, guess).inv() * wanted).magnitude())

    found = min(
        minimize(distance, rng.uniform(-np.pi, np.pi, len(letters)), method="Nelder-Mead").fun for _ in range(4)
    )
    assert distance(angles) <= found + 1e-6


@pytest.mark.parametrize("order", ORDERS)
def test_two_channels_say_exactly_what_they_can(order: str) -> None:
    grid = np.radians([(a, b) for a in range(-175, 180, 25) for b in range(-175, 180, 25)])
    rotations = from_euler(grid, order[:2])
    for rotation, expected in zip(rotations, grid, strict=True):
        for signed in (rotation, -rotation):
            assert np.abs(angles_of(signed[None], order[:2])[0] - expected).max() < 1e-12


def test_what_a_joint_cannot_hold_is_said() -> None:
    joint = Joint("knee", -1, "knee", Convention.LISTED, ("Tx", "Rx"), "X", translation="absolute")
    writer = HubWriter(Skeleton((joint,)))
    rotation = from_euler(np.radians([[30.0, 20.0]]), "XY")[:, None]
    values = writer.write(np.array([[[1.0, 2.0, 3.0]]]), rotation)
    assert values[0, 0] == 1.0
    assert np.degrees(writer.shortfall.angles[0]) == pytest.approx(20.0, abs=1e-9)
    assert writer.shortfall.lengths[0] == pytest.approx(np.hypot(2, 3))
    told = [notice.what for notice in writer.shortfall.notices(writer.skeleton)]
    assert "20 degrees" in told[0]
    assert "3.61" in told[1]


@pytest.mark.parametrize("convention", CONVENTIONS)
@given(seed=st.integers(0, 100_000))
def test_known_values_keep_their_bits_and_the_others_follow_them(convention: Convention, seed: int) -> None:
    clip = random_clip(convention, seed)
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    values = np.vstack([block.values for block in clip.blocks()])
    # Values that no decomposition gives: whole turns away.
    turned = values + np.where([channel in (3, 4, 5) for _, channel in skeleton.columns()], 720.0, 0.0)
    hub = HubReader(skeleton, reading).read(block_of(skeleton, turned))
    holds = np.random.default_rng(seed).random((len(values), len(skeleton))) < 0.5
    holds[0] = True
    written = HubWriter(skeleton, reading).write(
        hub.translations, hub.rotations, hub.scales, known=Known(turned, holds)
    )
    for column, (joint, _) in enumerate(skeleton.columns()):
        kept = holds[:, joint]
        assert np.array_equal(written[kept, column].view(np.int64), turned[kept, column].view(np.int64))
    again = HubReader(skeleton, reading).read(block_of(skeleton, written))
    assert angle_between(again.rotations, hub.rotations).max() < 1e-9
    assert np.abs(again.translations - hub.translations).max() < 1e-9


def test_residuals_of_markers_are_carried() -> None:
    point = Joint("m", -1, "m", Convention.MARKER, ("Tx", "Ty", "Tz", "residual"), translation="absolute")
    skeleton = Skeleton((point,))
    raw = np.array([[1.0, 2.0, 3.0, 0.25]])
    known = Known(raw, np.zeros((1, 1), dtype=bool))
    moved = np.array([[[5.0, 6.0, 7.0]]])
    rest = np.array([[[0.0, 0, 0, 1]]])
    assert HubWriter(skeleton).write(moved, rest, known=known).tolist() == [[5.0, 6.0, 7.0, 0.25]]
    assert HubWriter(skeleton).write(moved, rest).tolist() == [[5.0, 6.0, 7.0, 0.0]]


@given(seed=st.integers(0, 100_000))
def test_rotation_vectors_are_those_of_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turns = Rotation.random(8, random_state=rng) ** 1
    vectors = np.vstack([turns.as_rotvec(), turns.as_rotvec() * 1e-9, np.zeros((1, 3))])
    quaternions = from_vector(vectors)
    assert np.abs(angle_between(quaternions, Rotation.from_rotvec(vectors).as_quat())).max() < 1e-12
    assert np.abs(to_vector(quaternions) - vectors).max() < 1e-12
    assert np.abs(to_vector(-quaternions) - vectors).max() < 1e-12
    axis = np.eye(3)[seed % 3]
    angle = rng.uniform(-3.1, 3.1)
    assert twist(from_vector(axis * angle), axis) == pytest.approx(angle)
