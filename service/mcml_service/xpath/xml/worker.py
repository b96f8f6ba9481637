"""A process of its own that evaluates XPath 1.0 with libxml2: it can be killed, and its memory is bounded.

Its argument: MEMORY_BYTES. On its input, messages. A request is a JSON object {seconds, expression, document (whether
the document node may be selected), limit, offset}, then the document in pieces, then an empty message. On its output,
one JSON object. It imports little, to start fast.
"""

from __future__ import annotations

import json
import resource
import sys
from collections.abc import Callable, Iterator
from typing import Any

from lxml import etree

from mcml.language.addresses import ALWAYS_NUMBERED, address_attribute, address_namespace, address_text, number_steps
from mcml_service.processes.bounds import bound_memory, end_after
from mcml_service.processes.messages import read_message, write_message

LAST = ("memory", "document")
"""Errors after which the process ends: the rest of the request was not read, or memory may be in pieces."""


def main() -> None:
    bound_memory(resource.RLIMIT_AS, int(sys.argv[1]))
    answer_requests(lambda root, **request: evaluate(root.getroottree(), **request), etree.XPathError)


def answer_requests(evaluate: Callable[..., dict[str, Any]], refusal: type[Exception]) -> None:
    """Answer until nobody asks. evaluate: takes the root element and what stands in a request. refusal: what it raises
    for an expression."""
    source, target = sys.stdin.buffer, sys.stdout.buffer
    while (message := read_message(source)) is not None:
        request = json.loads(message)
        end_after(request.pop("seconds"))
        parser = etree.XMLParser(huge_tree=True, resolve_entities=False, no_network=True, load_dtd=False)
        try:
            while piece := read_message(source):
                parser.feed(piece)
            answer = evaluate(parser.close(), **request)
        except MemoryError:
            answer = {"error": "memory"}
        except refusal as error:
            answer = {"error": "expression", "message": " ".join(str(error).split())}
        except etree.XMLSyntaxError as error:
            # libxml2 reports memory that it could not get as an error of line 0.
            answer = {"error": "document" if error.lineno else "memory", "message": str(error)}
        end_after(None)
        write_message(target, json.dumps(answer).encode())
        if answer.get("error") in LAST:
            return
        del answer, parser


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


class Addresses:
    """Canonical addresses, each list of siblings numbered once."""

    def __init__(self) -> None:
        self._steps: dict[Any, dict[Any, str]] = {}
        self._known: dict[Any, str] = {}

    def of(self, element: Any) -> str:
        parent = element.getparent()
        if parent is None:
            return f"/{element.tag}"
        if parent not in self._known:
            self._known[parent] = self.of(parent)
        if parent not in self._steps:
            steps = number_steps([str(child.tag) for child in parent], ALWAYS_NUMBERED)
            self._steps[parent] = dict(zip(parent, steps, strict=True))
        return f"{self._known[parent]}/{self._steps[parent][element]}"
