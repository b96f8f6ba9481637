"""The quantities of a frame: each with its arguments, unit, joints, and the number of neighbouring frames that it uses.

Most are of a body; some are stated by the file beside it, such as the angles of a laboratory's own model. Values are
in metres, seconds and degrees (of a file: in its units), NaN where the unit, the frame time, a joint or a sample is
unknown. Those of a body depend on rounded positions only, so every way to compute them gives the same bits. A frame
range extended by `halo` frames gives the same values as the whole document.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from mcml.errors import NotFoundError, RequestError
from mcml.motion.anatomy.axes import joints_of_part
from mcml.motion.bodies.activities.activity import ANY_ACTIVITY
from mcml.motion.bodies.activities.recognition import find_frames, joints_needed
from mcml.motion.bodies.activities.signals import JOINTS as JOINTS_OF_ACTIVITIES
from mcml.motion.bodies.limb_angles import angle_named, turn_named
from mcml.motion.bodies.local_fit import bends, reach, slopes
from mcml.motion.bodies.stretch import HIPS, Stretch, known
from mcml.motion.feet.contacts import standing
from mcml.motion.skeleton import Array
from mcml.motion.vectors import angle_between, cross, length

AXES: Final = ("x", "y", "z", "up", "front", "left")
AXES_OF_FILE: Final = ("x", "y", "z")
"""Components of the measurements of a file: of its laboratory for forces, of its own model for angles and moments."""

FEET: Final = ("left", "right")
"""Arguments of contacts that are the feet of a walker, not joints; of several people behind a prefix: "Anna:left"."""
_GROUND = "_toes"
"""Joints on the ground: the ankle (`*_foot`) stays above it."""
_THICKEST = 0.15
"""Greatest distance, in leg lengths, of other joints from the body's surface when it lies on the ground."""

Arguments: TypeAlias = Sequence[str]


@dataclass(frozen=True)
class Quantity:
    """parameters: names of its arguments, the optional ones with `?`. unit: "m", "m/s", "m/s2", "s", "deg" or "".

    joints: the joints that given arguments need (alternatives with `|`). windowed: whether it uses neighbouring frames,
    as far as `local_fit.reach`. whole: whether it needs the whole document instead. compute: (n,) values of a stretch.
    of_file: whether the file states it, not the body: `mcml.formats.measurements` reads it, and `compute` gives NaN.
    is_truth: whether its values are 1 for true and 0 for false. optional: joints that it uses if they are known.
    """

    parameters: tuple[str, ...]
    unit: str
    joints: Callable[[Arguments], tuple[str, ...]]
    compute: Callable[[Stretch, Arguments], Array]
    windowed: bool = False
    whole: bool = False
    of_file: bool = False
    is_truth: bool = False
    optional: tuple[str, ...] = ()


def _height(stretch: Stretch, arguments: Arguments) -> Array:
    calibration = stretch.calibration
    if calibration.floor is None or calibration.metres is None:
        return np.full(stretch.frames, np.nan)
    steps = stretch.at(arguments[0]) @ stretch.up
    height: Array = (steps * calibration.step - calibration.floor) * calibration.metres
    return height


def _position(stretch: Stretch, arguments: Arguments) -> Array:
    _joints_of_position(arguments)
    joint, axis, *origin = arguments
    places = stretch.between(origin[0], joint) if origin else stretch.at(joint)
    if axis in ("x", "y", "z"):
        direction = np.eye(3)["xyz".index(axis)]
    elif axis == "up":
        direction = stretch.up
    else:
        left = stretch.level_left()
        direction = left if axis == "left" else cross(left, stretch.up[None])
    position: Array = (places * direction).sum(axis=1) * stretch.calibration.metres_per_step
    return position


def _distance(stretch: Stretch, arguments: Arguments) -> Array:
    lengths: Array = length(stretch.between(*arguments))
    return lengths * stretch.calibration.metres_per_step


def _angle(stretch: Stretch, arguments: Arguments) -> Array:
    if len(arguments) == 1:
        person, _, name = arguments[0].rpartition(":")
        angle, side = angle_named(name)
        return angle.compute(stretch.of_person(person), side)
    one, corner, other = arguments
    return angle_between(stretch.between(corner, one), stretch.between(corner, other))


