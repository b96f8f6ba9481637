"""The motion that an analysis made, for viewing: points in the world, and the lines between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcml.motion.guesses import likely_up
from mcml.motion.hub import walked
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import numbers
from mcml_schemas.frames import MotionHead
from mcml_service.analysis.interface import MadeClip


def show_motion(clip: MadeClip) -> tuple[MotionHead, NDArray[np.float32]]:
    """Return positions (F, P, 3) of joints and then of ends of chains, relative to the first joint's in frame 1; and
    their layout. NaN where there is no sample.
    """
    skeleton = clip.skeleton
    tips = [(index, numbers(site.offset)) for index, joint in enumerate(skeleton.joints) for site in joint.end_sites]
    positions, turned = walked(skeleton, clip.translations, clip.rotations)
    ends = [positions[:, joint] + rotate(turned[:, joint], offset) for joint, offset in tips]
    points = np.concatenate([positions, *(end[:, None] for end in ends)], axis=1)
    parents = [*(joint.parent for joint in skeleton.joints), *(joint for joint, _ in tips)]
    if clip.present is not None:
        points[~clip.present[:, [*range(len(skeleton)), *(joint for joint, _ in tips)]]] = np.nan
    origin = np.nan_to_num(points[0, 0]) if len(points) and len(skeleton) else np.zeros(3)
    points -= origin
    head = MotionHead(
        first=1,
        shape=list(points.shape),
        bones=list(skeleton.names),
        parents=parents,
        origin=origin.tolist(),
        seconds_per_frame=clip.frame_time,
        up=clip.up or likely_up(skeleton, positions).axis,
        metres=clip.metres,
    )
    return head, points.astype("<f4")
