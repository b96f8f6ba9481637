"""Hips in the pelvis, signed knees and turns of thighs, against OpenSim and against legs made with known angles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.formats import FORMATS
from mcml.motion.bodies.bone_axes import HingeSums, line_of, pool_hinges, sum_hinges
from mcml.motion.bodies.calibration import Calibration
from mcml.motion.bodies.clip_body import ClipBody, body_of, quantity_values
from mcml.motion.bodies.limb_angles import angle_names, clinical_name
from mcml.motion.bodies.positions import rounded, world_directions
from mcml.motion.bodies.quantities import asked_quantity, compute
from mcml.motion.bodies.reference import standing_zeros
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.clip import ClipStream, Reference
from mcml.motion.kinematics import Walker
from mcml.motion.rotations import from_matrix, rotate
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.units import reading_of
from mcml.testing import read
from tests.builders import TRC
from tests.motion.bodies.made import named, part_of
from tests.motion.bodies.rig import OFFSETS, RANGES, made_clip, random_angles, write_rig
from tests.motion.random_clips import random_clip

STEP = 1e-4
JOINTS = {"back": "waist", "hip": "up_leg", "knee": "low_leg", "ankle": "foot", "mtp": "toes"}
SIDES = {"l": "left", "r": "right"}
BONES = {"femur": "up_leg", "tibia": "low_leg"}


def mcml_name(name: str, words: Mapping[str, str]) -> str:
    part, _, side = name.partition("_")
    return f"{SIDES[side]}_{words[part]}" if side else words[part]


class Sample:
    """A motion of an OpenSim model, with the coordinates that OpenSim gives it."""

    def __init__(self, path: Path) -> None:
        self.arrays = np.load(path)
        self.names = [mcml_name(str(name), JOINTS) for name in self.arrays["joints"]]
        self.positions = self.arrays["positions"].astype(np.float64)
        rest = self.arrays["rest_rotations"]
        self.turns: dict[str, Array] = {}
        """Of bones from rest, and by the bones' own axes, which no rest pose tells."""
        self.own: dict[str, Array] = {}
        for place, bone in enumerate(self.arrays["bones"].tolist()):
            if bone != "pelvis":
                rotations = self.arrays["rotations"][:, place]
                self.turns[mcml_name(bone, BONES)] = from_matrix(rotations @ rest[place].T)
                self.own[mcml_name(bone, BONES)] = from_matrix(rotations)

    def zeros(self) -> dict[str, float]:
        skeleton = named(read(FORMATS["bvh"], {"bvh": write_rig()})).head.skeleton
        joints = tuple(replace(skeleton.joints[0], name=name, source_name=name) for name in self.names)
        return standing_zeros(Skeleton(joints), self.arrays["rest_positions"].astype(float), np.array([0.0, 0.0, 1.0]))

    def stretch(self, lines: Mapping[str, Array]) -> Stretch:
        steps = rounded(self.positions, STEP)
        places = {name: steps[:, place] for place, name in enumerate(self.names)}
        places |= {line_of(bone): rounded(left[:, None], STEP)[:, 0] for bone, left in lines.items()}
        calibration = Calibration(1.0, "Z", 0.0, 0.9, STEP, Reference("Z"), 0, {}, self.zeros())
        return Stretch(places, len(steps), 0.01, calibration)

    def degrees(self, coordinate: str) -> Array:
        found: Array = self.arrays[f"deg_{coordinate}"]
        return found


@pytest.fixture(params=["walk_gait2392", "crouch4"])
def sample(shared: Path, request: pytest.FixtureRequest) -> Sample:
    return Sample(shared / f"lab/skeleton_{request.param}.npz")


def rms_after_constant(found: Array, expected: Array) -> float:
    apart = found - expected
    return float(np.sqrt(((apart - apart.mean()) ** 2).mean()))