def _joints_of_angle(arguments: Arguments) -> tuple[str, ...]:
    if len(arguments) == 2:
        raise RequestError("angle takes the name of an angle, or three joints", remedy="Name one, or three.")
    if len(arguments) == 1:
        if (turn := turn_named(arguments[0])) is not None:
            return (joints_of_part(*turn[:2]),)
        person, _, name = arguments[0].rpartition(":")
        angle, side = angle_named(name)
        return tuple(_of_person(person, joint) for joint in angle.joints(side))
    return tuple(arguments)


def _of_person(person: str, joint: str) -> str:
    """The name of a joint, or several with `|` between them, of one of several people; the same where person is ""."""
    return "|".join(f"{person}:{name}" for name in joint.split("|")) if person else joint


def _tilt(stretch: Stretch, arguments: Arguments) -> Array:
    line = stretch.between(*arguments)
    return angle_between(line, np.broadcast_to(stretch.up, line.shape))


def _moving(stretch: Stretch, arguments: Arguments) -> Array:
    """(n, 3) steps of a joint, or of it from another one."""
    return stretch.at(arguments[0]) if len(arguments) == 1 else stretch.between(arguments[1], arguments[0])


def _speed(stretch: Stretch, arguments: Arguments) -> Array:
    if stretch.frame_time is None:
        return np.full(stretch.frames, np.nan)
    speeds: Array = length(slopes(_moving(stretch, arguments), stretch.frame_time))
    return speeds * stretch.calibration.metres_per_step


def _acceleration(stretch: Stretch, arguments: Arguments) -> Array:
    if stretch.frame_time is None:
        return np.full(stretch.frames, np.nan)
    accelerations: Array = length(bends(_moving(stretch, arguments), stretch.frame_time))
    return accelerations * stretch.calibration.metres_per_step


def _heading(stretch: Stretch, arguments: Arguments) -> Array:
    """From the axis that follows the upward one (Z where Y is up), to the left about it."""
    left = stretch.level_left()
    ahead: Array = np.roll(np.abs(stretch.up), 1)
    beside: Array = np.cross(stretch.up, ahead)
    turned: Array = np.degrees(np.arctan2(-(left @ ahead), left @ beside))
    seen = np.isfinite(turned)
    # By hand, as np.unwrap adds up steps that were rounded before: whole turns between neighbours.
    turns = np.cumsum(np.round(np.diff(turned[seen], prepend=turned[seen][:1]) / 360.0))
    turned[seen] -= 360.0 * turns
    return turned


def _contact(stretch: Stretch, arguments: Arguments) -> Array:
    """Return 1 where a joint is planted, else 0; NaN for the feet of a walker, which `mcml.laboratory` finds."""
    calibration, joint = stretch.calibration, arguments[0]
    places = stretch.at(joint)
    heights = places @ stretch.up
    seen = np.isfinite(heights)
    if calibration.floor is None or calibration.leg is None or stretch.frame_time is None or not seen.any():
        return np.full(stretch.frames, np.nan)
    leg = calibration.leg / calibration.step
    ground = calibration.floor / calibration.step
    if not joint.endswith(_GROUND):
        ground = float(np.clip(np.percentile(heights[seen], 5.0), ground, ground + _THICKEST * leg))
    speeds = length(slopes(places, stretch.frame_time)) / leg
    found = np.where(seen, 0.0, np.nan)
    for first, end in standing((heights - ground) / leg, speeds, stretch.frame_time):
        found[first:end] = 1.0
    return found


def _activity(stretch: Stretch, arguments: Arguments) -> Array:
    return find_frames(stretch, arguments[0])


def _time(stretch: Stretch, arguments: Arguments) -> Array:
    places: Array = np.arange(stretch.first, stretch.first + stretch.frames, dtype=np.float64)
    return places * (float("nan") if stretch.frame_time is None else stretch.frame_time)


def _leg(stretch: Stretch, arguments: Arguments) -> Array:
    leg, metres = stretch.calibration.leg, stretch.calibration.metres
    return np.full(stretch.frames, np.nan if leg is None or metres is None else leg * metres)


def _unit(stretch: Stretch, arguments: Arguments) -> Array:
    metres = stretch.calibration.metres
    return np.full(stretch.frames, np.nan if metres is None else metres)


def _joints_of_activity(arguments: Arguments) -> tuple[str, ...]:
    return joints_needed(arguments[0])


def _named(arguments: Arguments) -> tuple[str, ...]:
    return tuple(arguments)


