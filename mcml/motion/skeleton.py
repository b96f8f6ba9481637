"""Skeletons: joints in a tree, with the lexemes of the file they came from.

Numbers of the head are kept as the text that the source wrote (`"5.7300"`), so that a round trip loses nothing;
`offsets()` and its like give the arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property, wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

P = ParamSpec("P")
Found = TypeVar("Found")
Array = NDArray[np.float64]
Triple = tuple[str, str, str]

CHANNELS = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz", "SF", "residual", "weight")
"""Every channel a joint can have in a frame, in the order in which a frame_bone writes its attributes."""

CHANNEL_INDEX = {name: index for index, name in enumerate(CHANNELS)}
TRANSLATIONS = CHANNELS[0:3]
ROTATIONS = CHANNELS[3:6]


class Convention(StrEnum):
    """How a joint's channels become a rotation and a translation (see docs/conventions.md).

    LISTED: BVH. The rotation is the product of the channels' rotations in listed order, about local axes;
        the rest pose has no rotation; `offset` is in the parent's axes, which are the world's at rest.
    FIXED: ASF/AMC. Rotations about fixed axes, first listed applied first; `axis` is the world rest
        orientation C, the local rotation is C M C^-1; `direction` and `length` are in world rest axes and the
        next bone starts at this bone's end.
    BASE: HTR. Translation and rotation are relative to a base pose: T = offset + (Tx, Ty, Tz) in the parent's
        axes, R = R(axis) R(Rx, Ry, Rz), both in `rotation_order`.
    MARKER: labelled points (C3D, TRC): Tx Ty Tz are positions in the world.
    BLEND_SHAPE: a blend shape of a face or a body: `weight` says how much of it is there, 0 for none, 1 for all. It
        has no position and no rotation; its parent is the joint that it belongs to.
    """

    LISTED = "listed"
    FIXED = "fixed"
    BASE = "base"
    MARKER = "marker"
    BLEND_SHAPE = "shape"


@dataclass(frozen=True, slots=True)
class EndSite:
    """The tip of a leaf bone (BVH `End Site`).

    offset: lexemes, in the joint's axes. name: the text after `End Site`, or "".
    before: number of child joints of the same joint before it in the file.
    """

    offset: Triple
    name: str = ""
    before: int = 0


@dataclass(frozen=True, slots=True)
class Joint:
    """One joint (in ASF and HTR words: the bone that starts there). All numbers are lexemes.

    name: unique in the skeleton. Readers give the source's name, with `#2`, `#3` … appended to repeated ones;
        `mcml.language.joint_names` renames to MCML's.
    source_name: the name exactly as the file writes it.
    parent: index of the parent in `Skeleton.joints`, -1 for a root. Parents come before their children
        (`Skeleton` sorts depth-first; `declared` keeps the file's own order).
    channels: channel names in the file's order, e.g. ("Tx", "Ty", "Tz", "Rz", "Rx", "Ry"); () if it never moves.
    rotation_order: three letters such as "ZXY": for LISTED the channel order (missing axes left out, so it may be
        shorter), for FIXED the order of application, for BASE the file's EulerRotationOrder. "" without rotation.
    offset: LISTED: BVH OFFSET. FIXED: the root's `position`. BASE: T of the base position. None if not stated.
    direction, length: FIXED. `length` is BASE's BoneLength too.
    axis, axis_order: FIXED: `axis 0 0 20 XYZ`; for its root the `orientation` with the letters of `axis`.
        BASE: the base rotation (always Rx Ry Rz) with the file's order.
    translation: "absolute" (position channels replace the offset) or "relative" (they add to it); "" if none.
    limits: one text for each degree of freedom, such as "-160.0 20.0", without brackets.
    mapped: None before naming; then whether `name` is one of MCML's own.
    confidence: of that name, such as "0.6", if it is a guess; else None.
    role: of a joint without a name of MCML's, such as "jaw" or "left_finger_one_2"; None if unknown.
    """

    name: str
    parent: int
    source_name: str
    convention: Convention
    channels: tuple[str, ...] = ()
    rotation_order: str = ""
    offset: Triple | None = None
    direction: Triple | None = None
    length: str | None = None
    axis: Triple | None = None
    axis_order: str = ""
    translation: str = ""
    limits: tuple[str, ...] = ()
    bodymass: str | None = None
    cofmass: str | None = None
    id: str | None = None
    end_sites: tuple[EndSite, ...] = ()
    mapped: bool | None = None
    confidence: str | None = None
    role: str | None = None

    @property
    def own_name(self) -> str:
        """The source's name, without the joints above it where that is a path, as in USD (`Hips/Spine/Neck`)."""
        return self.source_name.rpartition("/")[2] or self.source_name

    @property
    def has_axes(self) -> bool:
        """Whether the joint has axes that can turn; markers and blend shapes have none."""
        return self.convention not in (Convention.MARKER, Convention.BLEND_SHAPE)


@dataclass(frozen=True)
class Skeleton:
    """Joints, parents before children, each subtree contiguous (pre-order).

    declared: the file's own order of the joints as indices into `joints`, where it differs from pre-order
        (ASF lists its bones, HTR its segments, in any order); () where it does not.
    """

    joints: tuple[Joint, ...]
    declared: tuple[int, ...] = ()

    def __len__(self) -> int:
        return len(self.joints)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joints)

    @property
    def doubtful(self) -> tuple[str, ...]:
        """Names of MCML's that are guesses."""
        return tuple(joint.name for joint in self.joints if joint.mapped and joint.confidence is not None)

    @property
    def parents(self) -> NDArray[np.intp]:
        """(J,) index of each joint's parent, -1 at a root."""
        return np.array([joint.parent for joint in self.joints], dtype=np.intp)

    @cached_property
    def blend_shapes(self) -> tuple[int, ...]:
        """The blend shapes: they have a weight and no place."""
        return tuple(index for index, joint in enumerate(self.joints) if joint.convention is Convention.BLEND_SHAPE)

    @property
    def roots(self) -> tuple[int, ...]:
        return tuple(index for index, joint in enumerate(self.joints) if joint.parent < 0)

    def children(self, index: int) -> tuple[int, ...]:
        return tuple(i for i, joint in enumerate(self.joints) if joint.parent == index)

    def in_declared_order(self) -> tuple[int, ...]:
        """Indices of the joints in the order in which the source file lists them."""
        return self.declared or tuple(range(len(self.joints)))

    def columns(self) -> tuple[tuple[int, int], ...]:
        """(joint, channel) of every motion value of a frame: joints in file order, channels as each lists them."""
        return self._columns

    @cached_property
    def _columns(self) -> tuple[tuple[int, int], ...]:
        return tuple(
            (index, CHANNEL_INDEX[channel])
            for index in self.in_declared_order()
            for channel in self.joints[index].channels
        )

    @cached_property
    def _follows(self) -> dict[Hashable, Any]:
        """Cached results of functions made by `once_a_skeleton`."""
        return {}

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.joints, self.declared))

    def __reduce__(self) -> tuple[Any, ...]:
        # Cached results are not sent to other processes.
        return Skeleton, (self.joints, self.declared)


