"""The calibration of a clip, which turns its numbers into metres and heights: unit, up axis, floor, leg, reference
pose. Few files state any of these, so most are guessed from the body, and every value has an origin. People may set
each of them. Guesses are used in queries, but never written to a file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeAlias, TypeVar

import numpy as np

from mcml.errors import RequestError
from mcml.motion.anatomy.axes import uprightness
from mcml.motion.bodies.beginnings import LOOKED_AT, frames_before_motion
from mcml.motion.bodies.bone_axes import MARKER_ZEROS, BoneAxis, HingeSums, bone_axes, pool_hinges
from mcml.motion.bodies.floors import find_floor
from mcml.motion.bodies.origins import Origin
from mcml.motion.bodies.reference import could_stand, standing_zeros
from mcml.motion.calibration_properties import OVERRIDES, read_value
from mcml.motion.clip import ClipHead, Reference, ReferencePose
from mcml.motion.floor_plates import kept_plates
from mcml.motion.frames import Rows
from mcml.motion.guesses import changed_up, stated_up, told_up, up_of_head
from mcml.motion.kinematics import rest_positions
from mcml.motion.landmarks.centres import body_names, centres_of, with_centres
from mcml.motion.landmarks.sizes import sizes_of
from mcml.motion.pictures.figures import axis_of
from mcml.motion.skeleton import Array, Skeleton, once_a_skeleton
from mcml.motion.units import UNITS, Reading, metres_of, reading_of
from mcml.motion.vectors import length
from mcml.numerics.ranks import median

LEGS: Final = 0.6, 1.1
"""Metres from hip to knee to ankle of the people whose motion is captured."""

CANDIDATES: Final[Mapping[str, float]] = {
    **{name: UNITS[name] for name in ("m", "ft", "inch", "cm", "mm")},
    "inch/0.45": 0.0254 / 0.45,
}
"""Units that files are written in without saying so, and their metres; the last one is that of Vicon's ASF files (CMU,
HDM05) and of their conversions. No leg of a person fits two of them."""

FINEST = 1e-4
"""Metres of a step of positions."""
STEPS_OF_A_LEG = 10_000
"""The same where the unit is not known."""

_UNSET: Final = object()

Value = TypeVar("Value")

PoseAt: TypeAlias = Callable[[int], ReferencePose]
HingesOf: TypeAlias = Callable[[], Mapping[str, HingeSums]]
Shared: TypeAlias = Callable[[str | None], Reference | None]

_SAMPLE = 5_000
"""Frames at most, and those at the start."""

_VALUES = ("metres", "up", "floor", "leg", "reference", "leaps", "pose")
_KEPT = ("metres", "up", "floor", "leg", "skipped")


@dataclass(frozen=True)
class Calibration:
    """metres: in a source unit, None where unknown.

    up: the axis that points up, such as "Y" or "-Z". floor: its height along that, in source units. leg: from hip to
    knee to ankle, in source units. step: of the rounded positions, in source units. start: the reference pose, from
    which angles of rotations start. skipped: number of frames at the start with a pose before the motion (a T-pose),
    which are excluded. origins: of each of these except the step, by the names of their settings (reference, leaps).
    zeros: degrees of a standing body, see `standing_zeros`, empty where no pose shows one. bones: where the lines to
    the left of thighs and shanks come from, by their upper joints. With markers of several people, the names of both
    begin with the prefix of a person and a colon.
    """

    metres: float | None
    up: str
    floor: float | None
    leg: float | None
    step: float
    start: Reference
    skipped: int
    origins: Mapping[str, Origin]
    zeros: Mapping[str, float] = field(default_factory=dict)
    bones: Mapping[str, BoneAxis] = field(default_factory=dict)

    @property
    def metres_per_step(self) -> float:
        """NaN where the unit is unknown."""
        return float("nan") if self.metres is None else self.metres * self.step

    @property
    def leaps(self) -> bool:
        """Whether the clip begins with a pose before the motion."""
        return self.skipped > 0

    @property
    def reference(self) -> int | None:
        """The frame, from 0, of the clip that the reference pose was found in, None for the rest pose or none."""
        return None if self.origins["reference"].kind == "unknown" else self.start.frame

    def of_person(self, person: str) -> Calibration:
        """The same with the zeros and bones of a person, by the prefix of the markers."""
        begin = f"{person}:"

        def own(named: Mapping[str, Value]) -> dict[str, Value]:
            return {name.removeprefix(begin): value for name, value in named.items() if name.startswith(begin)}

        return replace(self, zeros=own(self.zeros), bones=own(self.bones))

    def to_json(self) -> dict[str, Any]:
        """Plain values for JSON."""
        values = {name: getattr(self, name) for name in (*_KEPT, "step")} | {"start": self.start.to_json()}
        bones = {name: axis.to_json() for name, axis in self.bones.items()}
        origins = {name: [one.kind, one.reason] for name, one in self.origins.items()}
        return values | {"origins": origins, "zeros": dict(self.zeros), "bones": bones}

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Calibration:
        """Read the output of `to_json`."""
        origins = {name: Origin(*one) for name, one in values["origins"].items()}
        known = {name: values[name] for name in (*_KEPT, "step")}
        bones = {name: BoneAxis.from_json(axis) for name, axis in values["bones"].items()}
        start = Reference.from_json(values["start"])
        return cls(**known, start=start, origins=origins, zeros=values["zeros"], bones=bones)


def calibration_frames(count: int) -> Rows:
    """Return the indices, from 0, of the frames used for a calibration of a clip with this number of frames: all, or
    for long clips the first and evenly spaced ones, so that every calibration gives the same result.
    """
    if count <= _SAMPLE:
        return np.arange(count)
    spaced = np.linspace(0, count - 1, _SAMPLE).astype(np.intp)
    return np.union1d(np.arange(LOOKED_AT), spaced)


def calibrate(
    head: ClipHead,
    positions: Array,
    overrides: Mapping[str, Any] | None = None,
    frames: Rows | None = None,
    *,
    pose_at: PoseAt | None = None,
    shared: Shared | None = None,
    hinges_of: HingesOf | None = None,
) -> Calibration:
    """Calibrate a clip from its stated values and its body.

    head: its joints have MCML's names. positions: (n, J, 3) of the whole clip, or of a sample of it, in source units,
    NaN where unknown; without any, the rest pose is used. frames: (n,) indices of a sample in the clip, from 0.
    overrides: values set by people: metres, up, floor, leg, leaps, reference (a frame from 0, None: the rest pose) and
    pose (the pose of the reference frame when it was chosen, because the clip may have been cut since); by default
    those in the head's properties. Values that depend on a set value are computed from it.
    pose_at: the pose of a frame of the clip; without it angles from rotations can only start from the rest pose.
    shared: the reference that the clips of the skeleton share, by the up axis that is stated; by default the head's.
    hinges_of: sums of the bends of its knees, for a reference that no other clip has set.
    Raises RequestError for an impossible value.
    """
    skeleton = head.skeleton
    reading = reading_of(head)
    rest = _rest(skeleton, reading)
    places: Rows = np.arange(len(positions)) if frames is None else frames
    overrides = dict(overrides_of(head) if overrides is None else _checked(overrides))
    reference, pose = overrides.pop("reference", _UNSET), overrides.pop("pose", None)
    # A frame that the clip no longer has is no pose, unless what it showed is kept.
    kept = None if pose is None or not pose.fits(skeleton) else pose
    if kept is None and isinstance(reference, int) and reference > max(places, default=0):
        reference = _UNSET
    values: dict[str, Any] = dict(overrides)
    origins = dict.fromkeys(overrides, Origin("set"))

    def settle(name: str, found: tuple[Any, Origin]) -> None:
        if name not in overrides:
            values[name], origins[name] = found

    centres, names = centres_of(skeleton), body_names(skeleton)
    sizes = sizes_of(head, overrides.get("metres", metres_of(head)))
    settle("leg", _leg(names, with_centres(centres, positions if len(positions) else rest, sizes)))
    skipped, origin = frames_before_motion(skeleton, positions, places, values["leg"], head.seconds_per_frame())
    settle("leaps", (skipped > 0, origin))
    # A person who sets this where no such pose is detected means the first frame.
    values["skipped"] = max(skipped, 1) if values.pop("leaps") else 0
    if len(places) > 1 and places[0] == 0:
        rows = places >= values["skipped"]
        positions, places = (positions[rows], places[rows]) if rows.any() else (positions, places)
    poses = positions if len(positions) else rest
    settle("metres", _metres(head, values["leg"]))
    settle("up", _up(head, poses))
    up = axis_of(values["up"])
    points = with_centres(centres, poses, sizes_of(head, values["metres"]))
    settle("floor", find_floor(head, names, points, up, values["metres"]))
    origins["reference"] = Origin("set")
    if reference is None or isinstance(reference, int):
        if kept is None and reference is not None and pose_at is not None:
            kept = pose_at(reference)
        values["start"] = Reference(values["up"], None if reference is None else kept, reference)
    else:
        stated = values["up"] if origins["up"].kind in ("stated", "set") else None
        values["start"], origins["reference"] = _start(
            head, reading, positions, places, Up(values["up"], stated), pose_at, shared
        )
        values["start"] = start = _with_hinges(values["start"], hinges_of)
        if start.hinges:
            origins["reference"] = _tell_hinges(origins["reference"], start)
    values |= _anatomy(skeleton, reading, values["start"], origins["reference"])
    return Calibration(step=_step(values["metres"], values["leg"], poses), origins=origins, **values)


def _with_hinges(start: Reference, hinges_of: HingesOf | None) -> Reference:
    """The reference with the axes of knees, if it comes from this clip."""
    if hinges_of is None or start.pose is None or start.of or start.hinges:
        return start
    return replace(start, hinges=pool_hinges([hinges_of()]))


def _tell_hinges(origin: Origin, start: Reference) -> Origin:
    loose = max(hinge[3] for hinge in start.hinges.values())
    about = f"left of the legs by the axes of the knees, which single bends keep within {loose:.2g} degrees"
    return Origin(origin.kind, f"{origin.reason}; {about}")


def _anatomy(skeleton: Skeleton, reading: Reading, start: Reference, origin: Origin) -> dict[str, Any]:
    """Zeros and bones. A pose that the service chose does not show a standing body."""
    zeros: dict[str, float] = {}
    chosen = origin.kind == "set"
    if chosen and start.pose is not None:
        zeros = standing_zeros(skeleton, np.array(start.pose.positions), axis_of(start.up))
    elif could_stand(skeleton, reading, start.up):
        zeros = standing_zeros(skeleton, _rest(skeleton, reading)[0], axis_of(start.up))
    bones = bone_axes(skeleton, reading, start, chosen=chosen)
    # Frames of markers do not lean.
    zeros |= {
        bone.removesuffix(line) + zero: 0.0
        for bone in bones
        for zero, line in MARKER_ZEROS.items()
        if bone == line or bone.endswith(f":{line}")
    }
    return {"zeros": zeros, "bones": bones}


def overrides_of(head: ClipHead) -> dict[str, Any]:
    """Return the values of a calibration in the properties of a header; invalid values are ignored."""
    found: dict[str, Any] = {}
    for name, value, _ in head.properties:
        if name.startswith(OVERRIDES):
            with suppress(ValueError, RequestError):
                key = name.removeprefix(OVERRIDES)
                found |= _checked({key: read_value(key, value)})
    return found


def _checked(overrides: Mapping[str, Any]) -> Mapping[str, Any]:
    """The values that people set, in the order of the fields. RequestError for one that cannot be."""
    for name, value in overrides.items():
        number = isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))
        fits = {
            "metres": number and value > 0,
            "leg": number and value > 0,
            "floor": number,
            "up": isinstance(value, str) and value.removeprefix("-") in ("X", "Y", "Z"),
            "reference": value is None or (number and isinstance(value, int) and value >= 0),
            "pose": isinstance(value, ReferencePose),
            "leaps": isinstance(value, bool),
        }
        if not fits.get(name, False):
            raise RequestError(
                f"{name} cannot be {value!r} in a calibration",
                remedy="Set metres, leg (positive), floor (a number), up (such as Y or -Z), reference (a frame from 0, "
                "or nothing for the rest pose) or leaps (true or false).",
            )
    return {name: overrides[name] for name in _VALUES if name in overrides}


def _leg(names: Sequence[str], positions: Array) -> tuple[float | None, Origin]:
    """The mean of both sides; of rigs whose offsets come with the motion, the median over the frames."""
    at = {name: index for index, name in enumerate(names)}
    found = []
    for side in ("left", "right"):
        parts = [at.get(f"{side}_{part}") for part in ("up_leg", "low_leg", "foot")]
        if None not in parts:
            hip, knee, ankle = (positions[:, part] for part in parts)
            lengths = length(knee - hip) + length(ankle - knee)
            seen = lengths[np.isfinite(lengths)]
            found += [median(seen)] if len(seen) else []
    leg = sum(found) / len(found) if found else 0.0
    if not 0 < leg < np.inf:
        return None, Origin("unknown", "no leg is known from hip to knee to ankle")
    return leg, Origin("measured", "from hip to knee to ankle")


def _metres(head: ClipHead, leg: float | None) -> tuple[float | None, Origin]:
    stated = metres_of(head)
    if stated is not None:
        return stated, Origin("stated", head.fields["calibration_unit"])
    if leg is None:
        return None, Origin("unknown", "the file states none, and no leg tells")
    candidates = dict(CANDIDATES)
    with suppress(ValueError):
        factor = float(head.fields.get("units_length", 0))
        if factor > 0 and np.isfinite(factor):
            candidates[f"inch/{factor:g}"] = 0.0254 / factor
    low, high = LEGS
    fitting = {metres: name for name, metres in candidates.items() if low <= leg * metres <= high}
    if len(fitting) != 1:
        fits = "several units" if fitting else "no unit"
        return None, Origin("unknown", f"the file states none, and a leg of {leg:.4g} fits {fits}")
    metres, name = next(iter(fitting.items()))
    return metres, Origin("guessed", f"a leg of {leg:.4g} is {leg * metres:.2f} m in {name}")


def _up(head: ClipHead, positions: Array) -> tuple[str, Origin]:
    stated = stated_up(head)
    if stated is not None:
        told = told_up(head.skeleton, positions, kept_plates(head))
        if told is None or told.axis == stated:
            return stated, Origin("stated", "" if told is None else told.why)
        return stated, Origin("stated", f"but {told.axis} is likely: {told.why}")
    found = up_of_head(head, positions)
    changed = changed_up(head, positions)
    before = "" if changed is None else f"; by extents alone it was {changed[0]}"
    return found.axis, Origin("guessed", f"{found.axis}: {found.why}{before}")


@once_a_skeleton
def _rest(skeleton: Skeleton, reading: Reading) -> Array:
    """(1, J, 3) of the rest pose."""
    return rest_positions(skeleton, reading)[None, : len(skeleton)]


@dataclass(frozen=True)
class Up:
    """likely: the axis that points up. stated: the same where it is no guess."""

    likely: str
    stated: str | None


def _start(
    head: ClipHead,
    reading: Reading,
    positions: Array,
    frames: Rows,
    up: Up,
    pose_at: PoseAt | None,
    shared: Shared | None,
) -> tuple[Reference, Origin]:
    """The reference pose, where people set none."""
    skeleton = head.skeleton
    if could_stand(skeleton, reading, up.likely):
        return Reference(up.likely, stated=up.stated), Origin("measured", "a body could stand in the rest pose")
    known = head.reference if shared is None else shared(up.stated)
    if known is not None and known.stated == up.stated and (known.pose is None or known.pose.fits(skeleton)):
        if known.pose is None and known.frame is None:
            return known, Origin("measured", "a body could stand in the rest pose")
        where = f"frame {(known.frame or 0) + 1} of {known.of!r}, the first clip of this skeleton" if known.of else ""
        return known, Origin("measured", f"no body could stand in the rest pose; upright in {where or 'a frame'}")
    upright = uprightness(skeleton, positions, axis_of(up.likely))
    if not np.isfinite(upright).any():
        nothing = Reference(up.likely, frame=0, stated=up.stated)
        return nothing, Origin("unknown", "no frame shows the body, and it could not stand in the rest pose")
    frame = int(frames[int(np.nanargmax(upright))])
    pose = None if pose_at is None else pose_at(frame)
    why = "no body could stand in the rest pose; in this frame it is upright"
    return Reference(up.likely, pose, frame, stated=up.stated), Origin("measured", why)


def _step(metres: float | None, leg: float | None, positions: Array) -> float:
    if metres is not None:
        return FINEST / metres
    if leg is not None:
        return leg / STEPS_OF_A_LEG
    seen = positions[np.isfinite(positions).all(axis=2)]
    extent = float(np.ptp(seen, axis=0).max()) if len(seen) else 0.0
    # Of something without legs: the largest extent of all its places, as a body's height is two legs.
    return extent / (2 * STEPS_OF_A_LEG) if extent > 0 else FINEST
