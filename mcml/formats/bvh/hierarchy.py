"""The HIERARCHY of a BVH file: text to skeleton and back. See docs/formats/bvh.md."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from mcml.errors import FormatError, LimitError, Notice, Place
from mcml.formats.bvh.plain import CHANNEL_OF, OpenJoint, read_plain
from mcml.formats.format import Limits, note
from mcml.formats.text.lines import BLANKS, LINE_END, Encoding, Lines, Token, Tokens, shown
from mcml.formats.text.numbers import is_number, what_is_wrong
from mcml.motion.skeleton import Convention, EndSite, Joint, Skeleton, Triple, unique_names

LONGEST_SHARED: Final = 1 << 15
"""Bytes of a hierarchy that is kept for files to come; a person of 80 joints takes 10,000."""

_KEYWORDS = frozenset({"{", "}", "OFFSET", "CHANNELS", "JOINT", "ROOT", "END", "MOTION"})
_WORD_OF = {channel: f"{channel[1].upper()}{word[1:]}" for word, channel in CHANNEL_OF.items()}


@dataclass(frozen=True)
class SharedHierarchy:
    """The content of a hierarchy's text, independent of its file. lines: number of lines."""

    skeleton: Skeleton
    notices: tuple[Notice, ...]
    lines: int


@lru_cache(maxsize=64)
def shared_hierarchy(text: bytes, codec: str, limits: Limits) -> SharedHierarchy:
    """As `read_hierarchy`, of a text that holds nothing else and ends with a line."""
    notices: list[Notice] = []
    joints = None if b"\0" in text else read_plain(text.decode(codec, "replace"), limits)
    if joints is not None:
        return SharedHierarchy(_skeleton(joints, notices), tuple(notices), len(LINE_END.findall(text)))
    tokens = Tokens(Lines(io.BytesIO(text), Encoding(codec, 0)))
    skeleton = read_hierarchy(tokens, limits, notices)
    if tokens.peek() is not None:
        raise _unexpected(tokens.peek(), "MOTION", tokens)
    return SharedHierarchy(skeleton, tuple(notices), tokens.here.line or 0)


def read_hierarchy(tokens: Tokens, limits: Limits, notices: list[Notice]) -> Skeleton:
    """The skeleton; the next token is the one behind the last root's closing brace. FormatError, LimitError."""
    first = tokens.next()
    if first is None or first.text.upper() != "HIERARCHY":
        found = "an empty file" if first is None else _shown(first)
        raise FormatError(f"not a BVH file: expected HIERARCHY, found {found}", at=first.at if first else Place(line=1))
    joints: list[OpenJoint] = []
    stack: list[int] = []
    while True:
        if not stack:
            token = tokens.peek()
            if token is None or token.text.upper() != "ROOT":
                if not joints:
                    raise _unexpected(token, "ROOT", tokens)
                return _skeleton(joints, notices)
            tokens.next()
            stack.append(_open_joint(tokens, "ROOT", -1, joints, limits))
            continue
        joint = joints[stack[-1]]
        token = tokens.next()
        if token is None:
            raise FormatError(
                f"joint {joint.name!r} opened at line {joint.at.line} is not closed",
                at=tokens.here,
                remedy="The file was cut off; send it whole.",
            )
        word = token.text.upper()
        if word == "}":
            _close(joint, token)
            stack.pop()
        elif word == "OFFSET":
            if joint.offset is not None or joint.children:
                raise FormatError(f"joint {joint.name!r} has OFFSET twice or behind a child", at=token.at)
            joint.offset = _read_triple(tokens, f"OFFSET of joint {joint.name!r}")
        elif word == "CHANNELS":
            if joint.channels is not None or joint.children:
                raise FormatError(f"joint {joint.name!r} has CHANNELS twice or behind a child", at=token.at)
            joint.channels = _read_channels(tokens, joint.name)
        elif word == "JOINT":
            joint.children += 1
            if len(stack) >= limits.depth:
                raise LimitError(f"joints are nested too deep: more than {limits.depth}", at=token.at)
            stack.append(_open_joint(tokens, "JOINT", stack[-1], joints, limits))
        elif word == "END" or word.startswith("ENDSITE"):
            _read_end_site(token, tokens, joint, limits, notices)
        else:
            raise _unexpected(token, "OFFSET, CHANNELS, JOINT, End Site or }", tokens)


