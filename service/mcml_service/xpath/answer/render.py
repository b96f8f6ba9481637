"""Nodes as XML and text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from mcml.language.vocabulary import FRAME_BONE, MOTION_NAME
from mcml.language.writer import Layout, attribute_bytes, text_bytes, write_document, write_motion
from mcml.motion.clip import FrameBlock
from mcml.motion.skeleton import CHANNELS
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.motion_names import names_of_frames
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.engine import frames, values
from mcml_service.xpath.engine.node_tests import kinds_and_names
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.head_rows import HeadRows
from mcml_service.xpath.nodes.numbering import (
    BONE_WIDTH,
    BONES,
    FIRST_ATTRIBUTE,
    FRAME_SHIFT,
    IS_DOCUMENT,
    IS_ELEMENT,
    MOTION,
    Bools,
    Ints,
    code_names,
    documents_of,
    frames_of,
    in_frames,
    slots_of,
)

BLOCK_FRAMES = 1024
"""Frames written together."""

_EMPTY = b'"></frame>'


def node_values(forest: Forest, nodes: Ints) -> list[str]:
    """An element as XML, the text of other nodes. Whole documents are held in memory: `whole_xml` gives pieces."""
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
    outside = np.flatnonzero(elements & ~framed)
    if len(outside):
        result[outside] = _of_head(forest, nodes[outside])
    return list(result)


def _frames(forest: Forest, nodes: Ints) -> list[str]:
    texts: list[bytes] = []
    for start in range(0, len(nodes), BLOCK_FRAMES):
        texts += frames.each(forest, nodes[start : start + BLOCK_FRAMES])
    return [(text[: -len(_EMPTY)] + b'"/>' if text.endswith(_EMPTY) else text).decode() for text in texts]


def runs_of(nodes: Ints) -> Iterator[tuple[int, int, int]]:
    """Yield (document, first frame, last frame) of maximal runs of the nodes' frames, in the order of the nodes:
    each node is in the same frame as the previous one, or in the next frame.
    """
    frames = nodes >> FRAME_SHIFT
    step = np.diff(frames)
    edges = np.flatnonzero((step != 0) & (step != 1)) + 1
    starts = frames[np.r_[0, edges]] << FRAME_SHIFT if len(frames) else frames
    stops = frames[np.r_[edges - 1, len(frames) - 1]] << FRAME_SHIFT if len(frames) else frames
    yield from zip(documents_of(starts).tolist(), frames_of(starts).tolist(), frames_of(stops).tolist(), strict=True)


def frames_with_content(forest: Forest, nodes: Ints) -> bool:
    """Whether nodes are frames, each with a child."""
    if (slots_of(nodes) != 0).any() or not in_frames(nodes).all():
        return False
    return bool((forest.shapes.sizes(nodes) + forest.labels.sizes(nodes) > 0).all())


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


def holds_frames(nodes: Ints) -> Bools:
    """Which nodes are documents, `mcml` or motions: written out, they are the whole document."""
    slots = slots_of(nodes)
    return np.asarray((frames_of(nodes) == 0) & ((slots < 2) | (slots == MOTION)))


def whole_elements(tx: Transaction, stored: Listed) -> int:
    """About how many elements a whole document has."""
    return stored.frames * (1 + len(tx.heads.bone_names(stored.key)))


def whole_xml(tx: Transaction, stored: Listed, blocks: Iterable[FrameBlock], *, motion: bool) -> Iterator[bytes]:
    """The `mcml` of a document, or only its motion, without white space between elements.

    blocks: all frames, which may be read later.
    """
    names = bone_names(tx, stored)
    if motion:
        return write_motion(stored.frames, stored.frame_time, blocks, names, Layout.COMPACT)
    head = tx.heads.document(stored)
    pieces = write_document(head, stored.frames, stored.frame_time, blocks, names, layout=Layout.COMPACT)
    # The prolog is no part of the node.
    next(pieces)
    return pieces


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


def _of_head(forest: Forest, nodes: Ints) -> list[str]:
    head = forest.head
    rows, documents = head.rows(nodes), documents_of(nodes)
    texts = np.empty(len(nodes), object)
    leaves = head.leaves(rows)
    texts[leaves] = _leaves(head, rows[leaves])
    whole, motion = holds_frames(nodes), slots_of(nodes) == MOTION
    within = rows - head.starts[documents]
    for place in np.flatnonzero(~leaves).tolist():
        document = int(documents[place])
        if not whole[place]:
            texts[place] = head.head(document).xml(int(within[place]))
            continue
        listed = forest.documents[document]
        blocks = labelled_blocks(forest.tx, listed, 1, listed.frames)
        texts[place] = b"".join(whole_xml(forest.tx, listed, blocks, motion=bool(motion[place]))).decode()
    return list(texts)


def _leaves(head: HeadRows, rows: Ints) -> list[str]:
    """Elements that hold a text; equal ones are written once."""
    names = head.names[rows].astype(np.int64)
    different, place = np.unique((names << 32) | head.texts.codes[rows + 2], return_inverse=True)
    written: list[str] = []
    for name, code in zip((different >> 32).tolist(), (different & 0xFFFFFFFF).tolist(), strict=True):
        tag = code_names()[name]
        written.append(f"<{tag}>{text_bytes(head.texts.values[code]).decode()}</{tag}>")
    return [written[number] for number in place.reshape(-1).tolist()]
