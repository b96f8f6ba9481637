"""Conversions keep positions; angles stay where they can; what is lost is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import ConversionError
from mcml.motion.clip import ClipStream, full_shape
from mcml.motion.conventions.convert import convert, scale, turn_up
from mcml.motion.skeleton import CHANNELS, Convention, Joint, Skeleton
from mcml.motion.units import metres_per_unit
from tests import fuzz
from tests.motion import obvious
from tests.motion.random_clips import random_clip

LISTED, FIXED, BASE = Convention.LISTED, Convention.FIXED, Convention.BASE
PAIRS = [(start, end) for start in (LISTED, FIXED, BASE) for end in (LISTED, FIXED, BASE) if start is not end]


def by_name(clip: ClipStream) -> dict[str, np.ndarray]:
    """Positions (n, 3) of each joint, by the positions that the written-out formulas give."""
    found = obvious.positions(clip)
    return {joint.name: found[:, index] for index, joint in enumerate(clip.head.skeleton.joints)}


def tips_by_name(clip: ClipStream) -> dict[str, np.ndarray]:
    names = clip.head.skeleton.names
    return {names[joint]: places for joint, places in obvious.tips(clip).items()}


def distance(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> float:
    return max((float(np.abs(places - other[name]).max()) for name, places in one.items()), default=0.0)


@pytest.mark.parametrize(("start", "end"), PAIRS)
@fuzz.examples(8, 500)
@given(seed=st.integers(0, 100_000), radians=st.booleans())
def test_positions_stay(start: Convention, end: Convention, seed: int, radians: bool) -> None:
    clip = random_clip(start, seed, radians=radians and start is not LISTED)
    converted = convert(clip, end)
    assert {joint.convention for joint in converted.head.skeleton.joints} == {end}
    assert distance(by_name(clip), by_name(converted)) < 1e-8
    tips = tips_by_name(converted)
    assert distance({name: tip for name, tip in tips_by_name(clip).items() if name in tips}, tips) < 1e-8


@pytest.mark.parametrize(("start", "end"), [pair for pair in PAIRS if pair[1] is not FIXED])
@fuzz.examples(8, 500)
@given(seed=st.integers(0, 100_000))
def test_joints_that_move_in_their_parents_stay_where_they_are(start: Convention, end: Convention, seed: int) -> None:
    clip = random_clip(start, seed, moving=True)
    assert distance(by_name(clip), by_name(convert(clip, end))) < 1e-8


@pytest.mark.parametrize("start", [LISTED, BASE])
@fuzz.examples(8, 500)
@given(seed=st.integers(0, 100_000))
def test_asf_can_keep_moving_joints_when_asked(start: Convention, seed: int) -> None:
    clip = random_clip(start, seed, moving=True)
    assert distance(by_name(clip), by_name(convert(clip, FIXED, keep_translations=True))) < 1e-8


@pytest.mark.parametrize(("start", "end"), PAIRS)
@fuzz.examples(8, 500)
@given(seed=st.integers(0, 100_000))
def test_there_and_back_again(start: Convention, end: Convention, seed: int) -> None:
    clip = random_clip(start, seed)
    assert distance(by_name(clip), by_name(convert(convert(clip, end), start))) < 1e-8


def angles(clip: ClipStream) -> dict[tuple[str, str], list[float]]:
    found: dict[tuple[str, str], list[float]] = {}
    for block in clip.blocks():
        for index, (joint, channel) in enumerate(block.columns):
            key = (clip.head.skeleton.joints[joint].name, CHANNELS[channel])
            found.setdefault(key, []).extend(block.values[:, index].tolist())
    return {key: values for key, values in found.items() if key[1].startswith("R")}


def with_order(clip: ClipStream, order: str) -> ClipStream:
    joints = tuple(
        replace(joint, rotation_order=order, channels=(*joint.channels[:-3], *(f"R{axis.lower()}" for axis in order)))
        for joint in clip.head.skeleton.joints
    )
    skeleton = replace(clip.head.skeleton, joints=joints)

    def blocks():  # type: ignore[no-untyped-def]
        for block in clip.blocks():
            yield replace(block, columns=skeleton.columns())

    return ClipStream(replace(clip.head, skeleton=skeleton), blocks, clip.frames)


@given(seed=st.integers(0, 10_000), order=st.sampled_from(["ZXY", "XYZ", "ZYX"]))
def test_bvh_of_one_order_gives_htr_the_same_angles(seed: int, order: str) -> None:
    clip = with_order(random_clip(LISTED, seed, partial=False), order)
    converted = convert(clip, BASE)
    skeleton = clip.head.skeleton
    leaves = {joint.name for index, joint in enumerate(skeleton.joints) if index not in skeleton.parents}
    found = angles(converted)
    assert converted.head.skeleton.joints[0].rotation_order == order
    assert all(found[key] == values for key, values in angles(clip).items() if key[0] not in leaves)


@given(seed=st.integers(0, 10_000))
def test_bvh_in_the_order_of_acclaim_gives_amc_the_same_angles(seed: int) -> None:
    clip = with_order(random_clip(LISTED, seed, partial=False), "ZYX")
    assert angles(convert(clip, FIXED)) == angles(clip)


@given(seed=st.integers(0, 10_000))
def test_amc_angles_are_copied_to_htr(seed: int) -> None:
    clip = random_clip(FIXED, seed, partial=False)
    joints = tuple(replace(joint, rotation_order="XYZ") for joint in clip.head.skeleton.joints)
    clip = clip.with_head(replace(clip.head, skeleton=Skeleton(joints)))
    leaves = {joint.name for index, joint in enumerate(joints) if index not in clip.head.skeleton.parents}
    found = angles(convert(clip, BASE))
    assert all(found[key] == values for key, values in angles(clip).items() if key[0] not in leaves)


def test_limbs_of_cmu_only_change_signs_in_htr() -> None:
    """C^-1 d = -Y: half a turn about X makes the bone's axis true and flips the signs of ry and rz."""
    clip = random_clip(FIXED, 3, partial=False)
    root = clip.head.skeleton.joints[0]
    bone = Joint(
        "limb", 0, "limb", FIXED, ("Rx", "Ry", "Rz"), "XYZ", length="7", axis=("0", "0", "20"), axis_order="XYZ",
        direction=("0.34202014332566871", "-0.93969262078590843", "0"),
    )  # fmt: skip
    skeleton = Skeleton((root, bone))
    columns = skeleton.columns()
    blocks = [replace(b, values=b.values[:, :9], columns=columns, shapes=(((0, 63), (1, 56)),)) for b in clip.blocks()
              if b.values.shape[1] >= 9]  # fmt: skip
    limb = ClipStream(replace(clip.head, skeleton=skeleton), lambda: iter(blocks), clip.frames)
    converted = convert(limb, BASE)
    before, after = angles(limb), angles(converted)
    assert blocks
    assert after["limb", "Rx"] == before["limb", "Rx"]
    assert after["limb", "Ry"] == [-value for value in before["limb", "Ry"]]
    assert after["limb", "Rz"] == [-value for value in before["limb", "Rz"]]
    assert distance(tips_by_name(limb), tips_by_name(converted)) < 1e-9


