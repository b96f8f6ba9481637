"""Stored motions as clips that can be compared: one skeleton, continuous rotations, attributes, phases."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array, Convention, Joint, Skeleton
from mcml.motion.units import UNITS
from mcml_service.analysis.interface import AnalysisError, Motion
from mcml_service.analysis.reach_blending.options import Options
from mcml_service.analysis.reach_blending.phases import SEVERAL, Phases, angular_speed, check_phases, find_phases
from mcml_service.analysis.reach_blending.principal_components import principal_components
from mcml_service.analysis.reach_blending.quaternion_tracks import continuous, fill_gaps, jumps, second_moments, unit
from mcml_service.analysis.reach_blending.standpoint import Standpoint, find_standpoint

RANGES: Mapping[str, tuple[float, float, str]] = {
    "age": (0.0, 120.0, "year"),
    "height": (50.0, 250.0, "cm"),
    "hbp": (0.0, 2000.0, "mm"),
}
"""Possible values and units of attributes with a usual name."""
SIMILAR = 0.20
"""Of a bone: more than this and clips are warned of."""


@dataclass(frozen=True)
class Clip:
    """The data of a motion that the analysis uses.

    places: (J,) of the joints in the motion. subject: the person; the document's id if unknown. attributes: (A,).
    speed: (F,) of the phase joint, rad/s. offsets: (J, 3) of each joint in its parent. moments: (J, 4, 4), see
    `second_moments`. arm: (F, 3) principal components of the joints from above the phase joint to the hand.
    standpoint: where the clip is put, see `Options.align`.
    """

    motion: Motion
    subject: str
    attributes: Array
    speed: Array
    phases: Phases
    offsets: Array
    moments: Array
    arm: Array
    warnings: tuple[tuple[str, str], ...]
    places: NDArray[np.intp]
    standpoint: Standpoint | None

    def tracks(self) -> tuple[Array, Array]:
        """Root (F, 3) and continuous rotations (F, J, 4): computed on use, because thousands of clips have many."""
        rotations, translations, _ = _fill(self.motion, self.places)
        root, rotations = translations[:, 0], unit(rotations)
        if self.standpoint is not None:
            root, rotations = self.standpoint.move(root, rotations)
        return root, continuous(rotations)


@dataclass(frozen=True)
class Body:
    """The joints that all clips have.

    skeleton: of the first clip, with these joints only. phase_joint: place of the joint whose speed counts. chain:
    places of the joints from the root to the hand.
    """

    skeleton: Skeleton
    phase_joint: int
    chain: tuple[int, ...]

    @property
    def hand(self) -> int:
        return self.chain[-1]


def common_body(motions: Sequence[Motion], options: Options) -> tuple[Body, list[NDArray[np.intp]]]:
    """The joints that the motions share, and for each motion their places in it.

    Raises AnalysisError `skeleton-mismatch`, `no-rotations`, `phase-joint-not-found`.
    """
    first = motions[0]
    for motion in motions:
        if not _turns(motion):
            raise AnalysisError(
                "no-rotations",
                f"{motion.name} has no rotations, or more than one root: {motion.document}.",
                remedy="Leave it out; clips need one skeleton with joint rotations.",
                document=motion.document,
                leave_out=[other.document for other in motions if not _turns(other)],
            )
    if options.joints == "same":
        places = [np.arange(len(first.skeleton))] * len(motions)
        for motion in motions[1:]:
            if motion.skeleton is not first.skeleton:
                _same_joints(first, motion, motions)
    else:
        kept = _find_shared_joints(motions)
        places = [_places(motion.skeleton, kept) for motion in motions]
    skeleton = _part_of(first.skeleton, places[0])
    phase_joint = find_joint(skeleton, options.phase_joint, "phase-joint-not-found")
    hand = find_joint(skeleton, options.hand_joint, "hand-joint-not-found") if options.hand_joint else None
    hand = _hand_of(skeleton, phase_joint) if hand is None else hand
    return Body(skeleton, phase_joint, _chain(skeleton, hand)), places


def find_joint(skeleton: Skeleton, name: str, code: str) -> int:
    """The place of a joint by its MCML name or its source's. Raises AnalysisError with that code."""
    for spelled in (skeleton.names, tuple(joint.source_name for joint in skeleton.joints)):
        if name in spelled:
            return spelled.index(name)
    names = sorted({joint.name for joint in skeleton.joints} | {joint.source_name for joint in skeleton.joints})
    raise AnalysisError(code, f"No joint is named {name!r}.", remedy=f"Use one of: {', '.join(names)}.", joints=names)


