"""Nodes of real documents that generated expressions are written about, so that answers are seldom empty.

A witness is a node that the expression so far selects. These moves need not be complete or exact, as an XPath engine's
must be: they only propose where a path could lead.
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import Any


@dataclass(frozen=True)
class Witness:
    """kind: document, element, attribute, text or namespace. element: itself, or the one that it belongs to."""

    kind: str
    element: Any
    name: str = ""

    @property
    def value(self) -> str:
        """The string of the node."""
        if self.kind == "attribute":
            return str(self.element.get(self.name))
        if self.kind == "text":
            return str(self.element.text)
        return "" if self.kind == "namespace" else "".join(self.element.itertext())

    def evaluate(self, text: str) -> Any:
        """What libxml2 makes of an expression here; None where the node cannot be asked."""
        if self.kind != "element":
            return None
        try:
            return self.element.xpath(text)
        except Exception:  # whatever it is, the campaign meets it again and judges it
            return None


def element(found: Any) -> Witness:
    return Witness("element", found)


def move(node: Witness, axis: str, random: Random) -> Witness | None:
    """A node that an axis reaches, None if there is none."""
    return _MOVES[axis](node, random)


def child(node: Witness, random: Random, name: str = "") -> Witness | None:
    """A child; of a name, if one is given."""
    if node.kind == "document":
        return element(node.element)
    if node.kind != "element":
        return None
    if node.element.text:
        return Witness("text", node.element)
    count = len(node.element)
    if name:
        held = node.element.findall(name)
        return element(random.choice(held)) if held else None
    # Frames are nearly all children of motion: what stands before them is asked about as well.
    return element(node.element[random.randrange(count if random.random() < 0.6 else min(count, 4))]) if count else None


def _descendant(node: Witness, random: Random) -> Witness | None:
    found = child(node, random)
    while found is not None and random.random() < 0.6:
        below = child(found, random)
        if below is None:
            break
        found = below
    return found


def _parent(node: Witness, random: Random) -> Witness | None:
    if node.kind == "document":
        return None
    if node.kind != "element":
        return element(node.element)
    above = node.element.getparent()
    return element(above) if above is not None else Witness("document", node.element)


def _ancestor(node: Witness, random: Random) -> Witness | None:
    found = _parent(node, random)
    while found is not None and random.random() < 0.4:
        above = _parent(found, random)
        if above is None:
            break
        found = above
    return found


def _sibling(node: Witness, random: Random, *, after: bool) -> Witness | None:
    if node.kind != "element":
        return None
    found = node.element.getnext() if after else node.element.getprevious()
    for _ in range(random.choice([0, 0, 1, 3])):
        further = None if found is None else found.getnext() if after else found.getprevious()
        found = found if further is None else further
    return None if found is None else element(found)


def _beyond(node: Witness, random: Random, *, after: bool) -> Witness | None:
    current: Witness | None = node if node.kind in ("element", "document") else element(node.element)
    while current is not None and current.kind == "element":
        found = _sibling(current, random, after=after)
        if found is not None:
            return _or_self(_descendant, found, random)
        current = _parent(current, random)
    return None


def _attribute(node: Witness, random: Random) -> Witness | None:
    if node.kind != "element" or not node.element.attrib:
        return None
    return Witness("attribute", node.element, random.choice(list(node.element.attrib)))


def _namespace(node: Witness, random: Random) -> Witness | None:
    return Witness("namespace", node.element, "xml") if node.kind == "element" else None


def _or_self(function: Any, node: Witness, random: Random) -> Witness:
    return (function(node, random) if random.random() < 0.6 else None) or node


_MOVES: dict[str, Any] = {
    "self": lambda node, random: node,
    "child": child,
    "descendant": _descendant,
    "descendant-or-self": lambda node, random: _or_self(_descendant, node, random),
    "parent": _parent,
    "ancestor": _ancestor,
    "ancestor-or-self": lambda node, random: _or_self(_ancestor, node, random),
    "following-sibling": lambda node, random: _sibling(node, random, after=True),
    "preceding-sibling": lambda node, random: _sibling(node, random, after=False),
    "following": lambda node, random: _beyond(node, random, after=True),
    "preceding": lambda node, random: _beyond(node, random, after=False),
    "attribute": _attribute,
    "namespace": _namespace,
}
