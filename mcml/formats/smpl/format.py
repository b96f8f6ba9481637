"""Pose parameters of SMPL, SMPL-H and SMPL-X in `.npz`, as AMASS and its successors write them.

Sources: M. Loper et al., "SMPL: A Skinned Multi-Person Linear Model" (2015); J. Romero et al., "Embodied Hands" (2017);
G. Pavlakos et al., "Expressive Body Capture" (2019); N. Mahmood et al., "AMASS" (2019). Each joint has an axis times
an angle, in its parent; the rest pose has the arms stretched out and all axes along the world's.
"""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO, Final

import numpy as np

from mcml.errors import FormatError, LimitError, Notice
from mcml.formats.format import FileKind, Limits, ReadOptions, SourceFile
from mcml.formats.scenes.make_clip import ANGLE_DECIMALS, unroll, without_gaps
from mcml.formats.smpl.skeleton import body_of, skeleton_of
from mcml.formats.zip_entries import first_entry
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, SourcePart
from mcml.motion.lexemes import lexeme
from mcml.motion.rotation_vectors import from_vector
from mcml.motion.skeleton import Array, Convention

RATES: Final = ("mocap_framerate", "mocap_frame_rate", "fps")
_OF_AMASS: Final = RATES[:2]
_PIECES: Final = ("root_orient", "pose_body", "pose_jaw", "pose_eye", "pose_hand")
_DAMAGED: Final = "Save the file again with numpy.savez."
_FRAMES_AT_ONCE: Final = 2048
_ORDER: Final = "ZYX"


class Smpl:
    """The format `smpl`; see `mcml.formats.format.Reader`."""

    name = "smpl"
    title = "SMPL and AMASS poses"
    label = "SMPL"
    parts = (FileKind("npz", (".npz",), "Poses of a body model"),)
    convention = Convention.LISTED
    media_type = "application/octet-stream"
    states = frozenset({"unit", "up", "frame_time"})

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        entry = first_entry(first_bytes)
        return "npz" if entry is not None and entry.name.endswith(".npy") else None

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        file = files["npz"]
        with file.blamed():
            return _read(file, options)


