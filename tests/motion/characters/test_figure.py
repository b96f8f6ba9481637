"""The figure: of every rig of a person, in every rest pose, and in motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import mcml
from mcml.errors import ConversionError
from mcml.motion.bodies.clip_body import calibrate_clip
from mcml.motion.characters.figure import bind_character
from mcml.motion.kinematics import Walker, rest_positions
from mcml.motion.pictures.figures import axis_of
from mcml.motion.rotations import multiply
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.skin import Character
from mcml.motion.units import DEGREES, reading_of
from tests import fuzz
from tests.formats.scenes.clips import CLIPS
from tests.motion.bodies.made import clip_of
from tests.motion.bodies.made import person as walker
from tests.motion.characters.checks import check_limbs, check_mesh, check_weights
from tests.motion.characters.rigs import HANGING, REST, SLOPING, divide, pose_rig, rig
from tests.motion.rigs.rig_builder import USUAL, mirrored

FINGERS = USUAL | mirrored(
    {"left_wrist": "LeftWrist", "left_finger_one": "LeftThumb", "left_finger_three": "LeftMiddle"},
    [("Left", "Right")],
)
WITHOUT = [
    ("toes", ("left_toes", "right_toes")), ("collars", ("left_shoulder", "right_shoulder")), ("neck", ("neck1",)),
    ("head", ("Head",)), ("spine", ("waist", "torso2")),
]  # fmt: skip
REAL = [
    "bvh/bandai/dataset-1_bow_angry_001.bvh", "bvh/dance/131_01.bvh", "asfamc/cmu02/02_lf_01.amc",
    "bvh/exporters/perception_neuron_milad.bvh", "bvh/exporters/mixamo_freebvh.bvh",
    "bvh/exporters/rokoko_jesse_dance.bvh", "bvh/exporters/classic_example1.bvh", "bvh/exporters/bvh_test1.bvh",
    "bvh/exporters/AV_8Walk_Meredith_HVHA_Rep1.bvh", "bvh/exporters/cmu_daz_walk.bvh",
    "fbx/jog_max_biped_7400.fbx", "fbx/arnaud_rig_7500.fbx", "fbx/cmu_07_01_blender_7400.fbx",
    "glb/CesiumMan.gltf", "htr/xbot_jump_m_mixamo.com.htr",
]  # fmt: skip


def size_of(skeleton: Skeleton) -> float:
    return float(np.ptp(rest_positions(skeleton), axis=0).max())


def random_pose(skeleton: Skeleton, seed: int, frames: int = 4) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    turns = {name: Rotation.from_rotvec(rng.uniform(-0.7, 0.7, (frames, 3))) for name in skeleton.names}
    return pose_rig(skeleton, turns, frames)


@pytest.mark.parametrize("bent", [{}, HANGING, SLOPING], ids=["T", "hanging", "A"])
@pytest.mark.parametrize("names", [USUAL, FINGERS], ids=["usual", "fingers"])
def test_every_rest_pose_has_a_figure(bent: dict[str, Rotation], names: dict[str, str]) -> None:
    skeleton = rig(names, bent)
    made = bind_character(skeleton, DEGREES, REST)
    check_mesh(made)
    check_weights(made, skeleton)
    check_limbs(made, skeleton, *random_pose(skeleton, 1), size_of(skeleton))


def test_in_the_pose_it_is_bound_in_nothing_moves() -> None:
    skeleton = rig()
    made = bind_character(skeleton, DEGREES, REST)
    moved = made.move(*pose_rig(skeleton, {}))[0]
    assert np.abs(moved - made.points).max() < 1e-9 * size_of(skeleton)


def test_a_body_that_is_carried_away_carries_its_figure() -> None:
    skeleton = rig()
    made = bind_character(skeleton, DEGREES, REST)
    positions, rotations = random_pose(skeleton, 2)
    turn, shift = Rotation.from_euler("yxz", [70, 20, -35], degrees=True), np.array([300.0, -20.0, 45.0])
    carried = made.move(
        turn.apply(positions.reshape(-1, 3)).reshape(positions.shape) + shift, multiply(turn.as_quat(), rotations)
    )
    expected = made.move(positions, rotations)
    expected = turn.apply(expected.reshape(-1, 3)).reshape(expected.shape) + shift
    assert np.abs(carried - expected).max() < 1e-9 * size_of(skeleton)


@pytest.mark.parametrize(("bent", "back"), [(HANGING, 80), (SLOPING, 40)], ids=["hanging", "A"])
def test_arms_are_the_same_whatever_they_do_at_rest(bent: dict[str, Rotation], back: float) -> None:
    """A rig with hanging arms that raises them looks as one whose rest pose has them raised: hands have their palms
    down, none is turned about its forearm."""
    straight, other = rig(), rig(bent=bent)
    expected = bind_character(straight, DEGREES, REST)
    made = bind_character(other, DEGREES, REST)
    raised = {name: turn.inv() for name, turn in bent.items()}
    moved = made.move(*pose_rig(other, raised))[0]
    assert np.array_equal(made.faces, expected.faces)
    hands = [straight.names.index(f"{side}_hand") for side in ("left", "right")]
    own = np.isin(made.joints[:, 0], hands)
    assert own.sum() > 100
    assert np.abs(moved[own] - expected.points[own]).max() < 0.002 * size_of(straight)


@pytest.mark.parametrize(("what", "left_out"), WITHOUT, ids=[what for what, _ in WITHOUT])
def test_joints_that_a_rig_lacks_are_not_needed(what: str, left_out: tuple[str, ...]) -> None:
    skeleton = rig({name: own for name, own in USUAL.items() if name not in left_out})
    made = bind_character(skeleton, DEGREES, REST)
    check_mesh(made)
    check_weights(made, skeleton)
    tall = np.ptp(made.points[:, 1])
    assert 150 < tall < 195, what
    # Without its joint the head is a neck's length above all bones.
    check_limbs(
        made, skeleton, *random_pose(skeleton, 3), size_of(skeleton), reach=0.19 if "Head" in left_out else 0.14
    )


@fuzz.examples(6)
@given(
    st.sampled_from(["Root", "waist", "torso7", "left_up_arm", "left_low_leg", "right_low_arm"]),
    st.integers(2, 5),
    st.integers(0, 1000),
)
def test_bones_of_several_pieces_are_one_limb(above: str, pieces: int, seed: int) -> None:
    """In a pose that leaves the pieces straight, the figure is nearly where it is without them."""
    plain = rig()
    skeleton = divide(plain, above, pieces)
    made = bind_character(skeleton, DEGREES, REST)
    check_mesh(made)
    check_weights(made, skeleton)
    expected = bind_character(plain, DEGREES, REST)
    assert np.abs(made.points - expected.points).max() < 1e-6 * size_of(plain)
    check_limbs(made, skeleton, *random_pose(skeleton, seed), size_of(plain))


@fuzz.examples(8)
@given(st.floats(1e-3, 1e3), st.integers(0, 1000))
def test_the_unit_changes_nothing_but_the_size(size: float, seed: int) -> None:
    small, large = rig(), rig(size=size)
    one, other = (bind_character(each, DEGREES, REST) for each in (small, large))
    assert np.array_equal(one.faces, other.faces)
    moved, grown = (each.move(*random_pose(skeleton, seed)) for each, skeleton in ((one, small), (other, large)))
    # Offsets are texts of six digits.
    assert np.abs(moved * size - grown).max() < 1e-4 * size * size_of(small)


def test_the_figure_stands_on_the_ground_and_looks_ahead() -> None:
    skeleton = rig()
    made = bind_character(skeleton, DEGREES, REST)
    assert abs(made.points[:, 1].min()) < 3, "soles below the toes, which are 2 cm above the ground"
    assert 175 < made.points[:, 1].max() < 192, "the crown"
    feet = made.points[:, 1] < 5
    assert made.points[feet, 2].max() > 2.5 * -made.points[feet, 2].min()
    # The nose.
    head = made.joints[:, 0] == skeleton.names.index("Head")
    x, _, z = made.points[head][np.argmax(made.points[head, 2])]
    assert abs(x) < 0.1
    assert z > 10
    left = made.joints[:, 0] == skeleton.names.index("left_hand")
    assert (made.points[left, 0] > 60).all()


def test_a_figure_is_nearly_the_same_on_both_sides() -> None:
    made = bind_character(rig(), DEGREES, REST)
    mirror = made.points * (-1, 1, 1)
    away = np.linalg.norm(mirror[:, None] - made.points[None], axis=2).min(axis=1)
    assert away.max() < 2.5, "centimetres, of vertices that are at other places around their rings"
    assert np.median(away) < 0.2


@pytest.mark.parametrize(
    ("left_out", "reason"),
    [
        (("left_hand", "right_hand"), "left_hand, right_hand"),
        (("Head", "neck1"), "Head"),
        (("left_up_leg", "left_low_leg", "left_foot", "left_toes"), "left_up_leg, left_low_leg, left_foot"),
    ],
)
def test_missing_joints_are_named(left_out: tuple[str, ...], reason: str) -> None:
    skeleton = rig({name: own for name, own in USUAL.items() if name not in left_out})
    with pytest.raises(ConversionError, match=reason):
        bind_character(skeleton, DEGREES, REST)


def test_markers_and_chains_have_no_figure() -> None:
    with pytest.raises(ConversionError, match="Markers have no bones"):
        bind_character(CLIPS["trc"]().head.skeleton, DEGREES, REST)
    with pytest.raises(ConversionError, match=r"not recognised: left_up_arm, .* and 6 more"):
        bind_character(CLIPS["chain"]().head.skeleton, DEGREES, REST)


def test_joints_in_one_place_have_no_figure() -> None:
    skeleton = rig(size=0.0)
    with pytest.raises(ConversionError):
        bind_character(skeleton, DEGREES, REST)


def test_it_is_the_same_each_time() -> None:
    one, other = (bind_character(rig(), DEGREES, REST) for _ in range(2))
    assert np.array_equal(one.points, other.points)
    assert np.array_equal(one.weights, other.weights)


def moved_clip(path: Path) -> tuple[Skeleton, Character, Array, Array]:
    skeletons = [path.parent / "02_lf.asf"] if path.suffix == ".amc" else []
    motion = mcml.read([*skeletons, path])
    clip = motion._clip
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    start = calibrate_clip(clip, len(motion)).start
    rows = np.linspace(0, len(motion) - 1, 5).astype(int)
    positions, rotations = (np.asarray(motion.frames(space=space))[rows] for space in ("positions", "rotations"))
    return skeleton, bind_character(skeleton, reading, start), positions, rotations


@pytest.mark.parametrize("name", REAL)
def test_rigs_of_real_files_have_a_figure(shared: Path, name: str) -> None:
    skeleton, made, positions, rotations = moved_clip(shared / name)
    check_mesh(made)
    check_weights(made, skeleton)
    tall = float(np.ptp(positions[0], axis=0).max())
    size = max(tall, float(np.ptp(made.places, axis=0).max()))
    # Some files give each joint its place in every frame: their bones are a little longer or shorter then.
    check_limbs(made, skeleton, positions, rotations, size, loose=1e-3)


@pytest.mark.parametrize(
    "name",
    [
        "asfamc/cmu02/02_lf_01.amc",  # rests with the legs apart
        "bvh/bandai/dataset-1_walk_normal_001.bvh",  # is bound in a step
        "fbx/jog_max_biped_7400.fbx",  # rests in a run
        "bvh/exporters/mixamo_freebvh.bvh",
    ],
)
def test_soles_are_level_while_feet_stand(shared: Path, name: str) -> None:
    motion = mcml.read([*([shared / "asfamc/cmu02/02_lf.asf"] if name.endswith("amc") else []), shared / name])
    clip = motion._clip
    reading, start = reading_of(clip.head), calibrate_clip(clip, len(motion)).start
    made = bind_character(clip.head.skeleton, reading, start)
    positions, rotations = (np.asarray(motion.frames(space=space)) for space in ("positions", "rotations"))
    up = axis_of(start.up)
    for side in ("left", "right"):
        foot = motion.bones.index(f"{side}_foot")
        height = positions[:, foot] @ up
        standing = height < np.quantile(height, 0.2)
        # Vertices of the sole have normals that point away from the ankle: the lowest in the frame of the foot.
        own = np.flatnonzero((made.joints[:, 0] == foot) & (made.weights[:, 0] > 0.99))
        moved = made.move(positions[standing], rotations[standing])[:, own]
        faces = made.faces[np.isin(made.faces, own).all(axis=1)]
        place = np.full(len(made.points), -1)
        place[own] = np.arange(len(own))
        a, b, c = (moved[:, place[faces[:, corner]]] for corner in range(3))
        across = np.cross(b - a, c - a)
        # The largest flat part of a foot is its sole.
        down = across[:, np.argsort(-(across @ -up).mean(axis=0))[:6]].sum(axis=1)
        tilt = np.degrees(np.arccos(down @ -up / np.linalg.norm(down, axis=1)))
        assert np.median(tilt) < 16, side


def test_a_made_walk_has_its_figure() -> None:
    clip = clip_of(walker(3))
    skeleton = clip.head.skeleton
    (block,) = clip.blocks()
    made = bind_character(skeleton, DEGREES, calibrate_clip(clip, len(block)).start)
    check_mesh(made)
    check_limbs(made, skeleton, *Walker(skeleton, DEGREES).poses(block), 180.0)
