"""The body of the gait model in all frames: quantities by their names in Plug-in Gait."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Final, Literal, TypeAlias

import numpy as np

from mcml.laboratory.gait_model import lower_body, upper_body
from mcml.laboratory.gait_model.dynamics import JOINTS, Ground, Load, joint_loads
from mcml.laboratory.gait_model.lower_body import SIGNS, Leg, Markers
from mcml.laboratory.gait_model.segment_frames import along_z, column
from mcml.laboratory.gait_model.static_pass import has_device, has_knee_axis, stand
from mcml.laboratory.gait_model.subject import Subject, leave_out
from mcml.laboratory.gait_model.upper_body import Arm
from mcml.motion.landmarks.construction import harrington_hip
from mcml.motion.skeleton import Array

Method: TypeAlias = Literal["cgm1", "centres", "landmarks"]
"""cgm1: the Conventional Gait Model 1 from markers and measures alone. centres: the same with joint centres of the
file. landmarks: with centres of the file, or between lateral and medial markers, and hips by Harrington 2007."""

ANGLES: Final = ("Pelvis", "Hip", "Knee", "Ankle", "FootProgress", "Thorax", "Head", "Neck", "Spine", "Shoulder",
                 "Elbow", "Wrist")  # fmt: skip
CENTRES: Final = ("HJC", "KJC", "AJC", "SJC", "EJC", "WJC")
"""Of hip, knee, ankle, shoulder, elbow and wrist."""

OWN_CENTRES: Final[Mapping[str, tuple[str, ...]]] = {"hip": ("FEP", "HJC"), "knee": ("FEO", "KJC"),
                                                    "ankle": ("TIO", "AJC")}  # fmt: skip
"""Names, without the side, of centres in files: that of Plug-in Gait itself, and that of any model."""

QUANTITIES: Final = (
    *(f"{side}{part}Angles" for part in ANGLES for side in "LR"),
    *(f"{side}{centre}" for centre in CENTRES for side in "LR"),
    *(f"{side}{joint}{kind}" for kind in ("Moment", "Power") for joint in JOINTS[::-1] for side in "LR"),
)
"""Names of all quantities, by those of Plug-in Gait."""

_LEG: Final = ("Hip", "Knee", "Ankle", "FootProgress", "HJC", "KJC", "AJC")


class LackError(Exception):
    """parts: markers and measures that a quantity lacks."""

    def __init__(self, *parts: str) -> None:
        super().__init__(", ".join(parts))
        self.parts = parts


def is_load(name: str) -> bool:
    """Whether a quantity is a moment or a power, which needs force plates."""
    return name.endswith(("Moment", "Power"))


def is_of_leg(name: str) -> bool:
    """Whether a quantity depends on a leg, and so on the method."""
    return is_load(name) or name[1:].removesuffix("Angles") in _LEG


class ModelBody:
    """A body whose parts are computed once, when a quantity needs them.

    markers: (n, 3) millimetres by the names of `model_markers`, in consecutive frames. find_ground: returns the
    reaction of the ground on a side, in newtons and metres. rate: frames a second. Both are for moments and powers.
    """

    def __init__(
        self,
        markers: Markers,
        subject: Subject,
        method: Method = "cgm1",
        find_ground: Callable[[str], Ground] | None = None,
        rate: float = np.nan,
    ) -> None:
        self.method = method
        self._markers = leave_out(subject.unused, markers)
        self._subject, self._find_ground, self._rate = subject, find_ground, rate
        self._legs: dict[str, Leg] = {}
        self._arms: dict[str, Arm] = {}
        self._loads: dict[str, dict[str, Load]] = {}

    def quantity(self, name: str) -> Array:
        """(n, 3) of a quantity: degrees, millimetres, N mm/kg, or W/kg in the third component.

        Raises LackError where markers or measures are missing.
        """
        side, part = name[0], name[1:]
        if is_load(name):
            load = self._loads_of(side)[part.removesuffix("Moment").removesuffix("Power")]
            if part.endswith("Moment"):
                return load.moment
            none = np.where(np.isfinite(load.power), 0.0, np.nan)
            return np.stack([none, none, load.power], axis=1)
        if part == "HJC":
            return self._hip(side)
        if part in ("KJC", "AJC"):
            leg = self._leg(side)
            return leg.knee if part == "KJC" else leg.ankle
        if part in CENTRES:
            arm = self._arm(side)
            return {"SJC": arm.shoulder, "EJC": arm.elbow, "WJC": arm.wrist}[part]
        return self._angles(side, part.removesuffix("Angles"))

    def has_leg(self, side: str) -> bool:
        """Whether thigh and shank of a side can be computed."""
        try:
            self._leg(side)
        except LackError:
            return False
        return True

    def _angles(self, side: str, part: str) -> Array:
        laboratory = self._subject.laboratory[None]
        if part == "Pelvis":
            return lower_body.pelvis_angles(side, laboratory, self._pelvis[1])
        if part == "Hip":
            return lower_body.hip_angles(side, self._pelvis[1], self._leg(side).thigh)
        if part == "Knee":
            return lower_body.knee_angles(side, self._leg(side).thigh, self._leg(side).shank)
        if part in ("Ankle", "FootProgress"):
            self._need(*self._foot_markers(side))
        if part == "Ankle":
            return lower_body.ankle_angles(side, self._leg(side).torsioned, self._leg(side).foot)
        if part == "FootProgress":
            return lower_body.foot_progress_angles(side, laboratory, self._leg(side).foot)
        if part == "Thorax":
            return upper_body.thorax_angles(side, laboratory, self._thorax[1])
        if part == "Head":
            return upper_body.trunk_angles(side, laboratory, self._head)
        if part == "Neck":
            return upper_body.trunk_angles(side, self._head, self._thorax[1])
        if part == "Spine":
            return upper_body.trunk_angles(side, self._thorax[1], self._pelvis[1])
        arm = self._arm(side)
        if part == "Shoulder":
            return upper_body.shoulder_angles(side, self._thorax[1], arm.humerus)
        if part == "Elbow":
            return upper_body.elbow_angles(arm.humerus, arm.radius)
        self._need(f"{side}FIN", measures=(f"{side}HandThickness",))
        hand = upper_body.hand_frame(side, arm.wrist, self._markers, self._subject.measures, self._subject.diameter)
        return upper_body.wrist_angles(side, arm.radius, hand)

    @cached_property
    def _pelvis(self) -> tuple[Array, Array]:
        back = () if "SACR" in self._markers else ("LPSI", "RPSI")
        self._need("LASI", "RASI", *back)
        return lower_body.pelvis_frame(self._markers)

    @cached_property
    def _thorax(self) -> tuple[Array, Array]:
        self._need(*upper_body.TRUNK)
        return upper_body.thorax_frame(self._markers, self._subject.diameter)

    @cached_property
    def _head(self) -> Array:
        self._need(*upper_body.HEAD)
        return upper_body.head_frame(self._markers, self._subject.measures.of("HeadOffset"))

    def _hip(self, side: str) -> Array:
        if (own := self._own(side, "hip")) is not None:
            return own
        if self.method == "landmarks":
            sizes = np.array(self._subject.width), np.array(self._subject.depth)
            point = harrington_hip(SIGNS[side], *sizes)
            return lower_body.place_in(*self._pelvis, point)
        measures = self._subject.measures
        if all(measures.get(f"{each}LegLength") is None for each in "LR"):
            self._need(measures=(f"{side}LegLength",))
        point = lower_body.hip_in_pelvis(side, measures, self._subject.width, self._subject.diameter)
        return lower_body.place_in(*self._pelvis, point)

    def _leg(self, side: str) -> Leg:
        if side not in self._legs:
            make = self._make_from_landmarks if self.method == "landmarks" else self._make_leg
            self._legs[side] = make(side)
        return self._legs[side]

    def _make_leg(self, side: str) -> Leg:
        markers, subject = self._markers, self._subject
        measures, diameter = subject.measures, subject.diameter
        knee, ankle = self._own(side, "knee"), self._own(side, "ankle")
        with_device = subject.is_static and has_device(side, markers)
        with_axis = subject.is_static and has_knee_axis(side, markers)
        needed, widths = ["ANK"], []
        if not with_device:
            needed += ["KNE"] if knee is not None or with_axis else ["KNE", "THI"]
        if ankle is None and not (subject.is_static and f"{side}MED" in markers):
            needed.append("TIB")
        widths += ["KneeWidth"] if knee is None or with_device else []
        widths += ["AnkleWidth"] if ankle is None else []
        hip = self._need_all(
            lambda: self._hip(side), *(side + name for name in needed), measures=[side + name for name in widths]
        )
        markers = {**markers, f"{side}TOE": self._point(f"{side}TOE")}
        if subject.is_static and f"{side}HEE" in markers:
            return stand(side, hip, markers, measures, diameter, subject.up, subject.foot, (knee, ankle)).leg
        if knee is None:
            knee = lower_body.knee_centre(side, hip, markers, measures, diameter)
        if ankle is None:
            ankle = lower_body.ankle_centre(side, knee, markers, measures, diameter)
        return lower_body.leg_from_centres(side, hip, knee, ankle, markers, measures)

    def _make_from_landmarks(self, side: str) -> Leg:
        """A leg whose knee's and ankle's axes are along their lateral and medial markers; a foot from heel to toe."""
        hip, (knee, across_knee), (ankle, across_ankle) = (
            self._hip(side),
            self._between(side, "knee"),
            self._between(side, "ankle"),
        )
        shank = along_z(knee - ankle, across_ankle)
        foot = lower_body.foot_frame(self._point(f"{side}Heel") - self._point(f"{side}Toe"), column(shank, 1))
        return Leg(hip, knee, ankle, along_z(hip - knee, across_knee), shank, shank, foot)

    def _between(self, side: str, joint: str) -> tuple[Array, Array]:
        """(centre, direction to the left) of a joint between its lateral and medial markers, or with its own centre."""
        name, own = side + joint.capitalize(), self._own(side, joint)
        self._need(f"{name}Lateral", *([] if own is not None else [f"{name}Medial"]))
        outer = self._markers[f"{name}Lateral"]
        inner = self._markers.get(f"{name}Medial", own if own is not None else outer)
        return (outer + inner) / 2 if own is None else own, SIGNS[side] * (outer - inner)

    def _point(self, name: str) -> Array:
        """(n, 3) a marker, NaN where it is absent: other parts are known all the same."""
        return self._markers[name] if name in self._markers else np.full_like(self._pelvis[0], np.nan)

    def _arm(self, side: str) -> Arm:
        if side not in self._arms:
            thorax = self._thorax
            widths = [side + name for name in ("ShoulderOffset", "ElbowWidth", "WristWidth")]
            self._need(*(side + name for name in upper_body.ARM), measures=widths)
            self._arms[side] = upper_body.arm_of(
                side, thorax, self._markers, self._subject.measures, self._subject.diameter
            )
        return self._arms[side]

    def _loads_of(self, side: str) -> dict[str, Load]:
        if side not in self._loads:
            leg = self._leg(side)
            toe = self._foot_markers(side)[0]
            self._need(*self._foot_markers(side), measures=("Bodymass",))
            if self._find_ground is None:
                raise LackError("force plates")
            if not np.isfinite(self._rate):
                raise LackError("frame rate")
            self._loads[side] = joint_loads(
                side, leg, self._pelvis[1], self._markers[toe], self._find_ground(side),
                self._subject.measures.of("Bodymass"), self._rate, self._subject.up,
            )  # fmt: skip
        return self._loads[side]

    def _foot_markers(self, side: str) -> tuple[str, ...]:
        return (f"{side}Toe", f"{side}Heel") if self.method == "landmarks" else (f"{side}TOE",)

    def _own(self, side: str, joint: str) -> Array | None:
        """(n, 3) a centre that the file has, where the method uses it: none of model 1 among landmarks."""
        names = {"cgm1": (), "centres": OWN_CENTRES[joint], "landmarks": OWN_CENTRES[joint][1:]}[self.method]
        return next((self._markers[side + name] for name in names if side + name in self._markers), None)

    def _need_all(self, make: Callable[[], Array], *markers: str, measures: Sequence[str]) -> Array:
        """Make a part, and name all that it lacks together with further markers and measures."""
        parts: tuple[str, ...] = ()
        for deed in (make, lambda: self._need(*markers, measures=measures)):
            try:
                deed()
            except LackError as error:
                parts += error.parts
        if parts:
            raise LackError(*parts)
        return make()

    def _need(self, *markers: str, measures: Sequence[str] = ()) -> None:
        lacks = [f"marker {name}" for name in markers if name not in self._markers]
        lacks += [f"measure {name}" for name in measures if self._subject.measures.get(name) is None]
        if lacks:
            raise LackError(*lacks)


def choose_method(side: str, markers: Markers, subject: Subject) -> Method:
    """Return the method for a leg: the model where markers and measures, or its own centres in the file, allow it, else
    landmarks on both sides of the joints.
    """
    if ModelBody(markers, subject, "cgm1").has_leg(side):
        has_own = any(side + name in markers for names in OWN_CENTRES.values() for name in names)
        return "centres" if has_own else "cgm1"
    has_model = all(side + names[0] in markers for names in OWN_CENTRES.values())
    if has_model and ModelBody(markers, subject, "centres").has_leg(side):
        return "centres"
    return "landmarks" if ModelBody(markers, subject, "landmarks").has_leg(side) else "cgm1"
