"""Motions in files, without a repository."""

from __future__ import annotations

import io
from contextlib import ExitStack
from dataclasses import replace
from fractions import Fraction
from functools import cached_property, partial
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np

from mcml.errors import ConversionError
from mcml.files.check_names import check_frame_time
from mcml.files.convert_files import Converted, convert_files, result_paths, stated_format
from mcml.files.gait_labels import find_exclusions, find_gait_labels, read_labels, read_spans
from mcml.files.gather_files import gathered, several_motions
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.on_disk import Files, check_free, opened_character, opened_files, paths_of, write_file
from mcml.files.open_clip import open_clip
from mcml.files.read_numbers import Space, read_numbers
from mcml.formats.analog_files import analog_part, channels_reader
from mcml.formats.format import SourceFile
from mcml.formats.measurements import Measurement, Measurements
from mcml.frames import Frames
from mcml.laboratory.gait_events import Side
from mcml.laboratory.gait_model.standing_trial import STANDING_REMEDY, StandingTrial
from mcml.laboratory.gait_model.static_pass import FootOption
from mcml.laboratory.gait_points import find_gait_points
from mcml.laboratory.measure_gait import EventSource, Gait, find_walker, measure_gait
from mcml.language.elements import to_head
from mcml.motion.bodies.activities.activity import Activity
from mcml.motion.bodies.activities.recognition import recognize_activities
from mcml.motion.bodies.activities.signals import JOINTS
from mcml.motion.bodies.calibration import Calibration
from mcml.motion.bodies.clip_body import ClipBody, body_of, quantity_values
from mcml.motion.bodies.quantities import asked_quantity
from mcml.motion.clip import ClipStream
from mcml.motion.frames import joined
from mcml.motion.markers import read_marker_positions
from mcml.motion.skeleton import Array
from mcml.motion.solving.marker_skeleton import has_markers, solve_people


