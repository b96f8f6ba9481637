"""Facts that depend on the skeleton only, computed once for all clips that share it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from mcml.files.describe_clip import SkeletonFacts, skeleton_facts
from mcml.language import joint_names
from mcml.language.bones import write_skeleton
from mcml.language.dtd import validate_by_shapes
from mcml.language.elements import Element, mcml_element
from mcml.language.joint_names import NamingReport
from mcml.motion.carriers import first_moving
from mcml.motion.clip import ClipStream, Shape, full_shape
from mcml.motion.frames import rows_of
from mcml.motion.kinematics import Walker, unseen
from mcml.motion.landmarks.centres import bodies_of
from mcml.motion.landmarks.places import check_places, fullest_frame
from mcml.motion.rigs.recognise import Recognition
from mcml.motion.rigs.skeletons import MOST_JOINTS, recognise_clip
from mcml.motion.skeleton import Skeleton
from mcml.motion.units import reading_of

_AWAY = 0.3
"""Of the distance from the hips to the farthest joint below: a possible root that is farther away is on the floor."""


@dataclass(frozen=True, eq=False)
class SharedSkeleton:
    """The skeleton of a source in the form of a document; read-only.

    skeleton, report: with MCML's names, and their evidence. elements: `root`, if there is one, and `skeleton`. shape:
    of a frame that has every channel. facts: for receipts.
    """

    skeleton: Skeleton
    report: NamingReport
    elements: tuple[Element, ...]
    shape: Shape
    facts: SkeletonFacts


def shared_skeleton(clip: ClipStream, aliases: tuple[tuple[str, str], ...] = ()) -> SharedSkeleton:
    """Name the joints of a source and write them as elements.

    Raises DocumentError if these would be invalid. aliases: of a project (name in the source, name to give). Frames are
    read only if the motion must decide which of several joints is the root, or if the rest pose is not a standing body.
    """
    source = clip.head.skeleton
    rig = recognise_clip(clip)
    shared = (kept_skeleton if len(source) <= MOST_JOINTS else _made)(source, aliases, moving_root(clip, rig), rig)
    told = _told_of_places(clip)
    return replace(shared, report=replace(shared.report, told=(*shared.report.told, *told))) if told else shared


def _told_of_places(clip: ClipStream) -> list[str]:
    """Return sentences about landmarks whose positions in the first block of frames contradict their names."""
    bodies, block = bodies_of(clip.head.skeleton), None
    if bodies:
        block = next(iter(clip.blocks()), None)
    if block is None or not len(block):
        return []
    positions = Walker(clip.head.skeleton, reading_of(clip.head)).poses(block)[0]
    positions[unseen(clip.head.skeleton, block)] = np.nan
    places = positions[fullest_frame(bodies, positions)]
    return [sentence for body in bodies for sentence in check_places(body, places)]


def moving_root(clip: ClipStream, rig: Recognition) -> int | None:
    """Return which of several possible root joints is Root, None if the skeleton alone decides.

    It is the first that moves, if it is where the hips are. A joint on the floor that moves a figure, as for the root
    motion of game engines, is not: its height is not that of the pelvis.
    """
    source = clip.head.skeleton
    candidates = (_kept_candidates if len(source) <= MOST_JOINTS else joint_names.root_candidates)(source, rig)
    if len(candidates) < 2:
        return None
    hips, moving = candidates[-1], first_moving(clip, candidates)
    return hips if moving is None or _is_away(clip, moving, hips) else moving


def _is_away(clip: ClipStream, joint: int, hips: int) -> bool:
    """Tell whether a joint is far from the hips in the first frame, compared with the size of the body below them."""
    block = next(iter(clip.blocks()), None)
    if block is None or not len(block):
        return False
    skeleton = clip.head.skeleton
    places = Walker(skeleton, reading_of(clip.head)).poses(rows_of(block, 0, 1))[0][0]
    far = np.linalg.norm(places - places[hips], axis=1)
    body = [index for index in range(hips + 1, len(skeleton)) if far[index] > 0]
    return bool(far[joint] > _AWAY * max(far[body], default=0.0))


def _made(source: Skeleton, aliases: tuple[tuple[str, str], ...], root: int | None, rig: Recognition) -> SharedSkeleton:
    skeleton, report = joint_names.named(source, aliases, root, rig)
    elements = tuple(write_skeleton(skeleton))
    shape = full_shape(skeleton.columns())
    validate_by_shapes(mcml_element(Element("header"), elements), [(shape, 1)], skeleton.names)
    return SharedSkeleton(skeleton, report, elements, shape, skeleton_facts(skeleton))


kept_skeleton = lru_cache(maxsize=64)(_made)
_kept_candidates = lru_cache(maxsize=64)(joint_names.root_candidates)
