"""The CSV of Live Link Face: blend shapes of a clip, and the angles of head and eyes.

Source: Epic Games, Recording Face Animation with Live Link Face (the app's CSV). docs/formats/arkit.md describes the
writing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mcml.errors import ConversionError, FormatError
from mcml.formats.arkit.columns import FIRST
from mcml.formats.arkit.names import ANGLES, SHAPES, TURNING, shape_of
from mcml.formats.arkit.timecodes import RATES, SHOWS_BASE, read_timecode, write_timecodes
from mcml.formats.format import FileKind, need_seconds, note
from mcml.formats.target_names import legal_names
from mcml.formats.text.number_text import rows_of_text
from mcml.motion.clip import ClipStream
from mcml.motion.frames import in_columns
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Convention, Joint, Skeleton
from mcml.motion.units import reading_of

_BASE = 60
"""Frames a second that the app's timecodes count in."""
_ANGLE_COLUMNS = tuple(prefix + ending for prefix in TURNING.values() for ending in ANGLES)
_NEAR = 1e-9


class ArkitWriter:
    """The format `arkit` as it is written; see `mcml.formats.format.Writer`."""

    name = "arkit"
    title = "ARKit and Live Link Face"
    label = "ARKit CSV"
    parts = (FileKind("csv", (".csv",), "Blend shapes of a face"),)
    convention = None
    media_type = "text/csv"
    bodies, markers = True, True
    needs = frozenset({"frame_time", "blend_shapes"})
    assumes = ""

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        columns = _find_columns(clip)
        if clip.frames == 0:
            raise ConversionError("ARKit's CSV has rows, and the clip has no frames", remedy="Export it as MCML.")
        seconds = need_seconds(clip.head, "ARKit's CSV")
        return _write(clip, columns, 1 / seconds)


@dataclass(frozen=True)
class _Columns:
    """names: of the columns. source: joint and channel of each. factors: from the clip's numbers to radians."""

    names: tuple[str, ...]
    source: tuple[tuple[int, int], ...]
    factors: Array


def _find_columns(clip: ClipStream) -> _Columns:
    """The columns of a clip, blend shapes first. Raises ConversionError where it has none."""
    skeleton = clip.head.skeleton
    shapes = skeleton.blend_shapes
    if not shapes:
        raise ConversionError(
            "ARKit's CSV holds blend shapes, and the document has none", remedy="Export it as BVH, glTF or CSV."
        )
    names = _name_shapes(skeleton, clip)
    source = [(index, CHANNEL_INDEX["weight"]) for index in shapes]
    turning = {_role(joint): index for index, joint in enumerate(skeleton.joints) if _is_turning(skeleton, joint)}
    for name, prefix in TURNING.items():
        joint = skeleton.joints[turning[name]] if name in turning else None
        for ending, channel in ANGLES.items():
            if joint is not None and channel in joint.channels:
                names.append(prefix + ending)
                source.append((turning[name], CHANNEL_INDEX[channel]))
    left_out = len(skeleton) - len(shapes) - len(turning)
    if left_out:
        note(
            clip.notices,
            "warning",
            f"{left_out} joints are left out: ARKit's CSV has angles of a head and its eyes alone",
        )
    angle = reading_of(clip.head).motion_angle
    factors = np.array([1.0 if joint in shapes else angle for joint, _ in source])
    return _Columns(tuple(names), tuple(source), factors)


def _is_turning(skeleton: Skeleton, joint: Joint) -> bool:
    """Whether a joint is the head or an eye as the table has them: angles yaw, pitch, roll, no joint but the head
    above.
    """
    order = "".join(channel[1] for channel in ANGLES.values() if channel in joint.channels).upper()
    above = _role(skeleton.joints[joint.parent]) if joint.parent >= 0 else ""
    own = joint.convention is Convention.LISTED and joint.rotation_order == order
    return own and _role(joint) in TURNING and above in ("", "head") and set(joint.channels) <= set(ANGLES.values())


