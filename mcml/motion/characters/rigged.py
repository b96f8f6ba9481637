"""A character of a file: a mesh with a skin, and the rig that moves it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.errors import ConversionError, Notice
from mcml.motion.kinematics import rest_positions
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.skin import Character
from mcml.motion.units import Reading

MOST_VERTICES, MOST_TRIANGLES = 100_000, 200_000
"""Of the meshes of a file, together."""
_MOVED = 1e-3
"""Share of the size of a skeleton by which a joint at rest may be elsewhere than where the mesh was bound."""


@dataclass(frozen=True, eq=False)
class RiggedCharacter:
    """The skinned meshes of a file as one.

    character: in metres, Y up, bound to the joints of the rig. names: of the joints, as the file writes them, in the
    order in which its documents have them. rest: (J, 3) of them at rest. notices: parts of the file that are left out,
    and approximations.
    """

    character: Character
    names: tuple[str, ...]
    rest: Array
    notices: tuple[Notice, ...] = ()

    def check_skeleton(self, skeleton: Skeleton, reading: Reading) -> None:
        """Raises ConversionError where a skeleton no longer has the joints, at rest, that the mesh is bound to."""
        shapes = set(skeleton.blend_shapes)
        joints = [joint for index, joint in enumerate(skeleton.joints) if index not in shapes]
        if tuple(joint.source_name for joint in joints) == self.names:
            places = rest_positions(skeleton, reading)[: len(self.names)]
            size = float(np.ptp(self.rest, axis=0).max())
            if np.abs(places - self.rest).max() <= _MOVED * max(size, np.finfo(float).tiny):
                return
        raise ConversionError(
            "The skeleton of the character was edited since its file was imported: the mesh no longer fits.",
            remedy="Import the file again.",
        )
