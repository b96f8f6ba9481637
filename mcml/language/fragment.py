"""Pieces of MCML: one or more elements without a document around them."""

from __future__ import annotations

from typing import Any

from lxml import etree

from mcml.errors import DocumentError, LimitError, Place
from mcml.language.element import Element
from mcml.language.lexical import WHITE_SPACE

MOST_BYTES = 64 << 20
MOST_ATTRIBUTES = 64
"""Of one element, more than any of MCML may have: lxml lists n of them in a time that grows with n²."""
_AROUND = b"fragment"


def read_fragment(content: bytes) -> list[Element]:
    """The elements of a piece of XML in UTF-8. DocumentError where it is not well-formed, or holds anything else.

    Nothing is validated: that can only be done at the place where the elements go.
    """
    if len(content) > MOST_BYTES:
        raise LimitError(f"The fragment has more than {MOST_BYTES >> 20} MiB.", remedy="Insert it in parts.")
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=True, remove_comments=True, remove_pis=True
    )
    # On the first line, so that the lines of errors are those of the fragment.
    text = content.removeprefix(b"\xef\xbb\xbf").strip()
    if text.startswith(b"<?xml"):
        text = text[text.find(b"?>") + 2 :]
    try:
        parser.feed(b"<%b>" % _AROUND)
        parser.feed(text)
        parser.feed(b"</%b>" % _AROUND)
        root: Any = parser.close()
    except etree.XMLSyntaxError as error:
        raise DocumentError(
            f"The fragment is not well-formed: {error.msg}",
            at=Place(line=error.lineno or None),
            remedy="Send one or more MCML elements.",
        ) from error
    found = [_element(child) for child in root]
    if not found or (root.text or "").strip(WHITE_SPACE) or any((child.tail or "").strip() for child in root):
        raise DocumentError(
            "The fragment has no element, or text outside its elements.", remedy="Send MCML elements only."
        )
    return found


def _element(root: Any) -> Element:
    result = Element("")
    waiting = [(root, result)]
    while waiting:
        node, element = waiting.pop()
        if not isinstance(node.tag, str):
            raise DocumentError("The fragment holds an entity.", remedy="Write the text itself.")
        element.tag = node.tag
        if len(node.attrib) > MOST_ATTRIBUTES:
            raise DocumentError(
                f"{node.tag} has {len(node.attrib)} attributes.",
                at=Place(line=node.sourceline),
                remedy="Send those that MCML knows.",
            )
        element.attributes = {str(name): str(value) for name, value in node.attrib.items()}
        element.text = (node.text or "").strip(WHITE_SPACE)
        if len(node) and (element.text or any((child.tail or "").strip(WHITE_SPACE) for child in node)):
            raise DocumentError(f"{node.tag} has text between elements.", at=Place(line=node.sourceline))
        for child in node:
            inner = Element("")
            element.children.append(inner)
            waiting.append((child, inner))
    return result
