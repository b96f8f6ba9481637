"""Whole answers as bytes: XML, NDJSON, CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from functools import partial
from itertools import chain
from typing import TypeAlias

import numpy as np
import orjson

from schemas.queries import NodeItem
from service.mcml.writer import Layout, text_bytes, write_frames
from service.motion.clip import FrameBlock
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.storage.tracks import BLOCK_FRAMES
from service.xpath import frames
from service.xpath.describe import describe_nodes
from service.xpath.forest import Forest
from service.xpath.nodes import Node
from service.xpath.numbering import MOTION, Ints, documents_of, frames_of, slots_of
from service.xpath.render import check_size, document_xml, frames_with_content, labelled_blocks, node_values
from service.xpath.streams import Answer, Shown, holds_frames

Reading: TypeAlias = Callable[[], AbstractContextManager[Transaction]]
"""Opens a transaction at the commit that was asked."""

_CLOSING = b"</result>\n"
DENSE = 64
"""Of so many frames a document, they are written together."""
_AS_XML = frozenset({"element", "document"})
"""Kinds of nodes whose value is XML."""

FIELDS = ("document", "revision", "kind", "address", "value")


def xml_item(item: NodeItem | Node) -> str:
    """A `result` with the place of a node and the node itself."""
    document, revision = (
        (item.document, item.revision) if isinstance(item, NodeItem) else (item.stored.uuid, item.stored.revision)
    )
    value = item.value if item.kind in _AS_XML else text_bytes(item.value).decode()
    return f'<result document="{document}" revision="{revision}" address="{item.address}">{value}</result>\n'


def _xml(found: Answer | Shown) -> Iterator[bytes]:
    yield b'<?xml version="1.0" encoding="UTF-8"?>\n<results>\n'
    if isinstance(found, Shown):
        yield from map(_items, found.nodes())
    else:
        for pieces in found.shown(partial(_pieces, found.read)):
            yield from pieces
    yield b"</results>\n"


def _pieces(read: Reading, forest: Forest, nodes: Ints, max_elements: int) -> Iterable[bytes]:
    if frames_with_content(forest, nodes):
        return list(_frames(forest, nodes))
    if holds_frames(nodes).all() and slots_of(nodes)[0] != MOTION:
        return _document(read, forest, nodes, max_elements)
    return [_described(forest, nodes, max_elements)]


def _items(nodes: Iterable[Node]) -> bytes:
    return "".join([xml_item(node) for node in nodes]).encode()


def _described(forest: Forest, nodes: Ints, max_elements: int) -> bytes:
    """Nodes as `xml_item` writes them, what is the same for all of a document made once."""
    texts = node_values(forest, nodes, max_elements)
    places = documents_of(nodes).tolist()
    openings = {place: _opening(forest.documents[place]) for place in set(places)}
    parts = [
        f'{openings[place]}{address}">{text if kind in _AS_XML else text_bytes(text).decode()}</result>\n'
        for place, (kind, address), text in zip(places, describe_nodes(forest, nodes), texts, strict=True)
    ]
    return "".join(parts).encode()


def _opening(stored: Listed) -> str:
    """What stands before the address of a node. Neither holds anything that XML would escape."""
    return f'<result document="{stored.uuid}" revision="{stored.revision}" address="'


def _frames(forest: Forest, nodes: Ints) -> Iterator[bytes]:
    """Frames, written with their `result` at once."""
    documents = documents_of(nodes)
    openings = {
        place: (_opening(forest.documents[place]) + '/mcml/motion/frame[%d]">').encode()
        for place in np.unique(documents).tolist()
    }
    if len(nodes) < DENSE * len(openings):
        placed = zip(documents.tolist(), frames_of(nodes).tolist(), strict=True)
        before = [openings[place] % position for place, position in placed]
        yield b"".join(frames.each(forest, nodes, before, _CLOSING))
        return
    for place, some, block in frames.by_document(forest, nodes):
        before = [openings[place] % position for position in frames_of(some).tolist()]
        names = forest.layouts[place].names
        yield from write_frames(block, names, layout=Layout.COMPACT, before=before, after=_CLOSING)


def _document(read: Reading, forest: Forest, nodes: Ints, max_elements: int) -> Iterator[bytes]:
    """A whole document or its `mcml`, whose frames are read while it is written."""
    stored = forest.documents[int(documents_of(nodes)[0])]
    ((_, address),) = describe_nodes(forest, nodes)
    check_size(forest.tx, stored, max_elements)
    pieces = document_xml(forest.tx, stored, _blocks(read, stored))
    # The prolog is no part of the node.
    next(pieces)
    return chain((f'{_opening(stored)}{address}">'.encode(),), pieces, (b"</result>\n",))


def _blocks(read: Reading, stored: Listed) -> Iterator[FrameBlock]:
    """All frames of a document, each block read in a transaction of its own."""
    for first in range(1, stored.frames + 1, BLOCK_FRAMES):
        with read() as tx:
            blocks = list(labelled_blocks(tx, stored, first, min(first + BLOCK_FRAMES - 1, stored.frames)))
        yield from blocks


def _ndjson(found: Answer | Shown) -> Iterator[bytes]:
    """A JSON object a line, as the items of a page."""
    for nodes in found.nodes():
        yield b"".join([_line(node) for node in nodes])


def _line(node: Node) -> bytes:
    return orjson.dumps(dict(zip(FIELDS, _values(node), strict=True)), option=orjson.OPT_APPEND_NEWLINE)


def _csv(found: Answer | Shown) -> Iterator[bytes]:
    """A row a node, RFC 4180."""
    yield (",".join(FIELDS) + "\r\n").encode()
    for nodes in found.nodes():
        text = io.StringIO()
        csv.writer(text).writerows(_values(node) for node in nodes)
        yield text.getvalue().encode()


def _values(node: Node) -> tuple[str | int, ...]:
    return node.stored.uuid, node.stored.revision, node.kind, node.address, node.value


STREAMS: dict[str, tuple[Callable[[Answer | Shown], Iterator[bytes]], str]] = {
    "xml": (_xml, "application/xml"),
    "ndjson": (_ndjson, "application/x-ndjson"),
    "csv": (_csv, "text/csv"),
}
"""For each form, what writes it, and its media type."""
