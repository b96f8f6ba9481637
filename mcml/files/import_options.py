"""Options of an import."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from mcml.errors import DocumentError, RequestError
from mcml.files.limits import FileLimits
from mcml.formats.format import Limits, ReadOptions
from mcml.formats.repairs import REPAIRS


@dataclass(frozen=True)
class Label:
    """A motion name for frames first to last; None: from the beginning, to the end."""

    name: str
    first: int | None = None
    last: int | None = None


@dataclass(frozen=True)
class ImportOptions:
    """Information about the files from the user. Nothing else is assumed: no unit, axis or rate.

    name: of the document, if there is one; default the file name's stem.
    frame_time: seconds, as `check_frame_time` takes them.
    skeleton: uuid of a stored document whose skeleton is used for motion without one.
    aliases: (name in files, MCML's name) that the project adds; `import_files` looks them up.
    movements: name anatomical movements that are found in the motion with at least this confidence, 0 to 1.
    repair: repairs of text files that are made before they are read (`formats.repairs`).
    take: which motion of files that hold several; all of them where it is None. rate: frames a second at which keys are
    sampled, where a file has no rate or another is wanted.
    on_duplicate: "new" (store again, name the twin in the receipt) or "skip" (answer the stored twin).
    """

    project: str = "default"
    name: str | None = None
    description: str = ""
    labels: tuple[Label, ...] = ()
    properties: tuple[tuple[str, str, str], ...] = ()
    encoding: str | None = None
    translation: str = "auto"
    unit: str | None = None
    up: str | None = None
    frame_time: str | float | None = None
    skeleton: str | None = None
    on_duplicate: str = "new"
    strict_names: bool = False
    movements: float | None = None
    aliases: tuple[tuple[str, str], ...] = ()
    repair: tuple[str, ...] = ()
    take: str | None = None
    rate: float | None = None

    def for_reader(self, limits: FileLimits, take: str | None = None) -> ReadOptions:
        """The options of a reader. take: of the clip, where its file holds several."""
        return ReadOptions(
            encoding=self.encoding,
            translation=self.translation,
            take=take,
            rate=self.rate,
            limits=Limits(joints=limits.joints, frames=limits.frames, values=limits.values),
        )


def checked_repairs(names: Sequence[str]) -> tuple[str, ...]:
    """Check names of repairs. Raises RequestError for an unknown one."""
    for name in names:
        if name not in REPAIRS:
            raise RequestError(f"There is no repair {name!r}.", remedy=f"There are: {', '.join(REPAIRS)}.")
    return tuple(names)


def parse_label(text: str) -> Label:
    """NAME or NAME:FIRST-LAST. DocumentError for anything else behind a colon: it is no part of a name."""
    name, colon, frames = text.strip().rpartition(":")
    if not colon and frames:
        return Label(frames)
    match = re.fullmatch(r"([0-9]{1,12})-([0-9]{1,12})", frames.strip())
    if match is None or not name.strip():
        one = re.fullmatch(r"[1-9][0-9]{0,11}", frames.strip())
        right = f"{name.strip()}:{one[0]}-{one[0]}" if one and name.strip() else "walk:1-120"
        raise DocumentError(
            f"{text!r} is not a label.",
            remedy=f"Write NAME for all frames, or NAME:FIRST-LAST, such as {right}: positions from 1, both included.",
        )
    first, last = int(match[1]), int(match[2])
    if not 1 <= first <= last:
        raise DocumentError(
            f"The label {text!r} begins at frame {first} and ends at {last}.",
            remedy="Frames are numbered from 1, and the first is before the last: NAME:FIRST-LAST.",
        )
    return Label(name.strip(), first, last)


def parse_property(text: str) -> tuple[str, str, str]:
    """NAME=VALUE or NAME=NUMBER UNIT."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise DocumentError(f"{text!r} is not a property.", remedy="Write NAME=VALUE, such as `age=23 year`.")
    number = re.fullmatch(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s+(\S+)\s*", value)
    return (name.strip(), number[1], number[2]) if number else (name.strip(), value.strip(), "")
