"""What Saxon answers: the oracle of XPath 2.0 and later."""

from __future__ import annotations

import re
from typing import Any

from lxml import etree

from mcml.language.addresses import address_attribute, address_namespace, address_text
from mcml_service.xpath.trees.evaluate import Addresses
from tests.xpath.libxml2 import describe

_SPECIAL = {"INF": "Infinity", "+INF": "Infinity", "-INF": "-Infinity", "NaN": "NaN"}
_NUMBERS = ("integer", "decimal", "double", "float")
_STEP = re.compile(r"/(?:Q\{\}([^\[/]+)\[(\d+)\]|@(.+)|(text\(\))\[\d+\]|(namespace::.+))")


def evaluate(
    saxon: Any,
    root: Any,
    expression: str,
    variables: dict[str, Any],
    limit: int,
    offset: int,
    *,
    compatible: bool = True,
) -> dict[str, Any]:
    """A page of the value of the expression, with the document as context item.

    compatible: in the mode compatible with XPath 1.0.
    """
    processor = saxon.new_xpath_processor()
    processor.set_language_version("3.1")
    processor.set_backwards_compatible(compatible)
    processor.declare_namespace("fn", "http://www.w3.org/2005/xpath-functions")
    processor.declare_namespace("math", "http://www.w3.org/2005/xpath-functions/math")
    for name, value in variables.items():
        processor.declare_variable(name)
        processor.set_parameter(name, _atomic(saxon, value))
    processor.set_context(xdm_item=saxon.parse_xml(xml_text=etree.tostring(root, encoding="unicode")))
    found = processor.evaluate(expression)
    total = 0 if found is None else found.size
    places = Places(saxon, root)
    items = [_item(found.item_at(place), places) for place in range(offset, min(total, offset + limit))]
    return {"total": total, "items": items}


def _atomic(saxon: Any, value: str | float | bool) -> Any:
    if isinstance(value, bool):
        return saxon.make_boolean_value(value)
    if isinstance(value, str):
        return saxon.make_string_value(value)
    # JSON has one kind of number; `1 to $n` wants an integer.
    return saxon.make_integer_value(int(value)) if float(value).is_integer() else saxon.make_double_value(float(value))


def _item(item: Any, places: Places) -> list[Any]:
    if item.is_node:
        return ["node", *places.describe(item)]
    if not item.is_atomic:
        return ["string", item.to_string()]
    atomic = item.get_atomic_value()
    kind = atomic.primitive_type_name.rpartition("}")[2].rpartition("#")[2]
    text = atomic.string_value
    if kind == "boolean":
        return ["boolean", text == "true"]
    if kind in _NUMBERS:
        return ["number", _SPECIAL.get(text) or float(text)]
    return ["string", text]


class Places:
    """Saxon's nodes as lxml's, which are described as all others are."""

    def __init__(self, saxon: Any, root: Any) -> None:
        self._root = root
        self._paths = saxon.new_xpath_processor()
        self._paths.set_language_version("3.1")
        self._addresses = Addresses()
        self._children: dict[Any, dict[str, list[Any]]] = {}

    def describe(self, node: Any) -> list[str]:
        self._paths.set_context(xdm_item=node)
        path = self._paths.evaluate_single("path(.)").string_value
        if path == "/":
            return describe(self._root.getroottree(), self._addresses)
        current: Any = None
        for name, number, attribute, text, _namespace in _STEP.findall(path):
            if name:
                current = self._root if current is None else self._child(current, name, int(number))
                continue
            own = self._addresses.of(current)
            if attribute:
                return ["attribute", address_attribute(own, attribute), current.get(attribute)]
            if text:
                return ["text", address_text(own), current.text]
            return ["namespace", address_namespace(own), node.string_value]
        return describe(current, self._addresses)

    def _child(self, parent: Any, name: str, number: int) -> Any:
        if parent not in self._children:
            held: dict[str, list[Any]] = {}
            for child in parent:
                held.setdefault(child.tag, []).append(child)
            self._children[parent] = held
        return self._children[parent][name][number - 1]