def test_legs_have_the_angles_of_opensim(sample: Sample) -> None:
    lines = {bone: rotate(turn, np.array([0.0, 1.0, 0.0])) for bone, turn in sample.turns.items()}
    stretch = sample.stretch(lines)
    assert stretch.calibration.zeros["pelvis"] == pytest.approx(-11.489, abs=1e-3)
    for side, letter in (("left", "l"), ("right", "r")):
        for name, coordinate, sign, most in (
            ("hip-flexion", "hip_flexion", 1, 0.5),
            ("hip-adduction", "hip_adduction", 1, 0.1),
            ("hip-internal-rotation", "hip_rotation", 1, 0.1),
            ("knee-flexion", "knee_angle", -1, 0.5),
        ):
            found = compute("angle", [f"{side}-{name}"], stretch)
            expected = sign * sample.degrees(f"{coordinate}_{letter}")
            assert rms_after_constant(found, expected) <= most, name
            # The constants are those of lines between centres of joints.
            assert np.abs(found - expected).max() < 0.7, name
            if name != "knee-flexion":
                assert np.polyfit(expected, found, 1)[0] == pytest.approx(1, abs=0.01), name


def test_hips_turn_by_the_hinge_of_the_knee_without_a_rest_pose(sample: Sample) -> None:
    places = {name: place for place, name in enumerate(sample.names)}
    skeleton = named(read(FORMATS["bvh"], {"bvh": write_rig()})).head.skeleton
    rotations = np.zeros((len(sample.positions), len(skeleton), 4))
    positions = np.full((len(sample.positions), len(skeleton), 3), np.nan)
    for index, name in enumerate(skeleton.names):
        if name in places:
            positions[:, index] = sample.positions[:, places[name]]
        rotations[:, index] = sample.own.get(name, np.array([0.0, 0.0, 0.0, 1.0]))
    hinges = pool_hinges([sum_hinges(skeleton, positions, rotations)])
    third = len(positions) // 3
    parts = [sum_hinges(skeleton, positions[rows], rotations[rows]) for rows in (slice(third), slice(third, None))]
    assert set(hinges) == {f"{side}_{bone}" for side in ("left", "right") for bone in ("up_leg", "low_leg")}
    assert max(hinge[3] for hinge in hinges.values()) < 0.1
    # A firm hinge is the same in any part, and parts add up to the whole.
    for part in ([parts[0]], [parts[1]], parts):
        for bone, hinge in pool_hinges(part).items():
            np.testing.assert_allclose(hinge, hinges[bone], atol=2e-6)
    stretch = sample.stretch({bone: rotate(sample.own[bone], np.array(hinge[:3])) for bone, hinge in hinges.items()})
    for side, letter in (("left", "l"), ("right", "r")):
        found = compute("angle", [f"{side}-hip-internal-rotation"], stretch)
        assert np.abs(found - sample.degrees(f"hip_rotation_{letter}")).max() <= 0.2
        knee = compute("angle", [f"{side}-knee-flexion"], stretch)
        assert rms_after_constant(knee, -sample.degrees(f"knee_angle_{letter}")) <= 0.5


def test_a_part_of_a_motion_has_the_same_bits(sample: Sample) -> None:
    stretch = sample.stretch({bone: rotate(turn, np.array([0.0, 1.0, 0.0])) for bone, turn in sample.turns.items()})
    third = stretch.frames // 3
    for name in ("left-hip-flexion", "right-hip-internal-rotation", "left-knee-flexion", "pelvis-tilt"):
        whole, part = compute("angle", [name], stretch), compute("angle", [name], part_of(stretch, 0, third))
        assert part.tobytes() == whole[:third].tobytes()


def test_a_pelvis_tilts_about_its_own_hips(sample: Sample) -> None:
    """OpenSim tilts it about an axis of the ground: the same angles in the order rotation, obliquity, tilt."""
    tilt, lean, turn = (sample.degrees(f"pelvis_{name}") for name in ("tilt", "list", "rotation"))
    frames = Rotation.from_euler("YXZ", np.stack([-tilt, lean, turn], axis=1), degrees=True)
    _, wanted_lean, wanted_tilt = frames.as_euler("ZXY", degrees=True).T
    stretch = sample.stretch({})
    found = compute("angle", ["pelvis-tilt"], stretch), compute("angle", ["pelvis-obliquity"], stretch)
    for degrees, expected in zip(found, (wanted_tilt, wanted_lean), strict=True):
        np.testing.assert_allclose(np.abs(degrees), np.abs(expected), atol=0.2)
    np.testing.assert_allclose(found[0], wanted_tilt, atol=0.2)


