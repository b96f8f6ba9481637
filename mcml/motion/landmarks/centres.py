"""Centres of joints from landmarks: additional points of a body besides its markers.

A landmark is not a joint: a lateral marker of the knee is half a knee's width away from its centre. Of each joint the
best way that its landmarks allow is taken: a centre that the file has, the middle between lateral and medial marker, a
regression from the pelvis (hips) or the acromia (shoulders), and a construction beside the lateral marker in the plane
that a wand shows, as the Conventional Gait Model does it. Where no marker shows that plane, the line between the front
spines of the pelvis stands for it, and the centre is a guess.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from mcml.motion.landmarks.construction import Sign, place_centre, place_hip, place_shoulder
from mcml.motion.landmarks.recognise import MarkerBody, recognise_markers
from mcml.motion.landmarks.sizes import Sizes
from mcml.motion.landmarks.tables import key_of
from mcml.motion.skeleton import Array, Convention, Skeleton, once_a_skeleton
from mcml.motion.vectors import cross, length

Rule: TypeAlias = Literal["mean", "hip", "shoulder", "wand", "elbow", "guess"]
"""How a centre is made. mean: of its markers. hip: regression from the pelvis. shoulder: below the acromion. wand:
beside a marker, in the plane of a wand. elbow: beside a marker, in the plane of shoulder and wrist. guess: beside a
marker, in the plane of the line between the front spines."""

_RULES: Final[Mapping[Rule, str]] = {
    "mean": "made from {markers}",
    "hip": "estimated from {markers} by Harrington 2007",
    "shoulder": "estimated from {markers} by Rab 2002",
    "wand": "constructed from {markers}, with the width of the joint that a property states, or a usual one",
    "elbow": "constructed from {markers}, with the width of the joint that a property states, or a usual one",
    "guess": "guessed from {markers}: no marker shows in which plane it is",
}
_SIDES: Final[tuple[tuple[str, str, Sign], ...]] = (("left", "L", 1), ("right", "R", -1))
_SPINES: Final = ("left_asis", "right_asis")
_PELVES: Final = ((*_SPINES, "left_psis", "right_psis"), (*_SPINES, "sacrum", "sacrum"))
"""Landmarks of the pelvis: the front spines, and two whose middle is the sacrum."""

_Way: TypeAlias = tuple[Rule, tuple[str, ...]]
"""A rule and its landmarks: * stands for a side, ~ for the other one, $ for its letter in names of Plug-in Gait."""

_SIDED: Final[tuple[tuple[str, str, tuple[_Way, ...]], ...]] = (
    ("up_leg", "", (("mean", ("$FEP",)), ("mean", ("*_hip_centre",)), *(("hip", pelvis) for pelvis in _PELVES))),
    ("low_leg", "up_leg", (
        ("mean", ("$FEO",)), ("mean", ("*_knee_centre",)), ("mean", ("*_knee_lateral", "*_knee_medial")),
        ("wand", ("*_knee_lateral", "*_thigh_tracking")), ("guess", ("*_knee_lateral", *_SPINES)))),
    ("foot", "low_leg", (
        ("mean", ("$TIO",)), ("mean", ("*_ankle_centre",)), ("mean", ("*_ankle_lateral", "*_ankle_medial")),
        ("wand", ("*_ankle_lateral", "*_shank_tracking")), ("guess", ("*_ankle_lateral", *_SPINES)))),
    ("toes", "", (("mean", ("*_mt1", "*_mt5")), ("mean", ("*_mt2",)))),
    ("up_arm", "", (
        ("mean", ("*_shoulder_centre",)), ("mean", ("$CLO",)),
        *(("shoulder", ("*_acromion", "~_acromion", *pelvis)) for pelvis in _PELVES))),
    ("low_arm", "up_arm", (
        ("mean", ("*_elbow_centre",)), ("mean", ("$HUO",)), ("mean", ("*_elbow_lateral", "*_elbow_medial")),
        ("elbow", ("*_elbow_lateral", "*_wrist_radial", "*_wrist_ulnar")))),
    ("hand", "", (("mean", ("*_wrist_centre",)), ("mean", ("$RAO",)), ("mean", ("*_wrist_radial", "*_wrist_ulnar")))),
)  # fmt: skip
"""Joint of a side, the joint above that its constructions need, and its ways, the best first."""
_MIDDLE: Final[tuple[tuple[str, tuple[_Way, ...]], ...]] = (
    ("Root", (("mean", ("hip_midpoint",)), *(("mean", pelvis) for pelvis in _PELVES),
              ("mean", ("left_hip_centre", "right_hip_centre")))),
    ("neck1", (("mean", ("neck",)), ("mean", ("c7", "jugular_notch")))),
    ("Head", (("mean", ("left_head_front", "right_head_front", "left_head_back", "right_head_back")),
              ("mean", ("left_ear", "right_ear")))),
)  # fmt: skip
_WITH_WANDS: Final = frozenset({"plug-in-gait", "helen-hayes"})
"""Sets whose markers of thigh and shank are in the plane of the joint below and its centre."""
_RADII: Final[Mapping[str, float]] = {"low_leg": 0.155, "foot": 0.098, "low_arm": 0.205}
"""Distance of a lateral marker from the centre of its joint, of its distance from the joint above: medians of public
trials whose files have widths measured by hand (knees 0.142 to 0.161, ankles 0.091 to 0.107; elbows of one trial)."""


@dataclass(frozen=True, slots=True)
class Centre:
    """The centre of a joint.

    name: MCML's, after the prefix of a person if there are several. markers: indices of markers. landmarks: theirs, or
    their names. side: of the joint, 0 in the middle. above: index of the joint above among `body_names`, -1 where none
    is needed. radius: usual distance from the marker, of the marker's distance from the joint above.
    """

    name: str
    markers: tuple[int, ...]
    landmarks: tuple[str, ...]
    rule: Rule = "mean"
    side: Literal[1, -1, 0] = 0
    above: int = -1
    radius: float = 0.0

    @property
    def is_guess(self) -> bool:
        return self.rule == "guess"

    def describe(self) -> str:
        """How it is made, as the end of a sentence."""
        return _RULES[self.rule].format(markers=" and ".join(dict.fromkeys(self.landmarks)))


@once_a_skeleton
def bodies_of(skeleton: Skeleton) -> tuple[MarkerBody, ...]:
    """Return the bodies of the markers of a skeleton; none if its joints are not markers."""
    if not skeleton.joints or any(joint.convention is not Convention.MARKER for joint in skeleton.joints):
        return ()
    return recognise_markers(marker_labels(skeleton))


def marker_labels(skeleton: Skeleton) -> list[str]:
    """The names by which markers are recognised: those of the source, or their own where the source repeats one."""
    often = Counter(joint.source_name for joint in skeleton.joints)
    return [joint.source_name if often[joint.source_name] == 1 else joint.name for joint in skeleton.joints]


@once_a_skeleton
def centres_of(skeleton: Skeleton) -> tuple[Centre, ...]:
    """The centres of joints that markers tell, without those whose name a marker has."""
    bodies = bodies_of(skeleton)
    points = {name: index for index, name in reversed(list(enumerate(skeleton.names)))}
    centres: list[Centre] = []
    for body in bodies:
        before = f"{body.prefix}:" if len(bodies) > 1 and body.prefix else ""
        for centre in _centres(body, index_landmarks(skeleton, body), points, before):
            points[centre.name] = len(skeleton) + len(centres)
            centres.append(centre)
    return tuple(centres)


def body_names(skeleton: Skeleton) -> tuple[str, ...]:
    """The names of the points of a body: its joints, and centres of joints that markers tell."""
    return (*skeleton.names, *(centre.name for centre in centres_of(skeleton)))


def doubtful_names(skeleton: Skeleton) -> tuple[str, ...]:
    """The names of `body_names` that are guesses."""
    return (*skeleton.doubtful, *(centre.name for centre in centres_of(skeleton) if centre.is_guess))


def index_landmarks(skeleton: Skeleton, body: MarkerBody) -> dict[str, int]:
    """Index of each landmark that a body has once, and of each point that is in no set, by its own name."""
    often = Counter(body.landmarks.values())
    at = {landmark: index for index, landmark in body.landmarks.items() if often[landmark] == 1}
    for prefix in dict.fromkeys((body.prefix, "")):
        for index, label in enumerate(marker_labels(skeleton)):
            before, _, bare = label.rpartition(":")
            if index not in body.landmarks and before.strip() == prefix:
                at.setdefault(key_of(bare).upper(), index)
    return at


def _centres(body: MarkerBody, at: Mapping[str, int], points: Mapping[str, int], before: str) -> Iterator[Centre]:
    """points: index of each name of the body, of centres that are made meanwhile too."""
    for joint, ways in _MIDDLE:
        way = next((way for way in ways if _has_all(at, way)), None)
        if way is not None and before + joint not in points:
            yield Centre(before + joint, tuple(at[part] for part in way[1]), way[1], way[0])
    for side, letter, sign in _SIDES:
        other = "right" if side == "left" else "left"
        for joint, above, ways in _SIDED:
            name, upper = f"{before}{side}_{joint}", points.get(f"{before}{side}_{above}", -1)
            named = (
                (rule, tuple(part.replace("*", side).replace("~", other).replace("$", letter) for part in parts))
                for rule, parts in ways
                if rule in ("mean", "hip", "shoulder") or (upper >= 0 and (rule != "wand" or _has_wands(body)))
            )
            way = next((way for way in named if _has_all(at, way)), None)
            if way is not None and name not in points:
                markers = tuple(at[part] for part in way[1])
                yield Centre(name, markers, way[1], way[0], sign, upper, _RADII.get(joint, 0.0))


def _has_wands(body: MarkerBody) -> bool:
    return body.set_name in _WITH_WANDS


def _has_all(at: Mapping[str, int], way: _Way) -> bool:
    return all(part in at for part in way[1])


def with_centres(centres: Sequence[Centre], positions: Array, sizes: Sizes) -> Array:
    """(n, J + C, 3) positions of markers and, after them, of centres; NaN where a marker of a centre is unknown.

    sizes: of the people. Where the unit of the positions is unknown, hips that are estimated from the pelvis are
    unknown.
    """
    if not centres:
        return positions
    points = np.concatenate([positions, np.empty((len(positions), len(centres), 3))], axis=1)
    for index, centre in enumerate(centres, positions.shape[1]):
        points[:, index] = _place(centre, points, sizes)
    return points


def _place(centre: Centre, points: Array, sizes: Sizes) -> Array:
    """(n, 3) a centre. points: (n, J + C, 3), with all centres that it needs."""
    if centre.rule == "mean" or centre.side == 0:
        mean: Array = points[:, list(centre.markers)].mean(axis=1)
        return mean
    first, second, *more = (points[:, marker] for marker in centre.markers)
    if centre.rule == "hip":
        return place_hip(centre.side, first, second, (more[0] + more[1]) / 2, sizes.metres)
    if centre.rule == "shoulder":
        return place_shoulder(first, second, (more[0] + more[1] + more[2] + more[3]) / 4)
    above = points[:, centre.above]
    wand = second
    if centre.rule == "guess":
        wand = first + centre.side * (second - more[0])
    elif centre.rule == "elbow":
        wand = first + centre.side * cross(above - first, (second + more[0]) / 2 - first)
    radius = sizes.radius(centre.name)
    turn = sizes.turns.get(centre.name, 0.0) if centre.rule == "wand" else 0.0
    return place_centre(above, first, wand, centre.radius * length(above - first) if radius is None else radius, turn)