def once_a_skeleton(function: Callable[Concatenate[Skeleton, P], Found]) -> Callable[Concatenate[Skeleton, P], Found]:
    """Cache the results of a function of a skeleton and of hashable values with the skeleton.

    Clips of one session share a skeleton, and computing these facts takes longer than reading a short clip. Treat
    results as read-only.
    """

    @wraps(function)
    def found(skeleton: Skeleton, /, *args: P.args, **kwargs: P.kwargs) -> Found:
        follows, key = skeleton._follows, (function, args, *kwargs.items())
        if key not in follows:
            follows[key] = function(skeleton, *args, **kwargs)
        result: Found = follows[key]
        return result

    return found


def numbers(lexemes: Triple | None) -> Array:
    """The vector a lexeme triple writes, (3,); zeros for None."""
    return np.zeros(3) if lexemes is None else np.array([float(text) for text in lexemes])


def unique_names(names: Iterator[str] | list[str]) -> list[str]:
    """Names made unique in order of appearance: the second `Hand` becomes `Hand#2`."""
    seen: set[str] = set()
    last: dict[str, int] = {}
    result = []
    for name in names:
        # Where the search for a free number left off, so that ten thousand equal names take no time.
        candidate, count = name, last.get(name, 1)
        while candidate in seen:
            count += 1
            candidate = f"{name}#{count}"
        seen.add(candidate)
        last[name] = count
        result.append(candidate)
    return result