class Motion:
    """A motion from files, completely in memory.

    Quantities of the body (`height`, `speed`, `angle`, …) are in metres, seconds and degrees: the numbers of the `mo:`
    functions of XPath, NaN where unit, frame time, joint or sample are unknown. `calibration` marks guessed values.

    name: of the file. format: such as "bvh". bones: MCML's names, in the order of the skeleton; source_names: those of
    the file. roles: of bones without a name of MCML's, such as "jaw" or "left_finger_one_2". parents: of each bone, -1
    at the root. frame_time: seconds a frame, None if the files do not state it. properties: (name, value, unit).
    notices: guesses and repairs.
    """

    def __init__(self, name: str, clip: ClipStream, original: bytes | None = None) -> None:
        head = clip.head
        self._original = original
        self._clip = _kept(clip)
        self.name = name
        self.format = head.format
        self.bones = list(head.skeleton.names)
        self.source_names = [joint.source_name for joint in head.skeleton.joints]
        self.roles = {joint.name: joint.role for joint in head.skeleton.joints if joint.role is not None}
        self.parents = [joint.parent for joint in head.skeleton.joints]
        self.frame_time = head.seconds_per_frame()
        self.properties = list(head.properties)
        self.notices = [notice.what for notice in clip.notices]

    def __repr__(self) -> str:
        return f"<Motion {self.name!r}: {len(self)} frames of {len(self.bones)} bones>"

    def __len__(self) -> int:
        """How many frames it has."""
        return self._clip.frames or 0

    def frames(self, *bones: str, space: Space = "channels") -> Frames:
        """Return all frames: the file's channels in its units, or global positions or rotations of bones.

        bones: MCML's names; default all. Raises Error for an unknown bone.
        """
        found = read_numbers(self._clip, self.bones, list(bones) or None, space)
        blocks = list(found.blocks())
        values = np.concatenate([block for block, _ in blocks]) if blocks else np.empty((0, *found.shape))
        ids = [str(one) for _, names in blocks for one in names]
        seconds = np.nan if self.frame_time is None else self.frame_time
        return Frames.of(values, found.columns, np.arange(len(values)) * seconds, ids)

    @cached_property
    def calibration(self) -> Calibration:
        """The values that quantities of the body depend on: unit, up axis, floor, leg, reference pose, each with its
        origin.
        """
        return self._body.calibration

    def height(self, joint: str) -> Array:
        """(frames,) metres of a joint above the floor.

        >>> read("walk.bvh").height("Head").shape
        (240,)
        """
        return self._quantity("height", joint)

    def position(self, joint: str, axis: str, origin: str | None = None) -> Array:
        """(frames,) metres along an axis: "x", "y", "z", "up", "front", "left". origin: a joint to measure from."""
        return self._quantity("position", joint, axis, origin)

    def distance(self, joint: str, other: str) -> Array:
        """(frames,) metres between two joints."""
        return self._quantity("distance", joint, other)

    def angle(self, name: str, middle: str | None = None, end: str | None = None) -> Array:
        """(frames,) degrees of an angle such as "left-hip-flexion", or between three joints, at the middle.

        docs/motion.md lists the names. A knee bent backwards is negative if rotations or markers tell where the left of
        its thigh is, otherwise its flexion is never negative.
        """
        return self._quantity("angle", name, middle, end)

    def tilt(self, joint: str, other: str) -> Array:
        """(frames,) degrees between the line from a joint to another and the vertical."""
        return self._quantity("tilt", joint, other)

    def speed(self, joint: str, relative: str | None = None) -> Array:
        """(frames,) metres a second of a joint. relative: a joint that it moves from."""
        return self._quantity("speed", joint, relative)

    def acceleration(self, joint: str, relative: str | None = None) -> Array:
        """(frames,) metres a second squared of a joint. relative: a joint that it moves from."""
        return self._quantity("acceleration", joint, relative)

    def heading(self) -> Array:
        """(frames,) degrees to which the body faces, to the left about the up axis, without jumps at half a turn."""
        return self._quantity("heading")

    def contact(self, joint: str) -> Array:
        """Return (frames,): 1 where a joint is planted on the ground, else 0.

        joint: "left" and "right" are the feet of a walker or runner, on the ground or a belt: 1 from strike to
        off, NaN where no event tells.
        """
        return self._quantity("contact", joint)

    def activity(self, name: str) -> Array:
        """(frames,) 1 where the body is in an activity, such as "walk", "turn left" or "sit", else 0.

        NaN where it cannot be recognised. Raises RequestError for unknown names, with the known ones.
        """
        return self._quantity("activity", name)

    def activities(self) -> tuple[Activity, ...]:
        """Return the activities of the body, such as walk, turn left and jump, in order; frames count from 0.

        >>> [activity.name for activity in read("walk.bvh").activities()]
        ['walk']
        """
        return recognize_activities(self._body.stretch(JOINTS))

    def quantity(self, label: str, axis: str) -> Array:
        """(frames,) of a quantity of the file's own model, such as "LKneeAngles" of Plug-in Gait, in the file's unit.

        axis: "x", "y" or "z". NaN where the file has no sample. Quantities of Plug-in Gait that the file lacks are
        computed from markers; "cgm1:LKneeAngles" always is. Raises NotFoundError for others, and where markers or
        measures are missing.
        """
        return self._quantity("quantity", label, axis)

    def analog(self, channel: str) -> Array:
        """(frames,) means of the samples of an analog channel in each frame, in the file's unit."""
        return self._quantity("analog", channel)

    def force(self, plate: str | int, axis: str) -> Array:
        """(frames,) newtons of the ground on a plate, such as 1, or a foot, such as "left".

        axis: "x", "y" or "z" of the laboratory.
        """
        return self._quantity("force", plate, axis)

    def cop(self, plate: str | int, axis: str) -> Array:
        """(frames,) metres of the centre of pressure on a plate or foot, as for `force`; NaN below 20 N."""
        return self._quantity("cop", plate, axis)

    def free_moment(self, plate: str | int) -> Array:
        """(frames,) newton metres about the vertical on a plate or foot, as for `force`; NaN below 20 N."""
        return self._quantity("free-moment", plate)

    @cached_property
    def measurements(self) -> tuple[Measurement, ...]:
        """The measurements of the file beside the motion: quantities of its model, analog channels, force plates."""
        return tuple(self._measurements.describe())

    @cached_property
    def _measurements(self) -> Measurements:
        head, original = self._clip.head, self._original
        return Measurements(head, None if original is None else channels_reader(head, io.BytesIO(original)))

    def measure_gait(self, events: EventSource = "auto", subject: str | None = None) -> Gait:
        """Measure the gait of a walker or runner: events, strides and spatio-temporal parameters.

        events: "auto" takes them from labels of the clip, such as `left-foot-strike`, where it has any of a side and
        kind, else from force plates and positions; "labels" and "positions" take one alone. subject: the prefix of a
        person's markers, where there are several people. Raises DocumentError without a frame rate, or if heels, toes
        or pelvis are unknown.

        >>> read("walk.c3d").measure_gait().summary("left", "stride_length")
        Summary(mean=1.24, sd=0.01, n=10)
        """
        head = self._clip.head
        points = find_gait_points(head.skeleton, subject)
        labels = find_gait_labels(read_labels(self._clip.blocks()), head, subject)
        exclusions = find_exclusions(read_spans(self._clip.blocks()))
        find_plates = partial(self._measurements.find_events, self._ids)
        return measure_gait(points, self._body.stretch(points.names), labels, events, find_plates, exclusions)

    def measure_standing(self, foot: FootOption | None = None, subject: str | None = None) -> StandingTrial:
        """Measure the offsets and lengths that a standing trial gives to walking trials.

        foot: "foot flat" sets the heel to the height of the toe; None tells it by the offsets that the file states.
        subject: as for `measure_gait`. `lacks` says why there are no measures (docs/analyses/gait_model.md).
        """
        return self._measurements.gait.of(subject).measure_standing(partial(read_marker_positions, self._clip), foot)

    def with_standing_trial(
        self, standing: Motion, foot: FootOption | None = None, subject: str | None = None
    ) -> Motion:
        """Return the motion with the measures of a standing trial of the same person, as properties.

        Measures of the body that the motion has stay. Raises ConversionError if the other motion is no standing trial,
        or if it lacks markers or measures.

        >>> read("walk.c3d").with_standing_trial(read("static.c3d")).quantity("LKneeAngles", "x").shape
        (215,)
        """
        trial = standing.measure_standing(foot, subject)
        if trial.lacks:
            raise ConversionError(f"{standing.name!r} is no standing trial: {trial.lacks}.", remedy=STANDING_REMEDY)
        if not self._measurements.gait.of(subject).has_pelvis:
            raise ConversionError(f"{self.name!r} has no markers of a pelvis.", remedy="Read a trial of markers.")
        own, positions = self._measurements, partial(read_marker_positions, self._clip)
        properties, notes = own.gait.of(subject).use_standing_trial(trial, standing.name, own.quantities, positions)
        head = replace(self._clip.head, properties=tuple(properties))
        made = Motion(self.name, self._clip.with_head(head), self._original)
        made.notices += notes
        return made

    def skeletons(self) -> list[Motion]:
        """Return the motion of every person of a marker trial with a skeleton, named by the prefix of its markers.

        Joints are at the centres that markers tell, bones have one length (docs/api/compose.md). Raises ConversionError
        for a motion with a skeleton, and for markers that show none.
        """
        if not has_markers(self._clip.head.skeleton):
            raise ConversionError(f"{self.name!r} has a skeleton already.", remedy="Read a file of markers.")
        people = solve_people(self._clip.head, joined(self._clip.blocks()))
        return [Motion(" ".join(filter(None, (self.name, one.person))), one.clip()) for one in people]

    @cached_property
    def _ids(self) -> list[Any]:
        return [number for block in self._clip.blocks() for number in block.ids]

    @cached_property
    def _body(self) -> ClipBody:
        return body_of(self._clip.head, self._clip.blocks())

    def _quantity(self, name: str, *arguments: str | int | None) -> Array:
        """Return a quantity in every frame. Raises NotFoundError for an unknown joint or measurement."""
        stated = [str(argument) for argument in arguments if argument is not None]
        asked = asked_quantity(f"{name}:{','.join(stated)}" if stated else name)
        if asked.of_gait:
            person, _, side = asked.arguments[0].rpartition(":")
            return self.measure_gait(subject=person or None).contacts(cast("Side", side), len(self))
        if asked.of_file:
            walker = partial(find_walker, self._clip.head.skeleton, lambda names: self._body.stretch(names))
            return self._measurements.values(asked, self._ids, walker, partial(read_marker_positions, self._clip))
        return quantity_values(self._clip, self._body, asked)


