"""Values that people set of a calibration go along when a clip gets another unit, size or up axis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import Notice
from mcml.motion.bodies.calibration import overrides_of
from mcml.motion.bodies.positions import filled
from mcml.motion.bodies.reference import pose_in
from mcml.motion.clip import ClipStream, ReferencePose
from mcml.motion.conventions.convert import scale, turn_axis, turn_up
from mcml.motion.skeleton import Convention
from mcml.motion.units import reading_of
from tests import fuzz
from tests.motion.bodies.made import clip_of, named, person, stretch_of
from tests.motion.random_clips import random_clip

CONVENTIONS = [Convention.LISTED, Convention.FIXED, Convention.BASE]
FRAME = 2


def pose_of(clip: ClipStream) -> ReferencePose:
    skeleton = clip.head.skeleton
    return pose_in(skeleton, reading_of(clip.head), filled(skeleton, clip.blocks()).values[FRAME])


def with_values(clip: ClipStream, **values: object) -> ClipStream:
    told = {name: value.to_json() if isinstance(value, ReferencePose) else value for name, value in values.items()}
    own = tuple((f"calibration {name}", orjson.dumps(value).decode(), "") for name, value in told.items())
    return clip.with_head(replace(clip.head, properties=(*clip.head.properties, *own)))


def assert_same_pose(one: ReferencePose, other: ReferencePose, largest: float) -> None:
    assert np.abs(np.array(one.positions) - np.array(other.positions)).max() < 1e-5 * max(largest, 1)
    products = np.abs((np.array(one.rotations) * np.array(other.rotations)).sum(axis=1))
    assert products.min() > 1 - 1e-5


@pytest.mark.parametrize("convention", CONVENTIONS)
@fuzz.examples(8, 300)
@given(seed=st.integers(0, 10_000), factor=st.sampled_from([0.01, 2.54, 1000.0]), unit=st.sampled_from([None, "cm"]))
def test_lengths_are_scaled(convention: Convention, seed: int, factor: float, unit: str | None) -> None:
    clip = random_clip(convention, seed, moving=True, partial=False)
    clip = with_values(clip, floor=-3.5, leg=80, metres=0.01, reference=FRAME, leaps=True, pose=pose_of(clip))
    scaled = scale(clip, factor, unit=unit)
    found = overrides_of(scaled.head)
    assert found["floor"] == pytest.approx(-3.5 * factor)
    assert found["leg"] == pytest.approx(80 * factor)
    assert found["metres"] == pytest.approx(0.01 if unit is None else 0.01 / factor)
    assert (found["reference"], found["leaps"]) == (FRAME, True)
    extent = max(np.abs(np.array(found["pose"].positions)).max(), factor)
    assert_same_pose(found["pose"], pose_of(scaled), extent)


@pytest.mark.parametrize("convention", CONVENTIONS)
@fuzz.examples(8, 300)
@given(seed=st.integers(0, 10_000), axes=st.permutations("XYZ"), sign=st.sampled_from(["", "-"]))
def test_poses_and_axes_are_turned(convention: Convention, seed: int, axes: list[str], sign: str) -> None:
    clip = random_clip(convention, seed, moving=True, partial=False)
    clip = with_values(clip, up=sign + axes[0], floor=2, pose=pose_of(clip))
    turned = turn_up(clip, axes[0], axes[1])
    found = overrides_of(turned.head)
    assert (found["up"], found["floor"]) == (sign + axes[1], 2)
    assert_same_pose(found["pose"], pose_of(turned), float(np.abs(np.array(found["pose"].positions)).max()))
    across = turn_axis(clip, axes[1], axes[0])
    assert overrides_of(across.head)["up"] == ("-" if sign == "" else "") + axes[1]


@pytest.mark.parametrize("factor", [0.01, 2.0])
def test_heights_above_a_set_floor_stay_in_metres(factor: float) -> None:
    clip = with_values(named(clip_of(person(5, 30))), floor=-12.5)
    clip = clip.with_head(replace(clip.head, fields=clip.head.fields | {"calibration_unit": "cm"}))
    before = stretch_of(clip).calibration
    scaled = stretch_of(scale(clip, 0.01, unit="m")).calibration
    assert (scaled.metres, before.metres) == (1.0, 0.01)
    assert (scaled.floor, before.floor) == (pytest.approx(-0.125), -12.5)
    larger = stretch_of(scale(clip, factor)).calibration
    assert larger.floor == pytest.approx(-12.5 * factor)


def test_values_without_meaning_and_other_properties_stay() -> None:
    odd = (
        ("calibration floor", "soft", ""),
        ("calibration pose", "[[1, 2]]", ""),
        ("calibration leg", '"long"', ""),
        ("calibration floor", "true", ""),
        ("calibration up", "[]", ""),
        ("floor", "3", "m"),
    )
    clip = random_clip(Convention.LISTED, 4)
    clip = clip.with_head(replace(clip.head, properties=odd))
    assert turn_up(clip, "Y", "Z").head.properties == odd
    assert scale(clip, 2.0, unit="cm").head.properties == odd


def test_measures_of_a_subject_of_another_size_are_left_out() -> None:
    measures = (("gait LKneeWidth", "104", "mm"), ("session", "12", ""))
    clip = random_clip(Convention.LISTED, 4)
    clip = clip.with_head(replace(clip.head, properties=measures))
    assert scale(clip, 100.0, unit="cm").head.properties == measures
    larger = scale(clip, 2.0)
    assert larger.head.properties == measures[1:]
    assert Notice("warning", "measures of the subject are left out: the body has another size") in larger.notices
