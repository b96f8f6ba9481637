"""Quantities of the gait model of a clip: which can be computed, from what, and their values.

Measures of the subject are of the kept file, and so are the directions of the laboratory and the offsets of a standing
trial, which are of the whole recording: trimmed clips have the values of the whole. Markers are those of the clip, so
that edits of them count.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml.formats.c3d.analog import Channels
from mcml.formats.c3d.subjects import read_measures, read_measures_of
from mcml.formats.gait_markers import FindPositions, GaitMarkers
from mcml.formats.gait_properties import Property, leave_out_equal, read_properties, standing_trial_of
from mcml.formats.gait_properties import use_standing_trial as properties_with
from mcml.laboratory.gait_model.dynamics import Ground
from mcml.laboratory.gait_model.measures import Measures, clean_measures
from mcml.laboratory.gait_model.model_body import (
    QUANTITIES,
    LackError,
    Method,
    ModelBody,
    choose_method,
    is_load,
    is_of_leg,
)
from mcml.laboratory.gait_model.segment_frames import make_continuous
from mcml.laboratory.gait_model.standing_trial import StandingTrial, measure_standing
from mcml.laboratory.gait_model.static_pass import FootOption
from mcml.laboratory.gait_model.subject import Subject, find_subject, has_pelvis
from mcml.laboratory.gait_model.upper_body import ARM, HEAD, TRUNK
from mcml.laboratory.gait_model.virtual_markers import VirtualMarker, find_virtual_markers
from mcml.motion.clip import ClipHead
from mcml.motion.guesses import stated_up, up_of_head
from mcml.motion.pictures.figures import axis_of
from mcml.motion.skeleton import Array

Ids: TypeAlias = NDArray[np.int64] | Sequence[str]
FindGround: TypeAlias = Callable[[str, NDArray[np.intp], int], Ground]
"""Returns the reaction of the ground on "L" or "R" in (count,) frames of the file, of which the clip has these."""

PREFIXES: Final[dict[str, Method]] = {"cgm1:": "cgm1", "landmarks:": "landmarks"}
"""Beginnings of names that ask for a method, also where the file has the quantity itself."""

_METHODS: Final[dict[Method, str]] = {
    "cgm1": "computed by the Conventional Gait Model 1 from markers",
    "centres": "computed by the Conventional Gait Model 1 from markers and the joint centres of the file",
    "landmarks": "computed from landmarks on both sides of the joints: not comparable with the Conventional Gait Model",
}
_KINDS: Final = {"Angles": ("deg", "ANGLES"), "Moment": ("Nmm/kg", "MOMENTS"), "Power": ("W/kg", "POWERS")}
"""Unit and group by the end of a name; centres have no such end."""

_TRAVEL_OF_CLIP: Final = "forward is the axis along which the pelvis travels in the clip, or that it faces"
_SAMPLE: Final = 2000
"""Frames of a clip without a file that tell the axis up."""


@dataclass(frozen=True)
class ComputedQuantity:
    """name: with its prefix. unit, group: of values. reason: why it cannot be computed, "" where it can. notes: its
    method and its assumptions."""

    name: str
    unit: str
    group: str
    reason: str
    notes: tuple[str, ...]


class GaitQuantities:
    """The quantities of the gait model of a clip.

    head: of the clip. channels: of its kept file, None without one; those of a file without points tell its frames
    alone. has_plates: whether force plates can be used. person: the prefix of the markers, where there are several
    people.
    """

    def __init__(
        self, head: ClipHead, channels: Channels | None, *, has_plates: bool, person: str | None = None
    ) -> None:
        self._head, self._channels, self._has_plates = head, channels, has_plates
        self._file = channels if channels is not None and channels.layout.points else None
        self._person = person
        self._markers = GaitMarkers(head, self._file, person)
        self._bodies: dict[Method, ModelBody] = {}
        self._bodies_of_file: dict[Method, ModelBody] = {}
        self._ids: Ids = []

    @property
    def are_asked(self) -> bool:
        """Whether the clip has markers of a pelvis and a knee, so that its quantities are listed."""
        knees = {f"{side}{name}" for side in "LR" for name in ("KNE", "KneeLateral")}
        return bool(self._markers.found.problem) or (self.has_pelvis and not knees.isdisjoint(self._markers.names))

    @property
    def has_pelvis(self) -> bool:
        """Whether the clip has the markers of a pelvis, without which no standing trial helps it."""
        return has_pelvis(dict.fromkeys(self._markers.names, np.empty(0)))

    def describe(self, stated: Sequence[str]) -> Iterator[ComputedQuantity]:
        """Every quantity that the file lacks, and model 1 beside stated quantities. stated: names in the file."""
        if not self.are_asked:
            return
        for name in QUANTITIES:
            described = self._describe(name if name not in stated else f"cgm1:{name}")
            # A clip of legs alone needs no list of everything that arms lack.
            if not described.reason or is_of_leg(name) or self._has_some_of(name):
                yield described

    def lacks(self, name: str) -> str | None:
        """Why a quantity cannot be computed, "" where it can, None for a name that is no quantity of the model."""
        _, bare = _split(name)
        if bare not in QUANTITIES or not (self.are_asked or self._markers.names):
            return None
        return self._describe(name).reason

    def measure_standing(self, find_positions: FindPositions, foot: FootOption | None = None) -> StandingTrial:
        """Measure the clip as a standing trial. foot: how it takes the foot; None as properties state, or to tell it by
        stored offsets."""
        found = self._markers.found
        if found.problem or not found.joints:
            return StandingTrial(lacks=found.problem or "it has no markers of a person")
        if self._file is None:
            positions = find_positions(self._markers.joints)
            markers = self._markers.name(positions)
            up = self._subject_of_clip(markers, positions).up
        else:
            markers, up = self._markers.sample, self._subject.up

        def find_virtual() -> dict[str, VirtualMarker]:
            others = self._markers.label_all(find_positions)
            return dict(find_virtual_markers(markers, others, self._markers.segments(), self._markers.labels))

        return measure_standing(self._measures, markers, up, foot or self._stated_by_people[1], find_virtual)

    def use_standing_trial(
        self, trial: StandingTrial, title: str, stated: Collection[str], find_positions: FindPositions
    ) -> tuple[list[Property], list[str]]:
        """(properties of the clip with the measures of a standing trial, notes).

        title: the name of that trial. stated: names of quantities in the file of the clip.
        """
        virtual, notes = self._markers.choose_virtual(trial.virtual)
        notes += self._markers.check_virtual(virtual, find_positions)
        properties, more = properties_with(
            self._head.properties, replace(trial, virtual=virtual), title, self._measures_of_file, self._person or ""
        )
        notes += more
        markers = {"ThighRotation": "THI", "ShankRotation": "TIB", "StaticPlantFlex": "TOE"}
        for measure in trial.measures:
            needed = measure.name[0] + markers.get(measure.name[1:], "")
            if measure.name[1:] in markers and needed not in self._markers.names:
                notes.append(f"{measure.name} is not used: there is no marker {needed}")
        if any(name.endswith(f"{side}KneeAngles") for name in stated for side in "LR"):
            notes.append("the file has angles of its laboratory, which come first; those of this trial are computed "
                         "beside them, such as cgm1:LKneeAngles")  # fmt: skip
        return properties, notes

    def values(
        self, name: str, axis: int, ids: Ids, find_positions: FindPositions, find_ground: FindGround | None
    ) -> Array:
        """(n,) of a quantity in frames with these ids; NaN in frames that are not of the file."""
        places, count = self._timeline(ids)
        if not np.array_equal(np.asarray(ids), np.asarray(self._ids)) or not self._bodies:
            self._bodies, self._ids = {}, ids
        prefix, bare = _split(name)
        method = self._method(prefix, bare)
        if method not in self._bodies:
            self._bodies[method] = self._make_body(method, places, count, find_positions, find_ground)
        whole = self._bodies[method].quantity(bare)[:, axis]
        if _kind_of(bare)[1] == "ANGLES":
            whole = whole + self._whole_turns(bare, method, whole, axis)
        values = np.full(len(places), np.nan)
        values[places >= 0] = whole[places[places >= 0]]
        return values

    def _whole_turns(self, name: str, method: Method, degrees: Array, axis: int) -> Array:
        """(count,) multiples of 360 that make an angle (count,) continuous, as it is in the whole file.

        Of somebody who turns round, angles grow beyond 180 degrees; in a trimmed clip they are the same.
        """
        frames, angles = np.arange(len(degrees)), degrees
        if self._file is not None:
            frames = self._markers.read[1]
            angles = self._body_of_file(method).quantity(name)[:, axis]
        continuous = make_continuous(angles[:, None])[:, 0]
        known = np.isfinite(continuous)
        if not known.any() or np.abs(continuous[known]).max() <= 180.0:
            return np.zeros(len(degrees))
        course = np.interp(np.arange(len(degrees)), frames[known], continuous[known])
        return np.asarray(360.0 * np.rint((course - degrees) / 360.0))

    def _body_of_file(self, method: Method) -> ModelBody:
        if method not in self._bodies_of_file:
            self._bodies_of_file[method] = ModelBody(self._markers.sample, self._subject, method)
        return self._bodies_of_file[method]

    def _make_body(
        self,
        method: Method,
        places: NDArray[np.intp],
        count: int,
        find_positions: FindPositions,
        find_ground: FindGround | None,
    ) -> ModelBody:
        positions = find_positions(self._markers.joints)
        whole = np.full((count, *positions.shape[1:]), np.nan)
        known = places >= 0
        whole[places[known]] = positions[known]
        markers = self._markers.name(whole)
        subject = self._subject if self._file is not None else self._subject_of_clip(markers, positions)
        ground = None if find_ground is None else lambda side: find_ground(side, places, count)
        return ModelBody(markers, subject, method, ground, self._rate)

    def _timeline(self, ids: Ids) -> tuple[NDArray[np.intp], int]:
        """(place of each frame in the recording, -1 for others; frames of the recording)."""
        channels, numbers = self._channels, np.asarray(ids)
        if channels is None:
            return np.arange(len(ids)), len(ids)
        if numbers.dtype.kind != "i":
            return np.full(len(ids), -1), channels.frames
        places = numbers - channels.first
        return np.where((places >= 0) & (places < channels.frames), places, -1), channels.frames

    def unit(self, name: str) -> str:
        """The unit of a quantity, "" for a name that is no quantity of the model."""
        bare = _split(name)[1]
        return _kind_of(bare)[0] if bare in QUANTITIES else ""

    def _describe(self, name: str) -> ComputedQuantity:
        prefix, bare = _split(name)
        unit, group = _kind_of(bare)
        if self._markers.found.problem:
            return ComputedQuantity(name, unit, group, self._markers.found.problem, ())
        method = self._method(prefix, bare)
        ground = _no_ground if self._has_plates else None
        body = ModelBody(self._instant, self._subject, method, ground, self._rate)
        try:
            body.quantity(bare)
        except LackError as error:
            return ComputedQuantity(name, unit, group, f"missing: {', '.join(error.parts)}", ())
        return ComputedQuantity(name, unit, group, "", tuple(self._notes(bare, method)))

    def _has_some_of(self, name: str) -> bool:
        """Whether the clip has any marker of a part of the upper body."""
        part = name[1:].removesuffix("Angles")
        own = {"Head": HEAD, "Neck": HEAD, "Thorax": TRUNK, "Spine": TRUNK}.get(
            part, [name[0] + marker for marker in ARM]
        )
        return part == "Pelvis" or any(marker in self._markers.names for marker in own)

    def _notes(self, name: str, method: Method) -> Iterator[str]:
        subject, part = self._subject, name[1:].removesuffix("Angles")
        own = {"cgm1": (), "centres": ("FEP", "HJC"), "landmarks": ("HJC",)}[method]
        has_hip = any(name[0] + centre in self._markers.names for centre in own)
        yield _METHODS[method if is_of_leg(name) else "cgm1"]
        if is_of_leg(name) and method == "landmarks":
            yield "hips of the file" if has_hip else "hips by Harrington 2007"
            virtual = [each for each in self._markers.virtual if each[0] == name[0]]
            if virtual:
                title = standing_trial_of(self._head.properties, self._person or "")
                yield f"virtual markers by the standing trial {title!r}: {', '.join(virtual)}"
        elif subject.diameter_note and (is_of_leg(name) or part in ("Shoulder", "Elbow", "Wrist", "SJC", "EJC", "WJC")):
            yield subject.diameter_note
        if is_of_leg(name) and not has_hip and subject.measures.get("InterAsisDistance") is None:
            width = f"{subject.width:.0f} mm, " if np.isfinite(subject.width) else ""
            yield f"InterAsisDistance not stated; {width}the mean distance of the markers"
        if subject.measures.were_degrees and method != "landmarks" and is_of_leg(name):
            yield "angles among the measures are taken as degrees: one of them exceeds pi"
        if subject.measures.unit != "mm" and method != "landmarks" and is_of_leg(name):
            yield f"lengths among the measures are taken as {subject.measures.unit}: so long are legs of people"
        stated = [measure for measure in self._stated_by_people[0] if measure[0] not in "LR" or measure[0] == name[0]]
        if stated and method != "landmarks" and part != "Pelvis":
            title = standing_trial_of(self._head.properties, self._person or "")
            source = f"the standing trial {title!r} and properties" if title else "properties"
            yield f"measures from {source}: {', '.join(stated)}"
        if part in ("Pelvis", "Thorax", "Head", "FootProgress"):
            yield subject.travel_note if self._file is not None else _TRAVEL_OF_CLIP
        if part in ("Ankle", "FootProgress") and method == "landmarks":
            heel, toe = (self._markers.labels.get(name[0] + end, end) for end in ("Heel", "Toe"))
            yield f"the foot is the line from {heel} to {toe}"
        elif part in ("Ankle", "FootProgress"):
            if subject.static_note:
                yield subject.static_note
            elif subject.measures.get(f"{name[0]}StaticPlantFlex") is None:
                yield "the file has no offsets of a standing trial: the foot is the line from ankle to toe"
        if is_load(name):
            yield "per kg of the measure Bodymass; known where this foot alone is on force plates"

    def _method(self, prefix: str, name: str) -> Method:
        if prefix:
            return PREFIXES[prefix]
        return self._methods[name[0]] if is_of_leg(name) else "cgm1"

    @property
    def _rate(self) -> float:
        """Frames a second, NaN where unknown."""
        seconds = self._head.seconds_per_frame()
        return float("nan") if seconds is None else 1 / seconds

    @cached_property
    def _methods(self) -> dict[str, Method]:
        return {side: choose_method(side, self._instant, self._subject) for side in "LR"}

    @cached_property
    def _instant(self) -> dict[str, Array]:
        """The first frame of the sample: enough to try every quantity."""
        return {name: places[:1] for name, places in self._markers.sample.items()}

    @cached_property
    def _subject(self) -> Subject:
        in_unit_of_file = self._markers.whole / self._markers.to_millimetres
        return self._find_subject(self._markers.sample, in_unit_of_file)

    def _subject_of_clip(self, markers: dict[str, Array], positions: Array) -> Subject:
        """The subject of a clip without a file. positions: (n, k, 3) of the joints of the markers."""
        rows = np.unique(np.linspace(0, len(positions) - 1, min(len(positions), _SAMPLE)).astype(np.intp))
        sample = np.full((len(rows), len(self._head.skeleton), 3), np.nan)
        sample[:, self._markers.joints] = positions[rows]
        return self._find_subject(markers, sample)

    def _find_subject(self, markers: dict[str, Array], positions: Array) -> Subject:
        """positions: (n, J, 3) of joints in some frames, which tell the axis up where the file does not state it."""
        stated = stated_up(self._head)
        if stated is None and len(positions):
            stated = up_of_head(self._head, positions).axis
        return find_subject(self._measures, markers, axis_of(stated or "Z"), self._stated_by_people[1])

    @cached_property
    def _measures(self) -> Measures:
        return self._measures_of_file.with_values(self._stated_by_people[0])

    @cached_property
    def _measures_of_file(self) -> Measures:
        if self._file is None:
            return clean_measures({})
        said, prefix = self._file.said, self._markers.found.prefix
        return clean_measures(read_measures(said, prefix) if self._person is None else read_measures_of(said, prefix))

    @cached_property
    def _stated_by_people(self) -> tuple[dict[str, float], FootOption | None]:
        measures, foot = read_properties(self._head.properties, self._person or "")
        return leave_out_equal(measures, self._measures_of_file), foot


def _split(name: str) -> tuple[str, str]:
    """(prefix, name of the model) of a name."""
    prefix = next((prefix for prefix in PREFIXES if name.startswith(prefix)), "")
    return prefix, name.removeprefix(prefix)


def _kind_of(name: str) -> tuple[str, str]:
    """(unit, group) of a quantity of the model."""
    return next((kind for ending, kind in _KINDS.items() if name.endswith(ending)), ("mm", "CENTRES"))


def _no_ground(side: str) -> Ground:
    gone = np.full((1, 3), np.nan)
    return Ground(gone, gone, gone)