def degrees_of(clip: ClipStream, names: Sequence[str], body: ClipBody | None = None) -> dict[str, Array]:
    body = body or body_of(clip.head, clip.blocks())
    return {name: quantity_values(clip, body, asked_quantity(f"angle:{name}")) for name in names}


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 100_000))
def test_a_leg_has_the_angles_that_it_is_made_with(seed: int) -> None:
    """Hyperextension among them, however the body lies in the world."""
    rng = np.random.default_rng(seed)
    angles = random_angles(rng, 12)
    clip = made_clip(angles, Rotation.random(12, random_state=seed))
    for name, found in degrees_of(clip, list(angles)).items():
        np.testing.assert_allclose(found, angles[name], atol=0.06, err_msg=name)
    opposites = degrees_of(clip, ["left-hip-abduction", "right-knee-valgus", "left-hip-external-rotation"])
    for name, found in zip(("left-hip-adduction", "right-knee-varus", "left-hip-internal-rotation"),
                           opposites.values(), strict=True):  # fmt: skip
        np.testing.assert_allclose(-found, angles[name], atol=0.06)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 100_000))
def test_bones_that_are_turned_at_rest_have_the_same_angles_by_the_hinge_of_the_knee(seed: int) -> None:
    rng = np.random.default_rng(seed)
    angles = random_angles(rng, 40, hinge=True)
    # It faces anywhere, and stands upright.
    facing = Rotation.from_euler("y", rng.uniform(-180, 180, (40, 1)), degrees=True)
    rest = dict(zip(OFFSETS, Rotation.random(len(OFFSETS), random_state=seed), strict=True))
    # Legs that point up at rest, in which nobody could stand.
    rest["left_up_leg"] = rest["right_up_leg"] = Rotation.from_euler("x", 170, degrees=True)
    clip = made_clip(angles, facing, rest)
    body = body_of(clip.head, clip.blocks())
    if body.calibration.origins["reference"].reason == "a body could stand in the rest pose":
        return
    assert {axis.origin for axis in body.calibration.bones.values()} == {"hinge"}
    assert body.calibration.zeros == {}
    for name, found in degrees_of(clip, list(angles), body).items():
        np.testing.assert_allclose(found, angles[name], atol=0.06, err_msg=name)


def test_a_cut_clip_has_the_zero_of_its_skeleton() -> None:
    rng = np.random.default_rng(4)
    angles = random_angles(rng, 60, hinge=True)
    rest = {name: Rotation.from_euler("x", 170, degrees=True) for name in ("left_up_leg", "right_up_leg")}
    whole = made_clip(angles, Rotation.identity(60), rest)
    body = body_of(whole.head, whole.blocks())
    blocks = [replace(block, values=block.values[40:], ids=block.ids[40:]) for block in whole.blocks()]
    head = replace(whole.head, reference=body.calibration.start)
    cut = ClipStream(head, lambda: iter(blocks), 20)
    expected = degrees_of(whole, list(angles), body)
    for name, found in degrees_of(cut, list(angles)).items():
        assert found.tobytes() == expected[name][40:].tobytes(), name


def test_knees_without_one_axis_take_the_upright_frame() -> None:
    rng = np.random.default_rng(4)
    rest = {name: Rotation.from_euler("x", 170, degrees=True) for name in ("left_up_leg", "right_up_leg")}
    clip = made_clip(random_angles(rng, 60), Rotation.identity(60), rest)
    body = body_of(clip.head, clip.blocks())
    assert body.calibration.start.hinges == {}
    assert {axis.origin for axis in body.calibration.bones.values()} == {"pose"}
    straight = random_angles(rng, 60, hinge=True)
    straight |= {name: np.full(60, 15.0) for name in straight if name.endswith("knee-flexion")}
    clip = made_clip(straight, Rotation.identity(60), rest)
    assert body_of(clip.head, clip.blocks()).calibration.start.hinges == {}


