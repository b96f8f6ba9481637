"""Lines between the markers of a person, to draw points as a figure: along limbs, around pelvis, trunk and head."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final, TypeAlias

from mcml.motion.landmarks.centres import bodies_of
from mcml.motion.skeleton import Skeleton, once_a_skeleton

_End: TypeAlias = tuple[str, ...]
"""Landmarks of which the first one that a body has is meant; * stands for a side."""

_HIP: Final[_End] = ("*_hip_centre", "*_greater_trochanter", "*_asis", "*_psis")
_KNEE: Final[_End] = ("*_knee_lateral", "*_knee_centre", "*_knee_medial")
_ANKLE: Final[_End] = ("*_ankle_lateral", "*_ankle_centre", "*_ankle_medial")
_HEEL: Final[_End] = ("*_heel",)
_TOE: Final[_End] = ("*_mt2", "*_mt5", "*_mt1", "*_big_toe", "*_toe_tip")
_SHOULDER: Final[_End] = ("*_acromion", "*_shoulder_centre", "*_shoulder_front")
_ELBOW: Final[_End] = ("*_elbow_lateral", "*_elbow_centre", "*_elbow_medial")
_WRIST: Final[_End] = ("*_wrist_radial", "*_wrist_centre", "*_wrist", "*_wrist_ulnar")
_BACK: Final[_End] = ("*_psis", "sacrum", "hip_midpoint")
_NECK: Final[_End] = ("c7", "neck", "jugular_notch")
_LINES: Final[tuple[tuple[_End, _End], ...]] = (
    (_HIP, _KNEE), (_KNEE, _ANKLE), (_ANKLE, _HEEL), (_ANKLE, _TOE), (_HEEL, _TOE),
    (("*_knee_medial",), ("*_ankle_medial",)), (("*_knee_lateral",), ("*_knee_medial",)),
    (("*_ankle_lateral",), ("*_ankle_medial",)), (("*_mt1",), ("*_mt5",)),
    (_SHOULDER, _ELBOW), (_ELBOW, _WRIST), (("*_wrist_radial",), ("*_wrist_ulnar",)),
    (_WRIST, ("*_mt3_hand", "*_mt2_hand")), (_SHOULDER, _NECK), (_SHOULDER, ("jugular_notch", "neck")),
    (("*_asis", "*_hip_centre"), _BACK), (("left_asis",), ("right_asis",)), (("left_psis",), ("right_psis",)),
    (("left_hip_centre",), ("right_hip_centre",)), (("c7",), ("t10", "t8")), (("jugular_notch",), ("xiphoid",)),
    (("neck",), ("hip_midpoint",)), (("*_head_front",), ("*_head_back",)),
    (("left_head_front",), ("right_head_front",)),
    (("left_head_back",), ("right_head_back",)), (("neck",), ("nose",)), (("nose",), ("*_eye",)),
    (("*_eye",), ("*_ear",)),
)  # fmt: skip


@once_a_skeleton
def marker_lines(skeleton: Skeleton) -> tuple[tuple[int, int], ...]:
    """Pairs of indices of markers that lines connect, each once; none where no person is recognised."""
    lines: dict[tuple[int, int], None] = {}
    for body in bodies_of(skeleton):
        at = {landmark: index for index, landmark in reversed(list(body.landmarks.items()))}
        for line in _lines_of(at):
            lines.setdefault((min(line), max(line)))
    return tuple(lines)


def _lines_of(at: Mapping[str, int]) -> Iterator[tuple[int, int]]:
    for side in ("left", "right"):
        for ends in _LINES:
            start, end = (
                next((at[name] for part in end if (name := part.replace("*", side)) in at), None) for end in ends
            )
            if start is not None and end is not None and start != end:
                yield start, end
