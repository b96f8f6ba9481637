"""Describe nodes for an answer: kind, canonical address, value."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mcml.language.addresses import address_attribute, address_child, address_frame, address_namespace, address_text
from mcml.language.vocabulary import FRAME_BONE, MOTION_NAME
from mcml.motion.skeleton import CHANNELS
from mcml_service.xpath.engine.node_tests import kinds_and_names
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.numbering import (
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
            element = _in_frame(frame, slot - NAMESPACE_SLOT, names[place])
            yield KIND_NAMES[kind], address_namespace(element)
        elif frame:
            yield KIND_NAMES[kind], _in_frame(frame, slot, names[place])
        else:
            yield KIND_NAMES[kind], outside[place]


_BONE_ATTRIBUTES = ("name", *CHANNELS)


def _in_frame(frame: int, slot: int, names: int) -> str:
    """names: how many motion names the frame has."""
    if slot >= BONES:
        number, place = divmod(slot - BONES, BONE_WIDTH)
        bone = address_child(frame, FRAME_BONE, number + 1)
        return bone if place == 0 else address_attribute(bone, _BONE_ATTRIBUTES[place - FIRST_ATTRIBUTE])
    here = address_frame(frame)
    if slot < NAMES_FROM:
        return address_attribute(here, "id") if slot else here
    number, place = divmod(slot - NAMES_FROM, NAME_WIDTH)
    name = address_child(frame, MOTION_NAME, number + 1) if names > 1 else f"{here}/{MOTION_NAME}"
    return address_text(name) if place > NAMESPACE_SLOT else name
