"""ASF: Acclaim's skeleton files to skeletons. See docs/formats/asf-amc.md.

Line oriented; `#` begins a comment; commas and brackets are white space. Angles and lengths are kept as written.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import BinaryIO

from mcml.errors import FormatError, LimitError, Notice, Place
from mcml.formats.asf_amc.tree import Bone, Word, build_skeleton
from mcml.formats.format import Limits, note
from mcml.formats.text.lines import BLANKS, Encoding, Line, Lines, shown
from mcml.formats.text.numbers import is_number, what_is_wrong
from mcml.motion.skeleton import Skeleton, Triple

CHANNEL_OF_DOF = {f"{kind}{axis}": f"{kind.upper()}{axis}" for kind in "tr" for axis in "xyz"} | {"l": "SF"}
DEFAULT_ROOT_ORDER = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz")
ORDERS = frozenset({"XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"})
_BRACKETS = str.maketrans("(),", "   ")
_INFINITE = re.compile(r"[+-]?inf(inity)?", re.IGNORECASE)
_BONE_FIELDS = frozenset({"id", "name", "direction", "length", "axis", "dof", "limits", "bodymass", "cofmass"})


@dataclass
class AsfFile:
    """The content of an ASF other than the skeleton.

    fields: as ClipHead.fields. keywords: section lines in their order.
    """

    skeleton: Skeleton
    fields: dict[str, str] = field(default_factory=dict)
    keywords: list[str] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)
    sections: list[tuple[str, str]] = field(default_factory=list)


def read_asf(stream: BinaryIO, encoding: Encoding, limits: Limits, notices: list[Notice]) -> AsfFile:
    """The skeleton file. Raises FormatError and LimitError with line and column."""
    return _Reader(Lines(stream, encoding), limits, notices).read()


class _Reader:
    def __init__(self, lines: Lines, limits: Limits, notices: list[Notice]) -> None:
        self.lines = lines
        self.limits = limits
        self.notices = notices
        self.text = 0
        self.file = AsfFile(Skeleton(()))
        self.root: Bone | None = None
        self.bones: list[Bone] | None = None
        self.hierarchy: list[list[Word]] | None = None

    def read(self) -> AsfFile:
        for line in self.lines:
            text = self._without_comment(line).strip(BLANKS)
            if not text:
                continue
            if not text.startswith(":"):
                found = shown(text)
                raise FormatError(
                    f"expected a section such as :version, found {found}", at=line.at(1), remedy="This is no ASF file."
                )
            self._read_section(text, line)
        if self.root is None:
            raise self._missing(":root")
        if self.bones is None:
            raise self._missing(":bonedata")
        if self.hierarchy is None:
            raise self._missing(":hierarchy")
        if "units_angle" not in self.file.fields:
            note(self.notices, "guess", "the ASF states no unit of angle: its own angles count as degrees")
        self.file.skeleton = build_skeleton(self.root, self.bones, self.hierarchy, self.limits, self.notices)
        return self.file

    def _missing(self, section: str) -> FormatError:
        return FormatError(f"ASF section {section} is missing", at=self.lines.here, remedy="Send the whole file.")

    def _read_section(self, text: str, line: Line) -> None:
        keyword, _, value = text.partition(" ") if " " in text else text.partition("\t")
        value = value.strip(BLANKS)
        name = keyword.lower()
        known = name in (":version", ":name", ":units", ":root", ":bonedata", ":hierarchy")
        if known and name in (item.lower() for item in self.file.keywords):
            raise FormatError(f"section {keyword} occurs twice", at=line.at(1))
        self.file.keywords.append(keyword)
        if name == ":version":
            self.file.fields["version"] = value
        elif name == ":name":
            self.file.fields["skeleton_name"] = value
        elif name == ":units":
            self._read_units(value, line)
        elif name == ":root":
            self.root = self._read_root()
        elif name == ":bonedata":
            self.bones = self._read_bones()
        elif name == ":hierarchy":
            self.hierarchy = self._read_hierarchy()
        else:
            self._count_text(line)
            self.file.sections.append((text, "\n".join(self._verbatim())))
            if name not in (":documentation", ":skin"):
                note(self.notices, "note", f"section {keyword} is kept and means nothing here", at=line.at(1))

    def _without_comment(self, line: Line) -> str:
        text, sign, comment = line.text.partition("#")
        if sign:
            self.file.comments.append((sign + comment).rstrip(BLANKS))
            self._count_text(line)
        return text

    def _verbatim(self) -> Iterator[str]:
        while (line := self.lines.peek()) is not None and not line.text.lstrip(BLANKS).startswith(":"):
            self.lines.next()
            self._count_text(line)
            yield line.text

    def _count_text(self, line: Line) -> None:
        # An empty line costs memory too.
        self.text += len(line.text) + 64
        self.limits.check_text(self.text, line.at())

    def _body(self) -> Iterator[list[Word]]:
        """The words of each line up to the next section."""
        while (line := self.lines.peek()) is not None and not line.text.lstrip(BLANKS).startswith(":"):
            self.lines.next()
            text = self._without_comment(line).translate(_BRACKETS)
            words = [Word(m.group(), line.at(m.start() + 1)) for m in re.finditer(r"\S+", text, re.ASCII)]
            if words:
                yield words

    def _read_units(self, value: str, line: Line) -> None:
        lines = list(self._body())
        if value:
            lines.insert(0, [Word(word, line.at()) for word in value.translate(_BRACKETS).split()])
        for words in lines:
            for name, number in zip(words[::2], words[1::2], strict=False):
                self._read_unit(name, number)
                if len(words) > 2 and words[2].text.lower() not in ("mass", "length", "angle"):
                    rest = " ".join(word.text for word in words[2:])
                    note(self.notices, "warning", f"units: {shown(rest)} behind {name.text} is ignored", at=name.at)
                    break

    def _read_unit(self, name: Word, value: Word) -> None:
        unit = name.text.lower()
        if unit in ("mass", "length"):
            _need_number(value, f"units {unit}")
        elif unit == "angle":
            if value.text.lower()[:3] not in ("deg", "rad"):
                raise FormatError(f"units angle: found {shown(value.text)}, expected deg or rad", at=value.at)
        else:
            note(self.notices, "warning", f"units: {shown(name.text)} is unknown and ignored", at=name.at)
            return
        self.file.fields[f"units_{unit}"] = value.text

    def _read_root(self) -> Bone:
        root = Bone(self.lines.here, name="root")
        for words in self._body():
            keyword, values = words[0].text.lower(), words[1:]
            if keyword == "order":
                root.channels = self._channels(values, "root")
            elif keyword == "axis":
                root.axis_order = _axis_order(values[0], "root") if values else ""
            elif keyword == "position":
                root.position = _triple(values, "position of the root", words[0].at)
            elif keyword == "orientation":
                root.axis = _triple(values, "orientation of the root", words[0].at)
            else:
                note(self.notices, "warning", f"root: {shown(words[0].text)} is unknown, ignored", at=words[0].at)
        if not root.channels:
            root.channels = DEFAULT_ROOT_ORDER
            note(self.notices, "guess", "the root states no order: TX TY TZ RX RY RZ", at=root.at)
        if any(root.axis or ()) and any(float(text) for text in root.axis or ()):
            note(
                self.notices,
                "warning",
                "the root is rotated in the rest pose (orientation); programs interpret that differently",
            )
        return root

    def _read_bones(self) -> list[Bone]:
        bones: list[Bone] = []
        bone: Bone | None = None
        in_limits = False
        pending: list[Word] = []
        for words in self._body():
            keyword = words[0].text.lower()
            if in_limits and (is_number(words[0].text) or _INFINITE.fullmatch(words[0].text)):
                pending += words
                if len(pending) > 1000:
                    raise FormatError(f"limits of bone {shown(bone.name if bone else '')} do not end", at=words[0].at)
                continue
            if bone is not None and in_limits:
                self._set_limits(bone, pending)
            in_limits = False
            if keyword == "begin":
                if bone is not None:
                    raise _not_closed(bone, words[0].at)
                if len(bones) >= self.limits.joints:
                    raise LimitError(f"the skeleton has more than {self.limits.joints} bones", at=words[0].at)
                bone = Bone(words[0].at)
                words = words[1:]
                if not words:
                    continue
                keyword = words[0].text.lower()
            if bone is None:
                raise FormatError(f"expected begin, found {shown(words[0].text)}", at=words[0].at)
            if keyword == "end":
                self._check_bone(bone)
                bones.append(bone)
                bone = None
            elif keyword == "limits":
                in_limits, pending = True, words[1:]
            else:
                self._read_field(bone, keyword, words)
        if bone is not None:
            raise _not_closed(bone, self.lines.here)
        return bones

    def _read_field(self, bone: Bone, keyword: str, words: list[Word]) -> None:
        values, at = words[1:], words[0].at
        what = f"bone {bone.name or '?'!r}"
        if keyword not in _BONE_FIELDS:
            note(self.notices, "warning", f"{what}: {shown(words[0].text)} is unknown and ignored", at=at)
            return
        if keyword == "dof":
            bone.channels = self._channels(values, what)
            return
        if not values:
            raise FormatError(f"{what}: {keyword} has no value", at=at)
        if keyword == "name":
            self.limits.check_name(values[0].text, at)
            bone.name = values[0].text
        elif keyword == "id":
            bone.id = values[0].text
        elif keyword == "direction":
            bone.direction = _triple(values, f"direction of {what}", at)
        elif keyword == "axis":
            bone.axis = _triple(values[:3], f"axis of {what}", at)
            bone.axis_order = _axis_order(values[3], what) if len(values) > 3 else ""
            if not bone.axis_order:
                bone.axis_order = "XYZ"
                note(self.notices, "guess", f"{what}: axis names no order, read as XYZ", at=at)
        else:
            _need_number(values[0], f"{keyword} of {what}")
            setattr(bone, keyword, values[0].text)
            if len(values) > 1:
                rest = " ".join(word.text for word in values[1:])
                note(self.notices, "warning", f"{what}: {shown(rest)} behind {keyword} is ignored", at=values[1].at)

    def _channels(self, words: list[Word], what: str) -> tuple[str, ...]:
        channels: list[str] = []
        for word in words:
            channel = CHANNEL_OF_DOF.get(word.text.lower())
            if channel is None:
                raise FormatError(
                    f"{what}: unknown degree of freedom {shown(word.text)}",
                    at=word.at,
                    remedy="Use tx ty tz rx ry rz l.",
                )
            if channel in channels:
                raise FormatError(f"{what}: degree of freedom {shown(word.text)} occurs twice", at=word.at)
            channels.append(channel)
        return tuple(channels)

    def _set_limits(self, bone: Bone, words: list[Word]) -> None:
        for word in words:
            if not _INFINITE.fullmatch(word.text):
                _need_number(word, f"limits of bone {bone.name!r}")
        texts = [word.text for word in words]
        bone.limits = tuple(" ".join(texts[place : place + 2]) for place in range(0, len(texts), 2))

    def _check_bone(self, bone: Bone) -> None:
        if not bone.name:
            raise FormatError("a bone has no name", at=bone.at)
        if bone.name.lower() == "root":
            raise FormatError("a bone is called root, which is the name of the root", at=bone.at)
        if bone.length is None:
            raise FormatError(f"bone {bone.name!r} has no length", at=bone.at)
        if bone.direction is None:
            raise FormatError(f"bone {bone.name!r} has no direction", at=bone.at, remedy="Write direction x y z.")
        if not any(float(text) for text in bone.direction) and float(bone.length) != 0:
            raise FormatError(
                f"bone {bone.name!r}: direction is the zero vector", at=bone.at, remedy="Write where the bone points."
            )
        if len(bone.limits) != len(bone.channels) and bone.channels:
            count = f"{len(bone.limits)} limits for {len(bone.channels)} degrees of freedom"
            note(self.notices, "warning", f"bone {bone.name!r} has {count}", at=bone.at)

    def _read_hierarchy(self) -> list[list[Word]]:
        lines: list[list[Word]] = []
        count = 0
        for words in self._body():
            if words[0].text.lower() in ("begin", "end") and len(words) == 1:
                continue
            lines.append(words)
            count += len(words)
            # Every bone appears once as a child, and at most once as the parent of each.
            if count > 2 * self.limits.joints + 2:
                raise LimitError(f"the hierarchy has more than {self.limits.joints} bones", at=words[0].at)
        return lines


def _not_closed(bone: Bone, at: Place) -> FormatError:
    return FormatError(
        f"bone {bone.name or '?'!r} opened at line {bone.at.line} is not closed", at=at, remedy="Close it with end."
    )


def _need_number(word: Word, what: str) -> None:
    if not is_number(word.text):
        raise FormatError(f"{what}: {what_is_wrong(word.text)}", at=word.at)


def _triple(words: list[Word], what: str, at: Place) -> Triple:
    if len(words) != 3:
        raise FormatError(f"{what} needs 3 numbers, found {len(words)}", at=at)
    for word in words:
        _need_number(word, what)
    return words[0].text, words[1].text, words[2].text


def _axis_order(word: Word, what: str) -> str:
    if word.text.upper() not in ORDERS:
        raise FormatError(f"{what}: axis order {shown(word.text)} is not a permutation of XYZ", at=word.at)
    return word.text
