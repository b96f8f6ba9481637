"""Thumbnails of clips: poses gathered while a clip is read, or read from the store, and drawn (`motion.thumbnails`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mcml.language.elements import to_head
from mcml.motion.carriers import carriers
from mcml.motion.clip import ClipHead, FrameBlock, full_shape
from mcml.motion.guesses import likely_unit, up_of_head
from mcml.motion.hub import HubReader, rest_of, walked
from mcml.motion.kinematics import rest_positions, unseen
from mcml.motion.landmarks.centres import centres_of, with_centres
from mcml.motion.landmarks.sizes import sizes_of
from mcml.motion.layout import Held
from mcml.motion.pictures.figures import (
    Figure,
    axis_of,
    figure_of,
    finite,
    is_markers,
    marker_body_figure,
    marker_figure,
    view_of,
)
from mcml.motion.pictures.thumbnails import busiest, carried, draw, loop_times, poses_at, scrub_times
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array
from mcml.motion.units import metres_of, reading_of
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

DENSE = 24.0
"""Poses a second that are looked at: twice as many as are drawn."""

MOST_POSES = 16_384
MOST_PLACES = 1_000_000
"""Poses, and joints in all of them, that are looked at of a clip; of longer ones fewer a second, and those of the loop
once more."""

MOST_AT_IMPORT = 1000
"""Joints of a clip whose thumbnail is made while it is imported."""

ASSUMED_RATE = 120.0
"""Frame rate in Hz if unknown: the usual rate of systems that do not state one."""


@dataclass(frozen=True)
class Thumbnail:
    """data: in the format of `motion.thumbnails`.

    facts: likely unit, its metres, likely up axis, whether of markers.
    """

    data: bytes
    facts: dict[str, Any]


class Poses:
    """Poses of a clip, gathered from its frames as they pass by."""

    def __init__(self, head: ClipHead, step: int = 1) -> None:
        """step: every step-th frame that is added is looked at."""
        self.head = head
        self.step = step
        self.full = False
        self._seen = 0
        self._held = Held(head.skeleton)
        self._markers = is_markers(head.skeleton)
        self._most = most_poses(head)
        self._values: list[Array] = []
        self._gaps: list[np.ndarray[Any, np.dtype[np.bool_]]] = []
        self._count = 0

    def add(self, block: FrameBlock) -> None:
        """Look at the frames that follow."""
        skip = -self._seen % self.step
        self._seen += len(block)
        if self.full or skip >= len(block):
            return
        rows = block.values[skip :: self.step]
        chosen = FrameBlock(rows, block.columns, block.shapes, block.ids[skip :: self.step])
        self._count += len(rows)
        if self._count > self._most:
            self.full, self._values, self._gaps = True, [], []
            return
        if self._markers:
            self._gaps.append(unseen(self.head.skeleton, chosen))
        self._values.append(self._held.values(chosen).copy())

    def positions(self) -> tuple[Array, Array, int]:
        """(n, P, 3) of joints and tips, or of markers and the centres that they tell, NaN for points that were not
        seen; (n, J, 3) of the joints alone; and which of them moves the body."""
        skeleton = self.head.skeleton
        reader = HubReader(skeleton, reading_of(self.head))
        if not self._values:
            rest = rest_positions(skeleton, reader.reading)[None]
            return rest, rest[:, : len(skeleton)], 0
        columns = skeleton.columns()
        values = np.concatenate(self._values)
        hub = reader.read(FrameBlock(values, columns, (full_shape(columns),), np.arange(len(values))))
        joints, turned = walked(skeleton, hub.translations, hub.rotations)
        if self._markers:
            joints[np.concatenate(self._gaps)] = np.nan
            return with_centres(centres_of(skeleton), joints, sizes_of(self.head, metres_of(self.head))), joints, 0
        ends = [joint for joint, _ in reader.rest.tips]
        along = np.array([vector for _, vector in reader.rest.tips]).reshape(-1, 3) * hub.scales[:, ends, None]
        tips = joints[:, ends] + rotate(turned[:, ends], along)
        return np.concatenate([joints, tips], axis=1), joints, carriers(skeleton, hub.translations)[0]


def most_poses(head: ClipHead) -> int:
    """How many poses of a clip are looked at."""
    return max(1, min(MOST_POSES, MOST_PLACES // max(1, len(head.skeleton))))


def poses_of(head: ClipHead) -> Poses:
    """Return an object that collects the poses of a whole clip while it is imported."""
    poses = Poses(head, max(1, int(_rate(head) / DENSE)))
    poses.full = len(head.skeleton) > MOST_AT_IMPORT
    return poses


def thumbnail_of(poses: Poses, head: ClipHead) -> Thumbnail | None:
    """Return the thumbnail of a clip whose frames were all added.

    None if it has no joints, or was too long. head: at the end of reading.
    """
    if poses.full or not len(head.skeleton):
        return None
    poses.head = head
    return _Drawing(poses, poses.step / _rate(head)).thumbnail()


def read_thumbnail(tx: Transaction, stored: StoredDocument) -> Thumbnail | None:
    """The thumbnail of a stored document. None where it has no joints."""
    head = to_head(tx.heads.document(stored), stored.frame_time)
    if not len(head.skeleton):
        return None
    dense = max(1, int(_rate(head) / DENSE))
    step = max(dense, -(-stored.frames // most_poses(head)))
    drawing = _Drawing(_read(tx, stored, head, 1, stored.frames, step), step / _rate(head))
    if step == dense:
        return drawing.thumbnail()
    start, end = drawing.window
    first = max(1, int(start * _rate(head)) + 1)
    last = min(stored.frames, int(np.ceil(end * _rate(head))) + 1)
    fine = _read(tx, stored, head, first, last, dense)
    if fine.full:
        return drawing.thumbnail()
    poses = finite(fine.positions()[0][:, drawing.figure.points])
    times = loop_times(drawing.figure, start, end) - (first - 1) / _rate(head)
    return drawing.thumbnail(poses_at(poses, dense / _rate(head), times))


def read_range_thumbnail(tx: Transaction, stored: StoredDocument, first: int, last: int) -> Thumbnail | None:
    """The thumbnail of frames first to last, positions from 1, both included: its whole clip is this range.

    None where the document has no joints. NotFoundError for frames outside of it.
    """
    head = to_head(tx.heads.document(stored), stored.frame_time)
    if not len(head.skeleton):
        return None
    step = max(1, int(_rate(head) / DENSE), -(-(last - first + 1) // most_poses(head)))
    return _Drawing(_read(tx, stored, head, first, last, step), step / _rate(head)).thumbnail()


def _read(tx: Transaction, stored: StoredDocument, head: ClipHead, first: int, last: int, step: int) -> Poses:
    poses = Poses(head)
    if stored.frames:
        for block in read_clip(tx, stored, first=first, last=last, step=step, labelled=False).clip.blocks():
            poses.add(block)
    return poses


def _rate(head: ClipHead) -> float:
    seconds = head.seconds_per_frame()
    return 1 / seconds if seconds is not None and 1e-5 < seconds < 1e3 else ASSUMED_RATE


class _Drawing:
    """One clip, seen: which points, from where, and when it is busiest. spacing: seconds from pose to pose."""

    def __init__(self, poses: Poses, spacing: float) -> None:
        with np.errstate(all="ignore"):
            points, joints, carrier = poses.positions()
        self.skeleton = poses.head.skeleton
        self.spacing = spacing
        self.whole = (len(points) - 1) * spacing
        self.facts = _facts(poses.head, joints)
        self.figure = self._figure(poses.head, points, joints, carrier)
        self.positions = finite(points[:, self.figure.points])
        self.points = finite(points if is_markers(self.skeleton) else joints)
        way = carried(self.figure, self.positions)
        up = axis_of(self.facts["up"])
        level = way - (way @ up)[:, None] * up
        self.window = busiest(self.positions - level[:, None], spacing)

    def _figure(self, head: ClipHead, points: Array, joints: Array, carrier: int) -> Figure:
        if not is_markers(self.skeleton):
            return figure_of(self.skeleton, rest_of(self.skeleton, reading_of(head)), carrier)
        if (body := marker_body_figure(self.skeleton, points)) is not None:
            return body
        with np.errstate(all="ignore"):
            seen = np.isfinite(joints).all(axis=2)
            first = np.take_along_axis(joints, seen.argmax(axis=0)[None, :, None], axis=0)[0]
        middle = joints[len(joints) // 2]
        return marker_figure(self.skeleton, np.where(np.isfinite(middle), middle, first))

    def thumbnail(self, loop: Array | None = None) -> Thumbnail | None:
        """loop: (L, P, 3) poses of the window where better ones are known."""
        if not self.figure.points:
            return None
        start, end = self.window
        times = loop_times(self.figure, start, end)
        poses = poses_at(self.positions, self.spacing, times) if loop is None else loop
        scrub = poses_at(self.positions, self.spacing, scrub_times(self.figure, len(self.positions), self.whole))
        middle = poses_at(self.points, self.spacing, times[len(times) // 2 : len(times) // 2 + 1])[0]
        view = view_of(self.skeleton, self.figure, middle, axis_of(self.facts["up"]))
        return Thumbnail(draw(self.figure, poses, scrub, end - start, view), self.facts)


def _facts(head: ClipHead, joints: Array) -> dict[str, Any]:
    unit, metres = likely_unit(head, joints[0])
    stated = head.fields.get("global_axis_of_gravity", "").strip().upper()
    up = stated if stated.lstrip("+-") in ("X", "Y", "Z") and stated else up_of_head(head, joints).axis
    return {"unit": unit, "metres": metres, "up": up.lstrip("+"), "markers": is_markers(head.skeleton)}
