"""The points of a body that gait is measured with: heels, toes and both sides of the pelvis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from mcml.errors import DocumentError, NotFoundError
from mcml.laboratory.gait_events import SIDES, WalkerPaths
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.landmarks.centres import bodies_of
from mcml.motion.landmarks.recognise import MarkerBody
from mcml.motion.skeleton import Array, Skeleton

Names: TypeAlias = tuple[str, ...]
"""Names of points whose mean is meant."""
Pair: TypeAlias = tuple[Names, Names]
"""Of the left and of the right side."""

_LANDMARKS: Final[Mapping[str, tuple[Names, ...]]] = {
    "heel": (("heel",), ("ankle_lateral", "ankle_medial"), ("ankle_lateral",), ("ankle_centre",)),
    "toe": (("mt2",), ("big_toe",), ("toe_tip",), ("mt1", "mt5"), ("mt5",), ("mt1",), ("small_toe",)),
    "hip": (("asis",), ("psis",), ("hip_centre",), ("greater_trochanter",)),
}
"""Landmarks of a side for each point, the best first."""
_NEARLY: Final = 0.9
"""Of the frames in which the best seen points are seen: a worse landmark is not worth the rest."""
_JOINTS: Final[Mapping[str, tuple[Names, ...]]] = {"heel": (("foot",),), "toe": (("toes",),), "hip": (("up_leg",),)}
"""Joints of a side in their place."""


@dataclass(frozen=True)
class GaitPoints:
    """choices: for "heel", "toe" and "hip" the pairs (left, right) of names that will do, the best first. ankles: names
    that are ankles in the place of heels. are_joints: whether these are joints of a skeleton instead of markers."""

    choices: Mapping[str, tuple[Pair, ...]]
    ankles: frozenset[Names]
    are_joints: bool

    @property
    def names(self) -> frozenset[str]:
        """All names that may be needed."""
        return frozenset(name for pairs in self.choices.values() for pair in pairs for names in pair for name in names)


@dataclass(frozen=True, eq=False)
class Walker:
    """paths: of a body, in steps of its rounded positions. points: the names that each point is the mean of."""

    paths: WalkerPaths
    points: Mapping[str, Names]


def find_gait_points(skeleton: Skeleton, subject: str | None = None) -> GaitPoints:
    """Find the points by the names of markers or joints.

    subject: the prefix of a person's markers, where there are several people. Raises DocumentError if a point is
    unknown or the person is not stated, NotFoundError for an unknown person.
    """
    bodies = bodies_of(skeleton)
    if bodies:
        body = _choose_body(bodies, subject)
        names = {landmark: skeleton.names[index] for index, landmark in body.landmarks.items()}
        known = _LANDMARKS
    elif subject:
        what = f"No markers have the prefix {subject!r}."
        raise NotFoundError(what, remedy="Leave out the person: the clip has no markers.")
    else:
        names, known = {name: name for name in skeleton.names}, _JOINTS
    choices = {
        point: tuple(
            (_names_of("left", words, names), _names_of("right", words, names))
            for words in ways
            if all(f"{side}_{word}" in names for side in SIDES for word in words)
        )
        for point, ways in known.items()
    }
    missing = [f"{point}s" for point, pairs in choices.items() if not pairs]
    if missing:
        raise DocumentError(
            f"Gait needs heels, toes and hips of both sides. Unknown: {', '.join(missing)}.",
            remedy="Name markers as a marker set such as Plug-in Gait does (LHEE, LTOE, LASI), or joints as MCML does "
            "(left_foot, left_toes, left_up_leg).",
        )
    heels = {name for landmark, name in names.items() if landmark.endswith("_heel")}
    ankles = {way for pair in choices["heel"] for way in pair if bodies and not heels.intersection(way)}
    return GaitPoints(choices, frozenset(ankles), not bodies)


def find_paths(points: GaitPoints, stretch: Stretch, rate: float) -> Walker:
    """Return the paths of the points; of several choices the one that is seen most.

    stretch: all frames, with the names of the points. rate: frames a second.
    """
    places = {name: stretch.at(name) for name in points.names}
    chosen: dict[str, Names] = {}
    for point, pairs in points.choices.items():
        left, right = _choose_pair(pairs, places)
        chosen |= {f"left_{point}": left, f"right_{point}": right}
    at = {point: np.mean([places[name] for name in names], axis=0) for point, names in chosen.items()}
    paths = WalkerPaths(
        heels={side: at[f"{side}_heel"] for side in SIDES},
        toes={side: at[f"{side}_toe"] for side in SIDES},
        pelvis=(at["left_hip"] + at["right_hip"]) / 2,
        across=at["left_hip"] - at["right_hip"],
        up=stretch.up,
        rate=rate,
    )
    return Walker(paths, chosen)


def _names_of(side: str, words: Sequence[str], names: Mapping[str, str]) -> Names:
    return tuple(names[f"{side}_{word}"] for word in words)


def _choose_body(bodies: Sequence[MarkerBody], subject: str | None) -> MarkerBody:
    prefixes = [body.prefix for body in bodies]
    listed = ", ".join(repr(prefix) for prefix in prefixes)
    if subject is not None:
        found = next((body for body in bodies if body.prefix == subject), None)
        if found is None:
            raise NotFoundError(f"No markers have the prefix {subject!r}.", remedy=f"Choose one of: {listed}.")
        return found
    if len(bodies) > 1:
        remedy = f"Choose one with `subject`, or begin the name with it: {prefixes[0]}:left."
        raise DocumentError(f"The markers are of several people: {listed}.", remedy=remedy)
    return bodies[0]


def _choose_pair(pairs: Sequence[Pair], places: Mapping[str, Array]) -> Pair:
    """Return the first pair that is seen nearly as long as any."""
    seen = [
        int(np.all([np.isfinite(places[name][:, 0]) for names in pair for name in names], axis=0).sum())
        for pair in pairs
    ]
    return next(pair for pair, count in zip(pairs, seen, strict=True) if count >= _NEARLY * max(seen))
