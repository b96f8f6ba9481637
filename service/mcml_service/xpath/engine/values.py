"""Strings and numbers of nodes."""

from __future__ import annotations

import numpy as np

from mcml.motion.skeleton import CHANNELS
from mcml.numerics.runs import find_equal
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.documents.encoding import channels_of
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.track_values import side_by_side
from mcml_service.xpath.library.tracks import Row
from mcml_service.xpath.library.zones import rows_of
from mcml_service.xpath.nodes.heads import XML_NAMESPACE
from mcml_service.xpath.nodes.numbering import (
    BONE_WIDTH,
    BONES,
    FIRST_ATTRIBUTE,
    FIRST_CHANNEL,
    IS_ATTRIBUTE,
    IS_NAMESPACE,
    IS_TEXT,
    NAME_WIDTH,
    NAMES_FROM,
    NAMESPACE_SLOT,
    Bools,
    Floats,
    Ints,
    documents_of,
    in_frames,
    slots_of,
)
from mcml_service.xpath.nodes.samples import sample_texts
from mcml_service.xpath.nodes.texts import Strings, compact, constant, joined, of_texts

MANY = 1024
"""Samples of one bone that may be looked up among those of all its tracks."""
MAX_TEXT = 32 << 20
"""Characters of the string of one element that holds frames."""


class TooLongError(Exception):
    """The string of an element is longer than is held at once."""


def channel_places(nodes: Ints) -> Bools:
    """Which nodes are channel attributes of frame_bones."""
    slots = slots_of(nodes)
    return np.asarray((slots >= BONES) & (slots % BONE_WIDTH >= FIRST_CHANNEL) & in_frames(nodes))


def numbers(forest: Forest, nodes: Ints) -> Floats:
    """`number()` of each node."""
    channels = channel_places(nodes)
    if channels.all():
        return samples(forest, nodes)
    result = np.empty(len(nodes), np.float64)
    if channels.any():
        result[channels] = samples(forest, nodes[channels])
    result[~channels] = strings(forest, nodes[~channels]).numbers()
    return result


def strings(forest: Forest, nodes: Ints) -> Strings:
    """`string()` of each node."""
    framed = in_frames(nodes)
    if not framed.any():
        return _of_head(forest, nodes)
    slots = slots_of(nodes)
    parts: list[tuple[Ints, Strings]] = []

    def add(which: Bools, function: object) -> None:
        index = np.flatnonzero(which)
        if len(index):
            parts.append((index, function(forest, nodes[index])))  # type: ignore[operator]  # all have this name

    add(~framed, _of_head)
    bones = framed & (slots >= BONES)
    place = slots % BONE_WIDTH
    add(bones & (place == 0), lambda _, some: constant("", len(some)))
    add(bones & (place == FIRST_ATTRIBUTE), _bone_names)
    add(bones & (place >= FIRST_CHANNEL), _sample_texts)
    low = framed & ~bones
    named = low & (slots >= NAMES_FROM)
    add(
        named & (slots % NAME_WIDTH != NAMESPACE_SLOT),
        lambda _, some: Strings(forest.labels.codes(some), forest.labels.texts),
    )
    add(low & (slots == 0), _frame_texts)
    add(low & (slots == FIRST_ATTRIBUTE), _id_texts)
    namespaces = framed & np.where(
        slots >= BONES, place == 1, np.where(slots >= NAMES_FROM, slots % 4 == 1, slots == 1)
    )
    add(namespaces, lambda _, some: constant(XML_NAMESPACE, len(some)))
    if len(parts) == 1:
        return parts[0][1]
    whole = joined([part for _, part in parts])
    order = np.concatenate([*(index for index, _ in parts), np.empty(0, np.int64)])
    codes = np.empty(len(nodes), np.int64)
    codes[order] = whole.codes
    return Strings(codes, whole.values)


