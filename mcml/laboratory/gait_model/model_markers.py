"""Markers of a clip by the names of Plug-in Gait, also if the file has other names for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from mcml.motion.landmarks.centres import bodies_of, marker_labels
from mcml.motion.landmarks.recognise import MarkerBody, measured_markers
from mcml.motion.landmarks.tables import key_of
from mcml.motion.skeleton import Skeleton

_MIDDLE: Final[Mapping[str, str]] = {"SACR": "sacrum", "CLAV": "jugular_notch", "C7": "c7", "STRN": "xiphoid",
                                     "T10": "t10"}  # fmt: skip
_SIDED: Final[Mapping[str, str]] = {
    "ASI": "asis",
    "PSI": "psis",
    "THI": "thigh_tracking",
    "KNE": "knee_lateral",
    "KNM": "knee_medial",
    "TIB": "shank_tracking",
    "ANK": "ankle_lateral",
    "MED": "ankle_medial",
    "HEE": "heel",
    "TOE": "mt2",
    "FHD": "head_front",
    "BHD": "head_back",
    "SHO": "acromion",
    "ELB": "elbow_lateral",
    "WRA": "wrist_radial",
    "WRB": "wrist_ulnar",
    "FIN": "mt3_hand",
}
_BY_NAME: Final = ("KAX", "KD1", "KD2", "FEP", "FEO", "TIO", "HJC", "KJC", "AJC")
"""The alignment device of the knee, and centres of hip, knee and ankle that programs write among the markers: those of
Plug-in Gait itself, and those of any model."""
_PAIRS: Final[Mapping[str, tuple[str, ...]]] = {
    "KneeLateral": ("knee_lateral",),
    "KneeMedial": ("knee_medial",),
    "AnkleLateral": ("ankle_lateral",),
    "AnkleMedial": ("ankle_medial",),
    "Heel": ("heel",),
    "Toe": ("mt2", "toe_tip", "big_toe"),
}
"""Points of any landmark set, the best first, by the name that the model gives them."""
_SIDES: Final = {"L": "left", "R": "right"}


@dataclass(frozen=True)
class ModelMarkers:
    """joints: index of each marker in the skeleton, by the name of Plug-in Gait ("LKNE", "LFEO") or of a landmark
    ("LKneeMedial"). sources: the names in the file. problem: why there are none, "" where there are, or where the clip
    has no markers of a body."""

    joints: Mapping[str, int] = field(default_factory=dict)
    sources: Mapping[str, str] = field(default_factory=dict)
    prefix: str = ""
    problem: str = ""


def find_people(skeleton: Skeleton) -> tuple[str, ...]:
    """Return the prefixes of people's markers, where there are several people; () for one or none."""
    bodies = bodies_of(skeleton)
    return tuple(body.prefix for body in bodies) if len(bodies) > 1 else ()


def find_model_markers(skeleton: Skeleton, person: str | None = None) -> ModelMarkers:
    """Find the markers: by their own names, else by the landmarks that they are recognised as.

    person: the prefix of the markers, where there are several people.
    """
    bodies = [body for body in bodies_of(skeleton) if person in (None, body.prefix)]
    if not bodies:
        return ModelMarkers()
    if len(bodies) > 1:
        listed = ", ".join(f"{body.prefix}:" for body in bodies)
        return ModelMarkers(problem=f"the markers are of several people: begin the name with one of {listed}")
    body = bodies[0]
    if body.are_centres:
        return ModelMarkers()
    own = _by_name(skeleton, body, is_alone=person is None)
    landmarks = _by_landmark(body)
    joints: dict[str, int] = {}
    wanted = {**_MIDDLE} | {
        side + name: f"{_SIDES[side]}_{landmark}" for side in "LR" for name, landmark in _SIDED.items()
    }
    for name, landmark in wanted.items():
        index = own.get(key_of(name), landmarks.get(landmark))
        if index is not None:
            joints[name] = index
    for side in "LR":
        for name in _BY_NAME:
            if (index := own.get(key_of(side + name))) is not None:
                joints[side + name] = index
        for name, ways in _PAIRS.items():
            seen = [index for way in ways if (index := landmarks.get(f"{_SIDES[side]}_{way}")) is not None]
            joints |= {side + name: seen[0]} if seen else {}
    sources = {name: skeleton.joints[index].source_name for name, index in joints.items()}
    return ModelMarkers(joints, sources, body.prefix)


def find_segments(skeleton: Skeleton, prefix: str) -> dict[str, str]:
    """Return "left_thigh" and such for the labels of markers that follow a segment, "" for labels without a meaning.

    prefix: of the person's markers; labels are without it. Other markers are not listed.
    """
    segments: dict[str, str] = {}
    labels = marker_labels(skeleton)
    for body in (body for body in bodies_of(skeleton) if body.prefix == prefix):
        for index in measured_markers(labels):
            before, _, bare = labels[index].rpartition(":")
            landmark = body.landmarks.get(index, "")
            segment = landmark.removesuffix("_tracking")
            if before.strip() == prefix and (not landmark or segment != landmark):
                segments.setdefault(bare.strip(), segment)
    return segments


def _by_name(skeleton: Skeleton, body: MarkerBody, *, is_alone: bool) -> dict[str, int]:
    """Index of each name without its prefix. Points that a model computes may lack the prefix of the person."""
    own: dict[str, int] = {}
    # Without a prefix they may be of anybody.
    for prefix in dict.fromkeys((body.prefix, "")) if is_alone else (body.prefix,):
        for index, label in enumerate(marker_labels(skeleton)):
            before, _, bare = label.rpartition(":")
            if before.strip() == prefix:
                own.setdefault(key_of(bare), index)
    return own


def _by_landmark(body: MarkerBody) -> dict[str, int]:
    """Index of each landmark; none of a segment that several markers follow, which have no order."""
    found: dict[str, int] = {}
    several = set()
    for index, landmark in body.landmarks.items():
        if landmark in found:
            several.add(landmark)
        found.setdefault(landmark, index)
    return {landmark: index for landmark, index in found.items() if landmark not in several}
