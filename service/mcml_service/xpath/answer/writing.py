"""Whole answers as bytes: XML, NDJSON, CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import TypeAlias

import numpy as np
import orjson

from mcml.language.addresses import FRAME_TEMPLATE
from mcml.language.writer import Layout, text_bytes, write_frames
from mcml.motion.clip import FrameBlock
from mcml_schemas.querying.queries import NodeItem
from mcml_service.cells import safe_cell
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.tracks import BLOCK_FRAMES
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.answer.describe import describe_nodes
from mcml_service.xpath.answer.render import frames_with_content, holds_frames, labelled_blocks, node_values, whole_xml
from mcml_service.xpath.answer.sources import described
from mcml_service.xpath.answer.streams import Answer, Shown
from mcml_service.xpath.engine import frames
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.node import Node
from mcml_service.xpath.nodes.numbering import MOTION, Ints, documents_of, frames_of, slots_of

Reading: TypeAlias = Callable[[], AbstractContextManager[Transaction]]
"""Opens a transaction at the commit of the query."""

_CLOSING = b"</result>\n"
DENSE = 64
"""Number of frames in a document from which they are written together."""
_AS_XML = frozenset({"element", "document"})
"""Kinds of nodes whose value is XML."""

FIELDS = ("document", "revision", "kind", "address", "value")


@dataclass(frozen=True)
class _Form:
    """The format of an answer.

    before, after: text before and after all nodes. nodes: writes nodes that are already described. stored: writes nodes
    of documents, in batches. opening: text before the value of a node, by document, kind and address; escaped: a piece
    of such a value; closing: text after it.
    """

    before: bytes
    after: bytes
    nodes: Callable[[Sequence[Node]], bytes]
    stored: Callable[[Forest, Ints], Iterable[bytes]]
    opening: Callable[[Listed, str, str], bytes]
    escaped: Callable[[bytes], bytes]
    closing: bytes


def _written(form: _Form, found: Answer | Shown) -> Iterator[bytes]:
    yield form.before
    if isinstance(found, Shown):
        yield from map(form.nodes, found.nodes())
    else:
        for pieces in found.shown(partial(_pieces, form, found.read)):
            yield from pieces
    yield form.after


def _pieces(form: _Form, read: Reading, forest: Forest, nodes: Ints) -> Iterable[bytes]:
    if not holds_frames(nodes).all():
        return form.stored(forest, nodes)
    # A whole document, which comes alone: its frames are read while it is written.
    stored = forest.documents[int(documents_of(nodes)[0])]
    ((kind, address),) = describe_nodes(forest, nodes)
    xml = whole_xml(forest.tx, stored, _blocks(read, stored), motion=int(slots_of(nodes)[0]) == MOTION)
    return chain((form.opening(stored, kind, address),), map(form.escaped, xml), (form.closing,))


def _blocks(read: Reading, stored: Listed) -> Iterator[FrameBlock]:
    """All frames of a document, each block read in a separate transaction."""
    for first in range(1, stored.frames + 1, BLOCK_FRAMES):
        with read() as tx:
            blocks = list(labelled_blocks(tx, stored, first, min(first + BLOCK_FRAMES - 1, stored.frames)))
        yield from blocks


# -- XML ---------------------------------------------------------------------------------------------------------------


def xml_item(item: NodeItem | Node) -> str:
    """A `result` with the place of a node and the node itself."""
    document, revision = (
        (item.document, item.revision) if isinstance(item, NodeItem) else (item.stored.uuid, item.stored.revision)
    )
    value = item.value if item.kind in _AS_XML else text_bytes(item.value).decode()
    return f'<result document="{document}" revision="{revision}" address="{item.address}">{value}</result>\n'


def _xml_of_stored(forest: Forest, nodes: Ints) -> Iterable[bytes]:
    return list(_frames(forest, nodes)) if frames_with_content(forest, nodes) else [_described(forest, nodes)]


def _described(forest: Forest, nodes: Ints) -> bytes:
    """Write nodes like `xml_item`, but with the common parts of a document made once."""
    texts = node_values(forest, nodes)
    places = documents_of(nodes).tolist()
    openings = {place: _opening(forest.documents[place]) for place in set(places)}
    parts = [
        f'{openings[place]}{address}">{text if kind in _AS_XML else text_bytes(text).decode()}</result>\n'
        for place, (kind, address), text in zip(places, describe_nodes(forest, nodes), texts, strict=True)
    ]
    return "".join(parts).encode()


def _opening(stored: Listed) -> str:
    """Return the text before the address of a node. It has no characters that XML must escape."""
    return f'<result document="{stored.uuid}" revision="{stored.revision}" address="'


def _frames(forest: Forest, nodes: Ints) -> Iterator[bytes]:
    """Frames, written with their `result` at once."""
    documents = documents_of(nodes)
    openings = {
        place: (_opening(forest.documents[place]) + FRAME_TEMPLATE + '">').encode()
        for place in np.unique(documents).tolist()
    }
    if len(nodes) < DENSE * len(openings):
        placed = zip(documents.tolist(), frames_of(nodes).tolist(), strict=True)
        before = [openings[place] % position for place, position in placed]
        yield b"".join(frames.each(forest, nodes, before, _CLOSING))
        return
    for place, some, block in frames.by_document(forest, nodes):
        before = [openings[place] % position for position in frames_of(some).tolist()]
        names = forest.shapes.names_of(place)
        yield from write_frames(block, names, layout=Layout.COMPACT, before=before, after=_CLOSING)


_XML = _Form(
    before=b'<?xml version="1.0" encoding="UTF-8"?>\n<results>\n',
    after=b"</results>\n",
    nodes=lambda nodes: "".join([xml_item(node) for node in nodes]).encode(),
    stored=_xml_of_stored,
    opening=lambda stored, _, address: f'{_opening(stored)}{address}">'.encode(),
    escaped=lambda piece: piece,
    closing=_CLOSING,
)


# -- NDJSON: a JSON object a line, as the items of a page --------------------------------------------------------------


def _lines(nodes: Iterable[Node]) -> bytes:
    return b"".join(
        [
            orjson.dumps(dict(zip(FIELDS, _values(node), strict=True)), option=orjson.OPT_APPEND_NEWLINE)
            for node in nodes
        ]
    )


def _values(node: Node) -> tuple[str | int, ...]:
    return *_place(node.stored, node.kind, node.address), node.value


def _place(stored: Listed, kind: str, address: str) -> tuple[str | int, ...]:
    """All fields but the value."""
    return stored.uuid, stored.revision, kind, address


_NDJSON = _Form(
    before=b"",
    after=b"",
    nodes=_lines,
    stored=lambda forest, nodes: [_lines(described(forest, nodes))],
    opening=lambda *place: orjson.dumps(dict(zip(FIELDS, _place(*place), strict=False)))[:-1] + b',"value":"',
    escaped=lambda piece: orjson.dumps(piece.decode())[1:-1],
    closing=b'"}\n',
)


# -- CSV: a row a node, RFC 4180 ---------------------------------------------------------------------------------------


def _rows(shown: Callable[[str], str], nodes: Iterable[Node]) -> bytes:
    text = io.StringIO()
    csv.writer(text).writerows((*_place(node.stored, node.kind, node.address), shown(node.value)) for node in nodes)
    return text.getvalue().encode()


def _csv(shown: Callable[[str], str]) -> _Form:
    """shown: returns the text of a cell for a value."""
    return _Form(
        before=(",".join(FIELDS) + "\r\n").encode(),
        after=b"",
        nodes=partial(_rows, shown),
        stored=lambda forest, nodes: [_rows(shown, described(forest, nodes))],
        # Neither of these has characters that CSV must quote. XML follows: it begins with "<".
        opening=lambda *place: (",".join(map(str, _place(*place))) + ',"').encode(),
        escaped=lambda piece: piece.replace(b'"', b'""'),
        closing=b'"\r\n',
    )


STREAMS: dict[str, tuple[Callable[[Answer | Shown], Iterator[bytes]], str]] = {
    "xml": (partial(_written, _XML), "application/xml"),
    "ndjson": (partial(_written, _NDJSON), "application/x-ndjson"),
    "csv": (partial(_written, _csv(safe_cell)), "text/csv"),
}
"""For each form, its writer and its media type."""

RAW_CSV = partial(_written, _csv(str))
"""Writes values that spreadsheets read as formulas without escaping."""
