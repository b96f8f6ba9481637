"""The interface of file formats, and the input of readers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import BinaryIO, Protocol, runtime_checkable

from mcml.errors import ConversionError, FormatError, LimitError, McmlError, Notice, Place
from mcml.motion.characters.rigged import RiggedCharacter
from mcml.motion.clip import ClipHead, ClipStream
from mcml.motion.skeleton import Convention, Skeleton

_CONTROL = re.compile("[\x00-\x1f\x7f]")


@dataclass(frozen=True, slots=True)
class FileKind:
    """One kind of file that a format consists of.

    name: "bvh", "asf" … extensions: with the dot, the usual one first. title: for people.
    """

    name: str
    extensions: tuple[str, ...]
    title: str


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a reader, checked before memory is allocated.

    joints: of a skeleton. depth: joints below each other. name: bytes of one name. frames, values: of a clip.
    text: characters of comments and unknown sections.
    """

    joints: int = 10_000
    depth: int = 256
    name: int = 1024
    frames: int = 50_000_000
    values: int = 4_000_000_000
    text: int = 4 << 20

    def check_name(self, name: str, at: Place | None = None) -> None:
        """Raises LimitError for a name that is too long, FormatError for one with control characters."""
        if len(name.encode(errors="replace")) > self.name:
            raise LimitError(f"a name is longer than {self.name} bytes", at=at, remedy="Give the joint a shorter name.")
        control = _CONTROL.search(name)
        if control is not None:
            raise FormatError(
                f"the name {name!r} holds the control character U+{ord(control[0]):04X}",
                at=at,
                remedy="Write joint names in letters, digits and punctuation.",
            )

    def check_points(self, names: Sequence[str]) -> None:
        """Raises as `check_name` for the label of a point, and LimitError for too many points."""
        if len(names) > self.joints or self.depth < 1:
            raise LimitError(
                f"the file has {len(names)} points, the limit is {self.joints}", remedy="Keep those that matter."
            )
        for name in names:
            self.check_name(name)

    def check_size(self, frames: int, channels: int, at: Place | None = None) -> None:
        """Raises LimitError where a motion of that size is more than allowed."""
        if frames > self.frames:
            raise LimitError(
                f"the file says it has {frames} frames, the limit is {self.frames}", at=at, remedy="Cut it into parts."
            )
        if frames * channels > self.values:
            raise LimitError(
                f"the motion would need {frames * channels} values ({frames} frames of {channels}), "
                f"the limit is {self.values}",
                at=at,
                remedy="Cut it into parts.",
            )

    def check_text(self, characters: int, at: Place | None = None) -> None:
        """Raises LimitError where a file has more comments and unknown sections than anybody wrote by hand."""
        if characters > self.text:
            raise LimitError(
                f"comments and unknown sections are longer than {self.text} characters", at=at, remedy="Remove them."
            )


MOST_NOTICES = 200
"""Limit of notices: longer receipts are useless."""


def note(notices: list[Notice], kind: str, what: str, at: Place | None = None) -> None:
    """Append a notice, unless there are too many or the same one exists."""
    notice = Notice(kind, what, at)
    if len(notices) < MOST_NOTICES and notice not in notices:
        notices.append(notice)


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """Information about a file from the user.

    encoding: Python codec for text that is not UTF-8. translation: of BVH position channels: "auto", "absolute" (they
    replace the OFFSET) or "relative" (they add to it). take: which motion of a file that holds several. rate: frames a
    second at which keys are sampled, where the file has no rate or another is wanted.
    """

    encoding: str | None = None
    translation: str = "auto"
    take: str | None = None
    rate: float | None = None
    limits: Limits = field(default_factory=Limits)


