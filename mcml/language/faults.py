"""Check frames before they are inserted into a document: read them as its motion, or list every fault with its address.

A reader stops at the first fault and knows its line. A person who inserts elements works with addresses, and needs all
faults at once. So refused frames are read again in parts, down to single attributes.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence

from mcml.errors import DocumentError, Place
from mcml.language.addresses import address_attribute, address_frame
from mcml.language.dtd import MOST_FAULTS, told
from mcml.language.element import Element, leaf
from mcml.language.reader import read_document
from mcml.language.vocabulary import FRAME, FRAME_BONE, MOTION, NAME
from mcml.language.writer import write_element
from mcml.motion.clip import FrameBlock


def read_frames(head: Element, frames: Sequence[Element]) -> list[FrameBlock]:
    """Frames as blocks, read and validated as the motion of a document with this head. DocumentError for the first
    fault."""
    header = head.children[0]
    # Counts that the header repeats are those of the whole document.
    header = Element(header.tag, header.attributes, header.text, [c for c in header.children if c.tag != "num_frames"])
    motion = Element(MOTION, {}, "", [leaf("frames", str(len(frames))), *frames])
    document = Element(head.tag, head.attributes, head.text, [header, *head.children[1:], motion])
    return list(read_document(io.BytesIO(write_element(document))).clip.blocks())


def all_faults(head: Element, frames: Sequence[Element], at: int, first: DocumentError) -> DocumentError:
    """Return the error for frames that are inserted at position `at`: each fault with its address, in order.

    first: the error without addresses; it is used if no part of a frame has a fault.
    """
    found: list[tuple[str, str]] = []
    for number, frame in enumerate(frames):
        found += _faults(head, frame, address_frame(at + number))
        if len(found) > MOST_FAULTS:
            break
    if not found:
        found = [(address_frame(at), first.what)]
    return DocumentError(told(found), at=Place(element=found[0][0]), remedy=first.remedy if len(found) == 1 else None)


def _faults(head: Element, frame: Element, address: str) -> Iterator[tuple[str, str]]:
    """Yield (address, fault) of a frame: of its attributes, of each child, or else of the whole frame."""
    whole = _fault(head, frame)
    if whole is None:
        return
    bare = None if frame.tag != FRAME else _fault(head, Element(frame.tag, frame.attributes, frame.text))
    own = [] if bare is None else [(address, bare)]
    kept = Element(FRAME, {"id": "1"})
    counts: dict[str, int] = {}
    for child in frame.children if frame.tag == FRAME else ():
        counts[child.tag] = counts.get(child.tag, 0) + 1
        own += _child_faults(head, kept, child, f"{address}/{child.tag}[{counts[child.tag]}]")
    yield from own or [(address, whole)]


def _child_faults(head: Element, frame: Element, child: Element, address: str) -> list[tuple[str, str]]:
    whole = _fault(head, Element(frame.tag, frame.attributes, "", [child]))
    if whole is None:
        return []
    found = []
    if child.tag == FRAME_BONE and NAME in child.attributes:
        for name, text in child.attributes.items():
            attributes = {NAME: child.attributes[NAME]} | {name: text}
            fault = _fault(head, Element(frame.tag, frame.attributes, "", [Element(child.tag, attributes)]))
            if fault is not None:
                found.append((address_attribute(address, name), fault))
            if name == NAME and fault is not None:
                # Nothing else can be checked for an unknown bone.
                break
    return found or [(address, whole)]


def _fault(head: Element, frame: Element) -> str | None:
    try:
        read_frames(head, [frame])
    except DocumentError as error:
        return error.what
    return None