def read_clip(motion: Motion, places: NDArray[np.intp], body: Body, options: Options) -> Clip:
    """One motion as a clip. Raises AnalysisError with the reason why it cannot be used."""
    warnings: list[tuple[str, str]] = []
    rotations, translations, count = _fill(motion, places)
    if count:
        warnings.append(("gap-filled", f"{motion.name}: samples of {count} frames were missing and are filled in"))
    rotations = continuous(unit(rotations))
    leaps = jumps(rotations)
    if leaps:
        frame, joint = leaps[0]
        name = body.skeleton.joints[joint].name
        more = f", and {len(leaps) - 1} more" if len(leaps) > 1 else ""
        warnings.append(("jump", f"{motion.name}: {name} turns by over 120° at frame {frame + 1}{more}"))
    attributes = np.array([attribute_of(motion, name) for name in options.attributes])
    joint_rotations = rotations[:, body.phase_joint]
    if motion.document in options.times:
        phases = check_phases(joint_rotations, motion.fps, options.times[motion.document], options.phase_method)
    else:
        phases = find_phases(joint_rotations, motion.fps, options.phase_method)
    if SEVERAL in phases.flags:
        text = "has several fast movements, and the fastest counts as the reach; check its phases, or set its `times`"
        warnings.append((SEVERAL, f"{motion.name}: {text}"))
    standpoint = None
    if options.align == "start":
        standpoint = find_standpoint(translations[:, 0], rotations[:, 0], phases.t1, motion.up)
        _, rotations = standpoint.move(translations[:, 0], rotations)
    offsets = np.median(translations, axis=0)
    offsets[0] = 0.0
    subject = motion.properties.get(options.subject, ("", ""))[0] if options.subject else ""
    return Clip(
        motion=motion,
        subject=subject or motion.document,
        attributes=attributes,
        speed=angular_speed(joint_rotations, motion.fps, options.phase_method),
        phases=phases,
        offsets=offsets,
        moments=second_moments(rotations),
        arm=_arm(rotations, body),
        warnings=tuple(warnings),
        places=places,
        standpoint=standpoint,
    )


def _fill(motion: Motion, places: NDArray[np.intp]) -> tuple[Array, Array, int]:
    """Rotations (F, J, 4) and translations (F, J, 3) of some joints, and in how many frames samples were filled in."""
    rotations, translations = motion.rotations[:, places], motion.translations[:, places]
    missing: NDArray[np.bool_] = ~np.isfinite(np.concatenate([rotations, translations], axis=2)).all(axis=2)
    if motion.present is not None:
        missing = missing | ~motion.present[:, places].astype(bool)
    if not missing.any():
        return rotations, translations, 0
    return fill_gaps(rotations, missing), fill_gaps(translations, missing), int(missing.any(axis=1).sum())


def _arm(rotations: Array, body: Body) -> Array:
    place = body.chain.index(body.phase_joint) if body.phase_joint in body.chain else 0
    joints = list(body.chain[max(place - 1, 0) :])
    components = principal_components(rotations[:, joints].reshape(len(rotations), -1), 3).coefficients
    return np.concatenate([components, np.zeros((len(components), 3 - components.shape[1]))], axis=1)


def attribute_of(motion: Motion, name: str) -> float:
    """A property as a number, lengths in the attribute's usual unit.

    Raises AnalysisError `missing-attribute`, `attribute-not-a-number`.
    """
    if name not in motion.properties:
        raise AnalysisError("missing-attribute", f"The clip has no property {name!r}.")
    text, unit_name = motion.properties[name]
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise AnalysisError("attribute-not-a-number", f"The property {name!r} is {text!r}, not a number.")
    usual = RANGES[name][2] if name in RANGES else ""
    if usual in UNITS and unit_name.strip().lower() in UNITS:
        factor = UNITS[unit_name.strip().lower()] / UNITS[usual]
        value = value if factor == 1.0 else value * factor
    return value


def unit_of(motions: Sequence[Motion], name: str) -> str:
    """The unit of an attribute, fixed by the model. Raises AnalysisError `unit-suspect` where clips differ in it."""
    if name in RANGES:
        return RANGES[name][2]
    units = sorted({motion.properties[name][1] for motion in motions if name in motion.properties} - {""})
    if len(units) > 1:
        raise AnalysisError(
            "unit-suspect", f"The clips state {name!r} in {' and '.join(units)}.", remedy="Bring them to one unit."
        )
    return units[0] if units else ""


def check_ranges(names: Sequence[str], values: Sequence[float], where: str) -> None:
    """Raises AnalysisError `unit-suspect` for a value that no person has."""
    for name, value in zip(names, values, strict=True):
        if name in RANGES:
            low, high, unit_name = RANGES[name]
            if not low <= value <= high:
                raise AnalysisError(
                    "unit-suspect",
                    f"{name} is {value:g} {where}; {low:g} to {high:g} {unit_name} are expected.",
                    remedy=f"Give it in {unit_name}, or set force if it is right.",
                    attribute=name,
                )


def turning_freely(skeleton: Skeleton) -> Skeleton:
    """The skeleton with a third rotation channel, the last, at joints with two: blends leave the two axes."""

    def free(joint: Joint) -> Joint:
        turns = [channel for channel in joint.channels if channel[0] == "R"]
        if len(turns) != 2:
            return joint
        third = next(channel for channel in ("Rx", "Ry", "Rz") if channel not in turns)
        order = "".join(channel[1].upper() for channel in (*turns, third))
        return replace(joint, channels=(*joint.channels, third), rotation_order=order)

    return Skeleton(tuple(free(joint) for joint in skeleton.joints))


