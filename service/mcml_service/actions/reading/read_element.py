"""One element of a stored document by its canonical address, such as `/mcml/motion/frame[100]/frame_bone[3]`."""

from __future__ import annotations

import re

import orjson

from mcml.errors import NotFoundError, Place
from mcml.language.addresses import address_frame, read_frame_address, split_attribute
from mcml.language.elements import Element, addresses, leaf
from mcml.language.lexical import escape
from mcml.language.vocabulary import FRAMES, FRAMETIME
from mcml.language.writer import write_element
from mcml.motion.skeleton import CHANNELS
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.motion_names import names_of_frames
from mcml_service.storage.transaction import Transaction

LEAF = re.compile(r"/mcml/motion/(frames|frametime)(?:/@[A-Za-z]+)?")
HEAD = re.compile(
    r"(?P<element>/mcml(?:/(?:header|root|skeleton)(?:/[a-z_]+(?:\[\d{1,9}\])?)*)?)(?:/@(?P<attribute>[A-Za-z_]+))?"
)


def read_element(tx: Transaction, stored: StoredDocument, address: str) -> bytes:
    """The element as XML, or the value of an attribute. NotFoundError."""
    element = element_at(tx, stored, address)
    _, attribute = split_attribute(address)
    if attribute is None:
        return write_element(element)
    if attribute not in element.attributes:
        raise missing_at(address)
    return element.attributes[attribute].encode()


def missing_at(address: str) -> NotFoundError:
    """Return the error for an address without an element."""
    return NotFoundError("The document has nothing at this address.", at=Place(element=address))


def element_at(tx: Transaction, stored: StoredDocument, address: str) -> Element:
    """The element at a canonical address, with all it holds. NotFoundError."""
    leaf, place = LEAF.fullmatch(address), read_frame_address(address)
    if leaf:
        if leaf[1] == FRAMES:
            return Element(FRAMES, {}, str(stored.frames))
        if stored.frame_time is None:
            raise missing_at(address)
        return Element(FRAMETIME, {}, stored.frame_time)
    if place is None:
        return _head_element(tx, stored, address)
    frame = frame_at(tx, stored, place.frame)
    if not place.tag:
        return frame
    of_tag = frame.all(place.tag)
    if not 1 <= place.number <= len(of_tag):
        raise missing_at(address)
    return of_tag[place.number - 1]


def _head_element(tx: Transaction, stored: StoredDocument, address: str) -> Element:
    match = HEAD.fullmatch(address)
    for here, element in addresses(tx.heads.document(stored)):
        if match is not None and here == match["element"]:
            return element
    raise missing_at(address)


def frame_at(tx: Transaction, stored: StoredDocument, position: int) -> Element:
    """The frame element at a position, with all it holds. NotFoundError."""
    if not 1 <= position <= stored.frames:
        raise NotFoundError(f"The document has {stored.frames} frames.", at=Place(element=address_frame(position)))
    names = tx.heads.bone_names(stored.key)
    block = next(tx.tracks.blocks(stored.key, position, position))
    shape = block.shapes[0 if block.shape_of is None else int(block.shape_of[0])]
    place = {column: index for index, column in enumerate(block.columns)}
    frame = Element("frame", {"id": str(block.ids[0])})
    labels = names_of_frames(tx.spans.of(stored.key, position, position), range(position, position + 1))
    frame.children += [leaf("motion_name", escape(name)) for name in (labels[0] if labels else ())]
    for bone, bits in shape:
        attributes = {"name": escape(names[bone])}
        for channel, name in enumerate(CHANNELS):
            if bits >> channel & 1:
                attributes[name] = orjson.dumps(float(block.values[0, place[bone, channel]])).decode()
        frame.children.append(Element("frame_bone", attributes))
    return frame
