"""BVH: Biovision's hierarchy and motion in one file.

Source: M. Meredith and S. Maddock, "Motion Capture File Formats Explained" (University of Sheffield, CS-01-11, 2001);
this program's reading of it is in docs/formats/bvh.md.

Reading takes the skeleton, then turns the motion block by block into arrays; nothing but the head is held. Angles are
degrees; the unit of length and the axes are not in the file and stay unknown.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import BinaryIO

from mcml.errors import FormatError, LimitError, Notice
from mcml.formats.bvh.hierarchy import LONGEST_SHARED, read_hierarchy, shared_hierarchy, write_hierarchy
from mcml.formats.bvh.motion import Motion
from mcml.formats.bvh.translation import guess_translation
from mcml.formats.format import FileKind, Limits, ReadOptions, SourceFile, need_convention, need_seconds, note
from mcml.formats.text.lines import Encoding, Lines, Token, Tokens, detect_encoding, encoded, shown
from mcml.formats.text.number_text import detect_style, rows_of_text
from mcml.formats.text.numbers import is_number, is_whole, what_is_wrong
from mcml.motion.clip import ClipHead, ClipStream, SourcePart
from mcml.motion.layout import Held, count_frames
from mcml.motion.lexemes import lexeme
from mcml.motion.skeleton import Convention, Skeleton

_MOTION = re.compile(rb"\bMOTION\s+Frames\b", re.IGNORECASE)
_MOTION_LINE = re.compile(rb"^MOTION\s+Frames\b", re.IGNORECASE | re.MULTILINE)
_COMMENTS = re.compile(rb"\A(?:[ \t]*(?:(?:#|//)[^\r\n]*)?[\r\n]+)+")
_NO_TIME = "0.00833333"
"""Of a pose, or of a skeleton alone, which take no time, but readers want one."""


class Bvh:
    """The format `bvh`; see `mcml.formats.format.Format`."""

    name = "bvh"
    title = "Biovision BVH"
    parts = (FileKind("bvh", (".bvh",), "Skeleton and motion"),)
    convention = Convention.LISTED
    media_type = "text/plain"
    label = "BVH"
    bodies, markers = True, False
    needs = frozenset({"frame_time"})
    assumes = ""
    states = frozenset({"frame_time"})

    def sniff(self, name: str, first_bytes: bytes) -> str | None:
        words = _COMMENTS.sub(b"", first_bytes.removeprefix(b"\xef\xbb\xbf")).split(None, 1)
        return "bvh" if words and words[0].upper() == b"HIERARCHY" else None

    def read(self, files: Mapping[str, SourceFile], options: ReadOptions) -> ClipStream:
        file = files["bvh"]
        stream = file.stream
        encoding = detect_encoding(stream, options.encoding, stop=lambda block: _MOTION.search(block) is not None)
        notices = list(encoding.notices)
        skeleton, tokens = _read_skeleton(stream, encoding, options.limits, notices)
        frames, frame_time = _read_motion_head(tokens, options.limits, len(skeleton.columns()), notices)
        if tokens.passed_over:
            what = f"{tokens.passed_over} comment lines are not in the document; the kept file has them"
            note(notices, "warning", what)
        motion = Motion(stream, tokens.offset(), skeleton, frames, encoding.start)
        sample = motion.sample()
        skeleton = guess_translation(skeleton, lambda: motion.spread(sample), options.translation, notices)
        head = ClipHead(
            format=self.name,
            skeleton=skeleton,
            frame_time=frame_time,
            number_style=detect_style(sample.text, sample.bounds),
            sources=(SourcePart(part="bvh", name=file.name.rsplit("/", 1)[-1], encoding=encoding.codec),),
        )
        return ClipStream(head, lambda: motion.blocks(notices), frames, notices)

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        need_convention(clip.head.skeleton, self.convention, self.title)
        return _write(clip)


def _read_skeleton(
    stream: BinaryIO, encoding: Encoding, limits: Limits, notices: list[Notice]
) -> tuple[Skeleton, Tokens]:
    """The skeleton, and the words behind it. Files of one session share its text, which is then read once."""
    stream.seek(encoding.start)
    text = stream.read(LONGEST_SHARED)
    motion = _MOTION_LINE.search(text)
    if motion is not None:
        # The error is raised below, with access to the whole file.
        with suppress(FormatError, LimitError):
            shared = shared_hierarchy(text[: motion.start()], encoding.codec, limits)
            notices += shared.notices
            return shared.skeleton, _tokens(Lines(stream, encoding, encoding.start + motion.start(), shared.lines + 1))
    tokens = _tokens(Lines(stream, encoding))
    return read_hierarchy(tokens, limits, notices), tokens


def _tokens(lines: Lines) -> Tokens:
    """BVH has no comments, and some programs write them."""
    return Tokens(lines, ("#", "//"))


def _read_motion_head(tokens: Tokens, limits: Limits, channels: int, notices: list[Notice]) -> tuple[int, str | None]:
    """(frames, lexeme of the frame time or None) from MOTION on."""
    token = tokens.next()
    if token is None:
        note(notices, "warning", "there is no MOTION: the file is a skeleton alone", at=tokens.here)
        return 0, None
    if token.text.upper() != "MOTION":
        raise _expected("MOTION", token, tokens)
    count = _value_behind(tokens, ("frames",))
    if count is None:
        raise FormatError("Frames: has no value", at=tokens.here, remedy="Write the number of frames behind it.")
    if not is_whole(count.text):
        raise FormatError(f"Frames: {shown(count.text)} is not a whole number", at=count.at)
    frames = int(count.text)
    if frames < 0:
        raise FormatError(f"Frames: {frames} is negative", at=count.at)
    limits.check_size(frames, channels, count.at)
    return frames, _read_frame_time(tokens, notices)


def _read_frame_time(tokens: Tokens, notices: list[Notice]) -> str | None:
    following = tokens.peek()
    missing = Notice("warning", "no Frame Time: the frame rate is unknown", at=tokens.here)
    joined = following is not None and following.text.lower().startswith("frametime")
    if following is None or (following.text.lower() != "frame" and not joined):
        if following is not None and not is_number(following.text):
            raise _expected("Frame Time:", following, tokens)
        notices.append(missing)
        return None
    time = _value_behind(tokens, ("frametime",) if joined else ("frame", "time"))
    if time is None:
        notices.append(missing)
        return None
    if not is_number(time.text):
        raise FormatError(f"Frame Time: {what_is_wrong(time.text)}", at=time.at)
    if float(time.text) < 0:
        raise FormatError(f"Frame Time: {time.text} is negative", at=time.at)
    if float(time.text) == 0:
        notices.append(Notice("warning", "Frame Time is 0: the frame rate is unknown", at=time.at))
    return time.text


def _value_behind(tokens: Tokens, words: tuple[str, ...]) -> Token | None:
    """The value of `Frames:` or `Frame Time:`, whose colon may touch the value or be separate.

    None if the line has none and the next line is not a single word.
    """
    title = " ".join(words).title() + ":"
    token: Token | None = None
    glued = ""
    for word in words:
        token = tokens.next()
        name, colon, glued = ("", "", "") if token is None else token.text.partition(":")
        if token is None or name.lower() != word or (colon and word != words[-1]):
            raise _expected(title, token, tokens)
    if token is not None and glued:
        return Token(glued, token.line, token.column + len(token.text) - len(glued))
    if token is not None and ":" not in token.text:
        colon_token = tokens.next()
        if colon_token is None or not colon_token.text.startswith(":"):
            raise _expected(title, colon_token, tokens)
        if len(colon_token.text) > 1:
            return Token(colon_token.text[1:], colon_token.line, colon_token.column + 1)
    if not tokens.has_words_in_line() and not tokens.next_line_is_a_word():
        return None
    return tokens.next()


def _expected(what: str, token: Token | None, tokens: Tokens) -> FormatError:
    if token is None:
        return FormatError(
            f"the file ends where {what} was expected", at=tokens.here, remedy="The file was cut off; send it whole."
        )
    return FormatError(f"expected {what}, found {shown(token.text)}", at=token.at)


def _write(clip: ClipStream) -> Iterator[bytes]:
    head = clip.head
    codec = next((source.encoding for source in head.sources if source.part == "bvh"), "utf-8")
    frames = count_frames(clip)
    frame_time = _frame_time(clip, frames)
    lines = [*write_hierarchy(head.skeleton, clip.notices), "MOTION", f"Frames: {frames}"]
    if frame_time is not None:
        lines.append(f"Frame Time: {frame_time}")
    yield encoded("\n".join(lines) + "\n", codec, clip.notices)
    held = Held(head.skeleton)
    style = head.number_style if head.format == "bvh" else "shortest"
    for block in clip.blocks():
        rows = rows_of_text(held.values(block), style)
        if rows:
            yield b"\n".join(rows) + b"\n"
    if held.missing:
        clip.notices.append(
            Notice("warning", f"{held.missing} samples are missing; BVH cannot say so, the last value was written")
        )


def _frame_time(clip: ClipStream, frames: int) -> str | None:
    """Return the frame time to write; None for a BVH file without one. Raises ConversionError if it is unknown."""
    head = clip.head
    if head.frame_time is not None:
        return head.frame_time
    if head.format == "bvh" and head.seconds_per_frame() is None:
        return None
    if frames < 2 and head.seconds_per_frame() is None:
        return _NO_TIME
    return lexeme(need_seconds(head, "BVH"))
