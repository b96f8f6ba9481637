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
from mcml.formats.c3d.parameters import BLOCK, INTEL
from mcml.formats.c3d.points import to_floats
from mcml.formats.c3d.quantities import Quantity, kept_quantities, rate_of, samples_at, units_of
from mcml.formats.format import need_seconds, note
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Skeleton

_RESIDUAL: Final = CHANNEL_INDEX["residual"]
_LONGEST_LABEL: Final = 127
_MOST_TEXTS: Final = 255
"""The sizes of a parameter are bytes: LABELS2 and further ones hold the rest."""

_MOST_BLOCKS: Final = 255
_CAPPED: Final = 0xFFFF


def write_c3d(clip: ClipStream) -> Iterator[bytes]:
    """The file of a clip. Raises ConversionError without a rate, without frames, or with too many labels."""
    head = clip.head
    seconds = need_seconds(head, "C3D")
    rate = float(head.fields.get("dataframe_rate") or 1 / seconds)
    if not 1e-38 < rate < 3e38:
        raise ConversionError(f"C3D cannot hold {rate:g} frames a second", remedy="State another frame time first.")
    sections = dict(head.sources[0].sections) if head.sources and head.sources[0].part == "c3d" else {}
    scale = abs(float(sections.get("POINT:SCALE", "1")) or 1.0)
    labels = [_label(joint.source_name, clip.notices) for joint in head.skeleton.joints]
    quantities = _quantities(clip)
    worst, frames, first = 0.0, 0, 1
    labelled: dict[int, tuple[str, ...]] = {}
    data: list[bytes] = []
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
        data.append(to_floats(coordinates, residuals, scale))
        if block.motion_names is not None:
            labelled |= {first + frames + row: names for row, names in enumerate(block.motion_names) if names}
        frames += len(block)
    if not frames:
        raise ConversionError("C3D cannot hold a motion without frames", remedy="Export it as TRC or MCML.")
    if worst:
        note(clip.notices, "warning", f"C3D holds numbers in single precision: the largest difference is {worst:.3g}")
    events = _events(clip, labelled, rate)
    parameters = _parameters(head, labels, quantities, events, frames, first, rate, scale)
    header = struct.pack(
        "<BBHHHHHfHHf", 2, 0x50, len(labels) + len(quantities), 0, first, min(first + frames - 1, _CAPPED), 0, -scale,
        2 + len(parameters) // BLOCK, 0, rate,
    )  # fmt: skip
    yield _filled(header) + parameters
    yield from data
    yield bytes(-sum(map(len, data)) % BLOCK)


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
    kept = kept_events(part.sections) if part is not None else []
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
    head: ClipHead,
    markers: list[str],
    quantities: list[Quantity],
    events: list[Event],
    frames: int,
    first: int,
    rate: float,
    scale: float,
) -> bytes:
    """The parameter section, in whole blocks."""
    labels = [*markers, *(quantity.label for quantity in quantities)]
    up = head.fields.get("global_axis_of_gravity", "")
    unit = head.fields.get("calibration_unit", "")
    last = first + frames - 1
    many = last > _CAPPED
    records = [
        _group(1, "POINT"),
        _record(1, "USED", 2, (), struct.pack("<H", len(labels))),
        _record(1, "FRAMES", 2, (), struct.pack("<H", min(frames, _CAPPED))),
        _record(1, "SCALE", 4, (), struct.pack("<f", -scale)),
        _record(1, "RATE", 4, (), struct.pack("<f", rate)),
        _texts(1, "UNITS", [unit.encode("utf-8", errors="replace")[:_LONGEST_LABEL]], single=True),
    ]
    if many:
        records.append(_record(1, "LONG_FRAMES", 4, (), struct.pack("<f", frames)))
    if up in ("Y", "Z"):
        records += [
            _texts(1, "X_SCREEN", [b"+X"], single=True),
            _texts(1, "Y_SCREEN", [b"+" + up.encode()], single=True),
        ]
    for start in range(0, len(labels), _MOST_TEXTS):
        some = [label.encode() for label in labels[start : start + _MOST_TEXTS]]
        number = str(start // _MOST_TEXTS + 1) if start else ""
        records += [_texts(1, f"LABELS{number}", some), _texts(1, f"DESCRIPTIONS{number}", [b" "] * len(some))]
    records += _typed(quantities)
    records += [_group(2, "ANALOG"), _record(2, "USED", 2, (), struct.pack("<H", 0))]
    records += [_group(3, "FORCE_PLATFORM"), _record(3, "USED", 2, (), struct.pack("<H", 0))]
    records += _event_records(events)
    if many:
        records.append(_group(4, "TRIAL"))
        for name, number_of in (("ACTUAL_START_FIELD", first), ("ACTUAL_END_FIELD", last)):
            records.append(_record(4, name, 2, (2,), struct.pack("<I", number_of)))
    # The last record has a known size, so the number of blocks is known before it is written.
    size = 4 + sum(map(len, records)) + len(_data_start(0)) + 2
    blocks = math.ceil(size / BLOCK)
    if blocks > _MOST_BLOCKS:
        raise ConversionError(
            f"the labels of {len(labels)} points need more room than the {_MOST_BLOCKS * BLOCK} bytes that C3D has",
            remedy="Export the motion as TRC or MCML.",
        )
    begin = struct.pack("<BBBB", 1, 0x50, blocks, INTEL)
    return _filled(begin + b"".join([*records, _data_start(2 + blocks)]))


def _typed(quantities: list[Quantity]) -> list[bytes]:
    """Return the parameters that list the quantities among the points, with their units."""
    units = units_of(quantities)
    if not units:
        return []
    stems = {group: group.removesuffix("S") for group in units}
    pairs = [word.encode() for group, stem in stems.items() for word in (group, stem)]
    records = [_texts(1, "TYPE_GROUPS", pairs)]
    for group, unit in units.items():
        records.append(_texts(1, f"{stems[group]}_UNITS", [unit.encode()], single=True))
        named = [quantity.label.encode() for quantity in quantities if quantity.group == group]
        for start in range(0, len(named), _MOST_TEXTS):
            number = str(start // _MOST_TEXTS + 1) if start else ""
            records.append(_texts(1, f"{group}{number}", named[start : start + _MOST_TEXTS]))
    return records


def _event_records(events: list[Event]) -> list[bytes]:
    """Return the parameters of the group EVENT."""
    if not events:
        return []
    records = [_group(5, "EVENT"), _record(5, "USED", 2, (), struct.pack("<H", len(events)))]
    for start in range(0, len(events), _MOST_TEXTS):
        some = events[start : start + _MOST_TEXTS]
        number = str(start // _MOST_TEXTS + 1) if start else ""
        columns = {
            "CONTEXTS": [event.context for event in some],
            "LABELS": [event.label for event in some],
            "SUBJECTS": [event.subject for event in some],
            "DESCRIPTIONS": [event.description for event in some],
        }
        for name, texts in columns.items():
            cut = [(text or " ").encode("utf-8", errors="replace")[:_LONGEST_LABEL] for text in texts]
            records.append(_texts(5, f"{name}{number}", cut))
        times = np.array([(0.0, event.seconds) for event in some], "<f4").tobytes()
        records.append(_record(5, f"TIMES{number}", 4, (2, len(some)), times))
    return records


def _data_start(block: int) -> bytes:
    return _record(1, "DATA_START", 2, (), struct.pack("<H", block))


def _group(number: int, name: str) -> bytes:
    return struct.pack("<bb", len(name), -number) + name.encode() + struct.pack("<HB", 3, 0)


def _record(group: int, name: str, kind: int, dimensions: tuple[int, ...], data: bytes) -> bytes:
    content = struct.pack("<bB", kind, len(dimensions)) + bytes(dimensions) + data + b"\0"
    return struct.pack("<bb", len(name), group) + name.encode() + struct.pack("<H", 2 + len(content)) + content


def _texts(group: int, name: str, texts: list[bytes], *, single: bool = False) -> bytes:
    """Texts filled up with blanks to one length. single: one text without a second dimension."""
    longest = max(1, *map(len, texts)) if len(texts) > 1 else max(1, len(texts[0]))
    data = b"".join(text.ljust(longest) for text in texts)
    return _record(group, name, -1, (longest,) if single else (longest, len(texts)), data)


def _filled(data: bytes) -> bytes:
    return data + bytes(-len(data) % BLOCK)


def _label(text: str, notices: list[Notice]) -> str:
    plain = text.encode("utf-8", errors="replace")[:_LONGEST_LABEL].decode("utf-8", errors="ignore")
    if plain != text:
        note(notices, "warning", f"labels in C3D have at most {_LONGEST_LABEL} bytes: {text[:40]!r} was cut")
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
