"""Centres of joints from landmarks: additional points of a body besides its markers.

A landmark is not a joint: a lateral marker of the knee is half a knee's width away from its centre. So a centre is
known only from both sides of a joint (the mean of lateral and medial), or if the file has it: key points of cameras,
and centres that a model wrote. No centre is guessed from one side, and none of a hip from the pelvis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mcml.motion.landmarks.recognise import MarkerBody, recognise_markers
from mcml.motion.skeleton import Array, Convention, Skeleton, once_a_skeleton

_SIDED: tuple[tuple[str, tuple[tuple[str, ...], ...]], ...] = (
    ("up_leg", (("hip_centre",),)),
    ("low_leg", (("knee_centre",), ("knee_lateral", "knee_medial"))),
    ("foot", (("ankle_centre",), ("ankle_lateral", "ankle_medial"))),
    ("toes", (("mt1", "mt5"),)),
    ("up_arm", (("shoulder_centre",),)),
    ("low_arm", (("elbow_centre",), ("elbow_lateral", "elbow_medial"))),
    ("hand", (("wrist_centre",), ("wrist_radial", "wrist_ulnar"))),
)
"""Of each joint of a side the landmarks that it is the mean of, the best first."""
_MIDDLE: tuple[tuple[str, tuple[tuple[str, ...], ...]], ...] = (
    ("Root", (("hip_midpoint",), ("left_asis", "right_asis", "left_psis", "right_psis"),
              ("left_asis", "right_asis", "sacrum", "sacrum"), ("left_hip_centre", "right_hip_centre"))),
    ("neck1", (("neck",), ("c7", "jugular_notch"))),
    ("Head", (("left_head_front", "right_head_front", "left_head_back", "right_head_back"),
              ("left_ear", "right_ear"))),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Centre:
    """The centre of a joint.

    name: MCML's, after the prefix of a person if there are several. markers: indices of the averaged markers.
    landmarks: their landmarks.
    """

    name: str
    markers: tuple[int, ...]
    landmarks: tuple[str, ...]


@once_a_skeleton
def bodies_of(skeleton: Skeleton) -> tuple[MarkerBody, ...]:
    """Return the bodies of the markers of a skeleton; none if its joints are not markers."""
    if not skeleton.joints or any(joint.convention is not Convention.MARKER for joint in skeleton.joints):
        return ()
    return recognise_markers([joint.source_name for joint in skeleton.joints])


@once_a_skeleton
def centres_of(skeleton: Skeleton) -> tuple[Centre, ...]:
    """The centres of joints that markers tell, without those whose name a marker has."""
    bodies = bodies_of(skeleton)
    taken = set(skeleton.names)
    found: list[Centre] = []
    for body in bodies:
        before = f"{body.prefix}:" if len(bodies) > 1 and body.prefix else ""
        for centre in _centres(body):
            name = before + centre.name
            if name not in taken:
                taken.add(name)
                found.append(Centre(name, centre.markers, centre.landmarks))
    return tuple(found)


def body_names(skeleton: Skeleton) -> tuple[str, ...]:
    """The names of the points of a body: its joints, and centres of joints that markers tell."""
    return (*skeleton.names, *(centre.name for centre in centres_of(skeleton)))


def _centres(body: MarkerBody) -> list[Centre]:
    at: Mapping[str, int] = {landmark: index for index, landmark in body.landmarks.items()}
    asked = [
        (f"{side}_{joint}", [[f"{side}_{landmark}" for landmark in means] for means in ways])
        for side in ("left", "right")
        for joint, ways in _SIDED
    ]
    asked += [(joint, [list(means) for means in ways]) for joint, ways in _MIDDLE]
    found = []
    for name, ways in asked:
        landmarks = next((means for means in ways if all(landmark in at for landmark in means)), None)
        if landmarks is not None:
            found.append(Centre(name, tuple(at[landmark] for landmark in landmarks), tuple(landmarks)))
    return found


def with_centres(centres: Sequence[Centre], positions: Array) -> Array:
    """(n, J + C, 3) positions of markers and, after them, of centres; NaN where a marker of a centre is unknown."""
    if not centres:
        return positions
    means = [positions[:, list(centre.markers)].mean(axis=1) for centre in centres]
    return np.concatenate([positions, np.stack(means, axis=1)], axis=1)