def _role(joint: Joint) -> str:
    """The name of a joint as the reader gives it, of any spelling: "head", "left_eye"."""
    plain = {prefix.lower(): name for name, prefix in TURNING.items()}
    return plain.get(joint.source_name.lower().replace("_", ""), joint.source_name)


def _name_shapes(skeleton: Skeleton, clip: ClipStream) -> list[str]:
    """Names of the columns of blend shapes: those of ARKit in the app's spelling, others as they are."""
    shapes = tuple(
        replace(joint, source_name=shape_of(joint.source_name) or joint.source_name, parent=-1)
        for joint in (skeleton.joints[index] for index in skeleton.blend_shapes)
    )
    reserved = {*FIRST, *(name.lower() for name in _ANGLE_COLUMNS)}
    # A program for tables takes words that begin with these signs for formulas.
    names = legal_names(Skeleton(shapes), ',"\r\n\t', "=+-@ ", reserved, clip.notices, "ARKit's CSV", fold_case=True)
    missing = len(set(SHAPES) - set(names))
    if missing:
        note(
            clip.notices, "note", f"{missing} of ARKit's {len(SHAPES)} blend shapes have no column: the clip lacks them"
        )
    return names


def _write(clip: ClipStream, columns: _Columns, rate: float) -> Iterator[bytes]:
    start = _find_start(clip)
    if min(abs(rate - usual) / usual for usual in RATES) > _NEAR:
        note(clip.notices, "note", f"timecodes tell the rate of {rate:.6g} frames a second only nearly")
    head = ",".join(("Timecode", "BlendShapeCount", *columns.names)) + "\n"
    yield head.encode("utf-8", "replace")
    done = rows = latest = 0
    for block in clip.blocks():
        if not done and not isinstance(block.ids, list) and len(block) and block.ids[0] > 0:
            # Part of a clip: the timecode is that of frame 1.
            start += (int(block.ids[0]) - 1) * _BASE / rate
        values = in_columns(block, columns.source)
        there = np.flatnonzero(~np.isnan(values).all(axis=1))
        counts: Array = start + (done + there).astype(np.float64) * (_BASE / rate)
        latest = max(latest, int(np.max(counts % _BASE, initial=0)))
        yield _write_rows(values[there], columns, write_timecodes(counts, _BASE), clip.head.number_style)
        done, rows = done + len(block), rows + len(there)
    if rows < done:
        note(clip.notices, "note", f"{done - rows} frames without samples have no row")
    if latest < SHOWS_BASE and rate > _BASE / 1.5:
        what = "the table is too short to show that its timecodes count 60 frames a second: readers may take 30"
        note(clip.notices, "warning", what)


def _find_start(clip: ClipStream) -> float:
    """The timecode of the first frame, in frames of the base since midnight; 0 where the clip has none."""
    text = next((value for name, value, _ in clip.head.properties if name == "timecode"), None)
    if text is None:
        note(clip.notices, "note", "the clip states no timecode: rows are counted from 00:00:00:00.000")
        return 0.0
    try:
        second, count = read_timecode(text, 1)
    except FormatError:
        note(clip.notices, "warning", f"the timecode {text[:40]!r} is none: rows are counted from 00:00:00:00.000")
        return 0.0
    return second * _BASE + count


def _write_rows(values: Array, columns: _Columns, timecodes: list[str], style: str) -> bytes:
    missing = np.isnan(values)
    numbers = np.where(missing, 0.0, np.where(columns.factors == 1.0, values, values * columns.factors))
    count = len(columns.names)
    lines = []
    for row, text in enumerate(rows_of_text(numbers, style, "\t")):
        cells = text.split(b"\t")
        if missing[row].any():
            cells = [b"" if gone else cell for cell, gone in zip(cells, missing[row].tolist(), strict=True)]
        lines.append(b"%s,%d,%s\n" % (timecodes[row].encode(), count, b",".join(cells)))
    return b"".join(lines)
