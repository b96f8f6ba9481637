"""The skeleton of a document as the wire shows it to those who draw it."""

from __future__ import annotations

import numpy as np

from mcml.errors import FormatError, LimitError
from mcml.language import vocabulary
from mcml.language.element import addresses
from mcml.language.elements import to_head
from mcml.motion.bodies.positions import clip_positions, filled
from mcml.motion.clip import ClipHead
from mcml.motion.floor_plates import kept_plates, match_plates
from mcml.motion.guesses import likely_unit, up_of_head
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import rest_positions
from mcml.motion.landmarks.centres import centres_of
from mcml.motion.landmarks.lines import marker_lines
from mcml.motion.pictures.figures import is_markers
from mcml.motion.sides import is_left, partners
from mcml.motion.skeleton import CHANNELS, Array, Convention, Skeleton
from mcml.motion.units import reading_of
from mcml_schemas.skeletons import FloorPlate, Side, SkeletonBone, SkeletonView, Tip
from mcml_service.actions.reading.read_origin import first_pose, origin_in
from mcml_service.clips.frame_quantities import read_measurements
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

POSES = 64
"""Of a clip of points that its axis up is guessed from."""


def describe_skeleton(tx: Transaction, stored: StoredDocument) -> SkeletonView:
    """Describe a skeleton. Numbers are the doubles of the head's texts and of the first frame."""
    if stored.frames:
        source, pose = first_pose(tx, stored)
        head = source.clip.head
        head_pose, origin = pose, origin_in(pose)
    else:
        head = to_head(tx.heads.document(stored), stored.frame_time)
        head_pose, origin = rest_positions(head.skeleton, reading_of(head))[: len(head.skeleton)], np.zeros(3)
    reading = reading_of(head)
    rest = rest_of(head.skeleton, reading)
    unit, up = head.fields.get("calibration_unit"), head.fields.get("global_axis_of_gravity")
    likely, metres = likely_unit(head, head_pose)
    poses = head_pose if up else _some_poses(tx, stored, head.skeleton, head_pose)
    sides, others = sides_of(head.skeleton)
    joints = (vocabulary.ROOT, vocabulary.BONE)
    places = [address for address, element in addresses(tx.heads.document(stored)) if element.tag in joints]
    return SkeletonView(
        id=stored.uuid,
        name=stored.name,
        revision=stored.revision,
        frames=stored.frames,
        frame_time=stored.frame_time,
        seconds_per_frame=stored.seconds_per_frame,
        markers=any(joint.convention is Convention.MARKER for joint in head.skeleton.joints),
        unit=unit,
        likely_unit=likely,
        metres=metres,
        up=up,
        likely_up=up.strip().upper() if up else up_of_head(head, poses).axis,
        origin=origin.tolist(),
        radians=reading.motion_angle,
        bones=[
            SkeletonBone(
                address=places[index],
                name=joint.name,
                source_name=joint.source_name,
                mapped=joint.mapped,
                confidence=None if joint.confidence is None else float(joint.confidence),
                role=joint.role,
                parent=joint.parent,
                side=sides[index],
                partner=others[index],
                offset=rest.offsets[index].tolist(),
                axes=rest.orientations[index].tolist(),
                along=rest.bones[index].tolist(),
                channels=list(joint.channels),
                rotation_order=joint.rotation_order,
                convention=joint.convention.value,
                translation=joint.translation,
            )
            for index, joint in enumerate(head.skeleton.joints)
        ],
        tips=_tips(head.skeleton, rest.tips),
        centres=[centre.name for centre in centres_of(head.skeleton)],
        lines=list(marker_lines(head.skeleton)),
        plates=_plates(tx, stored, head, metres),
        columns=[f"{head.skeleton.joints[joint].name}.{CHANNELS[part]}" for joint, part in head.skeleton.columns()],
    )


def _plates(tx: Transaction, stored: StoredDocument, head: ClipHead, metres: float | None) -> list[FloorPlate]:
    """The plates of the head, with names where the forces of the file are those of a plate at the same place."""
    plates = kept_plates(head)
    if not len(plates):
        return []
    try:
        corners = read_measurements(tx, stored).plate_corners
    except (FormatError, LimitError):
        corners = {}
    names = match_plates(plates * (metres or np.nan), corners)
    return [FloorPlate(name=name, corners=plate.tolist()) for name, plate in zip(names, plates, strict=True)]


def sides_of(skeleton: Skeleton) -> tuple[list[Side], list[int]]:
    """The side of each joint, and the index of its partner on the other one, its own in the middle."""
    others = partners(skeleton).tolist()
    sides: list[Side] = []
    for index, other in enumerate(others):
        sides.append("centre" if other == index else "left" if is_left(skeleton, index, other) else "right")
    return sides, others


def _tips(skeleton: Skeleton, tips: tuple[tuple[int, Array], ...]) -> list[Tip]:
    """Ends of chains, with the names that their file gives them."""
    names = {index: [site.name for site in joint.end_sites] for index, joint in enumerate(skeleton.joints)}
    return [
        Tip(bone=joint, name=names[joint].pop(0) if names[joint] else "", offset=vector.tolist())
        for joint, vector in tips
    ]


def _some_poses(tx: Transaction, stored: StoredDocument, skeleton: Skeleton, pose: Array) -> Array:
    """Return poses spread over the clip for points, whose travel decides the up axis; for bodies the first pose, (J,
    3).
    """
    if not stored.frames or not is_markers(skeleton):
        return pose
    clip = read_clip(tx, stored, step=max(1, stored.frames // POSES), bare=True).clip
    (positions,) = clip_positions(skeleton, [filled(skeleton, clip.blocks())], reading_of(clip.head))
    return positions
