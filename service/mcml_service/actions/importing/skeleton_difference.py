"""How the head of a new file differs from a document's: joints, the meaning of their numbers, frame rate."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml.motion.clip import ClipHead
from mcml.motion.skeleton import Joint, Skeleton, unique_names
from mcml_schemas.revisions import SkeletonReplaced

SAME_RATE = 1e-6
"""Relative difference of two frame times that count as equal."""

SAME_LENGTH = 1e-5
"""Of the longest bone: files that another program wrote again have other decimals."""

SAME_ANGLE = 1e-3
"""Degrees."""

_STATED = {"calibration_unit": "unit of length", "global_axis_of_gravity": "up axis"}
"""Fields that people may set, compared where both state them."""

_MEANING = {"units_length": "factor of lengths", "units_angle": "unit of angles", "bone_length_axis": "axis of bones"}
"""Fields that decide what the numbers of frames mean."""

Lexemes: TypeAlias = str | Sequence[str] | None


@dataclass(frozen=True)
class HeadDifference:
    """reason: a sentence about the first difference. skeleton: all of them."""

    reason: str
    skeleton: SkeletonReplaced


def compare_heads(old: ClipHead, new: ClipHead) -> HeadDifference | None:
    """Compare the head of a new file with a document's; None where its frames can replace the document's.

    Names that people may change do not count; numbers count as equal within SAME_LENGTH and SAME_ANGLE.
    """
    reasons = [*_compare_joints(old.skeleton, new.skeleton), *_compare_fields(old, new), *_compare_rates(old, new)]
    if not reasons:
        return None
    before, after = _by_source(old.skeleton), _by_source(new.skeleton)
    shared = [name for name in before if name in after]
    lengths = _find_tolerance(old.skeleton)
    rate_before, rate = (_rate(head) for head in (old, new))
    about = SkeletonReplaced(
        added=[joint.name for name, joint in after.items() if name not in before],
        removed=[joint.name for name, joint in before.items() if name not in after],
        changed=[
            before[name].name
            for name in shared
            if _differs(before[name], after[name], lengths)
            or _parent(old.skeleton, before[name]) != _parent(new.skeleton, after[name])
        ],
        rate_before=rate_before,
        rate=rate if rate is not None else rate_before,
    )
    return HeadDifference(reasons[0], about)


def _compare_joints(old: Skeleton, new: Skeleton) -> Iterable[str]:
    if len(old) != len(new):
        yield f"The file has {len(new)} joints, the document {len(old)}."
        return
    lengths = _find_tolerance(old)
    for ours, theirs in zip(old.joints, new.joints, strict=True):
        fault = f"name ({theirs.source_name!r})" if ours.source_name != theirs.source_name else ""
        fault = fault or ("parent" if ours.parent != theirs.parent else _differs(ours, theirs, lengths))
        if fault:
            yield f"Joint {ours.name!r} has another {fault} in the file."


def _compare_fields(old: ClipHead, new: ClipHead) -> Iterable[str]:
    for field, words in (_STATED | _MEANING).items():
        ours, theirs = (head.fields.get(field, "").strip().lower() for head in (old, new))
        if ours != theirs and (field in _MEANING or (ours and theirs)):
            yield f"The file has another {words} ({theirs or 'none'}) than the document ({ours or 'none'})."


def _compare_rates(old: ClipHead, new: ClipHead) -> Iterable[str]:
    ours, theirs = old.seconds_per_frame(), new.seconds_per_frame()
    if ours is not None and theirs is not None and abs(ours - theirs) > SAME_RATE * ours:
        yield f"The file has {1 / theirs:g} frames a second, the document {1 / ours:g}."


def _rate(head: ClipHead) -> float | None:
    seconds = head.seconds_per_frame()
    return None if seconds is None else 1 / seconds


def _by_source(skeleton: Skeleton) -> dict[str, Joint]:
    """Return the joints by their names in the source; names that repeat are made unique."""
    names = unique_names([joint.source_name or joint.name for joint in skeleton.joints])
    return dict(zip(names, skeleton.joints, strict=True))


def _parent(skeleton: Skeleton, joint: Joint) -> str:
    above = skeleton.joints[joint.parent] if joint.parent >= 0 else None
    return "" if above is None else above.source_name or above.name


def _find_tolerance(skeleton: Skeleton) -> float:
    """The difference of two lengths that counts as none."""
    longest = max((np.abs(_numbers(joint.offset)).max(initial=0.0) for joint in skeleton.joints), default=0.0)
    stated = max((float(joint.length) for joint in skeleton.joints if joint.length is not None), default=0.0)
    return SAME_LENGTH * float(max(longest, stated))


def _differs(ours: Joint, theirs: Joint, lengths: float) -> str:
    """Which fact of two joints differs, "" for none. lengths: as of `_find_tolerance`."""
    if ours.channels != theirs.channels or ours.rotation_order != theirs.rotation_order:
        return "list of channels"
    if ours.convention != theirs.convention or ours.translation != theirs.translation:
        return "convention"
    if ours.axis_order != theirs.axis_order:
        return "axis order"
    if not _equal(ours.offset, theirs.offset, lengths):
        return "offset"
    if not _equal(ours.length, theirs.length, lengths):
        return "length"
    if not _equal(ours.direction, theirs.direction, SAME_LENGTH):
        return "direction"
    if not _equal(ours.axis, theirs.axis, SAME_ANGLE):
        return "axis"
    ends, other_ends = ([number for end in joint.end_sites for number in end.offset] for joint in (ours, theirs))
    return "" if _equal(ends, other_ends, lengths) else "end site"


def _equal(one: Lexemes, other: Lexemes, most: float) -> bool:
    if (one is None) != (other is None):
        return False
    before, after = _numbers(one), _numbers(other)
    return before.shape == after.shape and bool((np.abs(before - after) <= most).all())


def _numbers(value: Lexemes) -> NDArray[np.float64]:
    """Lexemes as numbers, none for None."""
    if value is None:
        return np.empty(0)
    return np.array([value] if isinstance(value, str) else value, dtype=float).reshape(-1)
