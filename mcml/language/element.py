"""One element of a document, and its place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from mcml.language.addresses import number_steps
from mcml.language.lexical import WHITE_SPACE


@dataclass(slots=True)
class Element:
    """One element: tag, attributes in order, text (only of leaves), children."""

    tag: str
    attributes: dict[str, str] = field(default_factory=dict)
    text: str = ""
    children: list[Element] = field(default_factory=list)

    def first(self, tag: str) -> Element | None:
        """The first child of that tag, None without one."""
        return next((child for child in self.children if child.tag == tag), None)

    def all(self, tag: str) -> list[Element]:
        """The children of that tag, in order."""
        return [child for child in self.children if child.tag == tag]

    def leaf(self, tag: str) -> str | None:
        """The trimmed text of the first child of that tag, None without one."""
        child = self.first(tag)
        return None if child is None else child.text.strip(WHITE_SPACE)


def leaf(tag: str, text: str, **attributes: str) -> Element:
    """An element that holds text only."""
    return Element(tag, attributes, text)


def elements(element: Element) -> Iterator[Element]:
    """The element and all below it, in document order."""
    stack = [element]
    while stack:
        current = stack.pop()
        yield current
        stack += reversed(current.children)


def addresses(element: Element, address: str = "") -> Iterator[tuple[str, Element]]:
    """Every element of the tree in document order with its canonical address, such as `/mcml/skeleton/bone[2]/name`.

    A step carries its position where siblings of the same tag exist, so that an address is an XPath that finds
    exactly its element. address: that of the element itself; "" for the document element.
    """
    stack = [(address or f"/{element.tag}", element)]
    while stack:
        here, current = stack.pop()
        yield here, current
        if not current.children:
            continue
        steps = number_steps([child.tag for child in current.children])
        below = [(f"{here}/{step}", child) for step, child in zip(steps, current.children, strict=True)]
        stack.extend(reversed(below))
