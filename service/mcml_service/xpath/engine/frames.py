"""Read and write frames: those of one document as a block, or those of many documents separately."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mcml.language.writer import columns_of, frame_texts
from mcml.motion.clip import FrameBlock, Shape
from mcml.motion.skeleton import Array
from mcml.numerics.runs import evenly, find_equal
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.documents.blocks import Block, Stretch, gathered
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.tracks import BlockKey, read_blocks
from mcml_service.xpath.nodes.numbering import Ints, documents_of


def each(forest: Forest, nodes: Ints, before: Sequence[bytes] = (), after: bytes = b"") -> list[bytes]:
    """Yield the XML of each frame, for ascending frame nodes.

    before: text before each; after: text after all of them. All possible work is done for all documents together: best
    for a few frames of many documents.
    """
    slots, shapes = forest.shapes.slot_of(nodes), forest.shapes.shape_of(nodes)
    blocks, block_of = _blocks(forest, documents_of(nodes), slots // CHUNK)
    kinds: dict[tuple[int, int], int] = {}
    held: list[tuple[Shape, Sequence[str]]] = []
    kind_of: list[int] = []
    orders: dict[tuple[int, int], list[int] | slice | None] = {}
    values: list[Array] = []
    numbered = zip(
        documents_of(nodes).tolist(), shapes.tolist(), block_of.tolist(), (slots % CHUNK).tolist(), strict=True
    )
    for place, number, unit, offset in numbered:
        shape, names, block = forest.shapes.numbered_shapes[number], forest.shapes.names_of(place), blocks[unit]
        # Equal ones are the same object, and comparing identity is faster.
        kind = kinds.setdefault((id(shape), id(names)), len(kinds))
        if kind == len(held):
            held.append((shape, names))
        kind_of.append(kind)
        layout = kind, id(block.columns)
        if layout not in orders:
            orders[layout] = columns_of(shape, block.columns) if any(bits for _, bits in shape) else None
        order = orders[layout]
        if order is not None:
            values.append(block.values[:, offset][order])
    ids, others = forest.ids.numbers(nodes)
    texts = [others.get(index, str(number)) for index, number in enumerate(ids.tolist())] if others else ids
    labels = forest.labels.of_frames(nodes)
    together = np.concatenate([*values, np.empty(0)])
    return frame_texts(together, held, kind_of, texts, labels, before=before, after=after)


def by_document(forest: Forest, nodes: Ints) -> Iterator[tuple[int, Ints, FrameBlock]]:
    """The frames that ascending nodes are, which need not follow each other, as a block for each document.

    Yields (place of the document, its nodes, block).
    """
    slots, shapes = forest.shapes.slot_of(nodes), forest.shapes.shape_of(nodes)
    ids, others = forest.ids.numbers(nodes)
    labels = forest.labels.of_frames(nodes)
    documents, edges = np.unique(documents_of(nodes), return_index=True)
    blocks, block_of = _blocks(forest, documents_of(nodes), slots // CHUNK)
    for document, (start, stop) in zip(documents.tolist(), pairwise([*edges.tolist(), len(nodes)]), strict=True):
        stretches = _stretches(blocks, block_of[start:stop], slots[start:stop] % CHUNK)
        values, columns = gathered(list(stretches), stop - start)
        numbers, shape_of = _distinct(shapes[start:stop])
        own_ids = ids[start:stop]
        texts = None
        if others:
            texts = [others.get(start + index, str(number)) for index, number in enumerate(own_ids.tolist())]
        block = FrameBlock(
            values,
            columns,
            tuple(forest.shapes.numbered_shapes[number] for number in numbers),
            own_ids if texts is None else texts,
            shape_of,
            None if labels is None else labels[start:stop],
        )
        yield document, nodes[start:stop], block


def _distinct(shapes: Ints) -> tuple[list[int], NDArray[np.intp] | None]:
    """The different ones, and which of them each is; None where all are one."""
    if (shapes == shapes[0]).all():
        return [int(shapes[0])], None
    numbers, shape_of = np.unique(shapes, return_inverse=True)
    return numbers.tolist(), shape_of.reshape(-1).astype(np.intp)


def _blocks(forest: Forest, documents: Ints, chunks: Ints) -> tuple[list[Block], Ints]:
    """All tracks over chunks of documents side by side, and in which of these blocks each frame is.

    documents, chunks: of each frame.
    """
    units, block_of = np.unique((documents << 32) | chunks, return_inverse=True)
    keys: list[BlockKey] = []
    for place, chunk in zip((units >> 32).tolist(), (units & 0xFFFFFFFF).tolist(), strict=True):
        keys.append((forest.documents[place].key, forest.documents[place].revision, chunk))

    def missing(some: list[BlockKey]) -> dict[BlockKey, Block]:
        blocks = read_blocks(forest.tx, [(key, chunk) for key, _, chunk in some])
        return {key: blocks[key[0], key[2]] for key in some}

    return forest.caches.blocks.get(keys, missing), block_of.reshape(-1)


def _stretches(blocks: Sequence[Block], block_of: Ints, offsets: Ints) -> Iterator[Stretch]:
    """Frames by their chunk. offsets: indices in it."""
    order = np.argsort(block_of, kind="stable")
    for start, stop in find_equal(block_of[order]).tolist():
        places = order[start:stop]
        yield Stretch(blocks[block_of[places[0]]], evenly(offsets[places]), evenly(places))