@dataclass(frozen=True, slots=True)
class SourceFile:
    """A file to read. stream: seekable, read from its beginning; the caller closes it after the last block.

    notices: guesses about the file itself, such as the encoding of its name.
    """

    name: str
    stream: BinaryIO
    notices: tuple[Notice, ...] = ()

    @contextmanager
    def blamed(self) -> Iterator[None]:
        """Add the name of this file to errors raised in the block."""
        try:
            yield
        except McmlError as error:
            raise error.in_file(self.name) from None


class Writer(Protocol):
    """A file format that clips leave in.

    name: as in the catalogue. title, label: for people, the label short. convention: the only one that `write` takes,
    None where it takes any. media_type: of its files. bodies, markers: which documents it can hold. needs: facts
    without which a document is not written, of "frame_time", "unit", "force_plates" and "blend_shapes". assumes: the
    unit that programs take the numbers for where the document states none, "" where they take none.
    """

    @property
    def name(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def label(self) -> str: ...
    @property
    def parts(self) -> tuple[FileKind, ...]: ...
    @property
    def convention(self) -> Convention | None: ...
    @property
    def media_type(self) -> str: ...
    @property
    def bodies(self) -> bool: ...
    @property
    def markers(self) -> bool: ...
    @property
    def needs(self) -> frozenset[str]: ...
    @property
    def assumes(self) -> str: ...

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        """One part of the clip as bytes.

        Raises ConversionError if the clip has another convention. Losses are appended to `clip.notices`.
        """
        ...


class Reader(Protocol):
    """A file format that is read.

    name: as in the catalogue. title, label: for people, the label short. states: facts of a document that its files
    hold, of "unit", "up", "frame_time", "force_plates" and "blend_shapes".
    """

    @property
    def name(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def label(self) -> str: ...
    @property
    def parts(self) -> tuple[FileKind, ...]: ...
    @property
    def media_type(self) -> str: ...
    @property
    def states(self) -> frozenset[str]: ...

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        """Recognise the part of a file by its first bytes (at least 4 kB or all) and its name; None for another
        format.
        """
        ...

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        """The clip that the files, by part, hold. The frames are read when `blocks()` is iterated.

        Raises FormatError (also while frames are read), UnsupportedError, LimitError; each with file, line, column.
        """
        ...


@runtime_checkable
class TakesReader(Reader, Protocol):
    """A format whose files may hold several motions."""

    def takes(self, files: Mapping[str, SourceFile], options: ReadOptions) -> tuple[str, ...]:
        """The names of the motions, each unique; `ReadOptions.take` chooses one. Raises as `read` does."""
        ...


@runtime_checkable
class CharacterReader(Reader, Protocol):
    """A format whose files may hold a character: a mesh with a skin."""

    def read_character(self, files: Mapping[str, SourceFile], options: ReadOptions) -> RiggedCharacter | None:
        """The skinned meshes of the files as one, None where they have none. Raises as `read` does, and LimitError for
        meshes of too many vertices."""
        ...

    def count_vertices(self, stream: BinaryIO) -> int:
        """The number of vertices of the skinned meshes of a file; 0 for damaged ones."""
        ...


class Format(Reader, Writer, Protocol):
    """A file format that is read and written."""

    @property
    def convention(self) -> Convention: ...


def need_seconds(head: ClipHead, title: str) -> float:
    """Return the frame time in seconds. Raises ConversionError if it is unknown: writers never guess it."""
    seconds = head.seconds_per_frame()
    if seconds is None:
        raise ConversionError(
            f"{title} says how fast frames follow, and the document does not",
            remedy="Export it with `frame_time`, the seconds of a frame, or state that once: mcml set ID --frame-time.",
        )
    return seconds


def need_convention(skeleton: Skeleton, convention: Convention, title: str) -> None:
    """Raises ConversionError where a joint is in another convention than the format's."""
    for joint in skeleton.joints:
        if joint.convention is not convention:
            raise ConversionError(
                f"joint {joint.name!r} is in the convention {joint.convention.value!r}, {title} writes "
                f"{convention.value!r}",
                remedy="Convert the clip first.",
            )
