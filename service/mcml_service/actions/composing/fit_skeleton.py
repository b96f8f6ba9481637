"""Convert frames of one clip to the skeleton of another: unchanged if both are the same body, else retargeted."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mcml.errors import DocumentError
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.conventions.resizing import scale, turn_up
from mcml.motion.frames import joined
from mcml.motion.retargeting.bone_mapping import Match, suggest_matches
from mcml.motion.retargeting.retarget import retarget
from mcml.motion.skeleton import Skeleton
from mcml.motion.solving.marker_skeleton import has_markers, with_skeleton
from mcml.motion.units import metres_of
from mcml_schemas.retarget import JointPair
from mcml_service.actions.editing.motion_processing import Whole


@dataclass(frozen=True)
class JointMapping:
    """A mapping of joints by a person.

    exact: every name must exist; else unknown names are ignored, as in a mapping that was saved for many rigs.
    """

    pairs: tuple[JointPair, ...]
    exact: bool = True


@dataclass(frozen=True)
class Fitted:
    """block: in the joints and channels of the other skeleton. notices: the changes, as text."""

    block: FrameBlock
    notices: tuple[str, ...] = ()


def fit(source: Whole, body: Whole, mapping: JointMapping | None, frame_time: float) -> Fitted:
    """Convert frames to the skeleton of `body`: bit by bit if it is the same one, in any order of its joints.

    Markers keep their places, in the unit of `body`. Another body is retargeted by its MCML names, or by `mapping`; its
    travel is scaled by the legs, which also converts units. Markers on a body get a skeleton first. frame_time:
    seconds. The frames of `body` show lengths that its skeleton lacks at rest. Raises DocumentError for a body on
    markers, for markers that lack some of `body`'s, and if almost no joints match; ConversionError for markers that
    show no skeleton.
    """
    own, two = source.head.skeleton, body.head.skeleton
    if has_markers(own) and has_markers(two):
        return _markers(source, body)
    if mapping is None and _is_same_body(own, two):
        return Fitted(_renumber_joints(source, two))
    if has_markers(two):
        raise DocumentError(
            "The result has markers: a body does not fit on them.", remedy="Take the document of a body as skeleton."
        )
    source, solved = give_skeleton(source)
    source, notices = upright(source, body.up)
    notices = [*solved, *notices]
    own = source.head.skeleton
    matches = match_joints(own, two, mapping)
    if mapping is None and 2 * len(matches) <= min(len(own), len(two)):
        raise DocumentError(
            f"Only {len(matches)} joints of {len(own)} are known in the skeleton of the result, which has {len(two)}.",
            remedy="Say in `mapping` which joint is which, or take the skeleton of another document.",
        )
    made = retarget(
        own,
        source.block,
        two,
        matches,
        frame_time,
        reading=source.reading,
        target_reading=body.reading,
        up=source.up,
        target_block=body.block,
    )
    notices += [notice.what for notice in [*made.report.notices(own, two), *made.shortfall.notices(two)]]
    return Fitted(made.block, tuple(notices))


def upright(whole: Whole, up: str) -> tuple[Whole, list[str]]:
    """The same motion with this axis up, and a notice where it was another one."""
    if whole.up == up:
        return whole, []
    clip = turn_up(ClipStream(whole.head, lambda: iter([whole.block]), len(whole.block)), whole.up, up)
    made = replace(whole, head=clip.head, block=joined(clip.blocks()), up=up)
    return made, [f"turned, so that {up} points up and not {whole.up}"]


def match_joints(source: Skeleton, target: Skeleton, mapping: JointMapping | None) -> tuple[Match, ...]:
    """Return suggested matches, or those of a mapping. Raises DocumentError for unknown names in an exact mapping."""
    if mapping is None:
        return suggest_matches(source, target)
    suggested = {(match.source, match.target): match for match in suggest_matches(source, target)}
    matches = []
    for pair in mapping.pairs:
        unknown = [
            (what, name)
            for name, skeleton, what in ((pair.source, source, "motion"), (pair.target, target, "skeleton"))
            if name not in skeleton.names
        ]
        if unknown and mapping.exact:
            what, name = unknown[0]
            raise DocumentError(f"The {what} has no joint {name!r}.", remedy="Ask with preview for all names.")
        if not unknown:
            key = source.names.index(pair.source), target.names.index(pair.target)
            matches.append(suggested.get(key) or Match(*key, 1.0, "you said so"))
    return tuple(matches)


def give_skeleton(whole: Whole) -> tuple[Whole, list[str]]:
    """The same motion with a skeleton where it has markers, and notices about that. Raises as `with_skeleton` does."""
    if not has_markers(whole.head.skeleton):
        return whole, []
    clip = with_skeleton(ClipStream(whole.head, lambda: iter([whole.block]), len(whole.block)))
    made = replace(whole, head=clip.head, block=joined(clip.blocks()), names=clip.head.skeleton.names)
    return made, [notice.what for notice in clip.notices]


def _is_same_body(one: Skeleton, two: Skeleton) -> bool:
    """Whether every bone of one is a bone of the other, below the same one."""
    if one == two:
        return True
    others = {joint.name: (_parent(two, joint.parent), replace(joint, parent=0)) for joint in two.joints}
    return len(one) == len(two) and all(
        others.get(joint.name) == (_parent(one, joint.parent), replace(joint, parent=0)) for joint in one.joints
    )


def _parent(skeleton: Skeleton, index: int) -> str:
    return skeleton.joints[index].name if index >= 0 else ""


def _renumber_joints(source: Whole, skeleton: Skeleton) -> FrameBlock:
    """Renumber the joints of frames for the other skeleton; joints that it lacks are left out."""
    block, names = source.block, source.head.skeleton.names
    if names == skeleton.names:
        return block
    place = {name: index for index, name in enumerate(skeleton.names)}
    number = {joint: place[name] for joint, name in enumerate(names) if name in place}
    kept = [column for column, (joint, _) in enumerate(block.columns) if joint in number]
    return replace(
        block,
        values=block.values[:, kept],
        columns=tuple((number[joint], channel) for joint, channel in block.columns if joint in number),
        shapes=tuple(
            tuple((number[joint], bits) for joint, bits in shape if joint in number) for shape in block.shapes
        ),
    )


def _markers(source: Whole, body: Whole) -> Fitted:
    names = set(source.head.skeleton.names), set(body.head.skeleton.names)
    lacking, extra = sorted(names[1] - names[0]), sorted(names[0] - names[1])
    if lacking:
        raise DocumentError(
            f"The markers of the result are not all there: {', '.join(lacking[:20])}.",
            remedy="Take the document with the fewest markers as skeleton.",
        )
    source, notices = upright(source, body.up)
    if extra:
        notices.append(f"{len(extra)} markers that the result does not have are left out: {', '.join(extra[:20])}")
    units = metres_of(source.head), metres_of(body.head)
    if units[0] is not None and units[1] is not None and units[0] != units[1]:
        factor = units[0] / units[1]
        clip = scale(ClipStream(source.head, lambda: iter([source.block]), len(source.block)), factor)
        notices.append(f"lengths are multiplied by {factor:.6g}: the units differ")
        source = replace(source, block=joined(clip.blocks()))
    elif (units[0] is None) != (units[1] is None):
        notices.append("lengths stay as they are: only one of the units is stated")
    return Fitted(_renumber_joints(source, body.head.skeleton), tuple(notices))
