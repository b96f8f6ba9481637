"""Nodes as numbers: every node of every document in scope is a 64-bit integer, and document order is their order.

    bits 48–62  document    its index in the batch, from 0
    bits 24–47  frame       its position from 1; 0 for nodes outside frames
    bits  0–23  slot        the node in the frame, or in the head

A frame has its own element in slot 0, its namespace node in 1, `@id` in 2; motion names from slot 16 in fours (element,
namespace, text); frame_bones from slot BONES in sixteens (element, namespace, `@name`, then the channels in order).
The head numbers its nodes in document order from 0, the document node. `motion` and its content other than frames begin
at slot MOTION, so that the numbers of frames need no head. Numbers have gaps; nothing else is lost by that, and most
axes become arithmetic on arrays (compare Grust 2002, "Accelerating XPath location steps").
"""

from __future__ import annotations

from functools import cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml.language.content import declarations
from mcml.language.vocabulary import FRAME, FRAME_BONE, MOTION_NAME, NAME
from mcml.motion.skeleton import CHANNELS

Ints: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]
Floats: TypeAlias = NDArray[np.float64]

DOCUMENT_SHIFT, FRAME_SHIFT = 48, 24
SLOT_MASK = (1 << FRAME_SHIFT) - 1
FRAME_MASK = (1 << (DOCUMENT_SHIFT - FRAME_SHIFT)) - 1
MAX_DOCUMENTS = 1 << 15
MAX_FRAMES = FRAME_MASK

NAMES_FROM, NAME_WIDTH = 16, 4
BONES, BONE_WIDTH = 1 << 20, 16
MOTION = 1 << 23

NAMESPACE_SLOT, FIRST_ATTRIBUTE, NAME_TEXT = 1, 2, 2
FIRST_CHANNEL = FIRST_ATTRIBUTE + 1
"""Place of the channel Tx in a frame_bone's sixteen slots, behind element, namespace and `@name`."""

IS_DOCUMENT, IS_ELEMENT, IS_ATTRIBUTE, IS_TEXT, IS_NAMESPACE = range(5)
KIND_NAMES = ("document", "element", "attribute", "text", "namespace")


@cache
def name_codes() -> dict[str, int]:
    """A small number for every element and attribute name of the language; "" is 0 and "xml" names namespace nodes."""
    names = {"": 0, "xml": 1}
    for tag, declaration in declarations().items():
        for name in (tag, *declaration.attributes):
            names.setdefault(name, len(names))
    return names


@cache
def code_names() -> list[str]:
    return list(name_codes())


def documents_of(nodes: Ints) -> Ints:
    return nodes >> DOCUMENT_SHIFT


def frames_of(nodes: Ints) -> Ints:
    """Return the positions of the nodes' frames, 0 for the head."""
    return (nodes >> FRAME_SHIFT) & FRAME_MASK


def slots_of(nodes: Ints) -> Ints:
    return nodes & SLOT_MASK


def in_frames(nodes: Ints) -> Bools:
    return np.asarray(frames_of(nodes) > 0)


def frame_elements(nodes: Ints) -> Ints:
    """The frame element of each node in a frame."""
    return nodes & ~SLOT_MASK


def first_of_documents(documents: Ints) -> Ints:
    """The document node of each document."""
    return documents << DOCUMENT_SHIFT


@cache
def _bone_slots() -> tuple[NDArray[np.int8], NDArray[np.int16]]:
    """Kind and name code of each of a frame_bone's sixteen slots."""
    codes = name_codes()
    kinds = np.full(BONE_WIDTH, IS_ATTRIBUTE, np.int8)
    names = np.zeros(BONE_WIDTH, np.int16)
    kinds[:2] = IS_ELEMENT, IS_NAMESPACE
    names[:3] = codes[FRAME_BONE], codes["xml"], codes[NAME]
    names[FIRST_CHANNEL : FIRST_CHANNEL + len(CHANNELS)] = [codes[channel] for channel in CHANNELS]
    return kinds, names


@cache
def _frame_slots() -> tuple[NDArray[np.int8], NDArray[np.int16]]:
    """Kind and name code of the slots below NAMES_FROM and then of one motion_name's four."""
    codes = name_codes()
    kinds = np.array([IS_ELEMENT, IS_NAMESPACE, IS_ATTRIBUTE, IS_ELEMENT, IS_NAMESPACE, IS_TEXT], np.int8)
    names = np.array([codes[FRAME], 1, codes["id"], codes[MOTION_NAME], 1, 0], np.int16)
    return kinds, names


def frame_kinds(slots: Ints) -> tuple[NDArray[np.int8], NDArray[np.int16]]:
    """(kind, name code) of nodes in frames by their slots."""
    kinds, names = _bone_slots()
    place = slots & (BONE_WIDTH - 1)
    low = slots < BONES
    if not low.any():
        return kinds[place], names[place]
    small_kinds, small_names = _frame_slots()
    # A motion_name's slots come after the frame's three in that table.
    small = np.where(slots < NAMES_FROM, slots, 3 + (slots & (NAME_WIDTH - 1)))
    small = np.where(low, small, 0)
    return np.where(low, small_kinds[small], kinds[place]), np.where(low, small_names[small], names[place])
