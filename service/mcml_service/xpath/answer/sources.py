"""Pages and runs of the nodes of an answer."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mcml.errors import LimitError
from mcml_service.storage.documents.columns import Listed
from mcml_service.xpath.answer.describe import describe_nodes
from mcml_service.xpath.answer.render import holds_frames, node_values, runs_of, whole_elements
from mcml_service.xpath.engine.source import Source
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.node import Node, Run, in_no_frame, join_runs
from mcml_service.xpath.nodes.numbering import Ints, documents_of, frames_of

PAGE_ELEMENTS = 200_000
"""Of whole documents on one page: some 15 MB of text, which is held several times on its way."""


def page(source: Source, offset: int, limit: int, max_elements: int) -> tuple[list[Node], bool]:
    """Return (nodes from `offset` on, whether more follow): `limit` nodes, or fewer if whole documents among them are
    too large together. Raises LimitError if the first one alone is too large.
    """
    result: list[Node] = []
    room = min(max_elements, PAGE_ELEMENTS)
    for forest, nodes in source.chunks():
        if offset >= len(nodes):
            offset -= len(nodes)
            continue
        if len(result) == limit:
            return result, True
        some = nodes[offset : offset + limit - len(result)]
        taken = np.cumsum(_elements(forest, some))
        fits = int(np.searchsorted(taken, room, side="right"))
        if not fits and not result:
            raise _too_large(forest.documents[int(documents_of(some[:1])[0])], int(taken[0]), room)
        result += described(forest, some[:fits]) if fits else []
        if fits < len(some) or offset + len(some) < len(nodes):
            return result, True
        room -= int(taken[-1])
        offset = 0
    return result, False


def _elements(forest: Forest, nodes: Ints) -> Ints:
    """About how many elements the whole documents among nodes have, 0 for other nodes."""
    counts = np.zeros(len(nodes), np.int64)
    whole = np.flatnonzero(holds_frames(nodes))
    places = documents_of(nodes[whole]).tolist()
    counts[whole] = [whole_elements(forest.tx, forest.documents[place]) for place in places]
    return counts


def _too_large(stored: Listed, elements: int, most: int) -> LimitError:
    return LimitError(
        f"The result contains all of {stored.name!r}, about {elements:,} elements; a page holds {most:,}.",
        remedy="Ask with as=xml, ndjson or csv and without a limit, which streams it. Export the document, or ask for "
        "some of its frames.",
        code="query-too-large",
    )


def described(forest: Forest, nodes: Ints) -> list[Node]:
    """Nodes as an answer shows them."""
    texts = node_values(forest, nodes)
    places = documents_of(nodes).tolist()
    return [
        Node(kind, forest.documents[place], address, text)
        for place, (kind, address), text in zip(places, describe_nodes(forest, nodes), texts, strict=True)
    ]


def runs(source: Source) -> Iterator[Run]:
    """Yield maximal ranges of the nodes' frames. Raises QueryError for a node outside frames."""
    return join_runs(_runs_of_chunks(source))


def _runs_of_chunks(source: Source) -> Iterator[Run]:
    for forest, nodes in source.chunks():
        outside = np.flatnonzero(frames_of(nodes) == 0)
        if len(outside):
            _, address = next(describe_nodes(forest, nodes[outside[:1]]))
            raise in_no_frame(address)
        for document, first, last in runs_of(nodes):
            yield Run(forest.documents[document], first, last)
