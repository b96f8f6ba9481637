"""What libxml2 answers: the oracle of XPath 1.0."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lxml import etree

from mcml.language.addresses import address_attribute, address_namespace, address_text
from mcml_service.xpath.trees.evaluate import Addresses


def evaluate(tree: Any, expression: str, document: bool, limit: int, offset: int) -> dict[str, Any]:
    """The value of the expression with the document as context node.

    Nodes: {"type": "nodes", "total": n, "items": [[kind, address, value] …]} for items offset … offset + limit - 1
    in document order. Scalars: {"type": "number" | "string" | "boolean", "value": …}, NaN and infinities as texts.
    """
    value: Any = etree.XPath(expression)(tree)
    if isinstance(value, bool):
        return {"type": "boolean", "value": value}
    if isinstance(value, float):
        special = {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}.get(str(value))
        return {"type": "number", "value": special or value}
    if isinstance(value, str):
        return {"type": "string", "value": str(value)}
    nodes: list[Any] = value
    # lxml leaves the document node out of its lists; counted, it shows. It is always the first.
    count: Any = etree.XPath(f"count({expression})")(tree) if document else 0
    if count > len(nodes):
        nodes = [tree, *nodes]
    addresses = Addresses()
    page = nodes[offset : offset + limit]
    owners = namespace_owners(tree, expression) if any(isinstance(node, tuple) for node in page) else iter(())
    for node in nodes[:offset]:
        if isinstance(node, tuple):
            next(owners, None)
    items = [describe(node, addresses, owners) for node in page]
    return {"type": "nodes", "total": len(nodes), "items": items}


def namespace_owners(tree: Any, expression: str) -> Iterator[Any]:
    """The elements of the namespace nodes that an expression selects; lxml does not tell whose they are."""
    # Every element has one namespace node, that of xml.
    owners: Any = etree.XPath(f"({expression})[count(. | ../namespace::*) = count(../namespace::*)]/..")(tree)
    return iter(owners)


def describe(node: Any, addresses: Addresses, owners: Iterator[Any] = iter(())) -> list[str]:
    """Kind, canonical address and value of a node. owners: the elements of namespace nodes that come."""
    if isinstance(node, etree._ElementTree):
        return ["document", "/", etree.tostring(node.getroot(), encoding="unicode")]
    if isinstance(node, tuple):
        owner = next(owners, None)
        return ["namespace", "" if owner is None else address_namespace(addresses.of(owner)), str(node[1])]
    if isinstance(node, str):
        smart: Any = node
        parent = addresses.of(smart.getparent())
        if smart.is_attribute:
            return ["attribute", address_attribute(parent, smart.attrname), str(node)]
        return ["text", address_text(parent), str(node)]
    return ["element", addresses.of(node), etree.tostring(node, encoding="unicode", with_tail=False)]
