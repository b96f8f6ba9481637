"""Nodes as what an answer shows: kind, canonical address, value."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from service.mcml.vocabulary import FRAME_BONE, MOTION_NAME
from service.motion.skeleton import CHANNELS
from service.xpath.axes import kinds_and_names
from service.xpath.forest import Forest
from service.xpath.numbering import (
    BONE_WIDTH,
    BONES,
    FIRST_ATTRIBUTE,
    IS_ATTRIBUTE,
    IS_DOCUMENT,
    IS_ELEMENT,
    IS_NAMESPACE,
    IS_TEXT,
    KIND_NAMES,
    NAME_WIDTH,
    NAMES_FROM,
    NAMESPACE_SLOT,
    Ints,
    code_names,
    frames_of,
    slots_of,
)


def describe_nodes(forest: Forest, nodes: Ints) -> Iterator[tuple[str, str]]:
    """(kind, address) of each node. An address is an XPath that finds the node; a namespace node has none."""
    kinds, _ = kinds_and_names(forest, nodes)
    frames, slots = frames_of(nodes), slots_of(nodes)
    inner = np.flatnonzero(frames > 0)
    names = dict(zip(inner.tolist(), forest.labels.sizes(nodes[inner]).tolist(), strict=True)) if len(inner) else {}
    head = _HeadAddresses(forest)
    for place, (node, kind, frame, slot) in enumerate(
        zip(nodes.tolist(), kinds.tolist(), frames.tolist(), slots.tolist(), strict=True)
    ):
        if kind == IS_NAMESPACE:
            yield KIND_NAMES[kind], ""
        elif frame:
            yield KIND_NAMES[kind], f"/mcml/motion/frame[{frame}]{_in_frame(slot, names[place])}"
        else:
            yield KIND_NAMES[kind], head.of(node)


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


class _HeadAddresses:
    """Addresses of nodes outside of frames; the children of an element are counted once."""

    def __init__(self, forest: Forest) -> None:
        self._forest = forest
        self._known: dict[int, str] = {}

    def of(self, node: int) -> str:
        head = self._forest.head
        return self._row(int(head.rows(np.array([node]))[0]))

    def _row(self, row: int) -> str:
        head = self._forest.head
        kind = int(head.kinds[row])
        if kind == IS_DOCUMENT:
            return "/"
        parent = int(head.parents[row])
        if row in self._known:
            return self._known[row]
        above = self._row(parent).rstrip("/")
        name = code_names()[head.names[row]]
        if kind == IS_ATTRIBUTE:
            return f"{above}/@{name}"
        if kind == IS_TEXT:
            return f"{above}/text()"
        inside = np.arange(parent + 1, head.ends[parent] + 1)
        siblings = inside[(head.parents[inside] == parent) & (head.kinds[inside] == IS_ELEMENT)]
        codes = head.names[siblings].tolist()
        total = Counter(codes)
        seen: Counter[int] = Counter()
        for sibling, code in zip(siblings.tolist(), codes, strict=True):
            seen[code] += 1
            numbered = f"[{seen[code]}]" if total[code] > 1 else ""
            self._known[sibling] = f"{above}/{code_names()[code]}{numbered}"
        return self._known[row]
