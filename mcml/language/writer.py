"""A document as XML bytes, streamed.

Three layouts. LINES, the default: header, root and skeleton on a line each, then each frame on a line of its own, so
that an error can name a line and tools can compare two exports. COMPACT: no white space between elements at all,
which is how XPath sees a document. PRETTY: every element on its own line, indented. The order of the attributes of a
frame_bone is always name Tx Ty Tz Rx Ry Rz SF residual weight. Numbers are in the shortest form that reads back as the
same double (orjson's).
"""

from __future__ import annotations

import operator
from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from functools import lru_cache

import numpy as np
import orjson
from numpy.typing import NDArray

from mcml.errors import DocumentError
from mcml.language.element import Element
from mcml.language.lexical import escape
from mcml.language.vocabulary import PUBLIC_NAME
from mcml.motion.clip import FrameBlock, Shape
from mcml.motion.skeleton import CHANNELS, Array

PROLOGUE = f'<?xml version="1.0" encoding="UTF-8"?>\n<!DOCTYPE mcml SYSTEM "{PUBLIC_NAME}">\n'.encode()
VALUES_AT_A_TIME = 1 << 17
"""Numbers in one piece of text: a few megabytes."""
VALUES_TOGETHER = 1 << 13
"""Numbers written in one go: enough for speed, and few enough for the processor's cache."""


class Layout(Enum):
    """The white space between elements."""

    COMPACT = "compact"
    LINES = "lines"
    PRETTY = "pretty"


_END = {Layout.COMPACT: b"</frame>", Layout.LINES: b"</frame>\n", Layout.PRETTY: b"\n    </frame>\n"}
_TEXT = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", "\r": "&#13;"})
_ATTRIBUTE = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\r": "&#13;", "\n": "&#10;", "\t": "&#9;"}
)


def text_bytes(text: str) -> bytes:
    """The text of a leaf as XML."""
    return text.translate(_TEXT).encode()


def attribute_bytes(text: str) -> bytes:
    """The value of an attribute as XML, without the quotes."""
    return text.translate(_ATTRIBUTE).encode()


def write_document(
    document: Element,
    frames: int,
    frame_time: str | None,
    blocks: Iterable[FrameBlock],
    names: Sequence[str],
    *,
    pretty: bool = False,
    layout: Layout | None = None,
) -> Iterator[bytes]:
    """A whole document.

    document: the `mcml` element without its motion (a motion it has is left out). frames: number of frames in the
    blocks, for motion/frames. frame_time: text of motion/frametime, None to leave it out. names: of each joint, as
    `Joint.name` gives it. layout: LINES if not given; `pretty` is short for PRETTY.
    Raises DocumentError for a value that is not finite.
    """
    layout = layout or (Layout.PRETTY if pretty else Layout.LINES)
    line = b"" if layout is Layout.COMPACT else b"\n"
    yield PROLOGUE
    yield _start_tag(document).encode() + b">" + line
    for child in document.children:
        if child.tag != "motion":
            yield write_element(child, pretty=layout is Layout.PRETTY, depth=1) + line
    yield from write_motion(frames, frame_time, blocks, names, layout)
    yield b"</mcml>" + line


def write_motion(
    frames: int, frame_time: str | None, blocks: Iterable[FrameBlock], names: Sequence[str], layout: Layout
) -> Iterator[bytes]:
    """The `motion` element, as in a whole document."""
    indented = layout is Layout.PRETTY
    line = b"" if layout is Layout.COMPACT else b"\n"
    inner = b"\n    " if indented else b""
    yield (b"  " if indented else b"") + b"<motion>" + inner + b"<frames>" + str(frames).encode() + b"</frames>"
    if frame_time is not None:
        yield inner + b"<frametime>" + text_bytes(frame_time) + b"</frametime>"
    yield line
    for block in blocks:
        yield from write_frames(block, names, layout=layout)
    yield (b"  " if indented else b"") + b"</motion>" + line


def write_element(element: Element, *, pretty: bool = False, depth: int = 0) -> bytes:
    """One element with all it holds. depth: how far a pretty one is indented, two spaces a level."""
    parts: list[str] = []
    stack: list[tuple[Element | str, int]] = [(element, depth)]
    while stack:
        current, level = stack.pop()
        if isinstance(current, str):
            parts.append(current)
            continue
        indent = "  " * level if pretty else ""
        end = "\n" if pretty and level > depth else ""
        text = current.text.translate(_TEXT) if current.text else ""
        if current.children:
            # Text beside children is invalid MCML. It is written anyway, so that the document is refused.
            parts.append(f"{indent}{_start_tag(current)}>{text}" + ("\n" if pretty else ""))
            stack.append((f"{indent}</{current.tag}>{end}", level))
            stack.extend([(child, level + 1) for child in reversed(current.children)])
        elif text:
            parts.append(f"{indent}{_start_tag(current)}>{text}</{current.tag}>{end}")
        else:
            parts.append(f"{indent}{_start_tag(current)}/>{end}")
    return "".join(parts).encode()


