"""C3D: labelled points of optical systems, binary.

Source: The C3D File Format User Guide (Motion Lab Systems, c3d.org); this program's reading of it is in
docs/formats/c3d.md.

`parameters` reads header and parameters, `layout` finds the position of the points, `points` reads them; this module
turns them into a clip of markers.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from mcml.errors import Notice
from mcml.formats.c3d.data import find_data, first_frame
from mcml.formats.c3d.events import Event, label_frames, read_events, section_of
from mcml.formats.c3d.layout import scales_said
from mcml.formats.c3d.parameters import Statements, read_statements
from mcml.formats.c3d.plates import corners_of
from mcml.formats.c3d.points import Points
from mcml.formats.c3d.quantities import Quantity, quantities_of, sections_of, texts_of
from mcml.formats.c3d.rotations import count_rotations, read_rotations
from mcml.formats.c3d.subjects import read_measures_by_subject
from mcml.formats.c3d.writer import write_c3d
from mcml.formats.format import FileKind, ReadOptions, SourceFile, need_convention, note
from mcml.formats.gait_properties import state_measures
from mcml.laboratory.gait_model.measures import clean_measures
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, Shape, SourcePart, full_shape
from mcml.motion.floor_plates import section_of_plates
from mcml.motion.guesses import LikelyUp, told_up
from mcml.motion.markers import UNNAMED, marker_skeleton
from mcml.motion.skeleton import Array, Convention, Skeleton

_SAMPLE = 200_000
"""Positions, about, from which the up axis is told."""

_MOST_SUBJECTS = 20
_NAMED = 4
"""Properties that a notice names."""


class C3d:
    """The format `c3d`; see `mcml.formats.format.Format`."""

    name = "c3d"
    title = "C3D"
    parts = (FileKind("c3d", (".c3d",), "Markers"),)
    convention = Convention.MARKER
    media_type = "application/octet-stream"
    label = "C3D"
    bodies, markers = False, True
    needs = frozenset({"frame_time"})
    assumes = ""
    states = frozenset({"unit", "up", "frame_time", "force_plates"})

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        # Byte 2 is the mark, byte 1 the block of the parameters. A text file has no NUL.
        return (
            "c3d" if first_bytes[1:2] == b"P" and first_bytes[:1] not in (b"", b"\0") and b"\0" in first_bytes else None
        )

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        file = files["c3d"]
        with file.blamed():
            return _read(file, options)

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        need_convention(clip.head.skeleton, self.convention, self.title)
        return write_c3d(clip)


def _read(file: SourceFile, options: ReadOptions) -> ClipStream:
    limits, stream = options.limits, file.stream
    notices: list[Notice] = []
    said = read_statements(stream, notices)
    name = file.name.rsplit("/", 1)[-1]
    if count_rotations(said) and not said.number("POINT:USED") and not said.words[1]:
        fields = _fields(said, name, notices)
        clip = read_rotations(
            stream,
            said,
            float(fields.get("dataframe_rate", "0")),
            fields.get("calibration_unit", ""),
            fields.get("global_axis_of_gravity", ""),
            SourcePart(part="c3d", name=name),
            options,
        )
        clip.notices.extend(notices)
        return clip
    layout = find_data(stream, said, notices)
    limits.check_size(layout.frames, 3 * layout.points)
    labels = _labels(said, layout.points, notices)
    limits.check_points(labels)
    quantities = quantities_of(said, labels)
    places = np.array([place for place in range(layout.points) if place not in quantities], dtype=np.intp)
    if not len(places):
        note(notices, "warning", "the file has no markers: all of its points are quantities")
    scale = scales_said(said)[0][0]
    points = Points(stream, layout, said.machine, abs(scale))
    measured, unmeasured, sample = _survey(points, places)
    if unmeasured:
        notices.append(Notice("guess", "every residual says that there is no sample; the coordinates count"))
    own = [labels[place] for place in places.tolist()]
    skeleton = marker_skeleton(own, residual=measured, names=_names(said, labels, places.tolist(), notices))
    plates = corners_of(said)
    told = told_up(skeleton, sample, plates)
    fields, first_id = _fields(said, name, notices, told), first_frame(said, layout.frames)
    events = read_events(said, notices)
    labelled = _label_frames(events, fields, first_id, layout.frames, notices)
    _say_what_stays(said, layout.analog, notices)
    read = _with_samples(points, quantities, first_id, fields.get("dataframe_rate", "?"), unmeasured)
    sections = (("POINT:SCALE", repr(scale)), ("processor", said.machine.name), *sections_of(read, notices))
    sections += (section_of(events),) if events else ()
    sections += (section_of_plates(plates),) if len(plates) else ()
    sources = (SourcePart(part="c3d", name=name, sections=sections),)
    head = ClipHead("c3d", skeleton, fields, sources=sources, properties=_properties(said, notices))

    def blocks() -> Iterator[FrameBlock]:
        for first in range(0, layout.frames, points.block):
            coordinates, residuals = points.read(first, points.block)
            block = _block(coordinates[:, places], residuals[:, places], skeleton, first_id + first, unmeasured)
            names = [labelled.get(first + row, ()) for row in range(len(block))]
            yield replace(block, motion_names=names) if any(names) else block

    return ClipStream(head, blocks, layout.frames, notices)


def quantity_labels(stream: BinaryIO) -> tuple[str, ...]:
    """The labels of points in a C3D file that are quantities. Raises FormatError where it cannot be read.

    A document that was imported when they were taken as markers has joints of these source names.
    """
    said = read_statements(stream, [])
    labels = [_text(text, []) for text in texts_of(said, "POINT:LABELS")]
    return tuple(quantity.label for quantity in quantities_of(said, labels).values())


def _with_samples(
    points: Points, quantities: Mapping[int, Quantity], first_id: int, rate: str, unmeasured: bool
) -> Iterator[Quantity]:
    """Add the samples of the file to quantities; keys are their indices among the points."""
    if not quantities:
        return
    places = list(quantities)
    pieces = []
    for first in range(0, points.layout.frames, points.block):
        coordinates, residuals = points.read(first, points.block)
        there = np.isfinite(coordinates[:, places]).all(axis=2)
        kept = np.maximum(residuals[:, places], 0.0) if unmeasured else residuals[:, places]
        kept = np.where(there, kept, -1.0)
        pieces.append(np.concatenate([np.nan_to_num(coordinates[:, places]), kept[..., None]], axis=2))
    samples = np.concatenate(pieces) if pieces else np.zeros((0, len(places), 4))
    for index, place in enumerate(places):
        yield replace(quantities[place], first=first_id, rate=rate, samples=samples[:, index])


def _survey(points: Points, places: NDArray[np.intp]) -> tuple[bool, bool, Array]:
    """Return (whether the markers have residuals, whether all mark missing samples although there are coordinates,
    positions (n, markers, 3) of some frames, NaN where unknown).

    places: of the markers among the points.
    """
    measured = coordinates_there = False
    all_missing = points.layout.frames > 0
    step = max(1, points.layout.frames * max(1, len(places)) // _SAMPLE)
    positions, missing = [np.empty((0, len(places), 3))], [np.empty((0, len(places)), dtype=bool)]
    for first in range(0, points.layout.frames, points.block):
        coordinates, residuals = points.read(first, points.block)
        measured = measured or bool((residuals[:, places] > 0).any())
        all_missing = all_missing and bool((residuals < 0).all())
        coordinates_there = coordinates_there or bool(np.any(np.nan_to_num(coordinates)))
        rows = slice(-first % step, None, step)
        positions.append(coordinates[rows][:, places])
        missing.append(residuals[rows][:, places] < 0)
    sample, unmeasured = np.concatenate(positions), all_missing and coordinates_there
    if not unmeasured:
        sample[np.concatenate(missing)] = np.nan
    return measured, unmeasured, sample


def _say_what_stays(said: Statements, analog_values: int, notices: list[Notice]) -> None:
    channels = int(said.number("ANALOG:USED") or 0) or analog_values // max(1, int(said.words[9]))
    rotations = count_rotations(said)
    if analog_values:
        what = f"{channels} analog channels stay in the file; measurements and exports to C3D read them there"
        note(notices, "note", what)
    if rotations:
        note(notices, "warning", f"{rotations} rotations are not in the document; the kept file has them")


def _properties(said: Statements, notices: list[Notice]) -> tuple[tuple[str, str, str], ...]:
    """The measures of the subjects of a file as properties, with a notice."""
    by_subject = read_measures_by_subject(said)
    if len(by_subject) > _MOST_SUBJECTS:
        note(notices, "warning", f"the file has {len(by_subject)} subjects: their measures are only in the file")
        return ()
    properties = [
        item for subject, measures in by_subject.items() for item in state_measures(clean_measures(measures), subject)
    ]
    if properties:
        names = ", ".join(name for name, _, _ in properties[:_NAMED])
        more = f" and {len(properties) - _NAMED} more" if len(properties) > _NAMED else ""
        note(notices, "note", f"measures of the subject are properties of the document: {names}{more}")
    return tuple(properties)


def _label_frames(
    events: Sequence[Event], fields: Mapping[str, str], first_id: int, frames: int, notices: list[Notice]
) -> dict[int, tuple[str, ...]]:
    """The labels of events by frame, from 0, with notices."""
    rate = fields.get("dataframe_rate")
    if not events or rate is None:
        return {}
    labels = label_frames(events, float(rate), first_id, frames)
    outside = sum(not 0 <= event.frame(float(rate)) - first_id < frames for event in events)
    if labels:
        what = f"{len(events) - outside} events are labels of the nearest frames; a section of the head has their times"
        note(notices, "note", what)
    if outside:
        note(notices, "warning", f"{outside} events are outside of the frames: only a section of the head has them")
    return labels


def _labels(said: Statements, points: int, notices: list[Notice]) -> list[str]:
    """Labels from LABELS, LABELS2 … as one list, one for each point."""
    texts = texts_of(said, "POINT:LABELS")
    if len(texts) < points:
        note(notices, "warning", f"{points} points have {len(texts)} labels: the others are unnamed")
    labels = [_text(text, notices) for text in texts[:points]]
    return [*labels, *[UNNAMED] * (points - len(labels))]


def _names(said: Statements, labels: list[str], places: list[int], notices: list[Notice]) -> list[str]:
    """Names of markers: their labels, but descriptions where these tell markers of one label apart.

    Programs that cut labels to four letters write `RKNE` twice, and `R.Knee` and `R.Knee.Medial` as descriptions.
    """
    told = [_text(text, []).strip() for text in texts_of(said, "POINT:DESCRIPTIONS")]
    own = [labels[place] for place in places]
    places_of: dict[str, list[int]] = defaultdict(list)
    for index, label in enumerate(own):
        places_of[label].append(index)
    names, taken = list(own), set(own)
    apart, alike = [], []
    for label, same in places_of.items():
        if len(same) == 1 or label in ("", UNNAMED):
            continue
        before = label[: label.rfind(":") + 1]
        better = [before + told[places[index]] for index in same if places[index] < len(told) and told[places[index]]]
        if len(set(better) - taken) < len(same):
            alike.append(label)
            continue
        apart.append(label)
        taken.update(better)
        for index, name in zip(same, better, strict=True):
            names[index] = name
    if apart:
        note(notices, "note", f"several points have the labels {', '.join(apart)}: their descriptions are their names")
    if alike:
        note(notices, "warning", f"only their order tells points of one label apart: {', '.join(alike)}")
    return names


def _text(text: bytes, notices: list[Notice]) -> str:
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        note(notices, "guess", "texts that are not UTF-8 were read as Windows-1252")
        return text.decode("cp1252", errors="replace")


def _fields(said: Statements, name: str, notices: list[Notice], told: LikelyUp | None = None) -> dict[str, str]:
    """told: the axis up by names of markers or by force plates, which the axis on the screen may contradict."""
    fields = {"filetype": "C3D", "filename": name}
    rate = said.number("POINT:RATE") or said.rate
    if math.isfinite(rate) and rate > 0:
        fields["dataframe_rate"] = str(np.float32(rate)).removesuffix(".0")
    else:
        note(notices, "warning", "the file has no rate: how fast the frames follow is unknown")
    units = [_text(text, notices) for text in said.texts("POINT:UNITS")]
    if units and units[0]:
        fields["calibration_unit"] = units[0]
    screens = [text.decode("latin-1").upper() for text in said.texts("POINT:Y_SCREEN")]
    if screens and screens[0] in ("+X", "+Y", "+Z"):
        axis = screens[0][1]
        if told is None or told.axis[-1] == axis:
            also = "" if told is None else f"; {told.why}"
            note(notices, "guess", f"{axis} counts as up: the file shows it upward on the screen (Y_SCREEN){also}")
            fields["global_axis_of_gravity"] = axis
        else:
            why = f"the file shows {axis} upward on the screen (Y_SCREEN), but {told.axis} is likely: {told.why}"
            note(notices, "warning", f"no up axis is stated: {why}")
    return fields


def _block(coordinates: Array, residuals: Array, skeleton: Skeleton, first: int, unmeasured: bool) -> FrameBlock:
    columns = skeleton.columns()
    channels = len(columns) // max(1, len(skeleton))
    values = np.concatenate([coordinates, residuals[..., None]], axis=2)[..., :channels]
    ids = np.arange(first, first + len(values), dtype=np.int64)
    missing = ~np.isfinite(coordinates).all(axis=2) if unmeasured else residuals < 0
    whole = full_shape(columns)
    shapes: tuple[Shape, ...] = (whole,)
    shape_of = None
    if missing.any():
        values[missing] = np.nan
        patterns, shape_of = np.unique(missing, axis=0, return_inverse=True)
        shapes = tuple(
            tuple((joint, 0 if gone else bits) for (joint, bits), gone in zip(whole, row, strict=True))
            for row in patterns
        )
        shape_of = shape_of.reshape(-1)
    return FrameBlock(values.reshape(len(values), -1), columns, shapes, ids, shape_of)