def test_an_axis_takes_bends_and_one_direction() -> None:
    nothing = HingeSums(np.zeros(3), np.zeros((3, 3)), 0, np.array([0.0, 1.0, 0.0]), np.eye(3))
    assert nothing.axis() is None
    left = np.array([0.0, 1.0, 0.0])
    bent_backwards = HingeSums(-5.0 * left, 5 * np.outer(left, left), 5, left, 5 * np.eye(3))
    axis, rms = bent_backwards.axis() or (np.zeros(3), np.nan)
    np.testing.assert_array_equal(axis, left)
    assert rms == 0
    across = np.array([1.0, 0.0, 0.0])
    loose = bent_backwards + HingeSums(-left, np.outer(across, across), 1, left, np.eye(3))
    assert loose.axis() is None


def test_missing_samples_are_nan_and_never_held() -> None:
    rng = np.random.default_rng(7)
    angles = random_angles(rng, 10)
    clip = made_clip(angles, Rotation.identity(10))
    (block,) = clip.blocks()
    column = block.columns.index((clip.head.skeleton.names.index("left_up_leg"), 3))
    values = block.values.copy()
    values[4, column] = np.nan
    gappy = ClipStream(clip.head, lambda: iter([replace(block, values=values)]), 10)
    whole = degrees_of(clip, ["left-hip-internal-rotation", "left-knee-flexion", "right-knee-flexion"])
    for name, found in degrees_of(gappy, list(whole)).items():
        lost = [4] if name.startswith("left") else []
        assert np.flatnonzero(np.isnan(found)).tolist() == lost, name
        np.testing.assert_array_equal(np.delete(found, 4), np.delete(whole[name], 4))


def test_positions_alone_have_hips_and_unsigned_knees() -> None:
    rng = np.random.default_rng(3)
    angles = random_angles(rng, 10)
    clip = made_clip(angles, Rotation.identity(10))
    positions = np.concatenate([Walker(clip.head.skeleton).poses(block)[0] for block in clip.blocks()])
    steps = rounded(positions, 0.01)
    places = {name: steps[:, place] for place, name in enumerate(clip.head.skeleton.names)}
    stretch = Stretch(places, 10, 0.01, replace(body_of(clip.head, clip.blocks()).calibration, zeros={}))
    for side in ("left", "right"):
        for name in ("hip-flexion", "hip-adduction"):
            found = compute("angle", [f"{side}-{name}"], stretch)
            np.testing.assert_allclose(found, angles[f"{side}-{name}"], atol=0.06)
        assert (compute("angle", [f"{side}-knee-flexion"], stretch) >= 0).all()
        for name in ("hip-internal-rotation", "knee-varus", "knee-internal-rotation"):
            assert np.isnan(compute("angle", [f"{side}-{name}"], stretch)).all()


def test_standing_ankles_are_at_zero() -> None:
    angles = {f"{side}-{name}": np.zeros(1) for side in ("left", "right") for name in RANGES}
    clip = made_clip(angles, Rotation.identity(1))
    names = ["left-ankle-dorsiflexion", "right-ankle-plantarflexion", "pelvis-tilt", "pelvis-obliquity"]
    for found in degrees_of(clip, names).values():
        np.testing.assert_allclose(found, 0, atol=0.06)