def read(
    files: Files,
    *,
    encoding: str | None = None,
    frame_time: str | float | Fraction | None = None,
    unit: str | None = None,
    up: str | None = None,
    take: str | None = None,
    rate: float | None = None,
) -> Motion:
    """Read the motion in a file, or in several files that belong together (ASF and AMC).

    encoding: of their text, if it is not UTF-8. frame_time: seconds a frame, as a number or a text such as "1/120".
    unit: of its lengths, such as "cm"; up: "X", "Y" or "Z". These set values that the files do not state; nothing is
    converted. take: which motion of a file that holds several. rate: frames a second at which keys are sampled, where
    the file has no rate or another is wanted. Raises Error, with the problem, the line and the remedy.

    >>> read("walk.bvh").frames("Root", space="positions").shape
    (240, 1, 3)
    """
    seconds = None if frame_time is None else check_frame_time(frame_time)
    options = ImportOptions(encoding=encoding, frame_time=seconds, unit=unit, up=up, take=take, rate=rate)
    limits = FileLimits()
    with opened_files(files) as sources, gathered(sources, limits, options=options) as found:
        for _, error in found.problems:
            raise error
        if len(found.clips) != 1:
            raise several_motions(found)
        opened = open_clip(found.clips[0], options, limits)
        head = to_head(opened.document, seconds or opened.stream.head.frame_time)
        original = _content(found.clips[0].files.get(analog_part(head) or ""))
        return Motion(Path(found.clips[0].name).stem, opened.stream.with_head(head), original)


