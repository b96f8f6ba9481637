"""The head of an HTR file: header, hierarchy, base position. See docs/formats/htr.md."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import BinaryIO

from mcml.errors import FormatError, LimitError, Notice, Place, UnsupportedError
from mcml.formats.format import Limits, note
from mcml.formats.text.lines import BLANKS, Encoding, Line, Lines, shown
from mcml.formats.text.numbers import is_number, is_whole, what_is_wrong
from mcml.motion.skeleton import Convention, Joint, Skeleton

FIELD_OF_KEYWORD = {
    "filetype": "filetype",
    "datatype": "datatype",
    "fileversion": "version",
    "numsegments": "num_segments",
    "numframes": "num_frames",
    "dataframerate": "dataframe_rate",
    "eulerrotationorder": "euler_rotation_order",
    "calibrationunits": "calibration_unit",
    "rotationunits": "units_angle",
    "globalaxisofgravity": "global_axis_of_gravity",
    "bonelengthaxis": "bone_length_axis",
    "scalefactor": "scale_factor",
}
CHANNELS = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz", "SF")
GLOBAL = "GLOBAL"
_ORDERS = frozenset({"XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"})
_SECTION = re.compile(r"\[([^\]]*)\]")
_HIERARCHY = "segmentnames&hierarchy"


@dataclass
class HtrHead:
    """fields: as ClipHead.fields. data: byte offset of the first line behind the head. version: 1 or 2."""

    skeleton: Skeleton = field(default_factory=lambda: Skeleton(()))
    fields: dict[str, str] = field(default_factory=dict)
    keywords: list[str] = field(default_factory=list)
    unknown: list[tuple[str, str]] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)
    data: int = 0
    version: int = 1
    frames: int = 0


@dataclass(frozen=True, slots=True)
class _Row:
    words: list[str]
    at: Place


def read_head(stream: BinaryIO, encoding: Encoding, limits: Limits, notices: list[Notice]) -> HtrHead:
    """Everything before the motion. Raises FormatError, LimitError, UnsupportedError (GTR) with the line."""
    head = HtrHead()
    sections: dict[str, list[_Row]] = {}
    current: list[_Row] | None = None
    lines = Lines(stream, encoding)
    kept = 0
    while (line := lines.peek()) is not None:
        text = _without_comment(line, head)
        kept += len(line.text) + 64 if "#" in line.text else 0
        limits.check_text(kept, line.at())
        section = _SECTION.fullmatch(text)
        if section:
            name = section[1].strip().lower()
            # Some programs call the first section so; behind it, it is the segment of that name.
            name = "header" if name == "head" and not sections else name
            if name not in ("header", _HIERARCHY, "baseposition"):
                break
            if name in sections:
                raise FormatError(f"section [{section[1]}] occurs twice", at=line.at(1))
            current = sections.setdefault(name, [])
        elif re.match(r"frame\s+[0-9]+\s*:?$", text, re.IGNORECASE) and "baseposition" in sections:
            break
        elif text:
            if current is None:
                raise FormatError(
                    f"HTR section [Header] is missing, found {shown(text)}",
                    at=line.at(1),
                    remedy="This is no HTR file.",
                )
            if len(current) > limits.joints + 1000:
                raise LimitError(f"a section has more than {limits.joints} lines", at=line.at(1))
            current.append(_Row(re.findall(r"\S+", text, re.ASCII), line.at(1)))
        lines.next()
    head.data = line.start if line is not None else stream.seek(0, 2)
    for name, title in (("header", "Header"), (_HIERARCHY, "SegmentNames&Hierarchy"), ("baseposition", "BasePosition")):
        if name not in sections:
            raise FormatError(f"HTR section [{title}] is missing", at=lines.here, remedy="Send the whole file.")
    _read_header(sections["header"], head, notices)
    _read_segments(sections[_HIERARCHY], sections["baseposition"], head, limits, lines.here, notices)
    return head


def _without_comment(line: Line, head: HtrHead) -> str:
    text, sign, comment = line.text.partition("#")
    if sign:
        head.comments.append((sign + comment).rstrip(BLANKS))
    return text.strip(BLANKS)


def _read_header(rows: list[_Row], head: HtrHead, notices: list[Notice]) -> None:
    places: dict[str, Place] = {}
    for row in rows:
        keyword, value = row.words[0], " ".join(row.words[1:])
        if not value:
            raise FormatError(f"header: {keyword} has no value", at=row.at)
        name = FIELD_OF_KEYWORD.get(keyword.lower())
        if name is None:
            head.unknown.append((f"[Header] {keyword}", value))
            note(notices, "note", f"header keyword {shown(keyword)} is kept and means nothing here", at=row.at)
            continue
        if name in head.fields:
            if head.fields[name] != value:
                raise FormatError(
                    f"header: {keyword} is first {shown(head.fields[name])}, then {shown(value)}", at=row.at
                )
            continue
        head.fields[name] = value
        head.keywords.append(keyword)
        places[name] = row.at
    _check_header(head, places, notices)


def _check_header(head: HtrHead, places: dict[str, Place], notices: list[Notice]) -> None:
    fields = head.fields
    kind = fields.get("filetype", "htr").lower()
    if kind.startswith("gtr") or fields.get("datatype", "HTRS").upper().startswith("GTR"):
        raise UnsupportedError(
            "a GTR file holds positions and rotations in the world, without hierarchy: not read",
            at=places.get("filetype") or places.get("datatype"),
            remedy="Export the motion as HTR.",
        )
    if kind != "htr":
        raise FormatError(f"FileType is {shown(fields['filetype'])}, expected htr", at=places["filetype"])
    version = fields.get("version", "1")
    if not is_number(version) or float(version) not in (1, 2):
        raise UnsupportedError(f"FileVersion {shown(version)} is unknown, 1 and 2 are read", at=places.get("version"))
    head.version = int(float(version))
    for name, title in (("num_segments", "NumSegments"), ("num_frames", "NumFrames")):
        if name not in fields:
            raise FormatError(f"header: {title} is missing")
        if not is_whole(fields[name]) or int(fields[name]) < 0:
            raise FormatError(f"{title} {shown(fields[name])} is not a count", at=places[name])
    head.frames = int(fields["num_frames"])
    order = fields.get("euler_rotation_order")
    if order is None:
        fields_order = Notice("guess", "the header states no EulerRotationOrder: ZYX")
        notices.append(fields_order)
    elif order.upper() not in _ORDERS:
        raise FormatError(
            f"EulerRotationOrder {shown(order)} is not a permutation of XYZ", at=places["euler_rotation_order"]
        )
    for name, title in (("dataframe_rate", "DataFrameRate"), ("scale_factor", "ScaleFactor")):
        if name in fields and not is_number(fields[name]):
            raise FormatError(f"{title}: {what_is_wrong(fields[name])}", at=places[name])
    if float(fields.get("dataframe_rate", "0")) <= 0:
        notices.append(Notice("warning", "the header states no frame rate"))
    if float(fields.get("scale_factor", "1")) != 1:
        factor = fields["scale_factor"]
        notices.append(
            Notice("warning", f"ScaleFactor is {factor}: kept; lengths are multiplied by it only in a conversion")
        )
    for name, title in (("global_axis_of_gravity", "GlobalAxisofGravity"), ("bone_length_axis", "BoneLengthAxis")):
        if name in fields and fields[name].upper() not in ("X", "Y", "Z"):
            raise FormatError(f"{title} {shown(fields[name])} is not X, Y or Z", at=places[name])
    if "units_angle" not in fields:
        notices.append(Notice("guess", "the header states no RotationUnits: Degrees"))
    elif fields["units_angle"].lower()[:3] not in ("deg", "rad"):
        raise FormatError(
            f"RotationUnits {shown(fields['units_angle'])} are not Degrees or Radians", at=places["units_angle"]
        )


def _read_segments(
    hierarchy: list[_Row], base: list[_Row], head: HtrHead, limits: Limits, end: Place, notices: list[Notice]
) -> None:
    if len(hierarchy) > limits.joints:
        raise LimitError(f"the skeleton has more than {limits.joints} segments", at=hierarchy[limits.joints].at)
    if len(hierarchy) != int(head.fields["num_segments"]):
        raise FormatError(
            f"NumSegments says {head.fields['num_segments']}, the hierarchy lists {len(hierarchy)}",
            at=hierarchy[-1].at if hierarchy else end,
        )
    index_of: dict[str, int] = {}
    for number, row in enumerate(hierarchy):
        if len(row.words) != 2:
            raise FormatError(f"hierarchy: expected a segment and its parent, found {len(row.words)} words", at=row.at)
        limits.check_name(row.words[0], row.at)
        if row.words[0] in index_of:
            raise FormatError(f"segment {shown(row.words[0])} occurs twice in the hierarchy", at=row.at)
        index_of[row.words[0]] = number
    children: dict[int, list[int]] = {number: [] for number in range(-1, len(hierarchy))}
    for number, row in enumerate(hierarchy):
        parent = row.words[1]
        if parent not in index_of and parent.upper() != GLOBAL:
            raise FormatError(f"segment {shown(row.words[0])}: parent {shown(parent)} is unknown", at=row.at)
        children[index_of.get(parent, -1)].append(number)
    if hierarchy and not children[-1]:
        raise FormatError("no segment has the parent GLOBAL", at=hierarchy[0].at, remedy="Write GLOBAL as its parent.")
    bases = _read_base(base, index_of, end)
    order: list[int] = []
    joints: list[Joint] = []
    stack = [(number, -1, 1) for number in reversed(children[-1])]
    while stack:
        number, parent_joint, depth = stack.pop()
        if depth > limits.depth:
            raise LimitError(f"segments are nested too deep: more than {limits.depth}", at=hierarchy[number].at)
        order.append(number)
        joints.append(_joint(hierarchy[number].words[0], parent_joint, bases[number], head))
        stack += [(child, len(order) - 1, depth + 1) for child in reversed(children[number])]
    if len(order) < len(hierarchy):
        reached = set(order)
        left = next(number for number in range(len(hierarchy)) if number not in reached)
        raise FormatError(f"hierarchy: cycle at {shown(hierarchy[left].words[0])}", at=hierarchy[left].at)
    place = {number: index for index, number in enumerate(order)}
    declared = tuple(place[number] for number in range(len(order)))
    head.skeleton = Skeleton(tuple(joints), () if declared == tuple(range(len(joints))) else declared)


def _read_base(rows: list[_Row], index_of: dict[str, int], end: Place) -> dict[int, list[str]]:
    bases: dict[int, list[str]] = {}
    for row in rows:
        name, values = row.words[0], row.words[1:]
        if len(values) != 7:
            raise FormatError(
                f"BasePosition of {shown(name)} has {len(row.words)} fields, "
                "expected 8 (name Tx Ty Tz Rx Ry Rz BoneLength)",
                at=row.at,
            )
        if name not in index_of:
            raise FormatError(f"BasePosition: segment {shown(name)} is not in the hierarchy", at=row.at)
        if index_of[name] in bases:
            raise FormatError(f"BasePosition: segment {shown(name)} occurs twice", at=row.at)
        for value in values:
            if not is_number(value):
                raise FormatError(f"BasePosition of {shown(name)}: {what_is_wrong(value)}", at=row.at)
        bases[index_of[name]] = values
    for name, number in index_of.items():
        if number not in bases:
            raise FormatError(f"BasePosition: segment {shown(name)} is missing", at=end)
    return bases


def _joint(name: str, parent: int, base: list[str], head: HtrHead) -> Joint:
    order = head.fields.get("euler_rotation_order", "ZYX")
    return Joint(
        name=name,
        parent=parent,
        source_name=name,
        convention=Convention.BASE,
        channels=CHANNELS,
        rotation_order=order.upper(),
        offset=(base[0], base[1], base[2]),
        length=base[6],
        axis=(base[3], base[4], base[5]),
        axis_order=order.upper(),
    )