def _read(file: SourceFile, options: ReadOptions) -> ClipStream:
    limits = options.limits
    try:
        with zipfile.ZipFile(file.stream) as archive:
            found = _Arrays(archive, limits)
            poses, places = _poses_of(found), found.read("trans")
            rate = next((found.number(name) for name in RATES if found.has(name)), None)
            is_amass = rate is not None and any(found.has(name) for name in _OF_AMASS)
            properties = _properties(found)
    except (zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, RuntimeError, ValueError) as error:
        raise FormatError(f"the NPZ file is damaged or cut off: {error}", remedy=_DAMAGED) from None
    frames = len(poses)
    if len(places) != frames:
        raise FormatError(f"the file has {frames} poses and {len(places)} places of the root", remedy=_DAMAGED)
    if not frames:
        raise FormatError("the file has no frames", remedy=_DAMAGED)
    body = body_of(poses.shape[1] // 3)
    limits.check_size(frames, poses.shape[1] + 3)
    if len(body.names) > limits.joints or limits.depth < 12:
        raise LimitError(f"the body has {len(body.names)} joints, more than the limit", remedy="Raise the limit.")
    for name in body.names:
        limits.check_name(name)
    rate = options.rate or rate
    if not rate:
        raise FormatError("the file states no frame rate", remedy="Say it with `rate`: frames a second.")
    notices = [
        Notice("guess", "lengths of bones are those of a general adult of 1.70 m: the file holds only shape numbers")
    ]
    if is_amass:
        notices.append(Notice("note", "the file has AMASS' name of the rate, so Z is taken as up"))
    fields = {"dataframe_rate": lexeme(rate), "calibration_unit": "m"}
    fields |= {"global_axis_of_gravity": "Z"} if is_amass else {}
    skeleton = skeleton_of(body)
    head = ClipHead(
        "smpl",
        skeleton,
        fields,
        sources=(SourcePart("npz", file.name.rsplit("/", 1)[-1]),),
        properties=tuple(properties),
    )

    def blocks() -> Iterator[FrameBlock]:
        columns = skeleton.columns()
        before: list[Array | None] = [None] * len(skeleton)
        for first in range(0, frames, _FRAMES_AT_ONCE):
            turns = poses[first : first + _FRAMES_AT_ONCE].astype(np.float64).reshape(-1, len(body.names), 3)
            turns[~np.isfinite(turns).all(axis=-1)] = np.nan
            moved = places[first : first + _FRAMES_AT_ONCE].astype(np.float64) + np.array(body.offsets[0])
            angles = np.empty_like(turns)
            for joint, place in enumerate(body.places):
                angles[:, joint] = unroll(from_vector(turns[:, place]), before, joint, _ORDER)
            degrees = np.round(np.degrees(angles), ANGLE_DECIMALS) + 0.0
            values = np.empty((len(turns), len(columns)))
            for column, (joint, channel) in enumerate(columns):
                values[:, column] = moved[:, channel] if channel < 3 else degrees[:, joint, 5 - channel]
            values[~np.isfinite(values)] = np.nan
            yield without_gaps(values, columns, np.arange(first + 1, first + len(turns) + 1, dtype=np.int64))

    gaps = int((~np.isfinite(poses)).any(axis=1).sum())
    if 2 * gaps > frames:
        raise FormatError(f"{gaps} of {frames} poses have numbers that are not finite", remedy=_DAMAGED)
    if gaps:
        notices.append(Notice("warning", f"{gaps} poses have numbers that are not finite: no samples there"))
    return ClipStream(head, blocks, frames, notices)


class _Arrays:
    """The arrays of an NPZ file, each read after its size is known."""

    def __init__(self, archive: zipfile.ZipFile, limits: Limits) -> None:
        self._archive = archive
        self._limits = limits
        self._names = {name.removesuffix(".npy") for name in archive.namelist()}

    def has(self, name: str) -> bool:
        return name in self._names

    def read(self, name: str) -> Array:
        """A matrix of numbers, float32 or float64. FormatError where it is missing or something else."""
        if not self.has(name):
            raise FormatError(
                f"the file has no array {name!r}: it holds {', '.join(sorted(self._names))[:200] or 'nothing'}",
                remedy="Send a file with `poses` and `trans`, as AMASS has them.",
            )
        found: Array = self._load(name)
        if found.ndim != 2 or found.dtype.kind != "f":
            raise FormatError(f"{name} is no matrix of floating-point numbers", remedy=_DAMAGED)
        if name == "trans" and found.shape[1] != 3:
            raise FormatError(f"trans has {found.shape[1]} columns, not 3", remedy=_DAMAGED)
        return found

    def number(self, name: str) -> float | None:
        """A single positive number, None where it is none."""
        found = self._load(name)
        value = float(found.reshape(-1)[0]) if found.size == 1 and found.dtype.kind in "fiu" else 0.0
        return value if 0 < value < 1e6 else None

    def text(self, name: str) -> str:
        """A text, also one of bytes."""
        found = self._load(name)
        value = found.reshape(-1)[0] if found.size == 1 and found.dtype.kind in "SU" else ""
        return (value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value))[:100]

    def row(self, name: str) -> Array:
        """Numbers in one dimension; none where the array is something else."""
        found = self._load(name)
        return found.reshape(-1)[:400].astype(np.float64) if found.dtype.kind in "fiu" else np.empty(0)

    def _load(self, name: str) -> Any:
        with self._archive.open(f"{name}.npy") as member:
            try:
                shape, order, dtype = _read_header(member)  # type: ignore[arg-type]  # a stream as any other
            except ValueError as error:
                raise FormatError(f"the array {name!r} is damaged: {error}", remedy=_DAMAGED) from None
            if dtype.hasobject:
                raise FormatError(
                    f"{name} holds pickled data, which is not opened", remedy="Save it as an array of numbers."
                )
            count = int(np.prod(shape, dtype=object)) if shape else 1
            if count > self._limits.values:
                raise LimitError(f"{name} has {count} values, the limit is {self._limits.values}", remedy="Cut it.")
            data = member.read(count * dtype.itemsize)
        if len(data) != count * dtype.itemsize:
            raise FormatError(f"the array {name!r} is cut off", remedy=_DAMAGED)
        return np.frombuffer(data, dtype).reshape(shape, order="F" if order else "C")


def _read_header(member: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = np.lib.format.read_magic(member)
    if version == (1, 0):
        return np.lib.format.read_array_header_1_0(member)
    if version in ((2, 0), (3, 0)):
        return np.lib.format.read_array_header_2_0(member)
    raise ValueError(f"version {version} of its header is not known")


def _poses_of(found: _Arrays) -> Array:
    """(n, 3 J) of `poses`, or of the pieces in which newer files have them."""
    if found.has("poses") or not found.has("root_orient"):
        return found.read("poses")
    pieces = [found.read(name) for name in _PIECES if found.has(name)]
    if len({len(piece) for piece in pieces}) != 1:
        raise FormatError("the parts of the poses have different numbers of frames", remedy=_DAMAGED)
    return np.hstack(pieces)


def _properties(found: _Arrays) -> list[tuple[str, str, str]]:
    properties = []
    if found.has("gender") and (gender := found.text("gender")):
        properties.append(("gender", gender, ""))
    if found.has("betas") and len(betas := found.row("betas")):
        properties.append(("betas", " ".join(f"{value:.9g}" for value in betas), ""))
    return properties
