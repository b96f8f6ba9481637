"""Scenes: joints with a pose in the world at rest and in each frame, as FBX, glTF, USD and MVNX files hold them.

Such files have rest rotations, translations and scales on every node, pivots, and several ways to inherit scale. All of
that is in the transform of a node to the world, so readers give these transforms, and `make_clip` makes MCML's joints
of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, LimitError, Notice
from mcml.formats.format import Limits
from mcml.motion.skeleton import Array

MOST_TAKES = 256
"""Takes of one file that are read."""
MOST_TIPS = 64
"""Of one joint that are read."""
TIPS = "mcml_tips"
"""The name under which tips of bones stand in the extras of a node, or the custom data of a skeleton."""
REMEDY = "Send a file with a skeleton and its animation."


@dataclass(frozen=True, eq=False)
class Rig:
    """The joints of a scene. Parents stand before their children, subtrees are contiguous.

    names: as the file writes them; in USD the whole path in the skeleton. parents: (J,), -1 at a root. rest: (J, 3, 4)
    from each joint to the world at rest. shapes: names of blend shapes. tips: ends of bones without a joint there, as
    (joint, (3,) in the axes and units of its node).
    """

    names: tuple[str, ...]
    parents: NDArray[np.intp]
    rest: Array
    shapes: tuple[str, ...] = ()
    tips: tuple[tuple[int, Array], ...] = ()

    def __len__(self) -> int:
        return len(self.names)


@dataclass(frozen=True, eq=False)
class Take:
    """One motion of a scene.

    name: "" where the file has only one motion and no name for it. rate: frames a second. poses: of the frames first to
    end - 1 the transforms (n, J, 3, 4) of each joint to the world, NaN where there is no sample. weights: of the same
    frames the weights (n, S) of the rig's blend shapes, None if it has none. properties: further facts, (name, value,
    unit).
    """

    name: str
    rig: Rig
    frames: int
    rate: float
    poses: Callable[[int, int], Array]
    notices: tuple[Notice, ...] = ()
    properties: tuple[tuple[str, str, str], ...] = ()
    weights: Callable[[int, int], Array] | None = None
    labels: Callable[[int, int], list[tuple[str, ...]]] | None = None


@dataclass(frozen=True, eq=False)
class Scene:
    """The contents of a file.

    unit: of lengths, such as "cm"; "" where it is not known. up: "Y", "-Z" …, "" where the file does not say.
    size: bytes of memory or disk that the poses take.
    """

    takes: tuple[Take, ...]
    unit: str = ""
    up: str = ""
    notices: tuple[Notice, ...] = ()
    size: int = 0
    kept: object = field(default=None, repr=False)


def read_tips(values: object) -> list[Array]:
    """The tips of a joint that this program wrote beside it, a list of three numbers each; others are left out."""
    tips = []
    for value in values if isinstance(values, list) else []:
        if isinstance(value, list) and len(value) == 3 and all(isinstance(number, int | float) for number in value):
            tips.append(np.array(value, np.float64))
    return [tip for tip in tips[:MOST_TIPS] if np.isfinite(tip).all()]


def check_joints(names: Sequence[str], nodes: int, limits: Limits, label: str) -> None:
    """Raises FormatError where there is no joint, LimitError where there are too many, both for bad names.

    label: of the format.
    """
    if not names:
        raise FormatError(f"the {label} file has no skeleton: {nodes} nodes, none is a bone", remedy=REMEDY)
    if len(names) > limits.joints:
        raise LimitError(f"the skeleton has {len(names)} joints, the limit is {limits.joints}", remedy="Remove joints.")
    for name in names:
        limits.check_name(name)


def check_takes(takes: Sequence[object], joints: int) -> None:
    """Raises FormatError where there is no take, LimitError where there are too many."""
    if not takes:
        raise FormatError(f"the file has a skeleton of {joints} joints and no motion", remedy=REMEDY)
    if len(takes) > MOST_TAKES:
        raise LimitError(
            f"the file holds {len(takes)} takes, the limit is {MOST_TAKES}", remedy="Save them in several files."
        )
