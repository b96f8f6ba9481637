"""Names of columns as Live Link Face writes them.

Source: Apple, ARFaceAnchor.BlendShapeLocation; Live Link Face writes the names with a capital first.
"""

from __future__ import annotations

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
