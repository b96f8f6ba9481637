"""The functions of XPath, one row each: arguments, result, and, for functions without nodes, the implementation.

XPath 1.0 §4, XPath 2.0 and 3.1 Functions and Operators. A function that needs nodes or sequences, such as `count`, is
implemented in `engine/functions.py` or `engine/items.py`, by its name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcml_service.xpath.language import regular
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS

Numbers = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, slots=True)
class Signature:
    """result: "nodes", "number", "string", "boolean", "strings" or "sequence". least, most: arguments; most None: any
    number. takes_items: the first argument, or that at `place`, is a node set or sequence. of_node: it is a node.
    items: type of the items of a sequence. selects: these are items of that argument. is_integer: the number is one of
    XPath's integers.
    is_later: came after XPath 1.0. is_quick: no text takes it long. of_texts: the value for texts, one for each
    argument. of_many: the same for many first arguments with the same others. of_numbers: for arrays of numbers.
    """

    result: str
    least: int
    most: int | None
    takes_items: bool = False
    place: int = 0
    of_node: bool = False
    items: str = ""
    selects: bool = False
    is_integer: bool = False
    is_later: bool = False
    is_quick: bool = True
    of_texts: Callable[..., str | float | bool] | None = None
    of_many: Callable[..., list[bool]] | None = None
    of_numbers: Callable[..., Any] | None = None

    def takes(self, count: int) -> bool:
        """Tell whether it can be called with this number of arguments."""
        return self.least <= count and (self.most is None or count <= self.most)

    @property
    def words(self) -> str:
        """How many arguments it takes: "1 argument", "2 or 3 arguments"."""
        if self.most is None:
            return f"{self.least} arguments or more"
        counts = " or ".join(map(str, range(self.least, self.most + 1))) if self.most else "no"
        return f"{counts} argument" + "s" * (self.most != 1)


def _translate(text: str, old: str, new: str) -> str:
    table: dict[int, str | None] = {}
    for place, letter in enumerate(old):
        table.setdefault(ord(letter), new[place] if place < len(new) else None)
    return text.translate(table)


_SPACES = str.maketrans("\t\r\n", "   ")


def _normalized(text: str) -> str:
    return " ".join(part for part in text.translate(_SPACES).split(" ") if part)


def round_half_up(numbers: Numbers) -> Numbers:
    """`round()` of XPath: the closest integer, of two the greater; -0.5 up to 0 is negative zero."""
    with np.errstate(all="ignore"):
        floor = np.floor(numbers)
        rounded = np.where(numbers - floor >= 0.5, floor + 1, floor)
        return np.asarray(np.where((numbers < 0) & (numbers >= -0.5), -0.0, rounded), np.float64)


def _later(result: str, least: int, most: int | None, **others: Any) -> Signature:
    return Signature(result, least, most, is_later=True, **others)


def _of_number(function: Callable[[Numbers], Any]) -> Signature:
    return _later("number", 1, 1, of_numbers=function)


FUNCTIONS = {
    "last": Signature("number", 0, 0, is_integer=True),
    "position": Signature("number", 0, 0, is_integer=True),
    "count": Signature("number", 1, 1, takes_items=True, is_integer=True),
    "id": Signature("nodes", 1, 1),
    "local-name": Signature("string", 0, 1, of_node=True),
    "namespace-uri": Signature("string", 0, 1, of_node=True),
    "name": Signature("string", 0, 1, of_node=True),
    "string": Signature("string", 0, 1),
    "concat": Signature("string", 2, None, of_texts=lambda *texts: "".join(texts)),
    "starts-with": Signature("boolean", 2, 2, of_texts=str.startswith),
    "contains": Signature("boolean", 2, 2, of_texts=lambda text, part: part in text),
    "substring-before": Signature(
        "string", 2, 2, of_texts=lambda text, part: text.partition(part)[0] if part and part in text else ""
    ),
    "substring-after": Signature("string", 2, 2, of_texts=lambda text, part: text.partition(part)[2] if part else text),
    "substring": Signature("string", 2, 3),
    "string-length": Signature("number", 0, 1, is_integer=True, of_texts=lambda text: float(len(text))),
    "normalize-space": Signature("string", 0, 1, of_texts=_normalized),
    "translate": Signature("string", 3, 3, of_texts=_translate),
    "boolean": Signature("boolean", 1, 1),
    "not": Signature("boolean", 1, 1),
    "true": Signature("boolean", 0, 0),
    "false": Signature("boolean", 0, 0),
    "lang": Signature("boolean", 1, 1),
    "number": Signature("number", 0, 1),
    "sum": Signature("number", 1, 1, takes_items=True),
    "floor": Signature("number", 1, 1, of_numbers=np.floor),
    "ceiling": Signature("number", 1, 1, of_numbers=np.ceil),
    "round": Signature("number", 1, 1, of_numbers=round_half_up),
    # -- XPath 2.0 and 3.1 ---------------------------------------------------------------------------------------------
    "min": _later("number", 1, 1, takes_items=True),
    "max": _later("number", 1, 1, takes_items=True),
    "avg": _later("number", 1, 1, takes_items=True),
    "abs": _of_number(np.abs),
    "lower-case": _later("string", 1, 1, of_texts=str.lower),
    "upper-case": _later("string", 1, 1, of_texts=str.upper),
    "string-join": _later("string", 1, 2, takes_items=True),
    "ends-with": _later("boolean", 2, 2, of_texts=str.endswith),
    "matches": _later("boolean", 2, 3, of_texts=regular.matches, of_many=regular.match_all, is_quick=False),
    "replace": _later("string", 3, 4, of_texts=regular.replace, is_quick=False),
    "tokenize": _later("sequence", 1, 3, items="string"),
    "exists": _later("boolean", 1, 1, takes_items=True),
    "empty": _later("boolean", 1, 1, takes_items=True),
    "distinct-values": _later("strings", 1, 1, takes_items=True, items="any"),
    "data": _later("sequence", 1, 1, takes_items=True, items="any"),
    "reverse": _later("sequence", 1, 1, takes_items=True, selects=True),
    "head": _later("sequence", 1, 1, takes_items=True, selects=True),
    "tail": _later("sequence", 1, 1, takes_items=True, selects=True),
    "subsequence": _later("sequence", 2, 3, takes_items=True, selects=True),
    "remove": _later("sequence", 2, 2, takes_items=True, selects=True),
    "index-of": _later("sequence", 2, 2, takes_items=True, items="number", is_integer=True),
    "sort": _later("sequence", 1, 3, takes_items=True, selects=True),
    "math:pi": _later("number", 0, 0),
    "math:sqrt": _of_number(np.sqrt),
    "math:exp": _of_number(np.exp),
    "math:log": _of_number(np.log),
    "math:log10": _of_number(np.log10),
    "math:sin": _of_number(np.sin),
    "math:cos": _of_number(np.cos),
    "math:tan": _of_number(np.tan),
    "math:asin": _of_number(np.arcsin),
    "math:acos": _of_number(np.arccos),
    "math:atan": _of_number(np.arctan),
    "math:pow": _later("number", 2, 2, of_numbers=np.power),
    "math:atan2": _later("number", 2, 2, of_numbers=np.arctan2),
    # -- bodies in motion ----------------------------------------------------------------------------------------------
    **{
        name: Signature(
            one.result,
            one.least,
            len(one.parameters),
            takes_items=one.selects is not None,
            place=one.selects or 0,
            selects=one.selects is not None,
        )
        for name, one in MOTION_FUNCTIONS.items()
    },
}
"""Functions that run on columns."""

OTHER_FUNCTIONS = {
    name: _later("sequence", least, most)
    for name, least, most in (
        ("insert-before", 3, 3), ("compare", 2, 2), ("deep-equal", 2, 2), ("codepoints-to-string", 1, 1),
        ("string-to-codepoints", 1, 1), ("round-half-to-even", 1, 2), ("zero-or-one", 1, 1), ("one-or-more", 1, 1),
        ("exactly-one", 1, 1), ("root", 0, 1), ("unordered", 1, 1),
    )
}  # fmt: skip
"""Functions that have no columns, and that hints and completion know."""

SAFE_FUNCTIONS = FUNCTIONS | OTHER_FUNCTIONS
AGGREGATES = frozenset({"count", "sum", "min", "max", "avg", "exists", "empty", "distinct-values", "string-join"})
"""Functions that make one value of many items, or fewer of them; of the whole scope, outside predicates."""
OF_CONTEXT = frozenset({"string", "number", "string-length", "normalize-space", "name", "local-name", "namespace-uri"})
"""Functions that without an argument take the context node."""
