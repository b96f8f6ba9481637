"""The axes of XPath on arrays of nodes.

`step` takes context nodes and gives pairs (index of the context node, node reached), ordered by context and in
document order. Attributes have their element as parent and come between it and its children; as in libxml2, `following`
and `preceding` of an attribute are those of its element.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mcml.language.vocabulary import FRAME, FRAME_BONE, MOTION_NAME, NAME
from mcml.motion.skeleton import CHANNEL_INDEX
from mcml_service.xpath.engine.node_tests import kinds_and_names, passes
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.numbering import (
    BONE_WIDTH,
    BONES,
    DOCUMENT_SHIFT,
    FIRST_ATTRIBUTE,
    FRAME_SHIFT,
    IS_ATTRIBUTE,
    IS_DOCUMENT,
    IS_ELEMENT,
    IS_NAMESPACE,
    IS_TEXT,
    MAX_FRAMES,
    MOTION,
    NAME_TEXT,
    NAME_WIDTH,
    NAMES_FROM,
    NAMESPACE_SLOT,
    Bools,
    Floats,
    Ints,
    documents_of,
    frame_elements,
    frames_of,
    in_frames,
    name_codes,
    slots_of,
)
from mcml_service.xpath.nodes.pairs import NONE, Pairs, bounded, merge, where

SIBLINGS = frozenset({"following-sibling", "preceding-sibling"})
REVERSE = frozenset({"parent", "ancestor", "ancestor-or-self", "preceding", "preceding-sibling"})


def step(forest: Forest, nodes: Ints, axis: str, test: str) -> Pairs:
    """The nodes that an axis reaches and a node test lets pass."""
    if not len(nodes):
        return NONE
    source, reached = _AXES[axis](forest, nodes, test)
    keep = passes(forest, reached, axis, test)
    return (source, reached) if keep.all() else (source[keep], reached[keep])


def named_bones(forest: Forest, nodes: Ints, name: str) -> Pairs:
    """`child::frame_bone[@name='…']`."""
    return where(_is_frame(nodes), lambda some: forest.shapes.named(some, name), nodes)


def sibling_frames(forest: Forest, nodes: Ints, distance: int) -> Pairs:
    """`following-sibling::frame[n]` of frames, for a distance n; `preceding-sibling::frame[n]` for -n."""
    position = frames_of(nodes) + max(-MAX_FRAMES, min(distance, MAX_FRAMES))
    index = np.flatnonzero((position >= 1) & (position <= forest.frames[documents_of(nodes)]))
    return index, (documents_of(nodes[index]) << DOCUMENT_SHIFT) | (position[index] << FRAME_SHIFT)


def frames_at(forest: Forest, nodes: Ints, position: int) -> Pairs:
    """`child::frame[n]`."""
    found = children_of(forest, nodes, FRAME) >= position
    index = np.flatnonzero(found)
    return index, (documents_of(nodes[index]) << DOCUMENT_SHIFT) | (position << FRAME_SHIFT)


def children_of(forest: Forest, nodes: Ints, name: str) -> Floats:
    """How many children each node has that are frames, or frame_bones."""
    counts = np.zeros(len(nodes))
    if name == FRAME_BONE:
        index = np.flatnonzero(_is_frame(nodes))
        counts[index] = forest.shapes.sizes(nodes[index])
        return counts
    index = np.flatnonzero(~in_frames(nodes))
    documents = documents_of(nodes[index])
    is_motion = forest.head.rows(nodes[index]) == forest.head.motions[documents]
    counts[index] = np.where(is_motion, forest.frames[documents], 0)
    return counts


def are_frames(nodes: Ints) -> bool:
    return bool(_is_frame(nodes).all())


def _named_below(forest: Forest, nodes: Ints, test: str) -> Pairs:
    """Elements of a name below nodes of the head, found among all of that name."""
    head = forest.head
    rows = head.rows(nodes)
    named = head.named(name_codes().get(test, -1))
    begin = np.searchsorted(named, rows, side="right")
    source, within = bounded(np.searchsorted(named, head.ends[rows], side="right") - begin)
    return source, head.nodes(named[begin[source] + within])


def _head_children(forest: Forest, nodes: Ints, test: str) -> Pairs:
    if test in ("*", "node()", "text()"):
        return _of_rows(forest, nodes, children=True)
    source, rows = forest.head.children_named(name_codes().get(test, -1), forest.head.rows(nodes))
    return source, forest.head.nodes(rows)


def _of_rows(forest: Forest, nodes: Ints, *, children: bool) -> Pairs:
    """Elements and texts of the head below (or directly below) nodes of the head."""
    head = forest.head
    rows = head.rows(nodes)
    source, within = bounded(head.ends[rows] - rows)
    reached = rows[source] + 1 + within
    kinds = head.kinds[reached]
    keep = (kinds == IS_ELEMENT) | (kinds == IS_TEXT)
    if children:
        keep &= head.parents[reached] == rows[source]
    return source[keep], head.nodes(reached[keep])


def _frames_below(forest: Forest, nodes: Ints, *, direct: bool) -> Pairs:
    """Frames below nodes of the head: all of the document below motion, `mcml` and document; direct: below motion."""
    head = forest.head
    rows = head.rows(nodes)
    motion = head.motions[documents_of(nodes)]
    holds = rows == motion if direct else (rows <= motion) & (head.ends[rows] >= motion)
    holds &= (head.kinds[rows] == IS_ELEMENT) | (head.kinds[rows] == IS_DOCUMENT)
    index = np.flatnonzero(holds)
    documents = documents_of(nodes[index])
    source, position = bounded(forest.frames[documents])
    return index[source], (documents[source] << DOCUMENT_SHIFT) | ((position + 1) << FRAME_SHIFT)


def _below_frames(forest: Forest, frames: Ints, test: str) -> list[Pairs]:
    """Return everything in frames: motion_names, their texts, frame_bones; nodes that cannot match the test are left
    out.
    """
    parts = []
    if test in (MOTION_NAME, "text()", "*", "node()"):
        bounded(forest.labels.sizes(frames))
        source, names = forest.labels.children(frames)
        parts += [(source, names)] if test != "text()" else []
        parts += [(source, names + NAME_TEXT)] if test in ("text()", "node()") else []
    if test in (FRAME_BONE, "*", "node()"):
        bounded(forest.shapes.sizes(frames))
        parts.append(forest.shapes.children(frames))
    return parts


def _is_frame(nodes: Ints) -> Bools:
    return np.asarray((slots_of(nodes) == 0) & in_frames(nodes))


def _is_motion_name(nodes: Ints) -> Bools:
    slots = slots_of(nodes)
    named = (slots >= NAMES_FROM) & (slots < BONES) & (slots % NAME_WIDTH == 0)
    return np.asarray(named & in_frames(nodes))


def _is_frame_bone(nodes: Ints) -> Bools:
    slots = slots_of(nodes)
    return np.asarray((slots >= BONES) & (slots % BONE_WIDTH == 0) & in_frames(nodes))


def _self(forest: Forest, nodes: Ints, test: str) -> Pairs:
    return np.arange(len(nodes)), nodes


# -- downwards ---------------------------------------------------------------------------------------------------------


def _child(forest: Forest, nodes: Ints, test: str) -> Pairs:
    parts = []
    head = ~in_frames(nodes)
    if head.any():
        parts.append(where(head, lambda some: _head_children(forest, some, test), nodes))
        if test in (FRAME, "*", "node()"):
            parts.append(where(head, lambda some: _frames_below(forest, some, direct=True), nodes))
    if test in (MOTION_NAME, FRAME_BONE, "*", "node()"):
        frames = _is_frame(nodes)
        if frames.any():
            index = np.flatnonzero(frames)
            kept = "*" if test == "node()" else test
            parts += [(index[source], reached) for source, reached in _below_frames(forest, nodes[index], kept)]
    if test in ("text()", "node()"):
        parts.append(where(_is_motion_name(nodes), lambda some: (np.arange(len(some)), some + NAME_TEXT), nodes))
    return merge(parts)


def _descendant(forest: Forest, nodes: Ints, test: str) -> Pairs:
    parts = []
    head = ~in_frames(nodes)
    if head.any():
        if test in ("*", "node()", "text()"):
            parts.append(where(head, lambda some: _of_rows(forest, some, children=False), nodes))
        else:
            parts.append(where(head, lambda some: _named_below(forest, some, test), nodes))
        if test in (FRAME, MOTION_NAME, FRAME_BONE, "text()", "*", "node()"):
            source, frames = where(head, lambda some: _frames_below(forest, some, direct=False), nodes)
            parts += [(source, frames)] if test in (FRAME, "*", "node()") else []
            parts += [(source[inner], reached) for inner, reached in _below_frames(forest, frames, test)]
    framed = _is_frame(nodes)
    if framed.any():
        index = np.flatnonzero(framed)
        parts += [(index[source], reached) for source, reached in _below_frames(forest, nodes[index], test)]
    if test in ("text()", "node()"):
        parts.append(where(_is_motion_name(nodes), lambda some: (np.arange(len(some)), some + NAME_TEXT), nodes))
    return merge(parts)


def _descendant_or_self(forest: Forest, nodes: Ints, test: str) -> Pairs:
    return merge([_self(forest, nodes, test), _descendant(forest, nodes, test)])


def _attribute(forest: Forest, nodes: Ints, test: str) -> Pairs:
    parts = []
    framed = in_frames(nodes)
    if not framed.all():
        parts.append(where(~framed, lambda some: _head_kind(forest, some, IS_ATTRIBUTE), nodes))
    if test in ("id", "*", "node()"):
        parts.append(where(_is_frame(nodes), lambda some: (np.arange(len(some)), some + FIRST_ATTRIBUTE), nodes))
    bones = _is_frame_bone(nodes)
    if not bones.any():
        return merge(parts)
    if test == NAME:
        parts.append(where(bones, lambda some: (np.arange(len(some)), some + FIRST_ATTRIBUTE), nodes))
    elif test in CHANNEL_INDEX:
        parts.append(where(bones, lambda some: forest.shapes.channel(some, CHANNEL_INDEX[test]), nodes))
    elif test in ("*", "node()"):
        parts.append(where(bones, forest.shapes.attributes, nodes))
    return merge(parts)


def _head_kind(forest: Forest, nodes: Ints, kind: int) -> Pairs:
    """Attributes or namespace nodes of elements of the head: they follow their element."""
    head = forest.head
    rows = head.rows(nodes)
    source, within = bounded(np.where(head.kinds[rows] == IS_ELEMENT, np.minimum(head.ends[rows] - rows, 16), 0))
    reached = rows[source] + 1 + within
    keep = (head.parents[reached] == rows[source]) & (head.kinds[reached] == kind)
    return source[keep], head.nodes(reached[keep])


def _namespace(forest: Forest, nodes: Ints, test: str) -> Pairs:
    if test not in ("xml", "*", "node()"):
        return NONE
    kinds, _ = kinds_and_names(forest, nodes)
    return where(kinds == IS_ELEMENT, lambda some: (np.arange(len(some)), some + NAMESPACE_SLOT), nodes)


# -- upwards -----------------------------------------------------------------------------------------------------------


def parents(forest: Forest, nodes: Ints) -> Ints:
    """The parent of each node, -1 for document nodes."""
    slots = slots_of(nodes)
    if not in_frames(nodes).all():
        return _mixed_parents(forest, nodes)
    element = np.where(slots < NAMES_FROM, 0, np.where(slots < BONES, slots & ~3, slots & ~(BONE_WIDTH - 1)))
    inner = slots != element
    above = np.where(inner, frame_elements(nodes) | element, frame_elements(nodes))
    motion = (documents_of(nodes) << DOCUMENT_SHIFT) | MOTION
    return np.asarray(np.where(slots == 0, motion, above), np.int64)


def _mixed_parents(forest: Forest, nodes: Ints) -> Ints:
    result = np.empty(len(nodes), np.int64)
    framed = in_frames(nodes)
    if framed.any():
        result[framed] = parents(forest, nodes[framed])
    head = forest.head
    rows = head.rows(nodes[~framed])
    above = head.nodes(head.parents[rows])
    result[~framed] = np.where(head.kinds[rows] == IS_DOCUMENT, -1, above)
    return result


def _parent(forest: Forest, nodes: Ints, test: str) -> Pairs:
    above = parents(forest, nodes)
    index = np.flatnonzero(above >= 0)
    return index, above[index]


def _ancestor(forest: Forest, nodes: Ints, test: str) -> Pairs:
    parts: list[Pairs] = []
    index, current = np.arange(len(nodes)), nodes
    while len(index):
        above = parents(forest, current)
        kept = above >= 0
        index, current = index[kept], above[kept]
        parts.append((index, current))
    return merge(parts)


def _ancestor_or_self(forest: Forest, nodes: Ints, test: str) -> Pairs:
    return merge([_self(forest, nodes, test), _ancestor(forest, nodes, test)])


# -- sidewards ---------------------------------------------------------------------------------------------------------


def _siblings(forest: Forest, nodes: Ints, test: str, *, after: bool) -> Pairs:
    kinds, _ = kinds_and_names(forest, nodes)
    frames = _is_frame(nodes)
    parts = []
    if frames.any() and test in (FRAME, "*", "node()"):
        parts.append(where(frames, lambda some: _frame_siblings(forest, some, after=after), nodes))
    if frames.any() and not after and test != FRAME:
        # All children of motion other than frames come before them.
        parts.append(where(frames, lambda some: _of_rows(forest, parents(forest, some), children=True), nodes))
    others = ((kinds == IS_ELEMENT) | (kinds == IS_TEXT)) & ~frames
    parts.append(where(others, lambda some: _cut_children(forest, some, test, after=after), nodes))
    return merge(parts)


def _frame_siblings(forest: Forest, frames: Ints, *, after: bool) -> Pairs:
    position = frames_of(frames)
    source, within = bounded(forest.frames[documents_of(frames)] - position if after else position - 1)
    first = position + 1 if after else np.ones_like(position)
    return source, (documents_of(frames)[source] << DOCUMENT_SHIFT) | ((first[source] + within) << FRAME_SHIFT)


def _cut_children(forest: Forest, nodes: Ints, test: str, *, after: bool) -> Pairs:
    """The children of the parents of nodes, before or after the nodes."""
    unique, inverse = np.unique(parents(forest, nodes), return_inverse=True)
    source, children = _child(forest, unique, test)
    begin, end = np.searchsorted(source, inverse, "left"), np.searchsorted(source, inverse, "right")
    pairs, within = bounded(end - begin)
    reached = children[begin[pairs] + within]
    keep = reached > nodes[pairs] if after else reached < nodes[pairs]
    return pairs[keep], reached[keep]


def _following_sibling(forest: Forest, nodes: Ints, test: str) -> Pairs:
    return _siblings(forest, nodes, test, after=True)


def _preceding_sibling(forest: Forest, nodes: Ints, test: str) -> Pairs:
    return _siblings(forest, nodes, test, after=False)


def _beyond(forest: Forest, nodes: Ints, test: str, *, after: bool) -> Pairs:
    """`following` and `preceding`: the subtrees of siblings of a node and of its ancestors."""
    kinds, _ = kinds_and_names(forest, nodes)
    inside = (kinds == IS_ATTRIBUTE) | (kinds == IS_NAMESPACE)
    start = np.where(inside, parents(forest, nodes), nodes) if inside.any() else nodes
    source, lines = _ancestor_or_self(forest, start, "node()")
    inner, siblings = _siblings(forest, lines, "node()", after=after)
    source = source[inner]
    below, reached = _descendant_or_self(forest, siblings, test)
    return merge([(source[below], reached)])


def _following(forest: Forest, nodes: Ints, test: str) -> Pairs:
    return _beyond(forest, nodes, test, after=True)


def _preceding(forest: Forest, nodes: Ints, test: str) -> Pairs:
    return _beyond(forest, nodes, test, after=False)


_AXES: dict[str, Callable[[Forest, Ints, str], Pairs]] = {
    "self": _self,
    "child": _child,
    "descendant": _descendant,
    "descendant-or-self": _descendant_or_self,
    "attribute": _attribute,
    "namespace": _namespace,
    "parent": _parent,
    "ancestor": _ancestor,
    "ancestor-or-self": _ancestor_or_self,
    "following-sibling": _following_sibling,
    "preceding-sibling": _preceding_sibling,
    "following": _following,
    "preceding": _preceding,
}
