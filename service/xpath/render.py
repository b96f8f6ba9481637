"""Nodes as XML and text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from service.errors import LimitError
from service.mcml.vocabulary import FRAME_BONE, MOTION, MOTION_NAME
from service.mcml.writer import Layout, attribute_bytes, text_bytes, write_document, write_frames
from service.motion.clip import FrameBlock
from service.motion.skeleton import CHANNELS
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.storage.encoding import channels_of
from service.storage.motion_names import names_of_frames
from service.storage.tables import CHUNK
from service.xpath import values
from service.xpath.forest import Forest
from service.xpath.node_tests import kinds_and_names
from service.xpath.numbering import (
    BONE_WIDTH,
    BONES,
    DOCUMENT_SHIFT,
    FIRST_ATTRIBUTE,
    FRAME_SHIFT,
    IS_ATTRIBUTE,
    IS_DOCUMENT,
    IS_ELEMENT,
    IS_TEXT,
    Ints,
    code_names,
    documents_of,
    frames_of,
    in_frames,
    slots_of,
)

BLOCK_FRAMES = 1024
"""Frames written together."""


def node_values(forest: Forest, nodes: Ints, max_elements: int) -> list[str]:
    """An element as XML, the text of other nodes. LimitError for a document of more elements than the limit."""
    kinds, _ = kinds_and_names(forest, nodes)
    result = np.empty(len(nodes), object)
    elements = (kinds == IS_ELEMENT) | (kinds == IS_DOCUMENT)
    framed, slots = in_frames(nodes), slots_of(nodes)
    plain = np.flatnonzero(~elements)
    result[plain] = values.strings(forest, nodes[plain]).list()
    for which, write in (
        (elements & framed & (slots == 0), _frames),
        (elements & framed & (slots > 0) & (slots < BONES), _motion_names),
        (elements & framed & (slots >= BONES), _frame_bones),
    ):
        index = np.flatnonzero(which)
        if len(index):
            result[index] = write(forest, nodes[index])
    for place in np.flatnonzero(elements & ~framed).tolist():
        result[place] = _of_head(forest, int(nodes[place]), max_elements)
    return list(result)


def _frames(forest: Forest, nodes: Ints) -> list[str]:
    result: list[str] = []
    for document, positions in positions_of(nodes):
        result += [text.decode() for text in frame_texts(forest, document, positions)]
    return result


def positions_of(nodes: Ints) -> Iterator[tuple[int, Ints]]:
    """The positions of the frames that ascending nodes lie in, document by document."""
    documents, starts = np.unique(documents_of(nodes), return_index=True)
    yield from zip(documents.tolist(), np.split(frames_of(nodes), starts[1:]), strict=True)


def runs_of(nodes: Ints) -> Iterator[tuple[int, int, int]]:
    """(document, first frame, last frame) of maximal runs of frames that ascending nodes lie in, each frame once."""
    frames = np.unique(nodes >> 24)
    if not len(frames):
        return
    breaks = np.flatnonzero(np.diff(frames) != 1)
    starts = frames[np.concatenate([[0], breaks + 1])]
    stops = frames[np.concatenate([breaks, [len(frames) - 1]])]
    for start, stop in zip((starts << 24).tolist(), (stops << 24).tolist(), strict=True):
        begin, end = np.array([start]), np.array([stop])
        yield int(documents_of(begin)[0]), int(frames_of(begin)[0]), int(frames_of(end)[0])


def frame_texts(forest: Forest, document: int, positions: Ints) -> Iterator[bytes]:
    """Frames at ascending positions as XML."""
    names = bone_names(forest.tx, forest.documents[document])
    for start in range(0, len(positions), BLOCK_FRAMES):
        block = read_frames(forest, document, positions[start : start + BLOCK_FRAMES])
        for text in b"".join(write_frames(block, names)).split(b"</frame>\n")[:-1]:
            yield text[:-1] + b"/>" if text.endswith(b'">') else text + b"</frame>"


def read_frames(forest: Forest, document: int, positions: Ints) -> FrameBlock:
    """Frames at ascending positions, which need not follow each other."""
    nodes = (document << DOCUMENT_SHIFT) | (positions << FRAME_SHIFT)
    slots = forest.shapes.slot_of(nodes)
    chunks = slots // CHUNK
    wanted = {chunk: np.flatnonzero(chunks == chunk) for chunk in np.unique(chunks).tolist()}
    key = forest.keys[document]
    rows = [
        row for first, last in _stretches(list(wanted)) for row in forest.tx.columns.tracks([key], None, (first, last))
    ]
    place: dict[tuple[int, int], int] = {}
    for row in rows:
        for channel in channels_of(row.channels):
            place.setdefault((row.bone, channel), len(place))
    values = np.full((len(place), len(nodes)), np.nan)
    for row, data in zip(rows, forest.shared.tracks.read(forest.tx, rows), strict=True):
        some = wanted[row.chunk]
        held = [place[row.bone, channel] for channel in channels_of(row.channels)]
        values[np.array(held)[:, None], some] = data[:, slots[some] % CHUNK]
    numbers, shape_of = np.unique(forest.shapes.shape_of(nodes), return_inverse=True)
    ids, others = forest.ids.numbers(nodes)
    texts = [others.get(index, str(number)) for index, number in enumerate(ids.tolist())] if others else None
    return FrameBlock(
        np.ascontiguousarray(values.T),
        tuple(place),
        tuple(forest.shape(number) for number in numbers.tolist()),
        ids if texts is None else texts,
        shape_of.reshape(-1).astype(np.intp),
        forest.labels.of_frames(nodes),
    )


def _stretches(chunks: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Ascending chunks as (first, last) of those that follow each other."""
    first = last = chunks[0]
    for chunk in chunks[1:]:
        if chunk != last + 1:
            yield first, last
            first = chunk
        last = chunk
    yield first, last