def test_the_same_convention_is_the_same_clip() -> None:
    for convention in (LISTED, FIXED, BASE):
        clip = random_clip(convention, 1)
        assert convert(clip, convention) is clip


def test_what_asf_cannot_hold_is_said_with_its_size() -> None:
    said = 0
    for seed in range(60):
        clip = random_clip(LISTED, seed, moving=True)
        moved = [joint for joint in clip.head.skeleton.joints if joint.parent >= 0 and "Tx" in joint.channels]
        converted = convert(clip, FIXED)
        lost = [notice.what for notice in converted.notices if "stand still" in notice.what]
        assert len(lost) == min(1, len(moved))
        if len(moved) == 1:
            said += 1
            size = float(lost[0].split("by at most ")[1].split()[0])
            # The largest distance against the largest coordinate.
            assert size / 3.01 <= distance(by_name(clip), by_name(converted)) <= size * 1.001
    assert said > 3


def test_a_root_that_never_turns_takes_over_what_moves_in_it() -> None:
    clip = random_clip(LISTED, 8, partial=False)
    root, *others = clip.head.skeleton.joints
    still = replace(root, name="still", source_name="still", channels=(), rotation_order="", translation="")
    inner = replace(root, parent=0, translation="absolute")
    joints = (still, inner, *(replace(joint, parent=joint.parent + 1) for joint in others))
    skeleton = Skeleton(joints)

    def blocks():  # type: ignore[no-untyped-def]
        for block in clip.blocks():
            shapes = (full_shape(skeleton.columns()),)
            yield replace(block, columns=skeleton.columns(), shapes=shapes)

    nested = ClipStream(replace(clip.head, skeleton=skeleton), blocks, clip.frames)
    converted = convert(nested, FIXED)
    after = by_name(converted)
    before = {name: places for name, places in by_name(nested).items() if name != "still"}
    assert distance(before, after) < 1e-8
    assert any("the root never turns" in notice.what for notice in converted.notices)