def _open_joint(tokens: Tokens, keyword: str, parent: int, joints: list[OpenJoint], limits: Limits) -> int:
    at = tokens.here
    name = tokens.rest_of_line()
    if name is None:
        following = tokens.peek()
        name = tokens.rest_of_line() if following is not None and following.text not in "{}" else None
    if name is None:
        raise FormatError(f"{keyword} has no name", at=at, remedy="Write the name behind it.")
    limits.check_name(name.text, name.at)
    if len(joints) >= limits.joints:
        raise LimitError(f"the skeleton has more than {limits.joints} joints", at=name.at)
    _expect(tokens, "{", f"behind the name of joint {name.text!r}")
    joints.append(OpenJoint(name.text, parent, name.at))
    return len(joints) - 1


def _close(joint: OpenJoint, token: Token) -> None:
    if joint.offset is None:
        raise FormatError(
            f"joint {joint.name!r} opened at line {joint.at.line} has no OFFSET",
            at=token.at,
            remedy="Add OFFSET x y z.",
        )


def _read_end_site(end: Token, tokens: Tokens, joint: OpenJoint, limits: Limits, notices: list[Notice]) -> None:
    """An end site: `End Site`, a name behind it, or as some programs write, `End Site4`, `End toe_End`, `EndSite`."""
    site = end
    rest = tokens.rest_of_line()
    text = "" if rest is None else rest.text
    if end.text.upper() == "END" and re.match(r"site(?!\S)", text, re.IGNORECASE):
        text = text[4:].strip(BLANKS)
    else:
        following = tokens.peek() if rest is None else None
        if end.text.upper() == "END" and rest is None and (following is None or following.text != "{"):
            raise _unexpected(following, "Site behind End", tokens)
        text = end.text[len("EndSite") :] + text if end.text.upper() != "END" else text
        note(notices, "note", f"{_shown(end)} {text} is read as an End Site".replace("  ", " "), at=end.at)
    if text:
        limits.check_name(text, site.at)
    _expect(tokens, "{", f"behind End Site of joint {joint.name!r}")
    _expect(tokens, "OFFSET", f"in End Site of joint {joint.name!r}")
    offset = _read_triple(tokens, f"OFFSET of the End Site of joint {joint.name!r}")
    _expect(tokens, "}", f"to close End Site of joint {joint.name!r}")
    if len(joint.end_sites) >= limits.joints:
        raise LimitError(f"joint {joint.name!r} has more than {limits.joints} end sites", at=site.at)
    joint.end_sites.append(EndSite(offset, text, joint.children))


def _read_triple(tokens: Tokens, what: str) -> Triple:
    words = tokens.rest_words(3)
    if len(words) == 3 and all(map(is_number, words)):
        tokens.skip_line()
        return words[0], words[1], words[2]
    lexemes = []
    for count in range(3):
        token = tokens.peek()
        if token is None or token.text.upper() in _KEYWORDS:
            raise FormatError(
                f"{what} needs 3 numbers, found {count}", at=token.at if token else tokens.here, remedy="Write x y z."
            )
        tokens.next()
        if not is_number(token.text):
            raise FormatError(f"{what}: {what_is_wrong(token.text)}", at=token.at)
        lexemes.append(token.text)
    return lexemes[0], lexemes[1], lexemes[2]


def _read_channels(tokens: Tokens, joint: str) -> tuple[str, ...]:
    count = tokens.next()
    if count is None or not (count.text.isascii() and count.text.isdigit()):
        raise _unexpected(count, f"the number of channels of joint {joint!r}", tokens)
    channels: list[str] = []
    listed = [CHANNEL_OF.get(word.lower(), "") for word in tokens.rest_words(len(CHANNEL_OF))]
    if all(listed) and len(set(listed)) == len(listed):
        tokens.skip_line()
        channels = listed
    while (token := tokens.peek()) is not None:
        word = token.text.lower()
        if word not in CHANNEL_OF and not word.endswith(("position", "rotation")):
            break
        tokens.next()
        if word not in CHANNEL_OF:
            raise FormatError(
                f"joint {joint!r}: unknown channel {_shown(token)}",
                at=token.at,
                remedy="Channels are Xposition Yposition Zposition Xrotation Yrotation Zrotation.",
            )
        if CHANNEL_OF[word] in channels:
            raise FormatError(f"joint {joint!r}: channel {token.text!r} occurs twice", at=token.at)
        channels.append(CHANNEL_OF[word])
    if len(channels) != _small(count.text):
        raise FormatError(
            f"joint {joint!r}: CHANNELS says {count.text[:20]} but lists {len(channels)}",
            at=count.at,
            remedy="Correct the number, or name every channel.",
        )
    return tuple(channels)


def _small(text: str) -> int:
    """A count; anything long is simply too many (int() of endless digits takes endless time)."""
    return int(text) if len(text) < 10 else 10**10