def test_markers_of_knees_tell_their_sign() -> None:
    """The lateral and the medial marker of a knee are on its axis."""
    rng = np.random.default_rng(5)
    angles = random_angles(rng, 10)
    clip = made_clip(angles, Rotation.identity(10))
    poses = [Walker(clip.head.skeleton).poses(block) for block in clip.blocks()]
    places, turns = (np.concatenate(each) for each in zip(*poses, strict=True))
    at = {name: index for index, name in enumerate(clip.head.skeleton.names)}
    points: dict[str, Array] = {}
    for side, letter in (("left", "L"), ("right", "R")):
        outwards = np.array([5.0 if side == "left" else -5.0, 0.0, 0.0])
        knee, ankle = places[:, at[f"{side}_low_leg"]], places[:, at[f"{side}_foot"]]
        points[f"{letter}HJC"] = places[:, at[f"{side}_up_leg"]]
        across = Rotation.from_quat(turns[:, at[f"{side}_up_leg"]]).apply(outwards)
        points[f"{letter}KNE"], points[f"{letter}KNM"] = knee + across, knee - across
        across = Rotation.from_quat(turns[:, at[f"{side}_low_leg"]]).apply(outwards)
        points[f"{letter}ANK"], points[f"{letter}MED"] = ankle + across, ankle - across
        points[f"{letter}TOE"] = places[:, at[f"{side}_toes"]]
        points[f"{letter}HEE"] = ankle - [0.0, 5.0, 4.0]
        for name, x, z in (("ASI", 12.0, 8.0), ("PSI", 5.0, -10.0)):
            points[letter + name] = np.array([x if side == "left" else -x, 100.0, z]) + np.zeros((10, 3))
    rows = [f"{row + 1}\t{row / 100}\t" + "\t".join(f"{v:.6f}" for each in points.values() for v in each[row])
            for row in range(10)]  # fmt: skip
    names = "\t\t\t".join(points)
    head = TRC.decode().splitlines()[:2]
    count = f"100\t100\t10\t{len(points)}\tcm\t100\t1\t10"
    axes = "\t\t" + "\t".join(f"{axis}{n + 1}" for n in range(len(points)) for axis in "XYZ")
    text = "\n".join([*head, count, f"Frame#\tTime\t{names}\t\t", axes, "", *rows, ""])
    trial = read(FORMATS["trc"], {"trc": text.encode()})
    body = body_of(trial.head, trial.blocks())
    assert {axis.origin for axis in body.calibration.bones.values()} == {"markers"}
    names_of = [name for name in angles if "knee" in name or "hip-internal" in name or "hip-adduction" in name]
    for name, found in degrees_of(trial, names_of, body).items():
        np.testing.assert_allclose(found, angles[name], atol=0.1, err_msg=name)


def test_old_names_have_a_clinical_one() -> None:
    assert clinical_name("left-leg-flexion") == "left-hip-flexion"
    assert clinical_name("right-leg-adduction") == "right-hip-adduction"
    assert clinical_name("pelvis-anterior-tilt") == "pelvis-tilt"
    assert clinical_name("left-knee-flexion") is clinical_name("trunk-flexion") is None
    known = set(angle_names())
    others = [found for name in known if (found := clinical_name(name)) is not None]
    assert len(others) == 21
    assert set(others) <= known


@pytest.mark.parametrize("convention", [Convention.LISTED, Convention.FIXED, Convention.BASE])
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 100_000))
def test_directions_are_those_of_the_walker(convention: Convention, seed: int) -> None:
    """Of any skeleton, to the bit in any number of frames."""
    clip = random_clip(convention, seed, moving=seed % 2 == 0)
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    values = np.concatenate([block.values for block in clip.blocks()])
    turned = np.concatenate([Walker(skeleton, reading).poses(block)[1] for block in clip.blocks()])
    parents = sorted({joint.parent for joint in skeleton.joints} - {-1})
    fixed = [(joint, np.random.default_rng(joint).normal(size=3)) for joint in parents]
    found = world_directions(skeleton, values, fixed, reading)
    for place, (joint, direction) in enumerate(fixed):
        np.testing.assert_allclose(found[:, place], rotate(turned[:, joint], direction), atol=1e-9)
    part = world_directions(skeleton, values[1:], fixed, reading)
    assert part.tobytes() == np.ascontiguousarray(found[1:]).tobytes()
