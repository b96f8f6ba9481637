"""Nodes as what an answer shows: kind, canonical address, value."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from service.mcml.vocabulary import FRAME_BONE, MOTION_NAME
from service.motion.skeleton import CHANNELS
from service.xpath.forest import Forest
from service.xpath.node_tests import kinds_and_names
from service.xpath.numbering import (
    BONE_WIDTH,
    BONES,
    FIRST_ATTRIBUTE,
    IS_NAMESPACE,
    KIND_NAMES,
    NAME_WIDTH,
    NAMES_FROM,
    NAMESPACE_SLOT,
    Ints,
    frames_of,
    slots_of,
)
from service.xpath.worker import NAMESPACE


def describe_nodes(forest: Forest, nodes: Ints) -> Iterator[tuple[str, str]]:
    """(kind, address) of each node. An address is an XPath that finds the node."""
    kinds, _ = kinds_and_names(forest, nodes)
    frames, slots = frames_of(nodes), slots_of(nodes)
    inner = np.flatnonzero(frames > 0)
    outer = np.flatnonzero(frames == 0)
    addresses = forest.head.addresses(forest.head.rows(nodes[outer])) if len(outer) else []
    if not len(inner):
        yield from zip([KIND_NAMES[kind] for kind in kinds.tolist()], addresses, strict=True)
        return
    names = dict(zip(inner.tolist(), forest.labels.sizes(nodes[inner]).tolist(), strict=True))
    outside = dict(zip(outer.tolist(), addresses, strict=True))
    for place, (kind, frame, slot) in enumerate(zip(kinds.tolist(), frames.tolist(), slots.tolist(), strict=True)):
        if frame and kind == IS_NAMESPACE:
            element = _in_frame(slot - NAMESPACE_SLOT, names[place])
            yield KIND_NAMES[kind], f"/mcml/motion/frame[{frame}]{element}/{NAMESPACE}"
        elif frame:
            yield KIND_NAMES[kind], f"/mcml/motion/frame[{frame}]{_in_frame(slot, names[place])}"
        else:
            yield KIND_NAMES[kind], outside[place]


def _in_frame(slot: int, names: int) -> str:
    if slot == 0:
        return ""
    if slot < NAMES_FROM:
        return "/@id"
    if slot < BONES:
        number, place = divmod(slot - NAMES_FROM, NAME_WIDTH)
        numbered = f"[{number + 1}]" if names > 1 else ""
        return f"/{MOTION_NAME}{numbered}" + ("/text()" if place > NAMESPACE_SLOT else "")
    number, place = divmod(slot - BONES, BONE_WIDTH)
    attribute = "" if place == 0 else f"/@{('name', *CHANNELS)[place - FIRST_ATTRIBUTE]}"
    return f"/{FRAME_BONE}[{number + 1}]{attribute}"
