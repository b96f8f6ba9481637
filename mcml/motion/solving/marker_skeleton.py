"""Skeletons from markers: joints at the centres that markers tell, bones of constant length, rotations of segments.

Every person of a trial gets a skeleton. A bone has the median of its vectors in its segment over the frames, so bones
point as the centres do and joints may be away from them by as much as their distances change; how far is told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mcml.errors import ConversionError, LimitError, Notice
from mcml.motion.bodies.bone_axes import BONES, LINE, line_of, line_steps
from mcml.motion.bodies.calibration import Calibration, calibrate, calibration_frames
from mcml.motion.bodies.positions import UNSEEN, clip_positions, filled
from mcml.motion.calibration_properties import OVERRIDES
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, full_shape
from mcml.motion.frames import joined, leave_out
from mcml.motion.hub import walked
from mcml.motion.hub_writer import Flags, HubWriter
from mcml.motion.landmarks.centres import bodies_of, body_names, centres_of, index_landmarks, with_centres
from mcml.motion.landmarks.sizes import PREFIX, sizes_of
from mcml.motion.lexemes import lexeme, triple
from mcml.motion.pictures.figures import axis_of
from mcml.motion.rotations import IDENTITY, from_matrix, inverse, multiply
from mcml.motion.skeleton import TRANSLATIONS, Array, Convention, Joint, Skeleton
from mcml.motion.solving.segment_frames import Landmarks, segment_frames
from mcml.motion.units import reading_of
from mcml.motion.vectors import length

_ARM = "shoulder", "up_arm", "low_arm", "hand"
_LEG = "up_leg", "low_leg", "foot", "toes"
_PARENTS: Final[Mapping[str, str]] = {
    "Root": "",
    **{f"{side}_{one}": above for side in ("left", "right")
       for one, above in zip(_LEG, ("Root", *(f"{side}_{part}" for part in _LEG)), strict=False)},
    "waist": "Root",
    "torso7": "waist",
    "neck1": "torso7",
    "Head": "neck1",
    **{f"{side}_{one}": above for side in ("left", "right")
       for one, above in zip(_ARM, ("torso7", *(f"{side}_{part}" for part in _ARM)), strict=False)},
}  # fmt: skip
"""Joints from the root on, each with the one above."""
_AT: Final[Mapping[str, str]] = {
    "waist": "Root",
    **dict.fromkeys(("torso7", "left_shoulder", "right_shoulder"), "neck1"),
}
"""Joints that are at the centre of another one."""
_HIPS: Final = ("left_up_leg", "right_up_leg")
_FIELDS: Final[tuple[str, ...]] = ("dataframe_rate", "calibration_unit", "global_axis_of_gravity", "filename")
MOST_POINTS: Final = 20_000_000
"""Markers times frames, which are in memory together."""
_OF_REST: Final = frozenset(f"{OVERRIDES}{name}" for name in ("reference", "pose", "leaps"))
"""Properties about a pose of the markers."""


@dataclass(frozen=True)
class Miss:
    """How far a joint is from the centre that markers tell, in the unit of the trial.

    rms: root mean square over the frames, NaN without any. most: in the worst frame. unknown: frames without the joint,
    as a marker is missing that it needs.
    """

    joint: str
    rms: float
    most: float
    unknown: int


@dataclass(frozen=True, eq=False)
class SolvedPerson:
    """A person of a trial with a skeleton.

    person: prefix of the markers, "" where they have none. head, block: the motion, in the unit and axes of the trial.
    notices: guesses and losses.
    """

    person: str
    head: ClipHead
    block: FrameBlock
    misses: tuple[Miss, ...]
    notices: tuple[Notice, ...]

    def clip(self) -> ClipStream:
        return ClipStream(self.head, lambda: iter([self.block]), len(self.block), list(self.notices))


def has_markers(skeleton: Skeleton) -> bool:
    """Tell whether a skeleton consists of markers: points without bones."""
    return any(joint.convention is Convention.MARKER for joint in skeleton.joints)


def with_skeleton(clip: ClipStream) -> ClipStream:
    """Return a marker trial of one person as a clip with a skeleton; other clips as they are.

    Raises ConversionError for several people, and as `solve_people` does.
    """
    if not has_markers(clip.head.skeleton):
        return clip
    people = solve_people(clip.head, joined(clip.blocks()))
    if len(people) > 1:
        listed = ", ".join(person.person or "without a prefix" for person in people)
        raise ConversionError(
            f"The markers are of several people: {listed}.",
            remedy="Make a document of each person first: `mcml skeletons ID`.",
        )
    (person,) = people
    return replace(person.clip(), notices=[*clip.notices, *person.notices], character=clip.character)


def solve_people(head: ClipHead, block: FrameBlock) -> list[SolvedPerson]:
    """Return a skeleton and its motion for every person of a marker trial, in the order of their prefixes.

    Frames keep their ids and motion names. A joint has no sample in a frame in which a marker is missing that it needs.
    Raises ConversionError where no person has a pelvis and both hips.
    """
    _check_size(head.skeleton, len(block))
    people = [(prefix, *_take_person(head, block, prefix)) for prefix in dict.fromkeys(_prefixes(head.skeleton))]
    solved = [_solve(prefix, own, frames) for prefix, own, frames in people if _has_hips(own.skeleton)]
    solved = [person for person in solved if set(_HIPS) <= set(person.head.skeleton.names)]
    if not solved:
        raise ConversionError(
            "The markers show no pelvis with both hips, so no skeleton can be made.",
            remedy="Name the markers as a marker set does: docs/names.md lists the known ones.",
        )
    return solved


def _check_size(skeleton: Skeleton, frames: int) -> None:
    most = MOST_POINTS // max(1, len(skeleton))
    if frames > most:
        raise LimitError(
            f"A skeleton of {len(skeleton)} markers is made from at most {most:,} frames; the clip has {frames:,}.",
            remedy="Take a range of frames.",
        )


def _prefixes(skeleton: Skeleton) -> list[str]:
    """Of the people. Points that are joints by their names, as those of some cameras, are those of one."""
    return [body.prefix for body in bodies_of(skeleton)] or [""]


def _has_hips(skeleton: Skeleton) -> bool:
    names = {*skeleton.names, *(centre.name for centre in centres_of(skeleton))}
    return all(hip in names for hip in _HIPS)


def _take_person(head: ClipHead, block: FrameBlock, prefix: str) -> tuple[ClipHead, FrameBlock]:
    """The markers of one person, and those without a prefix; properties of that person lose its name."""
    skeleton = head.skeleton
    others = {other for other in _prefixes(skeleton) if other != prefix}
    kept = [
        index
        for index, joint in enumerate(skeleton.joints)
        if joint.source_name.rpartition(":")[0].strip() not in others
    ]
    if len(kept) == len(skeleton):
        return head, block
    number = {index: place for place, index in enumerate(kept)}
    columns = [place for place, (joint, _) in enumerate(block.columns) if joint in number]
    own = Skeleton(tuple(skeleton.joints[index] for index in kept))
    person, named = f"{PREFIX}{prefix} ", []
    for name, text, unit in head.properties:
        if not any(name.startswith(f"{PREFIX}{other} ") for other in others):
            named.append((f"{PREFIX}{name.removeprefix(person)}" if name.startswith(person) else name, text, unit))
    frames = replace(
        block,
        values=block.values[:, columns],
        columns=tuple((number[block.columns[place][0]], block.columns[place][1]) for place in columns),
        shapes=tuple(
            tuple((number[joint], bits) for joint, bits in shape if joint in number) for shape in block.shapes
        ),
    )
    return replace(head, skeleton=own, properties=tuple(named), reference=None), frames


def _solve(person: str, head: ClipHead, block: FrameBlock) -> SolvedPerson:
    body, calibration = _read_landmarks(head, block)
    frames = segment_frames(body)
    axes = _body_axes(calibration.up)
    tops, offsets = _joints(body, frames)
    rotations, known = _turns(list(tops), frames, axes)
    skeleton = _skeleton(list(tops), {joint: axes @ offset for joint, offset in offsets.items()}, axes)
    translations = np.tile(np.stack([axes @ offsets[joint] for joint in tops]), (len(block), 1, 1))
    there: Flags = np.all(np.isfinite(tops["Root"]), axis=1)
    known &= there[:, None]
    translations[:, 0] = np.where(there[:, None], tops["Root"], 0.0)
    values, columns = HubWriter(skeleton).write(translations, rotations), skeleton.columns()
    made = FrameBlock(values, columns, (full_shape(columns),), block.ids, None, block.motion_names)
    misses = _misses(tops, walked(skeleton, translations, rotations)[0], known)
    notices = _notices(head, calibration, misses)
    return SolvedPerson(person, _head(head, skeleton, calibration), leave_out(made, known), misses, notices)


def _misses(tops: Mapping[str, Array], positions: Array, known: Flags) -> tuple[Miss, ...]:
    joints, found = list(tops), []
    for place, joint in enumerate(joints):
        seen = known[:, [joints.index(above) for above in _above(joint)] or [0]].all(axis=1)
        away = length(positions[seen, place] - tops[joint][seen])
        away = away[np.isfinite(away)]
        rms, most = (float(np.sqrt(np.mean(away**2))), float(away.max())) if len(away) else (np.nan, np.nan)
        found.append(Miss(joint, rms, most, int(np.count_nonzero(~seen))))
    return tuple(found)


def _head(head: ClipHead, skeleton: Skeleton, calibration: Calibration) -> ClipHead:
    fields: dict[str, str] = {name: head.fields[name] for name in _FIELDS if name in head.fields}
    fields["euler_rotation_order"] = skeleton.joints[0].rotation_order
    properties = tuple(one for one in head.properties if one[0] not in _OF_REST)
    if calibration.floor is not None and f"{OVERRIDES}floor" not in {name for name, _, _ in properties}:
        # Plates and lowest markers tell the floor, which the skeleton lacks.
        properties += ((f"{OVERRIDES}floor", lexeme(calibration.floor), ""),)
    return replace(
        head, format="bvh", skeleton=skeleton, fields=fields, sources=(), properties=properties, reference=None
    )


def _notices(head: ClipHead, calibration: Calibration, misses: Sequence[Miss]) -> tuple[Notice, ...]:
    (prefix,) = _prefixes(head.skeleton)
    joints = {miss.joint for miss in misses}
    notices = []
    worst = max(misses, key=lambda miss: -1.0 if np.isnan(miss.rms) else miss.rms)
    scale, unit = (1.0, "units") if calibration.metres is None else (1000 * calibration.metres, "mm")
    whose = f"{prefix}: " if prefix else ""
    notices.append(
        Notice(
            "note",
            f"{whose}a skeleton of {len(misses)} joints was made from markers; its joints are within "
            f"{worst.rms * scale:.3g} {unit} (rms) of their centres, the farthest is {worst.joint}, "
            f"at most {worst.most * scale:.3g} {unit}",
        )
    )
    lost = [miss for miss in misses if miss.unknown]
    if lost:
        most = max(miss.unknown for miss in lost)
        notices.append(
            Notice("warning", f"{whose}{len(lost)} joints are unknown in up to {most} frames, as markers are missing")
        )
    guesses = [centre for centre in centres_of(head.skeleton) if centre.is_guess and centre.name in joints]
    notices += [Notice("guess", f"{whose}the centre {centre.name} is {centre.describe()}") for centre in guesses]
    if calibration.floor is not None and calibration.origins["floor"].kind == "guessed":
        notices.append(Notice("guess", f"{whose}floor of the trial: {calibration.origins['floor'].reason}"))
    return tuple(notices)


def _read_landmarks(head: ClipHead, block: FrameBlock) -> tuple[Landmarks, Calibration]:
    skeleton, reading = head.skeleton, reading_of(head)
    (positions,) = clip_positions(skeleton, [filled(skeleton, [block])], reading)
    rows = calibration_frames(len(positions))
    calibration = calibrate(head, positions[rows], frames=rows)
    points = with_centres(centres_of(skeleton), positions, sizes_of(head, calibration.metres))
    centres = {name: points[:, index] for index, name in enumerate(body_names(skeleton)) if name in _PARENTS}
    if "Root" not in centres:
        centres["Root"] = (centres["left_up_leg"] + centres["right_up_leg"]) / 2
    if "neck1" not in centres and {"left_up_arm", "right_up_arm"} <= centres.keys():
        centres["neck1"] = (centres["left_up_arm"] + centres["right_up_arm"]) / 2
    markers = {
        name: positions[:, index]
        for body in bodies_of(skeleton)
        for name, index in index_landmarks(skeleton, body).items()
    }
    names, steps = line_steps(skeleton, calibration.bones, points, None, reading)
    found = np.where(steps == UNSEEN, np.nan, steps / LINE)
    lines = {bone: found[:, names.index(line_of(bone))] for bone in BONES if line_of(bone) in names}
    return Landmarks(centres, markers, lines), calibration


def _joints(body: Landmarks, frames: dict[str, Array]) -> tuple[dict[str, Array], dict[str, Array]]:
    """The centre (n, 3) of each joint, from the root on, and its offset (3,) in the frame of the segment above.

    Adds the frames of joints at the ends of limbs, which turn with the segment that carries them.
    """
    tops, offsets = {"Root": body.centres["Root"]}, {"Root": np.zeros(3)}
    for joint, above in _PARENTS.items():
        centre = body.centres.get(_AT.get(joint, joint))
        if centre is None or above not in tops or above not in frames:
            continue
        vectors = np.einsum("nji,nj->ni", frames[above], centre - tops[above])
        vectors = vectors[np.isfinite(vectors).all(axis=1)]
        if len(vectors):
            tops[joint], offsets[joint] = centre, np.median(vectors, axis=0)
            frames.setdefault(joint, frames[above])
    return tops, offsets


def _above(joint: str) -> list[str]:
    """The joints above one, whose rotations its position depends on."""
    found = []
    while joint := _PARENTS[joint]:
        found.append(joint)
    return found


def _body_axes(up: str) -> Array:
    """(3, 3) to the front, to the left and up, in the axes of the trial, of a body at rest: it faces the axis after the
    upward one, as the heading 0 does."""
    upward = axis_of(up)
    front = np.roll(np.abs(upward), 1)
    return np.stack([front, np.cross(upward, front), upward], axis=1)


def _order(axes: Array) -> str:
    """The order of rotations: about the front, about the left, about up, as most BVH files have it."""
    return "".join("XYZ"[int(np.argmax(np.abs(axis)))] for axis in axes.T)


def _skeleton(chain: list[str], offsets: Mapping[str, Array], axes: Array) -> Skeleton:
    order = _order(axes)
    turns = tuple(f"R{letter.lower()}" for letter in order)
    return Skeleton(
        tuple(
            Joint(
                name=joint,
                parent=chain.index(_PARENTS[joint]) if _PARENTS[joint] else -1,
                source_name=joint,
                convention=Convention.LISTED,
                channels=turns if _PARENTS[joint] else (*TRANSLATIONS, *turns),
                rotation_order=order,
                offset=triple(offsets[joint]),
                translation="" if _PARENTS[joint] else "absolute",
                mapped=True,
            )
            for joint in chain
        )
    )


def _turns(chain: list[str], frames: Mapping[str, Array], axes: Array) -> tuple[Array, Flags]:
    """Local rotations (n, J, 4), those of the frame before where unknown, and where they are known (n, J)."""
    world = {joint: from_matrix(frames[joint] @ axes.T) for joint in chain}
    local = [
        multiply(inverse(world[_PARENTS[joint]]), world[joint]) if _PARENTS[joint] else world[joint] for joint in chain
    ]
    rotations = np.stack(local, axis=1)
    known: Flags = np.all(np.isfinite(rotations), axis=2)
    rows = np.where(known, np.arange(1, len(known) + 1)[:, None], 0)
    rows = np.maximum.accumulate(rows, axis=0)
    rest = np.broadcast_to(IDENTITY, (1, *rotations.shape[1:]))
    return np.take_along_axis(np.concatenate([rest, rotations]), rows[:, :, None], axis=0), known