def _expect(tokens: Tokens, text: str, where: str) -> None:
    token = tokens.next()
    if token is None or token.text.upper() != text:
        raise _unexpected(token, f"{text} {where}", tokens)


def _unexpected(token: Token | None, expected: str, tokens: Tokens) -> FormatError:
    if token is None:
        return FormatError(f"the file ends where {expected} was expected", at=tokens.here)
    return FormatError(f"expected {expected}, found {_shown(token)}", at=token.at)


def _shown(token: Token) -> str:
    return shown(token.text)


def _skeleton(read: list[OpenJoint], notices: list[Notice]) -> Skeleton:
    names = unique_names([joint.name for joint in read])
    repeated = [joint.name for joint, name in zip(read, names, strict=True) if joint.name != name]
    if repeated:
        notices.append(Notice("warning", f"{_list(repeated)}: names used more than once; the later ones got #2, #3 …"))
    bare = [joint.name for joint in read if not joint.children and not joint.end_sites]
    if bare:
        notices.append(Notice("warning", f"{_list(bare)}: no End Site, the length of the last bone is unknown"))
    joints = []
    for joint, name in zip(read, names, strict=True):
        channels = joint.channels or ()
        joints.append(
            Joint(
                name=name,
                parent=joint.parent,
                source_name=joint.name,
                convention=Convention.LISTED,
                channels=channels,
                rotation_order="".join(channel[1].upper() for channel in channels if channel[0] == "R"),
                offset=joint.offset,
                translation="absolute" if any(channel[0] == "T" for channel in channels) else "",
                end_sites=tuple(joint.end_sites),
            )
        )
    return Skeleton(tuple(joints))


def _list(names: list[str]) -> str:
    shown = ", ".join(repr(name) for name in names[:5])
    return shown + (f" and {len(names) - 5} more" if len(names) > 5 else "")


def legal_name(name: str) -> str:
    """The name as BVH can hold it: on one line, not empty, without blanks at its ends and a brace that opens a body."""
    text = "".join("_" if char in "\0\r\n" else char for char in name).strip(BLANKS)
    legal = ""
    for index, char in enumerate(text):
        opens = char == "{" and (not index or text[index - 1] in BLANKS or index == len(text) - 1)
        legal += "_" if opens else char
    return legal or "_"


def write_hierarchy(skeleton: Skeleton, notices: list[Notice]) -> Iterator[str]:
    """The lines, HIERARCHY to the last closing brace. Names that BVH cannot hold are changed with a notice."""
    changed = [joint.source_name for joint in skeleton.joints if legal_name(joint.source_name) != joint.source_name]
    if changed:
        notices.append(Notice("warning", f"{_list(changed)}: characters that BVH cannot hold became _"))
    children: list[list[int]] = [[] for _ in skeleton.joints]
    for index, joint in enumerate(skeleton.joints):
        if joint.parent >= 0:
            children[joint.parent].append(index)
    yield "HIERARCHY"
    # Items still to be written, last first: a joint with its depth, or text.
    stack: list[tuple[int, int] | str] = [(root, 0) for root in reversed(skeleton.roots)]
    while stack:
        item = stack.pop()
        if isinstance(item, str):
            yield item
            continue
        index, depth = item
        joint = skeleton.joints[index]
        indent = "\t" * depth
        yield f"{indent}{'JOINT' if depth else 'ROOT'} {legal_name(joint.source_name)}"
        yield indent + "{"
        yield f"{indent}\tOFFSET {' '.join(joint.offset or ('0', '0', '0'))}"
        if joint.channels:
            words = " ".join(_WORD_OF[channel] for channel in joint.channels)
            yield f"{indent}\tCHANNELS {len(joint.channels)} {words}"
        body: list[tuple[int, int] | str] = []
        for place, child in enumerate(children[index]):
            body += _end_sites(joint, indent, range(place, place + 1))
            body.append((child, depth + 1))
        body += _end_sites(joint, indent, range(len(children[index]), len(skeleton) + 1))
        stack += [indent + "}", *reversed(body)]


def _end_sites(joint: Joint, indent: str, places: range) -> list[str]:
    """Return the lines of the end sites before a number of children."""
    lines = []
    for site in joint.end_sites:
        if site.before in places:
            name = f" {legal_name(site.name)}" if site.name else ""
            lines += [f"{indent}\tEnd Site{name}", f"{indent}\t{{", f"{indent}\t\tOFFSET {' '.join(site.offset)}"]
            lines.append(f"{indent}\t}}")
    return lines
