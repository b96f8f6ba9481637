"""MVNX 3 and 4: segments of a suit of Xsens, with their places and rotations in the world.

Source: MVN User Manual, chapter "MVNX file format" (Movella). docs/formats/mvnx.md describes the reading.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import compress
from typing import BinaryIO, Final

import numpy as np
from lxml import etree

from mcml.errors import FormatError, LimitError, Notice
from mcml.formats.format import FileKind, Limits, ReadOptions, SourceFile
from mcml.formats.other_formats import root_of
from mcml.formats.scenes.reader import SceneReader
from mcml.formats.scenes.scene import Rig, Scene, Take, check_joints
from mcml.motion.nodes import sort_by_tree
from mcml.motion.rotations import rotate, to_matrix
from mcml.motion.skeleton import Array

REST_METRES: Final = 0.01
"""Offsets of a calibration pose may differ from those of the motion by so much."""
_POSES: Final = ("identity", "tpose", "npose")
_DAMAGED: Final = "Export the file again from MVN."
_FEET: Final = ("LeftFoot_Heel", "LeftFoot_Toe", "RightFoot_Heel", "RightFoot_Toe")
"""The parts of feet whose contacts are listed, where a file does not define them."""
_MOST_CONTACTS: Final = 64
_UNREAD: Final = ("fingerTrackingSegmentsLeft", "fingerTrackingSegmentsRight")


class Mvnx(SceneReader):
    """The format `mvnx`; see `mcml.formats.format.Reader`."""

    name = "mvnx"
    title = "Xsens MVNX"
    label = "MVNX"
    parts = (FileKind("mvnx", (".mvnx",), "Segments and motion"),)
    media_type = "application/xml"

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        return "mvnx" if root_of(first_bytes) == b"mvnx" else None

    def open_scene(self, files: Mapping[str, SourceFile], options: ReadOptions) -> Scene:
        return _Reading(files["mvnx"].stream, options).scene()


@dataclass
class _Contents:
    """The contents of a file.

    segments: labels. links: (parent's place, own place, offset of the joint in each). touching: labels of the parts of
    feet. contacts: of each frame which of them are on the ground, () where it does not say.
    odd_contacts: whether some are no list of 0 and 1.
    """

    rate: float | None = None
    segments: list[str] = field(default_factory=list)
    points: dict[str, Array] = field(default_factory=dict)
    links: list[tuple[str, str]] = field(default_factory=list)
    poses: dict[str, Array] = field(default_factory=dict)
    frames: int = 0
    touching: list[str] = field(default_factory=list)
    contacts: list[tuple[bool, ...]] = field(default_factory=list)
    odd_contacts: bool = False
    fingers: bool = False
    placed: bool = True
    properties: list[tuple[str, str, str]] = field(default_factory=list)


class _Reading:
    def __init__(self, stream: BinaryIO, options: ReadOptions) -> None:
        self.stream = stream
        self.limits: Limits = options.limits
        self.options = options
        self.found = _Contents()
        self.spool = tempfile.TemporaryFile()  # noqa: SIM115  # closed once its numbers are mapped into memory

    def scene(self) -> Scene:
        with self.spool:
            try:
                self._parse()
            except etree.XMLSyntaxError as error:
                line = error.position[0] if error.position else None
                raise FormatError(
                    f"the XML of the MVNX file is damaged or cut off (line {line})", remedy=_DAMAGED
                ) from None
            found = self.found
            check_joints(found.segments, len(found.segments), self.limits, "MVNX")
            rate = self.options.rate or found.rate
            if not rate:
                raise FormatError("the file states no frame rate", remedy="Say it with `rate`.")
            if not found.frames:
                raise FormatError(
                    f"the file has {len(found.segments)} segments and no frames of motion", remedy=_DAMAGED
                )
            self.spool.flush()
            motion: Array = np.memmap(self.spool, np.float64, "r", 0, (found.frames, len(found.segments), 7))
        parents, order = self._tree()
        if not found.placed:
            motion = self._place(motion, parents, order)
        rest, notices = self._rest(motion[0], parents)
        rig_parents = np.array([order.index(parents[at]) if parents[at] >= 0 else -1 for at in order], np.intp)
        posed = _matrices(rest)[order]
        rig = Rig(tuple(found.segments[at] for at in order), rig_parents, posed)
        poses = partial(_read_frames, motion, order)
        labels = self._label_contacts()
        take = Take("", rig, found.frames, rate, poses, (), tuple(found.properties), labels=labels)
        return Scene((take,), "m", "Z", tuple(Notice("note", what) for what in notices), 8 * motion.size)

    def _parse(self) -> None:
        self.stream.seek(0)
        events = etree.iterparse(
            self.stream, events=("start", "end"), resolve_entities=False, no_network=True, load_dtd=False
        )
        for event, element in events:
            name = str(element.tag).rpartition("}")[2]
            if event == "start":
                self._begin(name, element)
                continue
            if name == "frame":
                self._frame(element)
            elif name == "segments":
                self._segments(element)
            elif name == "joints":
                self._joints(element)
            if name in ("frame", "segments", "joints"):
                element.clear()
                while element.getprevious() is not None:
                    del element.getparent()[0]

    def _begin(self, name: str, element: etree._Element) -> None:
        if name == "subject":
            text = element.get("frameRate", "")
            rate = float(text) if re.fullmatch(r"\d{1,6}(\.\d{1,9})?", text) else 0.0
            self.found.rate = rate or None
        self.found.fingers |= name in _UNREAD
        if name == "contactDefinition" and len(self.found.touching) < _MOST_CONTACTS:
            self.found.touching.append(element.get("label", ""))

    def _segments(self, segments: etree._Element) -> None:
        for segment in segments.iterchildren("{*}segment"):
            label = segment.get("label", "").strip() or f"segment {len(self.found.segments) + 1}"
            if label in self.found.segments:
                raise FormatError(f"two segments are called {label[:60]!r}", remedy=_DAMAGED)
            self.found.segments.append(label)
            if len(self.found.segments) > self.limits.joints:
                raise LimitError(f"the file has more than {self.limits.joints} segments", remedy="Remove segments.")
            for point in segment.iter("{*}point"):
                values = _numbers(next((child.text for child in point if isinstance(child.tag, str)), ""), 3)
                if values is not None:
                    self.found.points[f"{label}/{point.get('label', '')}"] = values

    def _joints(self, joints: etree._Element) -> None:
        for joint in joints.iterchildren("{*}joint"):
            ends = [joint.findtext(f"{{*}}connector{number}", "").strip() for number in (1, 2)]
            self.found.links.append((ends[0], ends[1]))

    def _frame(self, frame: etree._Element) -> None:
        kind, found = frame.get("type", "normal"), self.found
        count = len(found.segments)
        line = frame.sourceline
        turns = _numbers(frame.findtext("{*}orientation", ""), 4 * count)
        if turns is None:
            raise FormatError(
                f"the orientations of the frame in line {line} are not {4 * count} numbers", remedy=_DAMAGED
            )
        text = frame.findtext("{*}position")
        places = np.zeros(3 * count) if text is None else _numbers(text, 3 * count)
        if places is None:
            raise FormatError(f"the positions of the frame in line {line} are not {3 * count} numbers", remedy=_DAMAGED)
        quaternions = turns.reshape(count, 4)
        lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
        quaternions = np.where(lengths > 0, quaternions / np.where(lengths > 0, lengths, 1.0), np.nan)
        numbers = np.hstack([places.reshape(count, 3), quaternions[:, [1, 2, 3, 0]]])
        if kind in _POSES:
            found.poses.setdefault(kind, numbers)
        if kind != "normal":
            return
        found.placed &= text is not None
        text = frame.findtext("{*}footContacts", "")
        found.contacts.append(_read_contacts(text))
        found.odd_contacts |= bool(text.strip()) and not found.contacts[-1]
        if not found.frames:
            for name, attribute in (("timecode", "tc"), ("recorded", "ms")):
                if frame.get(attribute):
                    found.properties.append((name, str(frame.get(attribute))[:100], ""))
        found.frames += 1
        self.limits.check_size(found.frames, 6 * count)
        self.spool.write(numbers.tobytes())

    def _name_contacts(self) -> list[str]:
        """The labels of contacts, in the order of their numbers; none where frames have none, or others."""
        counts = {len(row) for row in self.found.contacts if row}
        parts = self.found.touching or (list(_FEET) if counts == {len(_FEET)} else [])
        names = [_name_contact(part) for part in parts] if counts == {len(parts)} else []
        return names if len(set(names)) == len(names) else []

    def _label_contacts(self) -> Callable[[int, int], list[tuple[str, ...]]] | None:
        names, contacts = self._name_contacts(), self.found.contacts
        if not names:
            return None

        def label(first: int, end: int) -> list[tuple[str, ...]]:
            return [tuple(compress(names, row)) for row in contacts[first:end]]

        return label

    def _tree(self) -> tuple[list[int], list[int]]:
        """The parent of each segment, and the segments with each before its children."""
        place = {label: index for index, label in enumerate(self.found.segments)}
        parents = [-1] * len(place)
        for first, second in self.found.links:
            above, below = first.split("/")[0], second.split("/")[0]
            if above not in place or below not in place:
                raise FormatError(f"a joint connects {first[:60]!r} and {second[:60]!r}, which are no segments")
            if parents[place[below]] >= 0:
                raise FormatError(f"segment {below[:60]!r} has two parents", remedy=_DAMAGED)
            parents[place[below]] = place[above]
        return parents, sort_by_tree(parents, self.limits.depth)

    def _rest(self, first: Array, parents: list[int]) -> tuple[Array, list[str]]:
        """(J, 7) places and rotations at rest, and notices."""
        notices = []
        named = self._name_contacts()
        if named:
            notices.append(f"the contacts of the feet are labels: {', '.join(named)}")
        if self.found.odd_contacts or (any(self.found.contacts) and not named):
            notices.append("contacts of the feet do not fit their definition: they are only in the kept file")
        if self.found.fingers:
            notices.append("the motion of fingers is in the kept file; it is not read")
        if not self.found.placed:
            notices.append("the file has no positions: the first segment stays at 0, the others follow from its points")
        below = [at for at, parent in enumerate(parents) if parent >= 0]
        above = [parents[at] for at in below]
        moved = _offsets(first, above, below)
        for kind in _POSES:
            pose = self.found.poses.get(kind)
            near = pose is not None and np.abs(_offsets(pose, above, below) - moved).max(initial=0.0) <= REST_METRES
            if pose is not None and near:
                return pose, notices
        notices.append("no calibration pose of the file fits its motion: bones rest as in the first frame, unturned")
        rest = np.zeros_like(first)
        rest[:, 6] = 1.0
        offset = dict(zip(below, moved, strict=True))
        for at in sort_by_tree(parents, self.limits.depth):
            rest[at, :3] = first[at, :3] if parents[at] < 0 else rest[parents[at], :3] + offset[at]
        return rest, notices

    def _place(self, motion: Array, parents: list[int], order: list[int]) -> Array:
        """The motion with places of segments from the points of joints; roots stay at 0."""
        placed = np.array(motion)
        ends = {second.split("/")[0]: (first, second) for first, second in self.found.links}
        for at in order:
            if parents[at] < 0:
                continue
            first, second = ends[self.found.segments[at]]
            if first not in self.found.points or second not in self.found.points:
                raise FormatError("the file has neither positions nor the points of its joints", remedy=_DAMAGED)
            joint = placed[:, parents[at], :3] + rotate(placed[:, parents[at], 3:], self.found.points[first])
            placed[:, at, :3] = joint - rotate(placed[:, at, 3:], self.found.points[second])
        return placed


def _read_contacts(text: str) -> tuple[bool, ...]:
    """Which parts of feet are on the ground; () for a text that is no list of 0 and 1."""
    words = text.split()
    fits = len(words) <= _MOST_CONTACTS and all(word in ("0", "1") for word in words)
    return tuple(word == "1" for word in words) if fits else ()


def _name_contact(part: str) -> str:
    """The label of a contact: `contact-left-heel` for `LeftFoot_Heel`."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])|[^A-Za-z0-9]+", " ", part).lower().split()
    return "-".join(["contact", *(word for word in words if word != "foot" or len(words) == 1)])


def _numbers(text: str | None, count: int) -> Array | None:
    """(count,) the numbers of a text; None where it has others."""
    try:
        values = np.array((text or "").split(), np.float64)
    except ValueError:
        return None
    return values if len(values) == count else None


def _offsets(pose: Array, above: list[int], below: list[int]) -> Array:
    """(k, 3) where segments stand in their parents."""
    turns = pose[above, 3:] * np.array([-1.0, -1.0, -1.0, 1.0])
    return rotate(turns, pose[below, :3] - pose[above, :3])


def _matrices(numbers: Array) -> Array:
    """(..., 3, 4) transforms of places and rotations (..., 7)."""
    return np.concatenate([to_matrix(numbers[..., 3:]), numbers[..., :3, None]], axis=-1)


def _read_frames(motion: Array, order: list[int], first: int, end: int) -> Array:
    return _matrices(np.array(motion[first:end])[:, order])