def differing_bones(body: Body, offsets: Array) -> list[str]:
    """Names of joints whose distance from the parent, of offsets (N, J, 3), differs by over 20 % of the middle one."""
    lengths = np.linalg.norm(offsets, axis=2)
    middle = np.median(lengths, axis=0)
    wide = np.abs(lengths - middle).max(axis=0) > SIMILAR * middle
    return [joint.name for joint, is_wide in zip(body.skeleton.joints, wide, strict=True) if is_wide]


def _turns(motion: Motion) -> bool:
    """Whether it has rotations, and one root."""
    convention = motion.skeleton.joints[0].convention if motion.skeleton.joints else Convention.MARKER
    return convention is Convention.LISTED and len(motion.skeleton.roots) == 1


def _same_joints(first: Motion, other: Motion, motions: Sequence[Motion]) -> None:
    ours, theirs = first.skeleton.joints, other.skeleton.joints
    for place in range(max(len(ours), len(theirs))):
        mine = (ours[place].name, ours[place].parent) if place < len(ours) else None
        its = (theirs[place].name, theirs[place].parent) if place < len(theirs) else None
        if mine != its:
            raise AnalysisError(
                "skeleton-mismatch",
                f"Joint {place + 1} is {_describe(ours, place)} in {first.name}, "
                f"{_describe(theirs, place)} in {other.name}.",
                remedy='Choose clips of one skeleton, or set joints to "intersection".',
                documents=[first.document, other.document],
                leave_out=minority({m.document: tuple((j.name, j.parent) for j in m.skeleton.joints) for m in motions}),
            )


def minority(kinds: Mapping[str, Hashable]) -> list[str]:
    """Return the documents whose kind differs from the most frequent one: without them the others agree."""
    usual = Counter(kinds.values()).most_common(1)[0][0]
    return [document for document, kind in kinds.items() if kind != usual]


def _describe(joints: Sequence[Joint], place: int) -> str:
    if place >= len(joints):
        return "none"
    parent = joints[place].parent
    return f"{joints[place].name} below {joints[parent].name}" if parent >= 0 else f"{joints[place].name}, a root"


def _find_shared_joints(motions: Sequence[Motion]) -> list[str]:
    """Names of joints that every motion has, below the same parents, which are kept too; in the first one's order."""
    parents = [
        {j.name: motion.skeleton.joints[j.parent].name if j.parent >= 0 else "" for j in motion.skeleton.joints}
        for motion in motions
    ]
    kept: list[str] = []
    for name, parent in parents[0].items():
        if all(other.get(name) == parent for other in parents) and (not parent or parent in kept):
            kept.append(name)
    if not kept:
        raise AnalysisError(
            "skeleton-mismatch", "The clips' skeletons have no root in common.", remedy="Choose clips of one skeleton."
        )
    return kept


def _places(skeleton: Skeleton, names: Sequence[str]) -> NDArray[np.intp]:
    place = {joint.name: index for index, joint in enumerate(skeleton.joints)}
    return np.array([place[name] for name in names], dtype=np.intp)


def _part_of(skeleton: Skeleton, places: NDArray[np.intp]) -> Skeleton:
    if len(places) == len(skeleton):
        return Skeleton(skeleton.joints)
    new = {int(place): index for index, place in enumerate(places)}
    joints = (skeleton.joints[int(place)] for place in places)
    return Skeleton(tuple(replace(joint, parent=new.get(joint.parent, -1)) for joint in joints))


def _hand_of(skeleton: Skeleton, phase_joint: int) -> int:
    """The hand at the end of the phase joint's limb: one named so, else the last joint of its first chain."""
    below = {phase_joint}
    for index, joint in enumerate(skeleton.joints):
        if joint.parent in below:
            below.add(index)
            if joint.name in ("right_hand", "left_hand"):
                return index
    last = phase_joint
    while children := skeleton.children(last):
        last = children[0]
    return last


def find_arm(body: Body) -> tuple[int, int] | None:
    """Find the places of shoulder and elbow in the chain to the hand, by their names, else as its last two bones."""
    names = [body.skeleton.joints[joint].name for joint in body.chain]
    last = len(names) - 1
    shoulder = next((place for place, name in enumerate(names) if name.endswith("_up_arm")), last - 2)
    elbow = next((place for place, name in enumerate(names) if name.endswith("_low_arm")), shoulder + 1)
    return (shoulder, elbow) if 0 < shoulder < elbow < last else None


def _chain(skeleton: Skeleton, joint: int) -> tuple[int, ...]:
    chain = [joint]
    while skeleton.joints[chain[-1]].parent >= 0:
        chain.append(skeleton.joints[chain[-1]].parent)
    return tuple(reversed(chain))
