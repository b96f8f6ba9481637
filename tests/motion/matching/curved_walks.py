"""Walks on curves, made from the walk of the demo library."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mcml.motion.bodies.clip_body import body_of
from mcml.motion.clip import ClipStream
from mcml.motion.matching.tracks import JOINTS, Track, track_of
from mcml_service.demo import body

HEIGHT = 170.0
NAMES = {"Hips": "Root", "Spine": "waist", "Spine1": "torso7", "Neck": "neck1"} | {
    f"{side}{part}": f"{side.lower()}_{name}"
    for side in ("Left", "Right")
    for part, name in {
        "UpLeg": "up_leg",
        "Leg": "low_leg",
        "Foot": "foot",
        "ToeBase": "toes",
        "Shoulder": "shoulder",
        "Arm": "up_arm",
        "ForeArm": "low_arm",
        "Hand": "hand",
    }.items()
}


def curved_walk(degrees: float, seconds: float = 5.0, *, heading: float = 0.0, away: float = 0.0) -> ClipStream:
    """A walk that turns by so many degrees a second to the left, from a heading and a place (cm) on."""
    root, angles = body.walk(HEIGHT, seconds, 1.0, 6.0)
    time = np.arange(len(root)) / body.RATE
    yaw = np.radians(heading + degrees * time)
    side, forward = root[:, 0], np.diff(root[:, 2], prepend=root[0, 2])
    ways = np.cumsum(forward[:, None] * np.stack([np.sin(yaw), np.cos(yaw)], axis=1), axis=0)
    turned = np.stack([away + ways[:, 0] + side * np.cos(yaw), root[:, 1], ways[:, 1] - side * np.sin(yaw)], axis=1)
    zero = np.zeros_like(time)
    hips = np.stack([zero, zero, np.degrees(yaw)], axis=1)
    return body.clip(f"walk {degrees:g}", HEIGHT, turned, {**angles, "Hips": hips})


def track_of_clip(clip: ClipStream) -> Track:
    """The track of a clip whose joints have the names of the demo library."""
    named = with_names(clip)
    track = track_of(body_of(named.head, named.blocks()).stretch(JOINTS))
    assert track is not None
    return track


def with_names(clip: ClipStream) -> ClipStream:
    """The clip with MCML's names of joints, as an import gives them."""
    skeleton = clip.head.skeleton
    joints = tuple(replace(joint, name=NAMES.get(joint.name, joint.name)) for joint in skeleton.joints)
    return clip.with_head(replace(clip.head, skeleton=replace(skeleton, joints=joints)))