def samples(forest: Forest, nodes: Ints) -> Floats:
    """The numbers of channel attributes, read from their tracks, each track once."""
    if not len(nodes):
        return np.empty(0, np.float64)
    shapes = forest.shapes
    bones = shapes.bones[shapes.entries(nodes)]
    channels = slots_of(nodes) % BONE_WIDTH - FIRST_CHANNEL
    slot = shapes.slot_of(nodes)
    documents = documents_of(nodes)
    if len(nodes) >= MANY and (channels == channels[0]).all():
        names = shapes.names[shapes.entries(nodes)]
        if (names == names[0]).all():
            together = side_by_side(forest, shapes.texts[names[0]], int(channels[0]), documents, slot)
            if together is not None:
                return together
    result = np.empty(len(nodes), np.float64)
    # A track is (document, bone, chunk); sorted by it, the samples of a track are neighbours.
    track = (documents << 48) | (bones << 32) | (slot // CHUNK)
    order = np.argsort(track, kind="stable")
    starts, stops = find_equal(track[order]).T
    rows = _rows(forest, track[order[starts]])
    for row, data, start, stop in zip(
        rows, forest.caches.tracks.read(forest.tx, rows), starts.tolist(), stops.tolist(), strict=True
    ):
        some = order[start:stop]
        held = channels_of(row[4])
        columns = np.full(len(CHANNELS), -1)
        columns[held] = np.arange(len(held))
        result[some] = data[columns[channels[some]], slot[some] % CHUNK]
    return result


def _rows(forest: Forest, tracks: Ints) -> list[Row]:
    """Return the keys with which tracks (place << 48 | bone << 32 | chunk, ascending) are read."""
    if forest.has_tracks(len(np.unique(tracks >> 48))):
        return rows_of(forest.tracks.named(tracks).about)
    place = {key: number for number, key in enumerate(forest.keys)}
    found: dict[int, Row] = {}
    for asked, kept, chunks in _requests(forest, tracks >> 48, tracks >> 32 & 0xFFFF, tracks & 0xFFFFFFFF):
        for row in forest.tx.columns.tracks(asked, chunks, kept):
            document, chunk, bone, *_ = row
            found[(place[document] << 48) | (bone << 32) | chunk] = row
    return [found[track] for track in tracks.tolist()]


def _requests(
    forest: Forest, documents: Ints, bones: Ints, chunks: Ints
) -> list[tuple[list[int], list[int], tuple[int, int]]]:
    """(document keys, bones, chunks) to read: documents that need the same bones together."""
    groups: dict[tuple[int, ...], list[int]] = {}
    for document in np.unique(documents).tolist():
        which = documents == document
        groups.setdefault(tuple(np.unique(bones[which]).tolist()), []).append(document)
    result = []
    for kept, members in groups.items():
        which = np.isin(documents, members)
        span = (int(chunks[which].min()), int(chunks[which].max()))
        result.append(([forest.keys[member] for member in members], list(kept), span))
    return result


def _sample_texts(forest: Forest, nodes: Ints) -> Strings:
    return sample_texts(samples(forest, nodes))


def _bone_names(forest: Forest, nodes: Ints) -> Strings:
    return Strings(forest.shapes.names[forest.shapes.entries(nodes)], forest.shapes.texts)


def _id_texts(forest: Forest, nodes: Ints) -> Strings:
    ids, others = forest.ids.numbers(nodes)
    unique, codes = np.unique(ids, return_inverse=True)
    values = [str(number) for number in unique.tolist()]
    codes = codes.reshape(-1).astype(np.int64)
    for index, text in others.items():
        codes[index] = len(values)
        values.append(text)
    return Strings(codes, values)


def _frame_texts(forest: Forest, nodes: Ints) -> Strings:
    runs, codes = np.unique(forest.labels.run_of(nodes), return_inverse=True)
    return Strings(codes.reshape(-1).astype(np.int64), [_run_text(forest, run) for run in runs.tolist()])


def _run_text(forest: Forest, run: int) -> str:
    labels = forest.labels
    start, stop = labels.offsets[run], labels.offsets[run + 1]
    return "".join(labels.texts[code] for code in labels.names[start:stop].tolist())


def _of_head(forest: Forest, nodes: Ints) -> Strings:
    head = forest.head
    rows = head.rows(nodes)
    kinds = head.kinds[rows]
    plain = (kinds == IS_ATTRIBUTE) | (kinds == IS_TEXT) | (kinds == IS_NAMESPACE)
    leaves = head.leaves(rows)
    held = head.texts
    codes = held.codes[np.where(leaves, rows + 2, rows)]
    holders = np.flatnonzero(~(plain | leaves))
    # The texts inside an element follow one another among all texts.
    first = np.searchsorted(head.text_rows, rows[holders])
    counts = np.searchsorted(head.text_rows, head.ends[rows[holders]], side="right") - first
    single = np.flatnonzero(counts == 1)
    codes[holders[single]] = held.codes[head.text_rows[first[single]]]
    found = compact(Strings(codes, held.values))
    several = np.flatnonzero(counts > 1)
    motion = head.motions[documents_of(nodes)]
    moving = np.flatnonzero(~plain & (rows <= motion) & (motion <= head.ends[rows]))
    if not len(several) and not len(moving):
        return found
    texts = found.list()
    for place, begin, count in zip(
        holders[several].tolist(), first[several].tolist(), counts[several].tolist(), strict=True
    ):
        inside = held.codes[head.text_rows[begin : begin + count]].tolist()
        texts[place] = "".join([held.values[code] for code in inside])
    for place in moving.tolist():
        texts[place] += _motion_text(forest, int(documents_of(nodes[place])))
    return of_texts(texts)


def _motion_text(forest: Forest, document: int) -> str:
    """The motion names of all frames of a document."""
    labels = forest.labels
    runs = np.flatnonzero(labels.starts >> 24 == document)
    starts = labels.starts[runs] & ((1 << 24) - 1)
    lengths = np.diff(np.append(starts, forest.frames[document] + 1))
    texts = [_run_text(forest, run) for run in runs.tolist()]
    if sum(len(text) * length for text, length in zip(texts, lengths.tolist(), strict=True)) > MAX_TEXT:
        raise TooLongError
    return "".join(text * length for text, length in zip(texts, lengths.tolist(), strict=True))
