"""Documents as questions about motion see them: plain lists, a frame after the other.

What a quantity is in a frame `mcml.motion.bodies` says, which has a twin of its own; here it is on trial which
frames are looked at.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from lxml import etree

from mcml.motion.bodies.local_fit import rate
from mcml.motion.bodies.poses import NEEDS, at_rate, motion_distances, pose_distances, pose_features
from mcml.motion.bodies.quantities import QUANTITIES, compute
from mcml.motion.bodies.stretch import HIPS
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.clips.bodies import read_bodies, read_turned
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter

RESTS = {
    "metres": r"mo:(height|position|distance|speed|acceleration|leg|unit)\(",
    "up": r"mo:(height|contact|tilt|heading|pose-distance|motion-distance)\(|'(trunk|pelvis)-|, '(up|front|left)'",
    "floor": r"mo:(height|contact)\(",
}
"""What of a calibration the functions in a question make use of."""

TURNED = ("left-wrist-flexion", "head-left-rotation", "right-arm-medial-rotation", "pelvis-anterior-tilt")
NEARLY = 1e-6
Node = tuple[str, str]
"""The id of a document, and an address in it."""


@dataclass(frozen=True)
class Asked:
    """A part of a question. of: what it is in a frame (from 0) of a document."""

    text: str
    of: Callable[[Document, int], Any]


@dataclass
class Frame:
    names: list[str]
    bones: list[tuple[str, dict[str, float]]]


@dataclass
class Document:
    """revision: that it was read at. seconds: a frame, NaN where unknown."""

    uuid: str
    name: str
    revision: int
    frames: list[Frame]
    body: Any
    turned: dict[str, list[float]]
    kept: dict[Any, Any] = field(default_factory=dict)

    @property
    def seconds(self) -> float:
        return math.nan if self.body.frame_time is None else float(self.body.frame_time)

    def is_known(self, question: str) -> bool:
        """Whether none of what a question rests on is a guess."""
        origins = self.body.calibration.origins
        return not any(re.search(asks, question) and origins[name].kind == "guessed" for name, asks in RESTS.items())

    def lacks(self, condition: str) -> bool:
        """Whether something that a condition asks of the body is not known at all: then it is in no answer."""
        asked = re.findall(r"mo:([a-z-]+)\(", condition)
        calibration = self.body.calibration
        if {"height", "position", "distance", "speed", "acceleration", "leg", "unit"} & set(asked) and (
            calibration.metres is None
        ):
            return True
        if {"time", "speed", "acceleration", "rate", "contact"} & set(asked) and self.body.frame_time is None:
            return True
        if {"height", "contact"} & set(asked) and calibration.floor is None:
            return True
        for name, given in re.findall(r"mo:([a-z-]+)\(((?:'[^']*'(?:, )?)+)\)", condition):
            if name in QUANTITIES and name not in ("leg", "unit", "time"):
                texts = re.findall("'([^']*)'", given)
                wanted = set(QUANTITIES[name].joints(texts))
                if not all(set(one.split("|")) & set(self.body.names) for one in wanted):
                    return True
        return "mo:heading(" in condition and not all(set(one.split("|")) & set(self.body.names) for one in HIPS)

    @cached_property
    def features(self) -> Any:
        return pose_features(self.body.stretch(NEEDS)).astype(np.float32).astype(np.float64)

    def quantity(self, name: str, *arguments: str) -> list[float]:
        key = name, *arguments
        if key not in self.kept:
            if name == "angle" and arguments[0] in self.turned:
                self.kept[key] = self.turned[arguments[0]]
            else:
                stretch = self.body.stretch((*self.body.names, *self.body.lines))
                self.kept[key] = compute(name, arguments, stretch).tolist()
        found: list[float] = self.kept[key]
        return found

    def all(self, asked: Asked) -> list[Any]:
        """What is asked, in every frame."""
        if asked.text not in self.kept:
            self.kept[asked.text] = [asked.of(self, frame) for frame in range(len(self.frames))]
        found: list[Any] = self.kept[asked.text]
        return found

    def rates(self, asked: Asked) -> list[float]:
        key = "rate", asked.text
        if key not in self.kept:
            self.kept[key] = rate(np.array(self.all(asked), float), self.body.frame_time).tolist()
        found: list[float] = self.kept[key]
        return found

    def window(self, frame: int, low: float, high: float, *, by_frames: bool) -> list[int]:
        """The frames around one."""
        second = 1.0 if by_frames else self.seconds
        found = []
        for other in range(len(self.frames)):
            away = other - frame
            if low / second - NEARLY <= away <= high / second + NEARLY:
                found.append(other)
        return found

    def runs(self, frames: Sequence[int], gap: float) -> list[tuple[int, int]]:
        """First and last frames; between two of them are more frames than the gap has."""
        found: list[tuple[int, int]] = []
        for frame in frames:
            between = frame - found[-1][1] - 1 if found else 0
            if found and (between == 0 or between <= gap / self.seconds + NEARLY):
                found[-1] = found[-1][0], frame
            else:
                found.append((frame, frame))
        return found

    def long_runs(self, frames: Sequence[int], least: float, gap: float) -> list[int]:
        """The frames of runs of so many seconds, with those of closed gaps."""
        found: list[int] = []
        for first, last in self.runs(frames, gap):
            if (last - first + 1 + NEARLY) * self.seconds >= least:
                found += range(first, last + 1)
        return found

    def pose_distances(self, other: Document, position: int) -> list[float]:
        key = "pose", other.uuid, position
        if key not in self.kept:
            pose = pose_features(other.body.stretch(NEEDS))[position - 1 : position]
            self.kept[key] = [float(pose_distances(one[None], pose)[0, 0]) for one in self.features]
        found: list[float] = self.kept[key]
        return found

    def motion_distances(self, other: Document, first: int, last: int) -> list[float]:
        key = "motion", other.uuid, first, last
        if key not in self.kept:
            motion = pose_features(other.body.stretch(NEEDS))[first - 1 : last]
            if self.body.frame_time is None or other.body.frame_time is None:
                self.kept[key] = [math.nan] * len(self.frames)
            else:
                asked = motion
                if self.body.frame_time != other.body.frame_time:
                    asked = at_rate(motion, other.body.frame_time, self.body.frame_time)
                self.kept[key] = motion_distances(self.features, asked).tolist()
        found: list[float] = self.kept[key]
        return found

    def address(self, frame: int, bone: int | None = None) -> Node:
        inner = "" if bone is None else f"/frame_bone[{bone + 1}]"
        return self.uuid, f"/mcml/motion/frame[{frame + 1}]{inner}"


def read_documents(database: Database, at: dict[str, int] | None = None) -> list[Document]:
    """All of a store in the order of answers. at: revisions of some, which alone are read then."""
    with database.read() as tx:
        stored = list(tx.documents.page(DocumentFilter(), after=None, limit=1000))
        commits = {uuid: tx.documents.commit_of(tx.documents.get(uuid).key, n) for uuid, n in (at or {}).items()}
    if at is None:
        with database.read() as tx:
            return [_read(tx, one) for one in stored]
    found = []
    for uuid, commit in commits.items():
        with database.read(commit) as tx:
            found.append(_read(tx, tx.documents.get(uuid)))
    return found


def _read(tx: Any, stored: Any) -> Document:
    content = b"".join(export_document(tx, stored, ExportOptions("mcml")).content)
    tree = etree.parse(io.BytesIO(content), etree.XMLParser(remove_blank_text=True))
    frames = [
        Frame(
            [str(name.text) for name in frame.iter("motion_name")],
            [
                (str(bone.get("name")), {str(key): float(value) for key, value in bone.items() if key != "name"})
                for bone in frame.iter("frame_bone")
            ],
        )
        for frame in tree.iter("frame")
    ]
    body = read_bodies(tx, tx.columns.documents([stored.key]))[stored.key]
    turned = {name: read_turned(tx, stored, name, body).tolist() for name in TURNED}
    return Document(stored.uuid, stored.name, stored.revision, frames, body, turned)


def best_runs(documents: Sequence[Document], frames: Asked, wanted: int, key: Asked | None) -> list[Node]:
    """The frames of the best runs, the best run first; of equal ones the one that comes first."""
    found: list[tuple[float, list[Node]]] = []
    for document in documents:
        if document.lacks(frames.text):
            continue
        chosen = [number for number, holds in enumerate(document.all(frames)) if holds is True]
        for first, last in document.runs(chosen, 0.0):
            if key is None:
                score = (last - first + 1) * document.seconds
            else:
                known = [v for v in document.all(key)[first : last + 1] if v is not None and v == v]
                score = max(known) if known else math.nan
            if score == score:
                found.append((score, [document.address(frame) for frame in range(first, last + 1)]))
    found.sort(key=lambda run: -run[0])
    return [node for _, run in found[:wanted] for node in run]
