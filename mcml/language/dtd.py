"""Validation against `mcml.dtd` by libxml2: a second check, also for documents that the service makes.

Validity is local to an element: a frame is valid exactly when its attributes and the sequence of its children match.
So a motion is valid when one frame of every distinct shape is, and a converted clip of any length is validated by its
head and those. Uploaded documents are validated as they stream (`mcml.language.reader`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from functools import cache
from io import BytesIO
from typing import Any, BinaryIO

from lxml import etree

from mcml.errors import DocumentError, Place
from mcml.language.element import Element
from mcml.language.lexical import WHITE_SPACE, escape
from mcml.language.prologue import has_doctype, refused_doctype, utf8_chunks
from mcml.language.vocabulary import FRAME, FRAME_BONE, FRAMES, FRAMETIME, MOTION, MOTION_NAME, NAME
from mcml.language.writer import write_element
from mcml.motion.clip import Shape
from mcml.motion.skeleton import CHANNELS
from mcml.resources import dtd_path

MOST_FAULTS = 20
"""Limit for one message: more faults need no list."""

MOST_KNOWN = 4096
"""Kinds of documents that were valid and are remembered."""

MAX_BYTES = 256 << 20
"""Of a document that is validated as a tree, which takes several times as much memory."""


def violations(document: bytes | BinaryIO, max_bytes: int = MAX_BYTES) -> list[DocumentError]:
    """Return all violations in a document, each with its line; [] for a valid one.

    Raises DocumentError if it is not well-formed or has its own DOCTYPE, LimitError beyond max_bytes.
    """
    stream = BytesIO(document) if isinstance(document, bytes) else document
    data = b"".join(utf8_chunks(stream, max_bytes))
    if has_doctype(data):
        raise refused_doctype(None, "it is not MCML's own")
    try:
        root = etree.fromstring(data, _parser())
    except etree.XMLSyntaxError as error:
        line, column = error.position
        raise DocumentError(f"not well-formed XML: {error.msg}", at=Place(line=line, column=column)) from None
    dtd = _dtd()
    if dtd.validate(root):
        return []
    return [
        DocumentError(entry.message.strip(), at=Place(line=entry.line, element=entry.path or None))
        for entry in dtd.error_log.filter_from_errors()
    ]


def validate(document: bytes | BinaryIO, max_bytes: int = MAX_BYTES) -> None:
    """Raises DocumentError with all violations for a document that is not valid, at the place of the first."""
    found = violations(document, max_bytes)
    if found:
        faults = [(error.at.element or "" if error.at else "", error.what) for error in found]
        raise DocumentError(told(faults), at=found[0].at)


def told(faults: Sequence[tuple[str, str]]) -> str:
    """Join faults, each an (address, what), in one message: several as a list."""
    if len(faults) == 1:
        return faults[0][1]
    more = f", of which the first {MOST_FAULTS} are" if len(faults) > MOST_FAULTS else ""
    return f"{len(faults)} faults{more}: " + "; ".join(f"{address}: {what}" for address, what in faults[:MOST_FAULTS])


def validate_by_shapes(document: Element, shapes: Iterable[tuple[Shape, int]], names: Sequence[str]) -> None:
    """Raises DocumentError unless the document with frames of these shapes would be valid.

    document: the `mcml` element without its motion. shapes: each with a number of motion names. names: of the joints.
    """
    frames = {(tuple({bits: (joint, bits) for joint, bits in shape}.values()), count) for shape, count in shapes}
    validate_frames(document, (frame_of(shape, count, names) for shape, count in sorted(frames)))


def validate_often(document: Element, shapes: Iterable[tuple[Shape, int]], names: Sequence[str]) -> None:
    """As `validate_by_shapes`, for many documents that differ only in parts without effect on validity, mostly file
    names. A document equal to a valid one in all other parts is not serialised, parsed and validated again.
    """
    shapes = list(shapes)
    alike = hashlib.sha256(repr((_likeness(document), shapes, tuple(names))).encode("utf-8", "backslashreplace"))
    if (digest := alike.digest()) in _KNOWN_VALID:
        return
    validate_by_shapes(document, shapes, names)
    if len(_KNOWN_VALID) >= MOST_KNOWN:
        _KNOWN_VALID.clear()
    _KNOWN_VALID.add(digest)


_KNOWN_VALID: set[bytes] = set()


def _likeness(element: Element) -> tuple[object, ...]:
    """Return all parts of an element that can affect its validity: of free texts only whether they exist and are
    blank.
    """
    choices = _choices()
    attributes = [
        (name, value if (element.tag, name) in choices else _kind(value)) for name, value in element.attributes.items()
    ]
    return element.tag, attributes, _kind(element.text), [_likeness(child) for child in element.children]


def _kind(text: str) -> str | bool:
    """Tell whether a text is more than blanks; return the text itself if it is None, or has characters that XML may
    not allow.
    """
    return True if text.isprintable() and text.strip(WHITE_SPACE) else text


@cache
def _choices() -> frozenset[tuple[str, str]]:
    """(element, attribute) of those whose values the DTD lists."""
    return frozenset(
        (element.name, attribute.name)
        for element in _dtd().iterelements()
        for attribute in element.iterattributes()
        if attribute.type != "cdata"
    )


def validate_frames(document: Element, frames: Iterable[Element]) -> None:
    """Raises DocumentError unless the document with these frames as its motion is valid; tries one of each shape."""
    motion = Element(MOTION, children=[Element(FRAMES, text="0"), Element(FRAMETIME, text="0")])
    motion.children += {_shape_key(frame): frame for frame in frames}.values()
    children = [child for child in document.children if child.tag != MOTION]
    validate(write_element(Element(document.tag, document.attributes, document.text, [*children, motion])))


def frame_of(shape: Shape, motion_names: int, names: Sequence[str]) -> Element:
    """Return a frame of a shape with a number of motion names."""
    frame = Element(FRAME, {"id": "1"}, children=[Element(MOTION_NAME, text="name") for _ in range(motion_names)])
    for joint, bits in shape:
        channels = {channel: "0" for place, channel in enumerate(CHANNELS) if bits >> place & 1}
        frame.children.append(Element(FRAME_BONE, {NAME: escape(names[joint])} | channels))
    return frame


def _shape_key(frame: Element) -> tuple[object, ...]:
    """Return all parts of a frame that can affect its validity: tags, attribute names, and whether there is no, blank,
    or other text. Blank text is allowed between elements, but not in empty elements.
    """
    return (
        frame.tag,
        tuple(frame.attributes),
        bool(frame.text),
        bool(frame.text.strip(WHITE_SPACE)),
        tuple(_shape_key(child) for child in frame.children),
    )


@cache
def _parser() -> Any:
    return etree.XMLParser(
        encoding="utf-8", resolve_entities=False, no_network=True, load_dtd=False, huge_tree=True, recover=False
    )


@cache
def _dtd() -> Any:
    with dtd_path().open("rb") as stream:
        return etree.DTD(stream)