def test_several_roots_and_markers_are_refused() -> None:
    clip = random_clip(LISTED, 4)
    joints = tuple(replace(joint, parent=-1) for joint in clip.head.skeleton.joints)
    several = clip.with_head(replace(clip.head, skeleton=Skeleton(joints)))
    assert len(joints) > 1
    with pytest.raises(ConversionError, match="roots"):
        convert(several, FIXED)
    assert len(convert(several, BASE).head.skeleton.roots) == len(joints)
    markers = tuple(replace(joint, convention=Convention.MARKER) for joint in joints)
    with pytest.raises(ConversionError, match="markers"):
        convert(clip.with_head(replace(clip.head, skeleton=Skeleton(markers))), LISTED)


@pytest.mark.parametrize("convention", [LISTED, FIXED, BASE])
@fuzz.examples(8, 500)
@given(seed=st.integers(0, 10_000), factor=st.sampled_from([0.01, 2.54, 1000.0]))
def test_scaling_scales_positions_and_nothing_else(convention: Convention, seed: int, factor: float) -> None:
    clip = random_clip(convention, seed, moving=True)
    scaled = scale(clip, factor, unit="cm")
    before, after = by_name(clip), by_name(scaled)
    assert max(np.abs(after[name] - factor * before[name]).max() for name in before) < 1e-8 * factor
    assert angles(scaled) == angles(clip)
    assert scaled.head.fields["calibration_unit"] == "cm"


@pytest.mark.parametrize("factor", [0, -1, float("nan"), float("inf")])
def test_a_factor_is_positive(factor: float) -> None:
    with pytest.raises(ConversionError):
        scale(random_clip(LISTED, 1), factor)


@pytest.mark.parametrize("convention", [LISTED, FIXED, BASE])
@fuzz.examples(8, 500)
@given(seed=st.integers(0, 10_000), axes=st.permutations("XYZ"))
def test_turning_up_turns_every_position(convention: Convention, seed: int, axes: list[str]) -> None:
    clip = random_clip(convention, seed, moving=True)
    start, end = axes[0], axes[1]
    turned = turn_up(clip, start, end)
    first, last = "XYZ".index(start), "XYZ".index(end)
    matrix = np.zeros((3, 3))
    matrix[last, first], matrix[first, last], matrix[3 - first - last, 3 - first - last] = 1, -1, 1
    before, after = by_name(clip), by_name(turned)
    assert np.isclose(np.linalg.det(matrix), 1)
    assert max(np.abs(after[name] - before[name] @ matrix.T).max() for name in before) < 1e-8
    assert turned.head.fields["global_axis_of_gravity"] == end
    back = by_name(turn_up(turned, end, start))
    assert distance(before, back) < 1e-8


def test_turning_bvh_keeps_the_numbers_of_its_angles() -> None:
    clip = random_clip(LISTED, 6, partial=False)
    turned = turn_up(clip, "Y", "Z")
    assert sorted(abs(v) for values in angles(turned).values() for v in values) == sorted(
        abs(v) for values in angles(clip).values() for v in values
    )
    assert turn_up(clip, "Y", "Y") is clip
    with pytest.raises(ConversionError):
        turn_up(clip, "Y", "W")


def test_units() -> None:
    assert [metres_per_unit(name) for name in ("mm", "CM", "dm", "m", "Inches", "ft")] == [
        0.001, 0.01, 0.1, 1.0, 0.0254, 0.3048,
    ]  # fmt: skip
    with pytest.raises(ConversionError):
        metres_per_unit("furlong")
    stated = random_clip(LISTED, 1)
    stated = stated.with_head(replace(stated.head, fields={"calibration_unit": "cm"}))
    assert float(convert(stated, FIXED).head.fields["units_length"]) == pytest.approx(2.54)