def is_foot(argument: str) -> bool:
    """Whether the argument of a contact is the foot of a walker, not a joint."""
    return argument.rpartition(":")[2] in FEET


def _touching(arguments: Arguments) -> tuple[str, ...]:
    """The joint, none for the foot of a side."""
    return () if is_foot(arguments[0]) else tuple(arguments)


def _none(arguments: Arguments) -> tuple[str, ...]:
    return ()


def _hips(arguments: Arguments) -> tuple[str, ...]:
    return HIPS


def _joints_of_position(arguments: Arguments) -> tuple[str, ...]:
    joint, axis, *origin = arguments
    if axis not in AXES:
        raise RequestError(f"{axis!r} is no axis of a position", remedy=f"Take one of: {', '.join(AXES)}.")
    return (joint, *origin, *(HIPS if axis in ("front", "left") else ()))


def _give_nan(stretch: Stretch, arguments: Arguments) -> Array:
    return np.full(stretch.frames, np.nan)


def _axis_of_file(arguments: Arguments) -> tuple[str, ...]:
    """No joints. Raises RequestError where the second argument is not an axis of the file."""
    if arguments[1] not in AXES_OF_FILE:
        what = f"{arguments[1]!r} is no axis of {arguments[0]!r}"
        raise RequestError(what, remedy=f"Take one of: {', '.join(AXES_OF_FILE)}.")
    return ()


QUANTITIES: Final[Mapping[str, Quantity]] = {
    "time": Quantity((), "s", _none, _time),
    "unit": Quantity((), "m", _none, _unit),
    "leg": Quantity((), "m", _none, _leg),
    "height": Quantity(("joint",), "m", _named, _height),
    "position": Quantity(("joint", "axis", "origin?"), "m", _joints_of_position, _position),
    "distance": Quantity(("joint", "joint"), "m", _named, _distance),
    "angle": Quantity(("name or joint", "joint?", "joint?"), "deg", _joints_of_angle, _angle),
    "tilt": Quantity(("joint", "joint"), "deg", _named, _tilt),
    "speed": Quantity(("joint", "relative?"), "m/s", _named, _speed, windowed=True),
    "acceleration": Quantity(("joint", "relative?"), "m/s2", _named, _acceleration, windowed=True),
    "heading": Quantity((), "deg", _hips, _heading, whole=True),
    "contact": Quantity(("joint or side",), "", _touching, _contact, whole=True, is_truth=True),
    "activity": Quantity(
        ("activity",), "", _joints_of_activity, _activity, whole=True, is_truth=True, optional=JOINTS_OF_ACTIVITIES
    ),
    "quantity": Quantity(("label", "axis"), "", _axis_of_file, _give_nan, of_file=True),
    "analog": Quantity(("channel",), "", _none, _give_nan, of_file=True),
    "force": Quantity(("plate", "axis"), "N", _axis_of_file, _give_nan, of_file=True),
    "cop": Quantity(("plate", "axis"), "m", _axis_of_file, _give_nan, of_file=True),
    "free-moment": Quantity(("plate",), "N m", _none, _give_nan, of_file=True),
}
"""By name. `rate` is of any numbers (`local_fit.rate`); poses and motions are compared in `poses`."""


def quantity_of(name: str, arguments: Arguments) -> Quantity:
    """Return the quantity with a name. Raises RequestError for an unknown name or a wrong number of arguments."""
    quantity = QUANTITIES.get(name)
    if quantity is None:
        raise RequestError(f"there is no quantity {name!r}", remedy=f"Take one of: {', '.join(QUANTITIES)}.")
    fewest = sum(not parameter.endswith("?") for parameter in quantity.parameters)
    if not fewest <= len(arguments) <= len(quantity.parameters):
        takes = ", ".join(quantity.parameters) or "nothing"
        raise RequestError(f"{name} does not take {len(arguments)} arguments", remedy=f"It takes: {takes}.")
    return quantity


def joints_of(name: str, arguments: Arguments, joints: Collection[str]) -> tuple[str, ...]:
    """Return the joints of a skeleton that a quantity needs, and the lines to the left of its bones."""
    quantity = quantity_of(name, arguments)
    asked = (*quantity.joints(arguments), *quantity.optional)
    found = dict.fromkeys(found for one in asked if (found := known(one, joints)) is not None)
    if name == "angle" and len(arguments) == 1 and turn_named(arguments[0]) is None:
        person, _, angle_name = arguments[0].rpartition(":")
        angle, side = angle_named(angle_name)
        return (*found, *(_of_person(person, line) for line in angle.lines(side)))
    return tuple(found)


