"""What an expression means over several documents, in Saxon's words.

Outside of predicates an absolute path is one of `$all`, the document nodes of the scope, where a function of sequences
or a loop takes it or where it is the answer, and of `$each`, the document of which a value is asked, elsewhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from lxml import etree

from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.tree import (
    Call,
    Each,
    Expression,
    Filter,
    For,
    If,
    Let,
    Operation,
    Path,
    Quantified,
    Sequence,
    Step,
    Variable,
    free_variables,
    walk,
    with_children,
)
from mcml_service.xpath.language.unparse import unparse
from tests.xpath.oracle import plain
from tests.xpath.saxon import Places, _item

OF_SEQUENCES = {
    "count", "sum", "min", "max", "avg", "exists", "empty", "distinct-values", "string-join", "data", "reverse", "head",
    "insert-before", "tail", "subsequence", "remove", "index-of", "sort",
}  # fmt: skip


def spelled(tree: Expression) -> Expression:
    """With `$all` and `$each`. Where anything is asked of each document, so are all loops and nodes of the answer; not
    functions of sequences that nothing else stands in."""
    found = _spelled(tree, many=True, alone=False)
    return _spelled(tree, many=True, alone=True) if _asks_each(found) else found


def _asks_each(tree: Expression) -> bool:
    return any(isinstance(part, Variable) and part.name == "each" for part in walk(tree))


def _spelled(tree: Expression, *, many: bool, alone: bool) -> Expression:
    """many: any number of items may stand here. alone: the answer is one of each document."""
    if isinstance(tree, Path):
        if tree.start is not None:
            return Path(tree.steps, start=_spelled(tree.start, many=many, alone=alone))
        if not tree.absolute:
            return tree
        whose = "all" if many and not alone else "each"
        return Path(tree.steps or (Step("self", "node()"),), start=Variable(whose))
    if (
        alone
        and isinstance(tree, Quantified | Call)
        and (isinstance(tree, Quantified) or tree.function in OF_SEQUENCES)
    ):
        together = _spelled(tree, many=many, alone=False)
        if not _asks_each(together) and not free_variables(tree):
            return together
    if isinstance(tree, Filter):
        return Filter(_spelled(tree.operand, many=many, alone=alone), tree.predicates)
    if isinstance(tree, Call):
        takes = tree.function in OF_SEQUENCES
        return Call(
            tree.function,
            tuple(_spelled(each, many=takes and not n, alone=alone) for n, each in enumerate(tree.arguments)),
        )
    if isinstance(tree, Operation):
        inside = many and tree.operator in ("|", "intersect", "except")
        return Operation(tree.operator, tuple(_spelled(each, many=inside, alone=alone) for each in tree.operands))
    if isinstance(tree, For | Let | Each | Quantified):
        source = _spelled(tree.source, many=True, alone=alone)
        body = _spelled(tree.body, many=many and not isinstance(tree, Quantified), alone=alone)
        return replace(tree, source=source, body=body)
    if isinstance(tree, If):
        then, otherwise = (_spelled(each, many=many, alone=alone) for each in (tree.then, tree.otherwise))
        return If(_spelled(tree.test, many=False, alone=alone), then, otherwise)
    if isinstance(tree, Sequence):
        return Sequence(tuple(_spelled(item, many=many, alone=alone) for item in tree.items))
    return with_children(tree, lambda part: _spelled(part, many=False, alone=alone))


def answer(saxon: Any, text: str, trees: Mapping[str, Any]) -> list[Any]:
    """The items of the answer: (document, kind, address, value) of nodes, and values."""
    tree = spelled(parse(text).tree)
    sources = [etree.tostring(each.getroot(), encoding="unicode") for each in trees.values()]
    nodes = [saxon.parse_xml(xml_text=source) for source in sources]
    places = {
        _identity(saxon, node): (uuid, Places(saxon, each.getroot()))
        for node, (uuid, each) in zip(nodes, trees.items(), strict=True)
    }
    processor = saxon.new_xpath_processor()
    processor.set_language_version("3.1")
    processor.set_backwards_compatible(True)
    processor.declare_namespace("math", "http://www.w3.org/2005/xpath-functions/math")
    for number, node in enumerate(nodes):
        processor.declare_variable(f"d{number}")
        processor.set_parameter(f"d{number}", node)
    everything = f"({', '.join(f'$d{number}' for number in range(len(nodes)))})"
    asked = unparse(tree).replace("$all", everything)
    found: list[Any] = []
    for number, node in enumerate(nodes if _asks_each(tree) else nodes[:1]):
        processor.set_context(xdm_item=node)
        value = processor.evaluate(asked.replace("$each", f"$d{number}"))
        for place in range(0 if value is None else value.size):
            item = value.item_at(place)
            if not item.is_node:
                found.append(_item(item, next(iter(places.values()))[1])[1])
                continue
            uuid, own = places[_identity(saxon, item)]
            _, kind, address, shown = _item(item, own)
            found.append((uuid, kind, address, plain(kind, shown)))
    return found


def _identity(saxon: Any, node: Any) -> str:
    """What the document of a node is known by."""
    processor = saxon.new_xpath_processor()
    processor.set_context(xdm_item=node)
    return str(processor.evaluate_single("generate-id(root(.))").string_value)
