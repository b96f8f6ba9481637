"""Walks on curves, those of the demo library."""

from __future__ import annotations

from dataclasses import replace

from mcml.motion.bodies.clip_body import body_of
from mcml.motion.clip import ClipStream
from mcml.motion.matching.tracks import JOINTS, Track, track_of
from mcml_service.demo.walks import turning_walk

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
    return turning_walk(f"walk {degrees:g}", HEIGHT, degrees, seconds, heading=heading, away=away)


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
