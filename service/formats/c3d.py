"""C3D: labelled points of optical systems, binary. Facts and sources: formats.md 5.

The file itself is read and written by the package `c3d`; here its points become a clip of markers and back.
"""

from __future__ import annotations

import io
import json
import re
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np

from service.errors import ConversionError, FormatError, Notice
from service.formats import isolated
from service.formats.format import Part, ReadOptions, SourceFile, need_convention, note
from service.motion.clip import ClipHead, ClipStream, FrameBlock, Shape, SourcePart, full_shape
from service.motion.markers import marker_skeleton
from service.motion.skeleton import CHANNEL_INDEX, Array, Convention, Skeleton

_WORKER: Final = Path(__file__).with_name("c3d_worker.py")
_RESIDUAL: Final = CHANNEL_INDEX["residual"]
_OF_NO_INTEREST: Final = ("No analog data", "missing parameter")
"""Warnings of the package about what a file of markers need not have."""

_BLOCK: Final = 4096
_LONGEST_LABEL: Final = 127


class C3d:
    """The format `c3d`; see `service.formats.format.Format`."""

    name = "c3d"
    title = "C3D"
    parts = (Part("c3d", (".c3d",), "Markers"),)
    convention = Convention.MARKER
    media_type = "application/octet-stream"

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
        return _write(clip)


def _read(file: SourceFile, options: ReadOptions) -> ClipStream:
    limits = options.limits
    answer = isolated.run(_WORKER, [str(limits.memory), str(limits.values)], file.stream, limits)
    about = json.loads(answer.readline())
    if "error" in about:
        raise FormatError(f"the file is no C3D, or damaged: {about['error']}", remedy="Send the C3D file itself.")
    if not about["points"]:
        raise FormatError("the file has no points", remedy="Files with analog channels alone are not read.")
    start = answer.tell()
    frames, said = _ending(answer, start)
    points = (
        np.memmap(answer, dtype="<f4", mode="r", offset=start, shape=(frames, about["points"], 4)) if frames else None
    )
    limits.check_size(frames, 3 * about["points"])
    notices = _notices(about, frames, said)
    residuals = np.zeros(0) if points is None else np.asarray(points[:, :, 3])
    unmeasured = bool(frames) and bool((residuals < 0).all()) and bool(np.any(points[:, :, :3]))  # type: ignore[index]
    if unmeasured:
        notices.append(Notice("guess", "every residual says that there is no sample; the coordinates count"))
    labels = _labels(about, notices)
    limits.check_points(labels)
    skeleton = marker_skeleton(labels, residual=bool((residuals > 0).any()))
    clip_head = ClipHead(
        "c3d",
        skeleton,
        _fields(file, about, notices),
        sources=(
            SourcePart(
                part="c3d",
                name=file.name.rsplit("/", 1)[-1],
                sections=(("POINT:SCALE", repr(about["scale"])), ("processor", about["processor"])),
            ),
        ),
    )

    def blocks() -> Iterator[FrameBlock]:
        if points is not None:
            for first in range(0, frames, _BLOCK):
                yield _block(points[first : first + _BLOCK], skeleton, about["first"] + first, unmeasured)

    return ClipStream(clip_head, blocks, frames, notices)


def _ending(answer: BinaryIO, start: int) -> tuple[int, list[str]]:
    """(frames, warnings) from the last line of the reader's answer."""
    answer.seek(0, io.SEEK_END)
    size = answer.tell()
    answer.seek(max(start, size - (1 << 16)))
    tail = answer.read()
    found = re.search(rb'\{"frames": [0-9]+, "warnings": [^\n]*\}\n\Z', tail)
    if found is None:
        raise FormatError("the file is damaged: its reader did not finish")
    said = json.loads(found.group())
    return int(said["frames"]), list(said["warnings"])


def _notices(about: dict[str, Any], frames: int, said: list[str]) -> list[Notice]:
    notices: list[Notice] = []
    if frames != about["declared"]:
        note(notices, "warning", f"the file says it has {about['declared']} frames, {frames} follow: these count")
    else:
        for text in said:
            if not text.startswith(_OF_NO_INTEREST):
                note(notices, "warning", text[:200])
    lost = [
        f"{about['analog']} analog channels" if about["analog"] else "",
        f"{about['events']} events" if about["events"] else "",
    ]
    if any(lost):
        kept = " and ".join(text for text in lost if text)
        note(notices, "warning", f"{kept} are not in the document; the kept file has them")
    return notices


def _labels(about: dict[str, Any], notices: list[Notice]) -> list[str]:
    labels, points = about["labels"], about["points"]
    if len(labels) < points:
        note(notices, "warning", f"{points} points have {len(labels)} labels: the others are unnamed")
    return [*labels[:points], *["unnamed"] * (points - len(labels))]


