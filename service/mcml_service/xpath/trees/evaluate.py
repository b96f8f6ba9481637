"""Expressions of XPath 3.1 on documents as trees of nodes, by elementpath.

It runs in the process of the query: in a server, one with limits of the operating system (`query_worker`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import lru_cache
from itertools import islice
from typing import Any

import orjson
from elementpath.exceptions import ElementPathError
from elementpath.xpath_nodes import (
    AttributeNode,
    DocumentNode,
    ElementNode,
    NamespaceNode,
    TextNode,
    XPathNode,
)
from elementpath.xpath_tokens import XPathArray, XPathFunction, XPathMap
from lxml import etree

from mcml.errors import LimitError, McmlError, QueryError
from mcml.language.addresses import ALWAYS_NUMBERED, address_attribute, address_namespace, address_text, number_steps
from mcml_service.xpath.language.tree import Atomic
from mcml_service.xpath.language.xpath31.corrections import Context
from mcml_service.xpath.language.xpath31.parser import in_words, query_error, read_tokens
from mcml_service.xpath.language.xpath31.scope import mark_scope


@dataclass(frozen=True, slots=True)
class Found:
    """A node of a result.

    kind: "element", "attribute", "text", "document" or "namespace". address: the canonical XPath that finds it.
    value: an element as XML, the value of an attribute or text. document: its place among those of the tree.
    """

    kind: str
    address: str
    value: str
    document: int = 0


@dataclass(frozen=True, slots=True)
class Items:
    """A page of a sequence: nodes and atomic values in its order. total: their number on all pages."""

    items: tuple[Found | Atomic, ...]
    total: int


class Tree:
    """Documents that expressions are evaluated on.

    documents: of each its XML in pieces, without white space between elements. A single one is the document of all
    paths; of several, those that take sequences are of all (`language/xpath31/scope.py`).
    """

    def __init__(self, documents: Iterable[Iterable[bytes]]) -> None:
        self._nodes: list[Any] = []
        self._roots: list[Any] = []
        last = 0
        for document in documents:
            node, root, last = _read(document, last)
            self._nodes.append(node)
            self._roots.append(root)
        self._places = {node: place for place, node in enumerate(self._nodes)}
        self._addresses = Addresses()

    def items(
        self,
        text: str,
        *,
        variables: Mapping[str, Atomic],
        offset: int,
        limit: int,
        compatible: bool = True,
        document: int = 0,
    ) -> Items:
        """The value of an expression that has been checked (`language/xpath31/written.py`).

        document: the place of the one that is the focus, and that is asked where one value is needed.
        compatible: in the mode compatible with XPath 1.0. Raises QueryError where it has no value, with the W3C's code.
        """
        try:
            given: Any = {name: _given(value) for name, value in variables.items()}
            context = Context(self._nodes[document], variables=given, timezone="Z")
            tokens = _tokens(text, compatible)
            if len(self._nodes) > 1:
                context.scope = tuple(self._nodes)
                mark_scope(tokens)
            found = list(tokens.select(context))
            return Items(tuple(self._item(item) for item in islice(found, offset, offset + limit)), len(found))
        except ElementPathError as error:
            raise query_error(error) from None
        except RecursionError:
            raise LimitError("The expression calls itself too deeply.", code="query-too-large") from None
        except (MemoryError, McmlError):
            raise
        except Exception as error:
            # Errors of its code for unexpected values are not faults of the server.
            raise QueryError(f"This has no value: {in_words(str(error))[:200] or 'it is not defined'}.") from error

    def _item(self, item: Any) -> Found | Atomic:
        return self._found(item) if isinstance(item, XPathNode) else _atomic(item)

    def _found(self, node: Any) -> Found:
        top = node
        while top.parent is not None:
            top = top.parent
        place = self._places[top]
        if isinstance(node, DocumentNode):
            return Found("document", "/", str(etree.tostring(self._roots[place], encoding="unicode")), place)
        if isinstance(node, ElementNode):
            element: Any = node.value
            value = etree.tostring(element, encoding="unicode", with_tail=False)
            return Found("element", self._addresses.of(element), str(value), place)
        owner = self._addresses.of(node.parent.value)
        if isinstance(node, AttributeNode):
            return Found("attribute", address_attribute(owner, str(node.name)), str(node.value), place)
        if isinstance(node, TextNode):
            return Found("text", address_text(owner), node.value, place)
        if isinstance(node, NamespaceNode):
            return Found("namespace", address_namespace(owner), node.uri, place)
        raise QueryError("A comment or processing instruction is no node of MCML.")


def _read(document: Iterable[bytes], last: int) -> tuple[Any, Any, int]:
    """The node of a document, its root, and the position of its last node. last: that of the document before.

    Raises MemoryError.
    """
    parser = etree.XMLParser(huge_tree=True, resolve_entities=False, no_network=True, load_dtd=False)
    try:
        for piece in document:
            parser.feed(piece)
        root = parser.close()
    except etree.XMLSyntaxError as error:
        # libxml2 reports that it gets no memory as an error of the text.
        if getattr(error, "code", None) == etree.ErrorTypes.ERR_NO_MEMORY:
            raise MemoryError from None
        raise
    top: Any = Context(root.getroottree()).root
    node = top
    for node in top.iter_descendants():
        node.position += last
    # Namespaces and attributes count from their element.
    return top, root, node.position + len(getattr(node.value, "attrib", ())) + 2


@lru_cache(maxsize=256)
def _tokens(text: str, compatible: bool) -> Any:
    return read_tokens(text, compatible=compatible)


def _given(value: Atomic) -> Atomic:
    # JSON has one kind of number; `1 to $n` wants an integer.
    is_whole = isinstance(value, float) and value.is_integer()
    return int(value) if is_whole else value


def _atomic(value: Any) -> Atomic:
    """A value as the wire has it: integers exactly, other numbers as doubles, maps and arrays as JSON, else text."""
    if isinstance(value, bool | int | str):
        return value
    if isinstance(value, Decimal):
        return int(value) if value == value.to_integral_value() and abs(value) >= 2**53 else float(value)
    if isinstance(value, float):
        return float(value)
    if isinstance(value, XPathMap | XPathArray):
        return orjson.dumps(_plain(value)).decode()
    if isinstance(value, XPathFunction):
        return str(value)
    return str(value)


def _plain(value: Any) -> Any:
    if isinstance(value, XPathMap):
        return {str(_atomic(key)): _plain(one) for key, one in value.items()}
    if isinstance(value, XPathArray):
        return [_plain(one) for one in value.items()]
    if isinstance(value, list):
        return _plain(value[0]) if len(value) == 1 else [_plain(one) for one in value]
    if isinstance(value, XPathNode):
        return value.string_value
    found = _atomic(value)
    return str(found) if isinstance(found, float) and not math.isfinite(found) else found


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


def out_of_memory(memory: int) -> LimitError:
    """Return the error of a query that takes more than `memory` bytes."""
    return LimitError(
        f"The query needs more than {memory >> 20} MiB of memory.",
        remedy="Ask fewer documents, or narrow the expression by motion name, bone or position.",
        code="query-memory",
    )


NOTHING = b"<mcml/>"
"""The document of an expression without documents."""
