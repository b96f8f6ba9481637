"""Names of columns as Live Link Face writes them.

Source: Apple, ARFaceAnchor.BlendShapeLocation; Live Link Face writes the names with a capital first.
"""

from __future__ import annotations

import re
from typing import Final

SHAPES: Final = (
    "EyeBlinkLeft", "EyeLookDownLeft", "EyeLookInLeft", "EyeLookOutLeft", "EyeLookUpLeft", "EyeSquintLeft",
    "EyeWideLeft", "EyeBlinkRight", "EyeLookDownRight", "EyeLookInRight", "EyeLookOutRight", "EyeLookUpRight",
    "EyeSquintRight", "EyeWideRight", "JawForward", "JawRight", "JawLeft", "JawOpen", "MouthClose", "MouthFunnel",
    "MouthPucker", "MouthRight", "MouthLeft", "MouthSmileLeft", "MouthSmileRight", "MouthFrownLeft",
    "MouthFrownRight", "MouthDimpleLeft", "MouthDimpleRight", "MouthStretchLeft", "MouthStretchRight",
    "MouthRollLower", "MouthRollUpper", "MouthShrugLower", "MouthShrugUpper", "MouthPressLeft", "MouthPressRight",
    "MouthLowerDownLeft", "MouthLowerDownRight", "MouthUpperUpLeft", "MouthUpperUpRight", "BrowDownLeft",
    "BrowDownRight", "BrowInnerUp", "BrowOuterUpLeft", "BrowOuterUpRight", "CheekPuff", "CheekSquintLeft",
    "CheekSquintRight", "NoseSneerLeft", "NoseSneerRight", "TongueOut",
)  # fmt: skip
"""The 52 blend shapes of ARKit, in the order of the app's columns."""

TURNING: Final = {"head": "Head", "left_eye": "LeftEye", "right_eye": "RightEye"}
"""Names of joints, and how the names of their columns begin."""
ANGLES: Final = {"Yaw": "Ry", "Pitch": "Rx", "Roll": "Rz"}
"""How these names end, and channels, in the order in which the angles turn."""

_SPELLING: Final = {name.lower(): name for name in SHAPES}
_SIDES: Final = {"l": "left", "r": "right"}


def shape_of(name: str) -> str | None:
    """ARKit's name of a blend shape as the app writes it, None for others.

    Case does not count, nor does a prefix that ends with a point or a colon, as in Maya's `Face.jawOpen`; `eyeBlink_L`
    is `EyeBlinkLeft`.
    """
    plain = re.split(r"[.:]", name)[-1].strip().lower()
    side = re.fullmatch(r"(.+?)[_-]?(?<=[_-])([lr]|left|right)", plain)
    spellings = [plain, plain.replace("_", "")]
    if side is not None:
        spellings.append(side[1].replace("_", "") + _SIDES.get(side[2], side[2]))
    return next((_SPELLING[each] for each in spellings if each in _SPELLING), None)
