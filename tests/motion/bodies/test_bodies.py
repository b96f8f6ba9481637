"""Questions about bodies against their slow twin, alone or in a whole, and turned, moved and mirrored."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import RequestError, UnsupportedError, VocabularyError
from mcml.formats import FORMATS
from mcml.language.motion_names import MotionName, parse, parts
from mcml.motion.bodies import local_fit
from mcml.motion.bodies.limb_angles import ANGLES, CLINICAL, NEEDS_ROTATIONS, angle_named
from mcml.motion.bodies.poses import JOINTS, NEEDS, at_rate, motion_distances, pose_distances, pose_features
from mcml.motion.bodies.positions import UNSEEN, clip_positions, filled, rounded, world_positions
from mcml.motion.bodies.quantities import QUANTITIES, compute, halo_of, joints_of, quantity_of
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import CHANNEL_INDEX, Convention
from mcml.motion.units import reading_of
from mcml.motion.vectors import angle_between
from mcml.testing import read
from tests import fuzz
from tests.builders import TRC
from tests.formats.test_real_files import opened
from tests.motion.bodies import twin
from tests.motion.bodies.made import clip_of, named, part_of, person, positions_of, stretch_of
from tests.motion.random_clips import random_clip

CONVENTIONS = [Convention.LISTED, Convention.FIXED, Convention.BASE]

SIDED = [(part, movement) for part, movement in ANGLES if part not in ("trunk", "pelvis")]
ANGLE_NAMES = [f"{side}-{part}-{movement}" for part, movement in SIDED for side in ("left", "right")] + [
    f"{part}-{movement}" for part, movement in ANGLES if part in ("trunk", "pelvis")
]

CLINICAL_NAMES = [
    f"{side}-{part}-{movement}" for part, movement in CLINICAL if part != "pelvis" for side in ("left", "right")
] + [f"{part}-{movement}" for part, movement in CLINICAL if part == "pelvis"]

ASKED: list[tuple[str, ...]] = [
    ("time",),
    ("unit",),
    ("leg",),
    ("height", "left_hand"),
    ("position", "right_hand", "x"),
    ("position", "right_hand", "z", "Head"),
    ("position", "left_hand", "left", "Root"),
    ("position", "left_hand", "front", "Root"),
    ("position", "left_hand", "up"),
    ("distance", "left_hand", "right_foot"),
    ("angle", "left_hand", "left_low_arm", "Head"),
    *[("angle", name) for name in (*ANGLE_NAMES, *CLINICAL_NAMES)],
    ("tilt", "Root", "neck1"),
    ("speed", "right_hand"),
    ("speed", "right_hand", "Root"),
    ("acceleration", "left_toes"),
    ("acceleration", "left_toes", "left_foot"),
    ("heading",),
    ("contact", "left_toes"),
    ("contact", "right_foot"),
    ("contact", "left_hand"),
    ("height", "tail"),
    ("speed", "tail", "Root"),
    ("tilt", "Root", "Root"),
]
TWINS = {"time": "second"}


def twins_values(slow: twin.Twin, name: str, arguments: tuple[str, ...]) -> list[float]:
    if name == "angle":
        name = "named" if len(arguments) == 1 else "corner"
    return slow.values(TWINS.get(name, name), arguments)


def check_twin(stretch: Stretch, slow: twin.Twin) -> None:
    """Every quantity, within 1e-9 of it or of 1, and unknown in the same frames."""
    for name, *arguments in ASKED:
        found = compute(name, arguments, stretch)
        assert found.shape == (stretch.frames,)
        assert found.dtype == np.float64
        expected = np.array(twins_values(slow, name, tuple(arguments)))
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9, err_msg=f"{name} {arguments}")
    features = pose_features(stretch)
    expected = np.array([slow.features(frame, JOINTS) for frame in range(stretch.frames)])
    np.testing.assert_allclose(features, expected, rtol=1e-9, atol=1e-9)


def test_every_quantity_is_asked_for() -> None:
    # The folder activities tests "activity" with bodies that are made for it.
    assert {name for name, *_ in ASKED} | {"activity"} == {name for name in QUANTITIES if not QUANTITIES[name].of_file}


@pytest.mark.slow
@pytest.mark.parametrize("convention", CONVENTIONS)
@fuzz.examples(3)
@given(seed=st.integers(0, 100_000))
def test_quantities_are_those_of_the_twin(convention: Convention, seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame_time = float(rng.choice([1 / 120, 1 / 60, 1 / 30, 0.025]))
    scale = float(rng.choice([0.01, 1.0, 10.0, 1 / 2.54, 7.0]))
    clip = clip_of(person(seed, int(rng.integers(1, 25)), frame_time, scale), convention)
    stretch = stretch_of(clip)
    check_twin(stretch, twin.Twin.of(clip, stretch.calibration))


@pytest.mark.slow
@fuzz.examples(4)
@given(seed=st.integers(0, 100_000))
def test_gaps_leaps_and_any_axis_that_is_up(seed: int) -> None:
    """Missing joints and samples, a frame before the motion, no frame time, no unit."""
    rng = np.random.default_rng(seed)
    whole = stretch_of(clip_of(person(seed, 30)))
    turn = np.roll(np.eye(3, dtype=np.int32), int(rng.integers(3)), axis=1)
    if rng.random() < 0.5:
        # Half a turn, so that up is down.
        turn = turn * np.array([-1, -1, 1], dtype=np.int32)
    up = turn[1]
    axis = int(np.abs(up).argmax())
    calibration = replace(
        whole.calibration,
        up=("-" if up[axis] < 0 else "") + "XYZ"[axis],
        skipped=int(rng.integers(0, 4)),
        metres=None if rng.random() < 0.2 else whole.calibration.metres,
        floor=None if rng.random() < 0.2 else whole.calibration.floor,
        leg=None if rng.random() < 0.2 else whole.calibration.leg,
    )
    places = {}
    for name, steps in whole.places.items():
        if rng.random() < 0.9:
            places[name] = steps @ turn
            if rng.random() < 0.4:
                places[name][rng.random(30) < 0.2] = UNSEEN
    places.setdefault("Root", whole.places["Root"] @ turn)
    stretch = Stretch(places, 30, None if rng.random() < 0.2 else 1 / 60, calibration)
    rows: dict[str, list[twin.Place]] = {
        name: [None if x == UNSEEN else (x, y, z) for x, y, z in steps.tolist()] for name, steps in places.items()
    }
    check_twin(stretch, twin.Twin(rows, stretch.frame_time, calibration))


@fuzz.examples(8)
@given(seed=st.integers(0, 100_000))
def test_a_part_with_its_halo_is_that_part_of_the_whole(seed: int) -> None:
    """To the bit, with no more joints than are asked for."""
    rng = np.random.default_rng(seed)
    whole = stretch_of(clip_of(person(seed, 60, float(rng.choice([1 / 120, 1 / 30])))))
    whole = replace(whole, calibration=replace(whole.calibration, skipped=int(rng.integers(0, 4))))
    for steps in whole.places.values():
        steps[rng.random(60) < 0.02] = UNSEEN
    first, end = sorted(rng.integers(0, 61, 2).tolist())
    # Short parts at the ends have hardly more than one window.
    first, end = [(first, end), (0, 1), (59, 60), (2, 5), (first, min(60, first + 3))][seed % 5]
    for name, *arguments in ASKED:
        halo = halo_of(name, arguments, whole.frame_time)
        if halo is None:
            assert QUANTITIES[name].whole
            continue
        before, after = max(0, first - halo - int(rng.integers(3))), min(60, end + halo + int(rng.integers(3)))
        part = part_of(whole, before, after, joints_of(name, arguments, whole.places))
        found = compute(name, arguments, part)[first - before : end - before]
        assert found.tobytes() == compute(name, arguments, whole)[first:end].tobytes(), (name, arguments)
    features = pose_features(whole)
    part = part_of(whole, first, end, [name for name in NEEDS if name in whole.places])
    assert pose_features(part).tobytes() == features[first:end].tobytes()
    motion = features[20:26]
    before = max(0, first - 2 * (len(motion) - 1))
    near = motion_distances(features[before:end], motion)[first - before :]
    assert near.tobytes() == motion_distances(features, motion)[first:end].tobytes()
    values = compute("distance", ["left_hand", "Head"], whole)
    reach = local_fit.reach(whole.frame_time)
    before, after = max(0, first - reach), min(60, end + reach)
    near = local_fit.rate(values[before:after], whole.frame_time)[first - before : end - before]
    assert near.tobytes() == local_fit.rate(values, whole.frame_time)[first:end].tobytes()


@fuzz.examples(4)
@given(seed=st.integers(0, 100_000))
def test_poses_and_motions_are_as_unlike_as_the_twin_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    stretch = stretch_of(clip_of(person(seed, 24)))
    features = pose_features(stretch)
    features[rng.random(features.shape[:2]) < 0.2] = np.nan
    features[rng.random(24) < 0.1] = np.nan
    apart = pose_distances(features, features[3:5])
    expected = [[twin.pose_distance(one, other) for other in features[3:5]] for one in features]
    np.testing.assert_allclose(apart, expected, rtol=1e-9, atol=1e-12)
    motion = features[4 : 4 + int(rng.integers(1, 8))]
    found = motion_distances(features, motion)
    slow = [twin.motion_distance(list(features), list(motion), end) for end in range(24)]
    np.testing.assert_allclose(found, slow, rtol=1e-9, atol=1e-12)


def test_slopes_of_lines_and_parabolas_are_exact() -> None:
    time = np.arange(30) * 0.01
    values = np.stack([3 * time, 5 - 2 * time + 7 * time**2], axis=1)
    values[11] = np.nan
    slopes, bends = local_fit.slopes(values, 0.01), local_fit.bends(values, 0.01)
    expected = np.stack([np.full(30, 3.0), -2 + 14 * time], axis=1)
    expected[11] = np.nan
    np.testing.assert_allclose(slopes, expected, atol=1e-9)
    inner = np.isfinite(bends).all(axis=1)
    np.testing.assert_allclose(bends[inner], np.tile([0.0, 14.0], (inner.sum(), 1)), atol=1e-9)
    # Within five frames of an end, or of the gap, the window is not whole.
    assert np.flatnonzero(inner).tolist() == [5, *range(17, 25)]
    assert np.isnan(local_fit.slopes(values[:1], 0.01)).all()
    assert local_fit.slopes(values[:0], 0.01).shape == (0, 2)
    assert local_fit.slopes(values[:2], 0.01)[:, 0] == pytest.approx([3, 3])
    assert np.isnan(local_fit.rate(values[:, 0], None)).all()


def test_what_has_no_length_has_no_angle() -> None:
    one = np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 2, 3], [2, 0, 0]])
    other = np.array([[1.0, 1, 1], [-1, -1, -1], [0, 0, 0], [-1, -2, -3], [1, 0, 0]])
    np.testing.assert_allclose(angle_between(one, other), [np.nan, np.nan, np.nan, 180, 0])
    np.testing.assert_allclose(angle_between(other, one), [np.nan, np.nan, np.nan, 180, 0])


def test_no_frame_rate_asks_for_endless_windows() -> None:
    assert local_fit.reach(1e-300) == 500
    assert local_fit.reach(1e300) == local_fit.reach(None) == 2
    values = np.arange(2000.0)[:, None] * 1e-9
    values[::7] = np.nan
    found = local_fit.slopes(values, 1e-9)
    np.testing.assert_allclose(found[np.isfinite(values)], 1.0, rtol=1e-6)


def test_a_motion_is_found_in_itself_slower_and_faster() -> None:
    features = pose_features(stretch_of(clip_of(person(5, 60))))
    motion = features[20:41]
    assert motion_distances(features, motion)[40] == 0
    faster = at_rate(features, 1 / 60, 1 / 40)
    assert motion_distances(faster, motion)[26] < 0.1 * np.nanmedian(motion_distances(faster, motion))
    slower = at_rate(features, 1 / 60, 1 / 90)
    assert np.array_equal(slower[60], features[40])
    assert motion_distances(slower, motion)[60] < 0.1 * np.nanmedian(motion_distances(slower, motion))
    assert len(motion_distances(features, features[:0])) == 60
    assert np.isnan(motion_distances(features[:2], motion)).all()
    assert motion_distances(features[:0], motion).shape == (0,)


@fuzz.examples(4)
@given(seed=st.integers(0, 100_000))
def test_where_a_body_stands_and_faces_changes_little(seed: int) -> None:
    """Turned about the vertical by a quarter and moved, only where it is and faces changes."""
    rng = np.random.default_rng(seed)
    one = stretch_of(clip_of(person(seed, 40)))
    turn = np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]], dtype=np.int32)
    moved = rng.integers(-10_000, 10_000, 3).astype(np.int32) * np.array([1, 0, 1], dtype=np.int32)
    places = {name: steps @ turn + (0 if name.endswith(" left") else moved) for name, steps in one.places.items()}
    other = replace(one, places=places)
    for name, *arguments in ASKED:
        if name not in ("heading", "position"):
            before, after = compute(name, arguments, one), compute(name, arguments, other)
            np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-9, err_msg=f"{name} {arguments}")
    for axis in ("left", "front", "up"):
        asked = ["left_hand", axis, "Root"]
        np.testing.assert_allclose(compute("position", asked, other), compute("position", asked, one), atol=1e-9)
    change = compute("heading", [], other) - compute("heading", [], one)
    np.testing.assert_allclose(change - change[0], 0, atol=1e-9)
    assert change[0] % 360 == pytest.approx(90)
    np.testing.assert_allclose(pose_features(other), pose_features(one), atol=1e-9)


@fuzz.examples(4)
@given(seed=st.integers(0, 100_000))
def test_a_mirrored_body_swaps_left_and_right(seed: int) -> None:
    one = stretch_of(clip_of(person(seed, 40)))
    swap = {"left": "right", "right": "left"}

    def swapped(name: str, mark: str) -> str:
        side, _, rest = name.partition(mark)
        return f"{swap[side]}{mark}{rest}" if side in swap else name

    flip = np.array([-1, 1, 1], dtype=np.int32)
    places = {swapped(name, "_"): steps * flip for name, steps in one.places.items()}
    # What points to the left points to the right in a mirror.
    other = replace(one, places={name: -at if name.endswith(" left") else at for name, at in places.items()})
    for name in (*ANGLE_NAMES, *CLINICAL_NAMES):
        side, _, rest = name.partition("-")
        middle = not side.startswith(("left", "right"))
        twisted = name == "pelvis-obliquity" or (middle and ("left" in rest or "right" in rest))
        mirrored = compute("angle", [name if twisted else swapped(name, "-")], other)
        expected = compute("angle", [name], one) * (-1 if twisted else 1)
        apart = (mirrored - expected + 180) % 360 - 180
        np.testing.assert_allclose(apart, np.where(np.isnan(expected), np.nan, 0), atol=1e-9, err_msg=name)
    for joint in ("left_hand", "right_toes"):
        for name in ("height", "speed", "contact"):
            found = compute(name, [swapped(joint, "_")], other)
            np.testing.assert_allclose(found, compute(name, [joint], one), atol=1e-9)
    turned = compute("heading", [], one)
    np.testing.assert_allclose(compute("heading", [], other) - turned[0] * -1, turned[0] - turned, atol=1e-9)


@pytest.mark.parametrize("convention", CONVENTIONS)
@fuzz.examples(8)
@given(seed=st.integers(0, 100_000))
def test_positions_are_those_of_the_walker(convention: Convention, seed: int) -> None:
    """Of any skeleton, in any number of blocks."""
    clip = random_clip(convention, seed, moving=seed % 2 == 0)
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    blocks = list(clip.blocks())
    found = world_positions(skeleton, np.concatenate([block.values for block in blocks]), reading)
    expected = np.concatenate([Walker(skeleton, reading).poses(block)[0] for block in blocks])
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


def test_blocks_of_positions_follow_one_another(monkeypatch: pytest.MonkeyPatch) -> None:
    clip = clip_of(person(1, 30))
    whole = positions_of(clip)
    monkeypatch.setattr("mcml.motion.bodies.positions.BLOCK", 7)
    assert np.array_equal(positions_of(clip), whole)


def test_missing_samples_are_gaps() -> None:
    clip = clip_of(person(1, 20))
    skeleton = clip.head.skeleton
    names = list(skeleton.names)
    whole = positions_of(clip)
    (block,) = clip.blocks()
    values = block.values.copy()
    values[12, block.columns.index((names.index("left_low_arm"), CHANNEL_INDEX["Rx"]))] = np.nan
    parts = [replace(block, values=values[start : start + 5], ids=block.ids[start : start + 5]) for start in (0, 5, 10)]
    found, nothing = clip_positions(skeleton, [filled(skeleton, parts), filled(skeleton, [])])
    lost = np.zeros(found.shape[:2], dtype=bool)
    lost[12, [names.index("left_low_arm"), names.index("left_hand")]] = True
    assert np.array_equal(np.isnan(found), np.repeat(lost[:, :, None], 3, axis=2))
    assert np.array_equal(found[~lost], whole[:15][~lost])
    assert nothing.shape == (0, len(names), 3)


def test_markers_are_where_they_say() -> None:
    clip = read(FORMATS["trc"], {"trc": TRC})
    (block,) = clip.blocks()
    (found,) = clip_positions(clip.head.skeleton, [filled(clip.head.skeleton, clip.blocks())])
    assert np.isnan(found).any()
    assert np.array_equal(found.reshape(len(block), -1), block.values, equal_nan=True)


def test_rounding() -> None:
    places = np.array([[[0.04, 0.06, 0.05], [1.0, np.nan, 0.0], [3e9, 0.0, 0.0], [0.15, -0.26, 0.0]]])
    found = rounded(places, 0.1)
    assert found.dtype == np.int32
    assert found.tolist() == [[[0, 1, 0], [UNSEEN] * 3, [UNSEEN] * 3, [1, -3, 0]]]
    assert rounded(np.empty((0, 4, 3)), 0.1).shape == (0, 4, 3)


def test_every_movement_is_an_angle_or_needs_rotations() -> None:
    """The vocabulary of motion names, but what no one angle shows."""
    shapeless = {"circumduction", "opposition", "reposition", "upward-rotation", "downward-rotation"}
    left_out = {
        *((part, movement) for part in ("head", "neck") for movement in ("protraction", "retraction")),
        *(("foot", movement) for movement in ("pronation", "supination")),
        *((part, movement) for part in ("fingers", "finger-three") for movement in ("abduction", "adduction")),
        *((part, movement) for part in parts() if part.startswith("toe") for movement in ("abduction", "adduction")),
    }
    for name, part in parts().items():
        # No joint moves the jaw.
        for movement in set(part.movements) - shapeless if part.joints else ():
            ways = (movement in NEEDS_ROTATIONS.get(name, ())) + ((name, movement) in ANGLES)
            assert ways == ((name, movement) not in left_out), (name, movement)
    for name in ANGLE_NAMES:
        known = parse(name)
        assert isinstance(known, MotionName)
        assert str(known) == name
        assert angle_named(name)


def test_what_cannot_be_asked_is_refused() -> None:
    stretch = stretch_of(clip_of(person(1, 3)))
    with pytest.raises(UnsupportedError, match="rotations"):
        compute("angle", ["left-wrist-flexion"], stretch)
    with pytest.raises(VocabularyError):
        compute("angle", ["left-nose-flexion"], stretch)
    with pytest.raises(RequestError):
        quantity_of("colour", [])
    with pytest.raises(RequestError):
        quantity_of("distance", ["Root"])
    with pytest.raises(RequestError):
        joints_of("angle", ["Root", "Head"], ["Root", "Head"])
    with pytest.raises(RequestError):
        compute("position", ["Root", "sideways"], stretch)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["bvh/bandai/dataset-1_walk_angry_001.bvh", "asfamc/cmu_misc/07_05-walk.amc", "htr/xbot_walk_mixamo.com.htr"],
)
def test_real_files_are_those_of_the_twin(shared: object, name: str) -> None:
    clip = named(opened(shared / name))  # type: ignore[operator]
    clip = clip.with_head(replace(clip.head, frame_time=clip.head.frame_time or "0.0083333"))
    stretch = stretch_of(clip)
    check_twin(part_of(stretch, 0, min(80, stretch.frames)), twin.Twin.of(clip, stretch.calibration, 80))