def convert(
    files: Files,
    target: str | PathLike[str],
    *,
    to: str | None = None,
    for_: str | None = None,
    force: bool = False,
    character: str | PathLike[str] | None = None,
    **options: Any,
) -> list[Path]:
    """Write a motion in another format; return the written files (two for ASF/AMC).

    to: the format, if the name of the target does not decide it. for_: the program that reads the result, such as
    "blender": its preset decides format, unit and axes, and the ending of a name without one.
    force: replace existing files.
    character: a body with a skin, in glTF and USD: "own" for this project's figure, or a file with a skinned mesh.
    options: frame_time, encoding, unit, up, take, rate, frames, fps, scale, height, in_place, guesses, and names (of
    joints: mcml, bvh1, bvh2, asf or htr).
    Raises Error for files that cannot be read or written, or that exist.

    >>> convert("walk.bvh", "walk.mcml")
    [PosixPath('walk.mcml')]
    """
    result = Path(target)
    with ExitStack() as stack:
        sources = stack.enter_context(opened_files(files))
        form = stated_format(result, to, for_)
        body = stack.enter_context(opened_character(character))
        options |= {"for_": for_, "stem": result.stem, "character": body}
        converted = convert_files(sources, form, FileLimits(), **options)
        done: Converted = stack.enter_context(converted)
        paths = []
        for path, content in result_paths(result, done, form):
            check_free(path, force=force, sources=paths_of(files))
            write_file(path, content, force=force)
            paths.append(path)
        return paths


def _content(file: SourceFile | None) -> bytes | None:
    """The bytes of a file with measurements."""
    if file is None:
        return None
    file.stream.seek(0)
    return file.stream.read()


def _kept(clip: ClipStream) -> ClipStream:
    """The same clip with its frames in memory."""
    blocks = list(clip.blocks())
    return ClipStream(clip.head, lambda: iter(blocks), sum(map(len, blocks)), clip.notices)
