"""Clips of markers to C3D: floats of Intel machines, parameters as readers want them. See docs/formats/c3d.md."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mcml.errors import ConversionError, Notice
from mcml.formats.c3d.events import Event, events_of_labels, kept_events
from mcml.formats.c3d.originals import Ids, OriginalData, clear_baseline, read_original
from mcml.formats.c3d.parameters import BLOCK, INTEL
from mcml.formats.c3d.points import to_floats
from mcml.formats.c3d.quantities import Quantity, kept_quantities, rate_of, samples_at, units_of
from mcml.formats.c3d.records import (
    LONGEST_TEXT,
    MOST_TEXTS,
    float_record,
    group_record,
    record,
    text_record,
    word_record,
)
from mcml.formats.format import need_seconds, note
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Skeleton

_RESIDUAL: Final = CHANNEL_INDEX["residual"]
_MOST_BLOCKS: Final = 255
_CAPPED: Final = 0xFFFF


def write_c3d(clip: ClipStream) -> Iterator[bytes]:
    """The file of a clip. Raises ConversionError without a rate, without frames, or with too many labels."""
    head = clip.head
    seconds = need_seconds(head, "C3D")
    rate = float(head.rate_text() or 1 / seconds)
    if not 1e-38 < rate < 3e38:
        raise ConversionError(f"C3D cannot hold {rate:g} frames a second", remedy="State another frame time first.")
    sections = dict(head.sources[0].sections) if head.sources and head.sources[0].part == "c3d" else {}
    scale = abs(float(sections.get("POINT:SCALE", "1")) or 1.0)
    labels = [_label(joint.source_name, clip.notices) for joint in head.skeleton.joints]
    quantities = _quantities(clip)
    worst, frames, first = 0.0, 0, 1
    labelled: dict[int, tuple[str, ...]] = {}
    data: list[tuple[bytes, Ids]] = []
    for block in clip.blocks():
        if not frames and not isinstance(block.ids, list):
            first = int(block.ids[0]) if 0 < block.ids[0] < _CAPPED else 1
        coordinates, residuals = _points(block, head.skeleton)
        error = _rounding(coordinates, residuals >= 0)
        if not math.isfinite(error):
            raise ConversionError(
                "C3D holds numbers in single precision, up to 3.4e38; those of the motion are larger",
                remedy="Export it as TRC or MCML.",
            )
        worst = max(worst, error)
        if quantities:
            kept = np.stack([samples_at(quantity, block.ids) for quantity in quantities], axis=1)
            coordinates = np.concatenate([coordinates, kept[..., :3]], axis=1)
            residuals = np.concatenate([residuals, kept[..., 3]], axis=1)
        data.append((to_floats(coordinates, residuals, scale), block.ids))
        if block.motion_names is not None:
            labelled |= {first + frames + row: names for row, names in enumerate(block.motion_names) if names}
        frames += len(block)
    if not frames:
        raise ConversionError("C3D cannot hold a motion without frames", remedy="Export it as TRC or MCML.")
    if worst:
        note(clip.notices, "warning", f"C3D holds numbers in single precision: the largest difference is {worst:.3g}")
    events = _events(clip, labelled, rate)
    original = _original(clip, rate, [ids for _, ids in data])
    parameters, original = _parameters(clip, labels, quantities, events, original, frames, first, rate, scale)
    header = struct.pack(
        "<BBHHHHHfHHf", 2, 0x50, len(labels) + len(quantities), original.values, first,
        min(first + frames - 1, _CAPPED), 0, -scale, 2 + len(parameters) // BLOCK, original.samples, rate,
    )  # fmt: skip
    yield _filled(header) + parameters
    size = 0
    for points, ids in data:
        for content in original.add_samples(points, ids):
            size += len(content)
            yield content
    yield bytes(-size % BLOCK)


def _original(clip: ClipStream, rate: float, ids: list[Ids]) -> OriginalData:
    """The data of the file that the clip came from. ids: of its frames, in blocks."""
    head, notices = clip.head, clip.notices
    data = read_original(clip.original, rate, head.fields.get("calibration_unit", ""), notices)
    if data.channels is None:
        return data
    unknown = sum(map(data.count_unknown, ids))
    if unknown:
        what = f"{unknown} frames are not of the source file: their analog samples are missing (NaN)"
        note(notices, "warning", what)
    place = data.channels.first
    for some in ids:
        if unknown or not np.array_equal(some, np.arange(place, place + len(some))):
            return clear_baseline(data, notices)
        place += len(some)
    return data if place == data.channels.first + data.channels.frames else clear_baseline(data, notices)


def _quantities(clip: ClipStream) -> list[Quantity]:
    """The quantities that came with the clip from C3D, as far as its frames are still those of the file."""
    part = next((source for source in clip.head.sources if source.part == "c3d"), None)
    kept = kept_quantities(part.sections) if part is not None else []
    fitting = [quantity for quantity in kept if quantity.has_rate(rate_of(clip.head))]
    if len(fitting) < len(kept):
        what = f"{len(kept) - len(fitting)} quantities of the C3D file are of another frame rate: they were left out"
        note(clip.notices, "warning", what)
    fitting = [replace(quantity, label=_label(quantity.label, clip.notices)) for quantity in fitting]
    if fitting:
        what = (
            f"{len(fitting)} quantities (angles, forces …) are written unchanged from the C3D file, without later edits"
        )
        note(clip.notices, "note", what)
    return fitting


def _events(clip: ClipStream, labelled: Mapping[int, tuple[str, ...]], rate: float) -> list[Event]:
    """Events for labels of one frame. labelled: names by the number of the frame."""
    part = next((source for source in clip.head.sources if source.part == "c3d"), None)
    stated = float(clip.head.fields.get("dataframe_rate") or rate)
    kept = kept_events(part.sections) if part is not None else []
    kept = [replace(event, seconds=event.seconds * stated / rate) for event in kept] if stated != rate else kept
    instants: dict[int, list[str]] = {}
    spans: set[str] = set()
    for number, names in labelled.items():
        beside = {*labelled.get(number - 1, ()), *labelled.get(number + 1, ())}
        instants[number] = [name for name in names if name not in beside]
        spans |= beside & set(names)
    if spans:
        listed = ", ".join(sorted(spans))[:200]
        what = f"an event of C3D has one frame: labels of several frames are left out ({listed})"
        note(clip.notices, "warning", what)
    return events_of_labels(instants, kept, rate)


def _parameters(
    clip: ClipStream,
    markers: list[str],
    quantities: list[Quantity],
    events: list[Event],
    original: OriginalData,
    frames: int,
    first: int,
    rate: float,
    scale: float,
) -> tuple[bytes, OriginalData]:
    """The parameter section, in whole blocks, and the data of the original for which it has room."""
    head = clip.head
    labels = [*markers, *(quantity.label for quantity in quantities)]
    up = head.fields.get("global_axis_of_gravity", "")
    unit = head.fields.get("calibration_unit", "")
    many = first + frames - 1 > _CAPPED
    records = [
        group_record(1, "POINT"),
        word_record(1, "USED", len(labels)),
        word_record(1, "FRAMES", min(frames, _CAPPED)),
        float_record(1, "SCALE", -scale),
        float_record(1, "RATE", rate),
        text_record(1, "UNITS", [unit.encode("utf-8", errors="replace")[:LONGEST_TEXT]], single=True),
    ]
    if many:
        records.append(float_record(1, "LONG_FRAMES", frames))
    if up in ("Y", "Z"):
        records += [
            text_record(1, "X_SCREEN", [b"+X"], single=True),
            text_record(1, "Y_SCREEN", [b"+" + up.encode()], single=True),
        ]
    for start in range(0, len(labels), MOST_TEXTS):
        some = [label.encode() for label in labels[start : start + MOST_TEXTS]]
        number = str(start // MOST_TEXTS + 1) if start else ""
        records += [
            text_record(1, f"LABELS{number}", some),
            text_record(1, f"DESCRIPTIONS{number}", [b" "] * len(some)),
        ]
    records += _typed(quantities)
    records += _event_records(events)
    for data in original.lighter(clip.notices):
        more = data.records(first, frames, rate, is_long=many)
        # The last record has a known size, so the number of blocks is known before it is written.
        size = 4 + sum(map(len, [*records, *more])) + len(_data_start(0)) + 2
        blocks = math.ceil(size / BLOCK)
        if blocks <= _MOST_BLOCKS:
            begin = struct.pack("<BBBB", 1, 0x50, blocks, INTEL)
            return _filled(begin + b"".join([*records, *more, _data_start(2 + blocks)])), data
    raise ConversionError(
        f"the labels of {len(labels)} points need more room than the {_MOST_BLOCKS * BLOCK} bytes that C3D has",
        remedy="Export the motion as TRC or MCML.",
    )


def _typed(quantities: list[Quantity]) -> list[bytes]:
    """Return the parameters that list the quantities among the points, with their units."""
    units = units_of(quantities)
    if not units:
        return []
    stems = {group: group.removesuffix("S") for group in units}
    pairs = [word.encode() for group, stem in stems.items() for word in (group, stem)]
    records = [text_record(1, "TYPE_GROUPS", pairs)]
    for group, unit in units.items():
        records.append(text_record(1, f"{stems[group]}_UNITS", [unit.encode()], single=True))
        named = [quantity.label.encode() for quantity in quantities if quantity.group == group]
        for start in range(0, len(named), MOST_TEXTS):
            number = str(start // MOST_TEXTS + 1) if start else ""
            records.append(text_record(1, f"{group}{number}", named[start : start + MOST_TEXTS]))
    return records


def _event_records(events: list[Event]) -> list[bytes]:
    """Return the parameters of the group EVENT."""
    if not events:
        return []
    records = [group_record(5, "EVENT"), word_record(5, "USED", len(events))]
    for start in range(0, len(events), MOST_TEXTS):
        some = events[start : start + MOST_TEXTS]
        number = str(start // MOST_TEXTS + 1) if start else ""
        columns = {
            "CONTEXTS": [event.context for event in some],
            "LABELS": [event.label for event in some],
            "SUBJECTS": [event.subject for event in some],
            "DESCRIPTIONS": [event.description for event in some],
        }
        for name, texts in columns.items():
            cut = [(text or " ").encode("utf-8", errors="replace")[:LONGEST_TEXT] for text in texts]
            records.append(text_record(5, f"{name}{number}", cut))
        times = np.array([(0.0, event.seconds) for event in some], "<f4").tobytes()
        records.append(record(5, f"TIMES{number}", 4, (2, len(some)), times))
    return records


def _data_start(block: int) -> bytes:
    return word_record(1, "DATA_START", block)


def _filled(data: bytes) -> bytes:
    return data + bytes(-len(data) % BLOCK)


def _label(text: str, notices: list[Notice]) -> str:
    plain = text.encode("utf-8", errors="replace")[:LONGEST_TEXT].decode("utf-8", errors="ignore")
    if plain != text:
        note(notices, "warning", f"labels in C3D have at most {LONGEST_TEXT} bytes: {text[:40]!r} was cut")
    return plain


def _points(block: FrameBlock, skeleton: Skeleton) -> tuple[Array, Array]:
    """(coordinates (n, points, 3), residuals (n, points)), -1 where a coordinate is missing."""
    coordinates = np.full((len(block), len(skeleton), 3), np.nan)
    residuals = np.zeros((len(block), len(skeleton)))
    for index, (joint, channel) in enumerate(block.columns):
        if channel < 3:
            coordinates[:, joint, channel] = block.values[:, index]
        elif channel == _RESIDUAL:
            residuals[:, joint] = np.nan_to_num(block.values[:, index])
    missing = np.isnan(coordinates).any(axis=2)
    return np.where(missing[..., None], 0.0, coordinates), np.where(missing, -1.0, np.maximum(residuals, 0.0))


def _rounding(coordinates: Array, there: NDArray[np.bool_]) -> float:
    """The largest error of rounding to single precision."""
    error = np.abs(coordinates.astype(np.float32).astype(np.float64) - coordinates)[there]
    return float(error.max(initial=0.0))