def halo_of(name: str, arguments: Arguments, frame_time: float | None) -> int | None:
    """Return the number of frames before and after a range that the quantity needs for the values of the whole
    document; None: all frames.
    """
    quantity = quantity_of(name, arguments)
    if quantity.whole:
        return None
    return reach(frame_time) if quantity.windowed else 0


def compute(name: str, arguments: Arguments, stretch: Stretch) -> Array:
    """Return (n,) values of a quantity in a frame range, float64; NaN where unknown.

    stretch: has the joints of `joints_of`, and begins and ends with the document, or `halo_of` frames before and after
    the requested frames: values in the halo differ from the document's.
    """
    return quantity_of(name, arguments).compute(stretch, arguments)


def found_together(name: str, arguments: Arguments) -> tuple[tuple[str, ...], ...]:
    """Return the arguments of all quantities of this name that one pass over a clip finds, these included: recognition
    finds all activities, and events tell the contacts of both feet.
    """
    if name == "activity" and arguments[0] in ANY_ACTIVITY:
        return tuple((each,) for each in ANY_ACTIVITY)
    if name == "contact" and is_foot(arguments[0]):
        person, colon, _ = arguments[0].rpartition(":")
        return tuple((person + colon + side,) for side in FEET)
    return (tuple(arguments),)


@dataclass(frozen=True)
class AskedQuantity:
    """text: of the request, NAME:ARGUMENT,ARGUMENT. unit: "m", "m/s", "m/s2", "s", "deg" or ""."""

    text: str
    name: str
    arguments: tuple[str, ...]
    unit: str

    @property
    def needs_rotations(self) -> bool:
        """Whether it is read from the channels of the clip, as a turn from the reference pose."""
        return self.name == "angle" and len(self.arguments) == 1 and turn_named(self.arguments[0]) is not None

    @property
    def of_gait(self) -> bool:
        """Whether it is told by the gait events of a walker."""
        return self.name == "contact" and is_foot(self.arguments[0])

    @property
    def of_file(self) -> bool:
        """Whether the file states it, not the body."""
        return QUANTITIES[self.name].of_file

    def joints(self, names: Collection[str]) -> tuple[str, ...]:
        """Return the joints of a skeleton that it needs."""
        return joints_of(self.name, self.arguments, names)

    def check_joints(self, names: Sequence[str]) -> None:
        """NotFoundError where a skeleton with these joints lacks one that it needs."""
        needs = quantity_of(self.name, self.arguments).joints(self.arguments)
        lacking = [one for one in needs if known(one, names) is None]
        if lacking:
            raise NotFoundError(
                f"There is no bone {lacking[0]!r}, which {self.text} is made from.",
                remedy=self._find_remedy(lacking[0], names),
            )

    def _find_remedy(self, joint: str, names: Sequence[str]) -> str:
        """The way to a joint that a skeleton lacks: it may have it of several people."""
        endings = tuple(f":{one}" for one in joint.split("|"))
        of_people = [name for name in names if name.endswith(endings)]
        if not of_people:
            return f"There are: {', '.join(names[:60])}."
        if joint in self.arguments:
            return f"The markers are of several people. Name one of: {', '.join(of_people)}."
        if self.name != "angle":
            return "The markers are of several people. Make a skeleton of each, and ask that: mcml skeletons ID."
        begins = dict.fromkeys(name.rpartition(":")[0] + ":" for name in of_people)
        return f"The markers are of several people. Begin the name with one of: {', '.join(begins)}."


def asked_quantity(text: str) -> AskedQuantity:
    """Parse a quantity such as `speed:right_hand,Root`.

    Raises RequestError or VocabularyError for an unknown one, with the valid names.
    """
    name, _, rest = text.partition(":")
    arguments = tuple(part.strip() for part in rest.split(",")) if rest else ()
    if name.strip() in QUANTITIES and QUANTITIES[name.strip()].of_file and rest:
        # Names of files may have commas.
        arguments = tuple(rest.rsplit(",", len(QUANTITIES[name.strip()].parameters) - 1))
    quantity = quantity_of(name.strip(), arguments)
    quantity.joints(arguments)
    return AskedQuantity(text, name.strip(), arguments, quantity.unit)