def _fields(file: SourceFile, about: dict[str, Any], notices: list[Notice]) -> dict[str, str]:
    fields = {"filetype": "C3D", "filename": file.name.rsplit("/", 1)[-1]}
    if float(about["rate"]) > 0:
        fields["dataframe_rate"] = about["rate"].removesuffix(".0")
    else:
        note(notices, "warning", "the file has no rate: how fast the frames follow is unknown")
    if about["unit"]:
        fields["calibration_unit"] = about["unit"]
    screen = about["y_screen"].upper()
    if screen in ("+X", "+Y", "+Z"):
        note(notices, "guess", f"{screen[1]} counts as up: the file shows it upward on the screen (Y_SCREEN)")
        fields["global_axis_of_gravity"] = screen[1]
    return fields


def _block(points: Any, skeleton: Skeleton, first: int, unmeasured: bool) -> FrameBlock:
    columns = skeleton.columns()
    channels = len(columns) // len(skeleton)
    values = points[:, :, :channels].astype(np.float64)
    ids = np.arange(first, first + len(points), dtype=np.int64)
    missing = np.zeros(points.shape[:2], dtype=bool) if unmeasured else points[:, :, 3] < 0
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
    return FrameBlock(values.reshape(len(points), -1), columns, shapes, ids, shape_of)


def _write(clip: ClipStream) -> Iterator[bytes]:
    import c3d

    head = clip.head
    seconds = head.seconds_per_frame()
    if seconds is None:
        raise ConversionError("C3D says how fast frames follow, and the document does not", remedy="State it first.")
    rate = float(head.fields.get("dataframe_rate") or 1 / seconds)
    sections = dict(head.sources[0].sections) if head.sources and head.sources[0].part == "c3d" else {}
    scale = abs(float(sections.get("POINT:SCALE", "1")) or 1.0)
    unit = head.fields.get("calibration_unit", "")
    writer = c3d.Writer(point_rate=rate, point_scale=-scale, point_units=unit.ljust(4))
    labels = [_label(joint.source_name, clip.notices) for joint in head.skeleton.joints]
    _set_labels(writer, labels)
    up = head.fields.get("global_axis_of_gravity", "")
    if up in ("Y", "Z"):
        writer.set_screen_axis("+X", f"+{up}")
    worst, first = 0.0, None
    for block in clip.blocks():
        points, error = _points(block, head.skeleton)
        worst = max(worst, error)
        if first is None:
            first = int(block.ids[0]) if not isinstance(block.ids, list) else 1
        writer.add_frames([(frame, np.empty((0, 0), np.float32)) for frame in points])
    if first is None:
        raise ConversionError("C3D cannot hold a motion without frames", remedy="Export it as TRC or MCML.")
    writer.set_start_frame(first if first > 0 else 1)
    if worst:
        note(clip.notices, "warning", f"C3D holds numbers in single precision: the largest difference is {worst:.3g}")
    buffer = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        writer.write(buffer)
    yield buffer.getvalue()


def _set_labels(writer: Any, labels: list[str]) -> None:
    """LABELS, LABELS2 …: the sizes of a parameter are bytes, so that it has no more than 255 texts."""
    for start in range(0, len(labels), 255):
        some = labels[start : start + 255]
        text, longest = writer.pack_labels(some)
        number = "" if not start else str(start // 255 + 1)
        writer.point_group.add_str(f"LABELS{number}", "Point labels.", text, longest, len(some))
        writer.point_group.add_str(f"DESCRIPTIONS{number}", "Point descriptions.", " " * len(some), 1, len(some))


def _label(text: str, notices: list[Notice]) -> str:
    plain = text.encode("utf-8", errors="replace")[:_LONGEST_LABEL].decode("utf-8", errors="ignore")
    if plain != text:
        note(notices, "warning", f"labels in C3D have at most {_LONGEST_LABEL} bytes: {text[:40]!r} was cut")
    return plain


def _points(block: FrameBlock, skeleton: Skeleton) -> tuple[Any, float]:
    """((n, points, 5) float32 as the package takes them, the largest error of rounding to single precision)."""
    points = np.zeros((len(block), len(skeleton), 5), dtype=np.float64)
    points[:, :, 3] = -1.0
    place = {column: index for index, column in enumerate(block.columns)}
    seen = np.zeros((len(block), len(skeleton)), dtype=np.intp)
    for joint in range(len(skeleton)):
        for axis in range(3):
            if (joint, axis) in place:
                values: Array = block.values[:, place[joint, axis]]
                points[:, joint, axis] = np.nan_to_num(values)
                seen[:, joint] += ~np.isnan(values)
        residual = block.values[:, place[joint, _RESIDUAL]] if (joint, _RESIDUAL) in place else np.zeros(len(block))
        points[:, joint, 3] = np.where(seen[:, joint] == 3, np.nan_to_num(residual), -1.0)
    single = points.astype(np.float32)
    there = points[:, :, 3] >= 0
    error = np.abs(single[..., :3].astype(np.float64) - points[..., :3])[there]
    return single, float(error.max(initial=0.0))
