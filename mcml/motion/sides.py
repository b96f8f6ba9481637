"""Left and right: which joint is the other side's, where the body faces."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.frames import Rows
from mcml.motion.skeleton import ROTATIONS, Array, Skeleton, once_a_skeleton

_SWAPS = (
    (re.compile("left", re.I), "right"),
    (re.compile("right", re.I), "left"),
    (re.compile(r"(?<![a-z])l(?![a-z])", re.I), "r"),
    (re.compile(r"(?<![a-z])r(?![a-z])", re.I), "l"),
    (re.compile(r"(?:(?<=^)|(?<=[:_.\- ]))l(?=[A-Za-z])", re.I), "r"),
    (re.compile(r"(?:(?<=^)|(?<=[:_.\- ]))r(?=[A-Za-z])", re.I), "l"),
    (re.compile(r"(?<=[a-z0-9])L(?=$|[A-Z_.\- ])"), "R"),
    (re.compile(r"(?<=[a-z0-9])R(?=$|[A-Z_.\- ])"), "L"),
)
"""Notations of a side in names (left_foot, LeftFoot, Foot_L, Bip01 L Foot, lfoot, LFIN, footL) and their
counterparts for the other side. A swap is used only if the skeleton has the resulting name.
"""


@dataclass(frozen=True)
class Sagittal:
    """The plane between left and right, in world axes. normal: (3,) unit vector to the left. point: (3,) on it."""

    normal: Array
    point: Array


@dataclass(frozen=True)
class Sides:
    """partners: (J,) of `partners`. links: joints between the two sides of a pair that one side alone has."""

    partners: Rows
    links: frozenset[int]


def partners(skeleton: Skeleton) -> Rows:
    """(J,) the joint of the other side, by MCML's names or else the source's; its own index for one in the middle.

    Only joints that hang from partners, or from one joint, are partners, so that the two sides are trees of one form.
    Links that one side alone has do not count (`sides_of`). Joints whose names tell no side, such as connectors TLS and
    TRS between a trunk and its shoulders, are partners where joints below them are.
    """
    return sides_of(skeleton).partners


@once_a_skeleton
def sides_of(skeleton: Skeleton) -> Sides:
    """The two sides of a skeleton. Formats and programs insert a link on one side alone, as ASF a bone that only
    leads on."""
    found = _by_name([joint.name for joint in skeleton.joints])
    by_source = _by_name([joint.source_name for joint in skeleton.joints])
    for index, partner in enumerate(by_source):
        if found[index] == index and partner != index and found[partner] == partner:
            found[index], found[partner] = partner, index
    for index, partner in enumerate(found.tolist()):
        if partner > index:
            _pair_above(skeleton, found, index, partner)
    pairs = [(index, partner) for index, partner in enumerate(found.tolist()) if partner > index]
    stops = {joint for one, two in pairs for joint in {*_above(skeleton, one)} & {*_above(skeleton, two)}}
    stops |= {joint for pair in pairs for joint in pair}
    links: set[int] = set()
    for index, partner in pairs:
        (own, passed), (other, others) = (_bearer(skeleton, stops, joint) for joint in (index, partner))
        if other == own if min(own, other) < 0 else other == found[own]:
            links.update(passed, others)
        else:
            found[index], found[partner] = index, partner
    found.setflags(write=False)
    return Sides(found, frozenset(links))


def turns(skeleton: Skeleton, index: int) -> bool:
    """Whether a joint can turn in its parent."""
    return not set(ROTATIONS).isdisjoint(skeleton.joints[index].channels)


def _bearer(skeleton: Skeleton, stops: set[int], index: int) -> tuple[int, list[int]]:
    """The nearest joint above one where both sides stop, -1 above a root, and the links that were passed."""
    passed: list[int] = []
    for above in _above(skeleton, index):
        if above in stops:
            return above, passed
        passed.append(above)
    return -1, passed


def _above(skeleton: Skeleton, index: int) -> Iterator[int]:
    """The joints above one, from its parent on."""
    while (index := skeleton.joints[index].parent) >= 0:
        yield index


def is_left(skeleton: Skeleton, index: int, partner: int) -> bool:
    """Whether a joint with a partner is the left one."""
    for name in (skeleton.joints[index].name, skeleton.joints[index].source_name):
        for place, (pattern, _) in enumerate(_SWAPS):
            if pattern.search(name) and _swapped(name, place) in {
                skeleton.joints[partner].name,
                skeleton.joints[partner].source_name,
            }:
                return place % 2 == 0
    return False


def _by_name(names: list[str]) -> Rows:
    places = {name: index for index, name in enumerate(names)}
    found = np.arange(len(names), dtype=np.intp)
    for index, name in enumerate(names):
        for place in range(0, len(_SWAPS), 2):
            other = places.get(_swapped(name, place))
            if other is not None and other != index:
                found[index], found[other] = other, index
                break
    return found


def _swapped(name: str, place: int) -> str:
    pattern, word = _SWAPS[place]

    def cased(match: re.Match[str]) -> str:
        said = match.group()
        if said.isupper():
            return word.upper()
        return word.capitalize() if said[0].isupper() else word

    return pattern.sub(cased, name, count=1)


def _pair_above(skeleton: Skeleton, found: Rows, index: int, partner: int) -> None:
    """Makes partners of the joints above two partners, up to one joint or to partners."""
    pairs = []
    one, two = skeleton.joints[index].parent, skeleton.joints[partner].parent
    while min(one, two) >= 0 and one != two and found[one] == one and found[two] == two:
        pairs.append((one, two))
        one, two = skeleton.joints[one].parent, skeleton.joints[two].parent
    if pairs and (one == two or (min(one, two) >= 0 and found[one] == two)):
        for one, two in pairs:
            found[one], found[two] = two, one


@once_a_skeleton
def _pairs(skeleton: Skeleton) -> list[tuple[int, int]]:
    """(left, right) joints."""
    return [
        (index, int(partner))
        for index, partner in enumerate(partners(skeleton))
        if partner != index and is_left(skeleton, index, int(partner))
    ]


def sagittal(skeleton: Skeleton, positions: Array, up: Array, facing: Array | None = None) -> Sagittal:
    """The plane between the sides of a pose.

    positions: (J, 3) in the world. up: (3,) unit vector. facing: (3,) direction that the body faces, if given; else the
    joints of the left are to its left: the hips first, otherwise any pairs. It goes through the middle of the pairs, or
    else of all joints. Raises ConversionError if left and right are unknown.
    """
    pairs = _pairs(skeleton)
    hips = [pair for pair in pairs if skeleton.joints[pair[0]].name in ("left_hip", "left_up_leg")]
    if facing is not None:
        across = np.cross(up, facing)
    else:
        across = np.zeros(3)
        for left, right in hips or pairs:
            across += positions[left] - positions[right]
    across = across - (across @ up) * up
    length = float(np.linalg.norm(across))
    if length < 1e-9:
        raise ConversionError(
            "nothing tells left from right in this pose",
            remedy="Give its joints names that say left and right.",
        )
    middle = [(positions[left] + positions[right]) / 2 for left, right in hips or pairs]
    point = np.mean(middle, axis=0) if middle else positions.mean(axis=0)
    return Sagittal(across / length, point)
