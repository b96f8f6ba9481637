"""Checks that refuse an impossible retargeting with the reason, because its result would look plausible."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.retargeting.posed_bodies import PosedBody
from mcml.motion.retargeting.report import PartError
from mcml.motion.skeleton import Array, Skeleton

_ALIKE = 2.0
"""How many times as long or short as at rest a bone may be in the motion."""
_ACROSS = 45.0
"""Degrees, on the mean, that the line through the hips may point elsewhere."""
_REST = "Retarget from and to skeletons whose rest pose shows the body, such as a BVH with offsets."


def check_rest(one: PosedBody, two: PosedBody, pairs: Mapping[int, int], positions: Array) -> None:
    """Raises ConversionError where a rest pose does not show the body: offsets come with the motion.

    pairs: joint of the target -> joint of the source. positions: (n, J, 3) of the source.
    """
    for what, lengths in (
        ("motion", _lengths(one, two.skeleton, pairs, source=True)),
        ("target", _lengths(two, two.skeleton, pairs, source=False)),
    ):
        known = np.array(list(lengths.values()))
        legs = [lengths[end] for end in lengths if two.skeleton.joints[end].name.endswith(("_low_leg", "_foot"))]
        if len(known) and (2 * (known <= 0).sum() > len(known) or (legs and max(legs) <= 0)):
            raise ConversionError(
                f"the rest pose of the {what} does not show the body: {int((known <= 0).sum())} of {len(known)} bones "
                f"between matched joints have no length at rest, so where joints are comes with the motion",
                remedy=_REST,
            )
    if not len(positions):
        return
    rest = _lengths(one, two.skeleton, pairs, source=True)
    strange = []
    for end, length in rest.items():
        above = _above(two.skeleton, end, pairs)
        vectors = positions[:, pairs[end]] - positions[:, pairs[above]]
        moving = float(np.median(np.linalg.norm(vectors, axis=1)))
        if length > 0 and not length / _ALIKE <= moving <= length * _ALIKE:
            strange.append(two.skeleton.joints[end].name)
    if 2 * len(strange) > len(rest):
        raise ConversionError(
            f"the rest pose of the motion is of another body: {len(strange)} of {len(rest)} bones are twice or half as "
            f"long in the motion, such as {strange[0]}",
            remedy=_REST,
        )


def check_across(one: PosedBody, two: PosedBody, pairs: Mapping[int, int], errors: tuple[PartError, ...]) -> None:
    """Raises ConversionError where hips point so far elsewhere that joints without a match must turn them."""
    for error in errors:
        if error.what == "hips" and error.mean > _ACROSS:
            between = _unmatched_between(one.skeleton, set(pairs.values())) + _unmatched_between(
                two.skeleton, set(pairs)
            )
            names = ", ".join(dict.fromkeys(between)) or "none"
            raise ConversionError(
                f"the hips would point {error.mean:.0f} degrees elsewhere, on the mean; joints between matched ones "
                f"that have no match: {names}",
                remedy="Match these joints too in the mapping, or take another skeleton.",
            )


def angles_between(one: Array, two: Array) -> Array:
    """Degrees (n,) between vectors (n, 3)."""
    between: Array = np.degrees(np.arctan2(np.linalg.norm(np.cross(one, two), axis=1), (one * two).sum(axis=1)))
    return between


def _above(skeleton: Skeleton, joint: int, pairs: Mapping[int, int]) -> int:
    """The nearest matched joint above a joint, -1 for none."""
    above = skeleton.joints[joint].parent
    while above >= 0 and above not in pairs:
        above = skeleton.joints[above].parent
    return above


def _lengths(body: PosedBody, target: Skeleton, pairs: Mapping[int, int], *, source: bool) -> dict[int, float]:
    """The length in a pose of each bone between matched joints, by its end in the target."""
    found = {}
    for end in pairs:
        above = _above(target, end, pairs)
        if above >= 0:
            start, stop = (pairs[above], pairs[end]) if source else (above, end)
            found[end] = float(np.linalg.norm(body.positions[stop] - body.positions[start]))
    return found


def _unmatched_between(skeleton: Skeleton, matched: set[int]) -> list[str]:
    """Joints that have matched ones above and below them, and no match."""
    found = []
    for index in sorted(matched):
        passed = []
        above = skeleton.joints[index].parent
        while above >= 0 and above not in matched:
            passed.append(skeleton.joints[above].name)
            above = skeleton.joints[above].parent
        found += passed if above >= 0 else []
    return found
