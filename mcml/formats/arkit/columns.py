"""The head of the table: which columns are blend shapes, and which are angles of head and eyes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mcml.errors import FormatError, Place
from mcml.formats.arkit.names import ANGLES, TURNING
from mcml.formats.format import Limits
from mcml.motion.skeleton import Convention, Joint, Skeleton, unique_names

FIRST = ("timecode", "blendshapecount")
"""The first two columns, in lower case."""


@dataclass(frozen=True)
class Columns:
    """skeleton: head, eyes and blend shapes. cells: index of the cell of each of its columns. width: cells of a row."""

    skeleton: Skeleton
    cells: tuple[int, ...]
    width: int


def find_columns(names: Sequence[str], limits: Limits) -> Columns:
    """The columns by the names in the head of the table, in any order and any case. Raises FormatError, LimitError."""
    if tuple(name.lower() for name in names[:2]) != FIRST:
        raise FormatError("the first line does not begin with Timecode, BlendShapeCount", at=Place(line=1))
    place = {name.lower(): index for index, name in enumerate(names)}
    if len(place) != len(names):
        twice = next(name for index, name in enumerate(names) if place[name.lower()] != index)
        raise FormatError(
            f"the first line names {twice!r} twice", at=Place(line=1), remedy="Remove one of the columns."
        )
    joints: list[Joint] = []
    cells: list[int] = []
    used: set[int] = set(range(len(FIRST)))
    for name, prefix in TURNING.items():
        named = {channel: (prefix + angle).lower() for angle, channel in ANGLES.items()}
        found = {channel: place[column] for channel, column in named.items() if column in place}
        if found:
            parent = 0 if joints and joints[0].source_name == "head" else -1
            joints.append(_joint(name, parent, tuple(found)))
            cells += found.values()
            used |= set(found.values())
    parent = 0 if joints and joints[0].source_name == "head" else -1
    shapes = [index for index in range(len(names)) if index not in used]
    limits.check_points([names[index] for index in shapes])
    unique = unique_names([*(joint.name for joint in joints), *(names[index] for index in shapes)])[len(joints) :]
    for name, index in zip(unique, shapes, strict=True):
        joints.append(Joint(name, parent, names[index], Convention.BLEND_SHAPE, ("weight",)))
        cells.append(index)
    if not joints:
        raise FormatError("the first line names no blend shape", at=Place(line=1), remedy="Send the whole table.")
    return Columns(Skeleton(tuple(joints)), tuple(cells), len(names))


def _joint(name: str, parent: int, channels: tuple[str, ...]) -> Joint:
    order = "".join(channel[1].upper() for channel in channels)
    return Joint(name, parent, name, Convention.LISTED, channels, order, offset=("0", "0", "0"))
