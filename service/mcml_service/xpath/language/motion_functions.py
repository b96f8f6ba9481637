"""The functions of bodies in motion, such as `mo:height('left_hand')`: arguments, results and units.

Those of one frame are quantities (`mcml.motion.bodies.quantities`), which declare their arguments. The context is a
frame, or a node in one; a joint is given by its MCML name, or as a frame_bone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from mcml.motion.bodies.quantities import QUANTITIES

PREFIX: Final = "mo:"


@dataclass(frozen=True)
class MotionFunction:
    """A function of bodies in motion.

    parameters: names of its arguments, optional ones with `?`. result: "number", "boolean" or "nodes". unit: of the
    number. meaning: a short description. selects: index of the argument whose nodes it selects from.
    """

    parameters: tuple[str, ...]
    result: str
    unit: str
    meaning: str
    selects: int | None = None

    @property
    def least(self) -> int:
        """How many arguments it takes at least."""
        return sum(not parameter.endswith("?") for parameter in self.parameters)

    @property
    def detail(self) -> str:
        """`(joint, relative?) in m/s: how fast a joint moves`."""
        return f"({', '.join(self.parameters)}){f' in {self.unit}' * bool(self.unit)}: {self.meaning}"


_MEANINGS: Mapping[str, str] = {
    "time": "since frame 1",
    "unit": "of a unit of the source",
    "leg": "the body's leg, from hip to knee to ankle",
    "height": "of a joint above the clip's floor",
    "position": "of a joint along x, y, z, up, front or left, from an origin",
    "distance": "between two joints",
    "angle": "of a movement such as left-knee-flexion, or between three joints",
    "tilt": "of the line between two joints, 0 where it is upright",
    "speed": "of a joint, by itself or relative to another one",
    "acceleration": "of a joint, by itself or relative to another one",
    "heading": "where the body faces, without leaps, to the left",
    "contact": "whether a joint is on the ground and still, or the foot of a side is ('left'), from strike to off",
    "activity": "whether the body walks, runs, turns, jumps, sits …: 'walk', 'turn left'",
    "analog": "of an analog channel of the file, the mean of the samples of the frame",
    "force": "of the ground on a force plate ('1') or a foot ('left'), along x, y or z of the laboratory",
    "cop": "of the centre of pressure on a force plate, along x, y or z of the laboratory",
    "free-moment": "about the vertical on a force plate",
    "quantity": "of the file's own model, such as 'LKneeAngles', along x, y or z",
}
MOTION_FUNCTIONS: Final[Mapping[str, MotionFunction]] = {
    **{
        PREFIX + name: MotionFunction(
            quantity.parameters, "boolean" if quantity.is_truth else "number", quantity.unit, _MEANINGS[name]
        )
        for name, quantity in QUANTITIES.items()
    },
    "mo:rate": MotionFunction(("number",), "number", "per s", "of change of any number of a frame"),
    "mo:known": MotionFunction(
        ("number or truth",), "boolean", "", "whether the value of a function of bodies is known here, not NaN"
    ),
    "mo:window": MotionFunction(
        ("from", "to", "'frames'?"), "nodes", "", "the frames from so many seconds after this one to so many"
    ),
    "mo:runs": MotionFunction(
        ("frames", "least", "gap?"), "nodes", "", "frames of runs of so many seconds, gaps closed", selects=0
    ),
    "mo:top": MotionFunction(
        ("n", "frames", "key?"), "nodes", "", "the n best runs of the scope, by the best key", selects=1
    ),
    "mo:pose-distance": MotionFunction(
        ("document", "position"), "number", "leg lengths", "from the pose of a frame of a document"
    ),
    "mo:motion-distance": MotionFunction(
        ("document", "first", "last"), "number", "leg lengths", "of the range that ends here from one of a document"
    ),
}  # fmt: skip
OF_DOCUMENT: Final = frozenset({"mo:leg", "mo:unit"})
"""Functions whose value is the document's, not the frame's."""
ANGLE: Final = "mo:angle"
NAME_OF_ACTIVITY: Final = "activity"
JOINT_OR_SIDE: Final = "joint or side"
JOINTS: Final = frozenset({"joint", JOINT_OR_SIDE, "name or joint", "relative", "origin"})
"""Parameters that are joints."""
CONSTANT: Final = frozenset({"from", "to", "'frames'", "least", "gap", "document", "position", "first", "last"})
"""Parameters that are the same in every frame."""
OF_FRAMES: Final = frozenset({"number", "key"})
"""Parameters that are evaluated for frames without positions."""
DISTANCES: Final = frozenset({"mo:pose-distance", "mo:motion-distance"})
ACTIVITY, CONTACT, KNOWN = "mo:activity", "mo:contact", "mo:known"
TRUTHS: Final = frozenset({ACTIVITY, CONTACT})
"""Functions of a frame's body that are true or false, or unknown."""
OF_NUMBERS: Final = frozenset({"mo:rate", KNOWN})
"""Functions of any expression that is evaluated for a frame, not of names."""
TOP, WINDOW, RUNS, RATE = "mo:top", "mo:window", "mo:runs", "mo:rate"
OF_FRAME_SETS: Final = frozenset({TOP, WINDOW, RUNS})
"""Functions that give frames."""
