"""Parts of a document's text, with line numbers in the whole text; and finding a text in it.

The whole text is the export as MCML: LINES, or PRETTY on request. Its head is all lines before the first frame.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

from mcml.errors import NotFoundError
from mcml.language.addresses import MOTION, address_child, address_frame, number_steps
from mcml.language.elements import Element
from mcml.language.vocabulary import FRAME_BONE, FRAMES, FRAMETIME, MOTION_NAME
from mcml.language.writer import Layout, text_bytes, write_document, write_frames
from mcml_service.actions.reading.list_children import children_of_frames
from mcml_service.clips.read_clip import StoredClip, read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.motion_names import names_of_frames
from mcml_service.storage.transaction import Transaction

_FRAME_LINES = {Layout.LINES: 1, Layout.PRETTY: 2}
"""Lines of a frame, in addition to those of its content."""
_END = 2
"""Lines behind the last frame: those with which motion and document end."""

SEARCHED_AT_A_TIME = 1024
"""Frames."""
SHOWN = 200
"""Characters of a line that was found."""


@dataclass(frozen=True)
class Window:
    """first: number of the first line. lines, total: of the window and of the whole document."""

    content: Iterator[bytes]
    first: int
    lines: int
    total: int


@dataclass(frozen=True)
class Place:
    """The place of a text. line, column: from 1. address: of the element on the line. frame: its position."""

    line: int
    column: int
    address: str
    frame: int | None
    text: str


def head_window(tx: Transaction, stored: StoredDocument, layout: Layout) -> Window:
    """All lines before the first frame."""
    head, _ = _ends(_whole(tx, stored), layout)
    lines = head.count(b"\n")
    return Window(iter([head]), 1, lines, lines + _lines(tx, stored, stored.frames, layout) + _END)


def frames_window(tx: Transaction, stored: StoredDocument, first: int, last: int, layout: Layout) -> Window:
    """The frames first to last. NotFoundError outside the document."""
    source = read_clip(tx, stored, first=first, last=last)
    if not stored.frames:
        raise NotFoundError("The document has no frames.", remedy="Ask for part=head.")
    head = _ends(_whole(tx, stored), layout)[0].count(b"\n")
    before, to_end = (_lines(tx, stored, frame, layout) for frame in (first - 1, last))
    total = head + _lines(tx, stored, stored.frames, layout) + _END
    content = (piece for block in source.clip.blocks() for piece in write_frames(block, source.names, layout=layout))
    return Window(content, head + before + 1, to_end - before, total)


def find_text(
    tx: Transaction, stored: StoredDocument, text: str, line: int, layout: Layout, seconds: float
) -> tuple[Place | None, int | None]:
    """Return (the first place of a text from a line on, None without one; the line to continue from after the time
    limit). seconds: time limit.
    """
    wanted, until = text.encode(), time.monotonic() + seconds
    source = _whole(tx, stored)
    head, end = _ends(source, layout)
    lines = head.split(b"\n")[:-1]
    for number, content in enumerate(lines[line - 1 :], start=line):
        if (column := content.find(wanted)) >= 0:
            address = _head_addresses(source, stored, layout, len(lines))[number - 1]
            return _place(number, column, content, address, None), None
    at = len(lines) + 1
    for first in range(1, stored.frames + 1, SEARCHED_AT_A_TIME):
        last = min(first + SEARCHED_AT_A_TIME - 1, stored.frames)
        counts = children_of_frames(tx, stored, first, last) if layout is Layout.PRETTY else None
        size = last - first + 1 if counts is None else int(counts.sum()) + 2 * len(counts)
        if at + size > line:
            places = _in_frames(tx, stored, first, last, layout, wanted, at, line)
            if places is not None:
                return places, None
            if time.monotonic() > until and last < stored.frames:
                return None, at + size
        at += size
    for number, tail in enumerate(end.split(b"\n")[:-1], start=at):
        column = tail.find(wanted)
        if number >= line and column >= 0:
            return _place(number, column, tail, MOTION if number == at else "/mcml", None), None
    return None, None


def _in_frames(
    tx: Transaction, stored: StoredDocument, first: int, last: int, layout: Layout, wanted: bytes, at: int, line: int
) -> Place | None:
    """at: number of the first line of these frames. line: where to begin."""
    source = read_clip(tx, stored, first=first, last=last)
    blocks = (piece for block in source.clip.blocks() for piece in write_frames(block, source.names, layout=layout))
    text = b"".join(blocks)
    if wanted not in text:
        return None
    lines = text.split(b"\n")
    number, content = next(
        ((number, content) for number, content in enumerate(lines, start=at) if number >= line and wanted in content),
        (0, b""),
    )
    if not number:
        return None
    frame, address = _address_in(tx, stored, first, lines[: number - at + 1], layout)
    return _place(number, content.find(wanted), content, address, frame)


def _address_in(
    tx: Transaction, stored: StoredDocument, first: int, lines: list[bytes], layout: Layout
) -> tuple[int, str]:
    """The frame, and the address, of the last of some lines that begin with a frame."""
    if layout is Layout.LINES:
        frame = first + len(lines) - 1
        return frame, address_frame(frame)
    starts = [index for index, line in enumerate(lines) if line.startswith(b"    <frame ")]
    frame, inside = first + len(starts) - 1, len(lines) - 1 - starts[-1]
    if inside == 0 or not lines[-1].startswith(b"      "):
        return frame, address_frame(frame)
    (names,) = names_of_frames(tx.spans.of(stored.key, frame, frame), range(frame, frame + 1)) or [()]
    if inside <= len(names):
        return frame, address_child(frame, MOTION_NAME, inside)
    return frame, address_child(frame, FRAME_BONE, inside - len(names))


def _place(line: int, column: int, content: bytes, address: str, frame: int | None) -> Place:
    start = len(content[:column].decode())
    text = content.decode()
    return Place(line, start + 1, address, frame, text[max(0, start - SHOWN // 2) :][:SHOWN].strip())


def _whole(tx: Transaction, stored: StoredDocument) -> StoredClip:
    """The document with counts of all its frames, none of which is read."""
    return read_clip(tx, stored, labelled=False)


def _ends(source: StoredClip, layout: Layout) -> tuple[bytes, bytes]:
    """The lines before the first frame, and those behind the last one."""
    stored = source.stored
    whole = write_document(source.document, stored.frames, stored.frame_time, (), source.names, layout=layout)
    lines = b"".join(whole).split(b"\n")
    head, end = lines[: -_END - 1], lines[-_END - 1 :]
    return b"\n".join([*head, b""]), b"\n".join(end)


def _lines(tx: Transaction, stored: StoredDocument, frames: int, layout: Layout) -> int:
    """How many lines the first frames have."""
    lines = _FRAME_LINES[layout] * frames
    if layout is Layout.PRETTY and frames:
        lines += sum(count * bones for count, bones in tx.tracks.frame_bones(stored.key, 1, frames))
        lines += sum(min(span.last, frames) - span.first + 1 for span in tx.spans.of(stored.key, 1, frames))
    return lines


def _head_addresses(source: StoredClip, stored: StoredDocument, layout: Layout, lines: int) -> list[str]:
    """The address of the element that each line of the head belongs to."""
    motion = [MOTION]
    if layout is Layout.PRETTY:
        motion += [f"{MOTION}/{FRAMES}"] + [f"{MOTION}/{FRAMETIME}"] * (stored.frame_time is not None)
    below = list(_below(source.document, "/mcml", layout is Layout.PRETTY))
    # The lines before the document element belong to no element.
    before = lines - 1 - len(below) - len(motion)
    return ["/mcml"] * (before + 1) + below + motion


def _below(element: Element, address: str, pretty: bool) -> Iterator[str]:
    """The address that each line within an element belongs to."""
    steps = number_steps([child.tag for child in element.children])
    for step, child in zip(steps, element.children, strict=True):
        here = f"{address}/{step}"
        if child.children and pretty:
            yield here
            yield from _below(child, here, pretty)
            yield here
        else:
            breaks = sum(text_bytes(each.text).count(b"\n") for each in _within(child))
            yield from [here] * (1 + breaks)


def _within(element: Element) -> Iterator[Element]:
    yield element
    for child in element.children:
        yield from _within(child)