def bone_names(tx: Transaction, stored: Listed) -> list[str]:
    """The names of bones by their numbers, as `write_frames` takes them."""
    names = tx.heads.bone_names(stored.key)
    return [names.get(number, "") for number in range(max(names, default=-1) + 1)]


def labelled_blocks(
    tx: Transaction, stored: Listed, first: int, last: int, bones: Sequence[int] | None = None
) -> Iterator[FrameBlock]:
    """Frames first to last in blocks, with their motion names."""
    position = first
    for block in tx.tracks.blocks(stored.key, first, last, bones=bones):
        end = position + len(block) - 1
        labels = names_of_frames(tx.spans.of(stored.key, position, end), range(position, end + 1))
        yield replace(block, motion_names=labels)
        position = end + 1


def document_xml(tx: Transaction, stored: Listed) -> Iterator[bytes]:
    """The whole document without white space between elements."""
    document = tx.heads.document(stored)
    blocks = labelled_blocks(tx, stored, 1, stored.frames)
    names = bone_names(tx, stored)
    return write_document(document, stored.frames, stored.frame_time, blocks, names, layout=Layout.COMPACT)


def _motion_names(forest: Forest, nodes: Ints) -> list[str]:
    wrapped = [
        (b"<" + MOTION_NAME.encode() + b">" + text_bytes(text) + b"</" + MOTION_NAME.encode() + b">").decode()
        for text in forest.labels.texts
    ]
    return [wrapped[code] for code in forest.labels.codes(nodes).tolist()]


def _frame_bones(forest: Forest, nodes: Ints) -> list[str]:
    source, attributes = forest.shapes.attributes(nodes)
    place = slots_of(attributes) % BONE_WIDTH - FIRST_ATTRIBUTE
    opening = np.array([f' {name}="' for name in ("name", *CHANNELS)], object)[place]
    texts = values.strings(forest, attributes)
    quoted = [attribute_bytes(text).decode() + '"' for text in texts.values]
    parts: list[list[str]] = [[] for _ in range(len(nodes))]
    for bone, before, code in zip(source.tolist(), opening.tolist(), texts.codes.tolist(), strict=True):
        parts[bone] += (before, quoted[code])
    return [f"<{FRAME_BONE}{''.join(some)}/>" for some in parts]


def _of_head(forest: Forest, node: int, max_elements: int) -> str:
    head = forest.head
    row = int(head.rows(np.array([node]))[0])
    document = int(documents_of(np.array([node]))[0])
    motion = int(head.motions[document])
    if not row <= motion <= head.ends[row]:
        return _subtree(forest, row)
    stored = forest.documents[document]
    check_size(forest.tx, stored, max_elements)
    whole = b"".join(document_xml(forest.tx, stored)).decode()
    # Behind the prolog; a motion that stands in a text is written &lt;motion&gt;.
    start = whole.index(f"<{MOTION}>") if row == motion else whole.index("<mcml")
    stop = whole.rindex("</mcml>") if row == motion else len(whole)
    return whole[start:stop]


def check_size(tx: Transaction, listed: Listed, max_elements: int) -> None:
    """LimitError for a document that is too large to be in an answer whole."""
    elements = listed.frames * (1 + len(tx.heads.bone_names(listed.key)))
    if elements > max_elements:
        raise LimitError(
            f"The answer holds all of {listed.name!r}, about {elements:,} elements; the limit is {max_elements:,}.",
            remedy="Export the document instead, or ask for some of its frames.",
            code="query-too-large",
        )


def _subtree(forest: Forest, row: int) -> str:
    """An element outside of the motion, from its rows."""
    head = forest.head
    rows = np.arange(row, head.ends[row] + 1)
    kinds, names = head.kinds[rows].tolist(), head.names[rows].tolist()
    texts, ends = head.texts(rows), head.ends[rows].tolist()
    parts: list[str] = []
    open_: list[tuple[int, str]] = []
    in_tag = False
    for place, (kind, name, text) in enumerate(zip(kinds, names, texts, strict=True)):
        while open_ and place + row > open_[-1][0]:
            tag = open_.pop()[1]
            parts.append("/>" if in_tag else f"</{tag}>")
            in_tag = False
        if kind == IS_ATTRIBUTE:
            parts.append(f' {code_names()[name]}="{attribute_bytes(text).decode()}"')
        elif kind in (IS_ELEMENT, IS_TEXT):
            parts.append(">" * in_tag + (f"<{code_names()[name]}" if kind == IS_ELEMENT else text_bytes(text).decode()))
            in_tag = kind == IS_ELEMENT
            if in_tag:
                open_.append((ends[place], code_names()[name]))
    while open_:
        tag = open_.pop()[1]
        parts.append("/>" if in_tag else f"</{tag}>")
        in_tag = False
    return "".join(parts)
