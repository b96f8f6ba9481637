"""Where a clip starts: clips captured at different places, brought to one place and one heading."""

from __future__ import annotations

from dataclasses import dataclass

from mcml.motion.rotation_vectors import from_vector, twist
from mcml.motion.rotations import multiply, rotate
from mcml.motion.skeleton import Array
from mcml_service.analysis.interface import AnalysisError
from mcml_service.analysis.reach_blending.standing import axis_of


@dataclass(frozen=True)
class Standpoint:
    """place: (3,) that becomes the origin, on the ground. turn: (4,) rotation about the vertical, after the move."""

    place: Array
    turn: Array

    def move(self, root: Array, rotations: Array) -> tuple[Array, Array]:
        """Move roots (F, 3) and local rotations (F, J, 4), whose first joint is the root."""
        moved = rotations.copy()
        moved[:, 0] = multiply(self.turn, rotations[:, 0])
        return rotate(self.turn, root - self.place), moved


def find_standpoint(root: Array, rotations: Array, t1: float, up: str | None) -> Standpoint:
    """Find where a clip stands when its reach begins: below its root, with the heading that the root has there.

    root: (F, 3). rotations: (F, 4) of the root, in the world. t1: frames. up: "X", "Y" or "Z". Moved, the root is above
    the origin at t1, and its rotation has no part about the vertical: it faces as in the rest pose. Raises
    AnalysisError `no-up-axis`.
    """
    if up is None:
        raise AnalysisError(
            "no-up-axis",
            "The clip does not state which axis points up, so it has no heading.",
            remedy='Set its property "up", or fit with align "none".',
        )
    axis = axis_of(up)
    frame = min(round(t1), len(root) - 1)
    turn = from_vector(-float(twist(rotations[frame], axis)) * axis)
    return Standpoint(root[frame] * (1.0 - axis), turn)