def write_frames(
    block: FrameBlock,
    names: Sequence[str],
    *,
    first: int = 0,
    last: int | None = None,
    layout: Layout = Layout.LINES,
    before: Sequence[bytes] = (),
    after: bytes = b"",
) -> Iterator[bytes]:
    """Frames first … last - 1 (from 0) of a block as `frame` elements. Raises DocumentError for NaN and infinity.

    before: bytes before each frame of the block. after: bytes after each frame.
    """
    heads = _frame_heads(block.ids, block.motion_names, layout, before)
    step = max(1, VALUES_AT_A_TIME // max(1, len(block.columns)))
    inner = max(1, VALUES_TOGETHER // max(1, len(block.columns)))
    last = len(block) if last is None else min(last, len(block))
    shape_of = block.shape_of
    start = first
    while start < last:
        shape = block.shapes[0 if shape_of is None else int(shape_of[start])]
        stop = last
        if shape_of is not None:
            changes = np.flatnonzero(shape_of[start:last] != shape_of[start])
            stop = start + int(changes[0]) if changes.size else last
        literals, tail = _template(shape, tuple(names), layout)
        tail += _END[layout] + after
        for piece in range(start, stop, step):
            end = min(stop, piece + step)
            some = [(at, min(end, at + inner)) for at in range(piece, end, inner)]
            yield b"".join([_write_run(block, shape, literals, tail, heads, *ends) for ends in some])
        start = max(stop, start + 1)


def frame_texts(
    values: Array,
    kinds: Sequence[tuple[Shape, Sequence[str]]],
    kind_of: Sequence[int],
    ids: NDArray[np.int64] | list[str],
    motion_names: Sequence[tuple[str, ...]] | None = None,
    *,
    before: Sequence[bytes] = (),
    after: bytes = b"",
) -> list[bytes]:
    """Write frames of any documents, each separately, COMPACT. Raises DocumentError for NaN and infinity.

    values: of all frames one after the other, those of each in the order of its shape. kinds: the shapes that occur,
    each with the names of bones. kind_of: which of them each frame has. ids, motion_names: as in a FrameBlock. before,
    after: as in `write_frames`.
    """
    heads = _frame_heads(ids, motion_names, Layout.COMPACT, before)
    templates = [_template(shape, tuple(names), Layout.COMPACT) for shape, names in kinds]
    tokens = _tokens(values)
    texts: list[bytes] = []
    start = 0
    for head, kind in zip(heads, kind_of, strict=True):
        literals, tail = templates[kind]
        width = len(literals)
        parts = [head, *[b""] * (2 * width), tail, _END[Layout.COMPACT], after]
        parts[1 : 2 * width : 2] = literals
        parts[2 : 2 * width + 1 : 2] = tokens[start : start + width]
        texts.append(b"".join(parts))
        start += width
    return texts


def _write_run(
    block: FrameBlock, shape: Shape, literals: list[bytes], tail: bytes, heads: Sequence[bytes], first: int, last: int
) -> bytes:
    """Frames of one shape. The numbers of all of them become text at once and are set between the literal parts.

    heads: the beginning of each frame of the block. tail: the end of each.
    """
    heads = heads[first:last]
    if not literals:
        return b"".join([head + tail for head in heads])
    values = block.values[first:last, columns_of(shape, block.columns)]
    width, count = len(literals), last - first
    parts = [b""] * (2 * width * count)
    parts[0::2] = literals * count
    parts[1::2] = _tokens(values)
    opening = literals[0]
    # The first literal of a frame follows the end of the frame before it and this frame's own head.
    parts[0 :: 2 * width] = [(tail if place else b"") + head + opening for place, head in enumerate(heads)]
    parts.append(tail)
    return b"".join(parts)


def _tokens(values: Array) -> list[bytes]:
    text = orjson.dumps(np.ascontiguousarray(values).reshape(-1), option=orjson.OPT_SERIALIZE_NUMPY)
    if b"n" in text:
        raise DocumentError(
            "a channel is not a finite number", remedy="Leave the attribute out where there is no sample."
        )
    return text[1:-1].split(b",") if values.size else []


def _frame_heads(
    ids: NDArray[np.int64] | list[str],
    motion_names: Sequence[tuple[str, ...]] | None,
    layout: Layout,
    before: Sequence[bytes],
) -> list[bytes]:
    indented = layout is Layout.PRETTY
    opening = b'    <frame id="' if indented else b'<frame id="'
    texts = list(map(attribute_bytes, ids)) if isinstance(ids, list) else [b"%d" % number for number in ids.tolist()]
    heads = [opening + text + b'">' for text in texts]
    if before:
        heads = list(map(operator.add, before, heads))
    if motion_names is not None:
        named = [_motion_names(tuple(names), indented) for names in motion_names]
        heads = list(map(operator.add, heads, named))
    return heads


@lru_cache(maxsize=1024)
def _motion_names(names: tuple[str, ...], indented: bool) -> bytes:
    before = b"\n      " if indented else b""
    return b"".join([before + b"<motion_name>" + text_bytes(escape(name)) + b"</motion_name>" for name in names])


@lru_cache(maxsize=256)
def _template(shape: Shape, names: tuple[str, ...], layout: Layout) -> tuple[list[bytes], bytes]:
    """The literal text before each number of a frame of that shape, and the text after its last number."""
    literals: list[bytes] = []
    pending = b""
    before = b"\n      " if layout is Layout.PRETTY else b""
    for joint, bits in shape:
        pending += before + b'<frame_bone name="' + attribute_bytes(escape(names[joint])) + b'"'
        for index, channel in enumerate(CHANNELS):
            if bits >> index & 1:
                literals.append(pending + b" " + channel.encode() + b'="')
                pending = b'"'
        pending += b"/>"
    return literals, pending


@lru_cache(maxsize=256)
def columns_of(shape: Shape, columns: tuple[tuple[int, int], ...]) -> list[int] | slice:
    """Which columns (joint, channel) hold the numbers of a frame of that shape, in its order."""
    place = {column: index for index, column in enumerate(columns)}
    wanted = [place[joint, channel] for joint, bits in shape for channel in range(len(CHANNELS)) if bits >> channel & 1]
    return slice(None) if wanted == list(range(len(columns))) else wanted


def _start_tag(element: Element) -> str:
    attributes = [f' {name}="{value.translate(_ATTRIBUTE)}"' for name, value in element.attributes.items()]
    return f"<{element.tag}{''.join(attributes)}"
