"""Clips as HTR (segment-major, version 1) and HTR2 (frame-major, version 2) text."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from typing import Final

import numpy as np

from mcml.errors import ConversionError, Notice
from mcml.formats.htr.head import CHANNELS, FIELD_OF_KEYWORD, GLOBAL
from mcml.formats.target_names import legal_names
from mcml.formats.text.lines import encoded
from mcml.formats.text.number_text import rows_of_text
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, SourcePart
from mcml.motion.layout import count_frames
from mcml.motion.lexemes import lexeme
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Skeleton

WIDTH: Final = len(CHANNELS)
SPOOL_BYTES: Final = 1 << 25
"""Of motion kept in memory while its order changes from frame-major to segment-major; more goes to a temporary file."""

_ILLEGAL = frozenset(" \t\v\f\r\n\0#")
_DEFAULT_MISSING = "9999999"
_KEYWORDS = (
    "FileType",
    "DataType",
    "FileVersion",
    "NumSegments",
    "NumFrames",
    "DataFrameRate",
    "EulerRotationOrder",
    "CalibrationUnits",
    "RotationUnits",
    "GlobalAxisofGravity",
    "BoneLengthAxis",
    "ScaleFactor",
)
_DEFAULTS = {
    "filetype": "htr",
    "datatype": "HTRS",
    "version": "1",
    "units_angle": "Degrees",
    "bone_length_axis": "Y",
    "scale_factor": "1.0",
}
_ALWAYS_WRITTEN = ("num_segments", "num_frames", "dataframe_rate", "euler_rotation_order")
_UNKNOWN_FIELDS = {"calibration_unit", "global_axis_of_gravity", "dataframe_rate"}


def write_htr(clip: ClipStream) -> Iterator[bytes]:
    """The file. Raises ConversionError where joints differ in their rotation order."""
    head = clip.head
    order = _rotation_order(head)
    part = next((source for source in head.sources if source.part == "htr"), SourcePart("htr"))
    codec = "utf-8" if part.encoding == "utf-8-sig" else part.encoding
    names = legal_names(head.skeleton, _ILLEGAL, "[", {GLOBAL.lower()}, clip.notices, "HTR")
    frames = count_frames(clip)
    fields = _fields(clip, order, frames)
    lines = [*part.comments, "[Header]"]
    keywords = list(part.keywords) or [word for word in _KEYWORDS if FIELD_OF_KEYWORD[word.lower()] in fields]
    lines += [f"{keyword} {fields[FIELD_OF_KEYWORD[keyword.lower()]]}" for keyword in keywords]
    stated = {FIELD_OF_KEYWORD[keyword.lower()] for keyword in keywords}
    lines += [f"{word} {fields[name]}" for word in _KEYWORDS if (name := FIELD_OF_KEYWORD[word.lower()]) not in stated
              and name in fields and name in _ALWAYS_WRITTEN]  # fmt: skip
    lines += [f"{title.removeprefix('[Header] ')} {value}" for title, value in part.sections]
    lines += ["[SegmentNames&Hierarchy]", *_hierarchy(head.skeleton, names), "[BasePosition]"]
    lines += list(_base(head.skeleton, names))
    yield encoded("\n".join(lines) + "\n", part.encoding, clip.notices)
    shown = [encoded(name, codec, clip.notices) for name in names]
    style = head.number_style if head.format == "htr" else "shortest"
    missing = (part.missing or _DEFAULT_MISSING).encode()
    writer = _by_frame if float(fields.get("version", "1")) == 2 else _by_segment
    yield from writer(clip, shown, style, missing)
    yield b"[EndOfFile]\n"


def _rotation_order(head: ClipHead) -> str:
    orders = {joint.rotation_order.upper() for joint in head.skeleton.joints if joint.rotation_order}
    if len(orders) > 1:
        raise ConversionError(
            f"HTR has one rotation order, the joints have {', '.join(sorted(orders))}", remedy="Convert the clip first."
        )
    return next(iter(orders), head.fields.get("euler_rotation_order", "ZYX"))


def _fields(clip: ClipStream, order: str, frames: int) -> dict[str, str]:
    """Return header values for writing; unknown ones are left out with a notice."""
    head = clip.head
    own = head.format == "htr"
    known = {name: value for name, value in head.fields.items() if own or name in _UNKNOWN_FIELDS | {"scale_factor"}}
    fields = ({} if own else _DEFAULTS) | known
    if not own:
        fields |= {name: head.fields[name] for name in ("bone_length_axis", "units_angle") if name in head.fields}
    fields["num_segments"] = str(len(head.skeleton))
    fields["num_frames"] = str(frames)
    if fields.get("euler_rotation_order", "").upper() != order:
        fields["euler_rotation_order"] = order
    stated = head.rate_text()
    if stated is not None and stated != fields.get("dataframe_rate"):
        rate = float(stated)
        # 1 / 0.0083333 is 120.0005: the intended rate, if the text is too short for it.
        near = round(rate)
        fields["dataframe_rate"] = lexeme(near if abs(rate - near) < 1e-4 * rate else rate)
    lacking = sorted(_UNKNOWN_FIELDS - set(fields))
    if lacking and not own:
        clip.notices.append(
            Notice("warning", f"the source does not state {', '.join(lacking)}: left out of the header")
        )
    return fields


def _hierarchy(skeleton: Skeleton, names: list[str]) -> Iterator[str]:
    for index in skeleton.in_declared_order():
        parent = skeleton.joints[index].parent
        yield f"{names[index]}\t{GLOBAL if parent < 0 else names[parent]}"


def _base(skeleton: Skeleton, names: list[str]) -> Iterator[str]:
    zeros = ("0", "0", "0")
    for index in skeleton.in_declared_order():
        joint = skeleton.joints[index]
        yield "\t".join((names[index], *(joint.offset or zeros), *(joint.axis or zeros), joint.length or "0"))


def _dense(skeleton: Skeleton, block: FrameBlock) -> Array:
    """(n, J, 7) values, joints in file order, NaN where there is no sample; a scale never given is 1."""
    order = skeleton.in_declared_order()
    place = {column: index for index, column in enumerate(block.columns)}
    values = np.full((len(block), len(order), WIDTH), np.nan)
    for row, joint in enumerate(order):
        own = skeleton.joints[joint].channels
        for column, channel in enumerate(CHANNELS):
            source = place.get((joint, CHANNEL_INDEX[channel]))
            if source is not None:
                values[:, row, column] = block.values[:, source]
            elif channel not in own:
                values[:, row, column] = 1.0 if channel == "SF" else 0.0
    return values


def _rows(values: Array, style: str, missing: bytes) -> list[bytes]:
    """Rows of seven values separated by tabs. values: (n, 7), NaN for missing."""
    gaps = np.isnan(values)
    if not gaps.any():
        return rows_of_text(values, style, "\t")
    rows = rows_of_text(np.where(gaps, 0.0, values), style, "\t")
    for index in np.flatnonzero(gaps.any(axis=1)).tolist():
        words = rows[index].split(b"\t")
        rows[index] = b"\t".join(missing if gap else word for word, gap in zip(words, gaps[index], strict=True))
    return rows


def _by_frame(clip: ClipStream, names: list[bytes], style: str, missing: bytes) -> Iterator[bytes]:
    skeleton = clip.head.skeleton
    declared = skeleton.in_declared_order()
    place = {joint: row for row, joint in enumerate(declared)}
    for block in clip.blocks():
        # The rows of a frame stay in the order in which it lists its segments.
        listed = [[joint for joint, _ in shape] for shape in block.shapes]
        orders = [[*own, *(joint for joint in declared if joint not in set(own))] for own in listed]
        rows = _rows(_dense(skeleton, block).reshape(-1, WIDTH), style, missing)
        lines: list[bytes] = []
        for index, frame_id in enumerate(block.ids):
            lines.append(b"Frame %b:" % str(frame_id).encode())
            start = index * len(declared)
            order = orders[0 if block.shape_of is None else int(block.shape_of[index])]
            lines += [names[joint] + b"\t" + rows[start + place[joint]] for joint in order]
        yield b"\n".join(lines) + b"\n"


def _by_segment(clip: ClipStream, names: list[bytes], style: str, missing: bytes) -> Iterator[bytes]:
    skeleton = clip.head.skeleton
    order = skeleton.in_declared_order()
    with tempfile.SpooledTemporaryFile(max_size=SPOOL_BYTES) as spool:
        blocks: list[tuple[int, list[bytes]]] = []
        for block in clip.blocks():
            spool.write(np.ascontiguousarray(_dense(skeleton, block).transpose(1, 0, 2)).tobytes())
            blocks.append((len(block), [str(item).encode() for item in block.ids]))
        for row, joint in enumerate(order):
            yield b"[" + names[joint] + b"]\n"
            position = 0
            for count, ids in blocks:
                size = count * WIDTH * 8
                spool.seek(position + row * size)
                values = np.frombuffer(spool.read(size), dtype=np.float64).reshape(count, WIDTH)
                rows = _rows(values, style, missing)
                if rows:
                    yield (
                        b"\n".join([frame_id + b"\t" + text for frame_id, text in zip(ids, rows, strict=True)]) + b"\n"
                    )
                position += size * len(order)
