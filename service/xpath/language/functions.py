"""The functions of XPath: what they give and how many arguments they take. XPath 1.0 §4, XPath 2.0 functions."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Signature:
    """result: "nodes", "number", "string", "boolean", "strings" or "sequence". least, most: arguments; most None: any
    number. of_nodes: the first argument is a node set. is_xpath2: came with XPath 2.0."""

    result: str
    least: int
    most: int | None
    of_nodes: bool = False
    is_xpath2: bool = False

    def takes(self, count: int) -> bool:
        """Whether it may be called with so many arguments."""
        return self.least <= count and (self.most is None or count <= self.most)

    @property
    def words(self) -> str:
        """How many arguments it takes: "1 argument", "2 or 3 arguments"."""
        if self.most is None:
            return f"{self.least} arguments or more"
        counts = " or ".join(map(str, range(self.least, self.most + 1))) if self.most else "no"
        return f"{counts} argument" + "s" * (self.most != 1)


FUNCTIONS = {
    "last": Signature("number", 0, 0),
    "position": Signature("number", 0, 0),
    "count": Signature("number", 1, 1, of_nodes=True),
    "id": Signature("nodes", 1, 1),
    "local-name": Signature("string", 0, 1, of_nodes=True),
    "namespace-uri": Signature("string", 0, 1, of_nodes=True),
    "name": Signature("string", 0, 1, of_nodes=True),
    "string": Signature("string", 0, 1),
    "concat": Signature("string", 2, None),
    "starts-with": Signature("boolean", 2, 2),
    "contains": Signature("boolean", 2, 2),
    "substring-before": Signature("string", 2, 2),
    "substring-after": Signature("string", 2, 2),
    "substring": Signature("string", 2, 3),
    "string-length": Signature("number", 0, 1),
    "normalize-space": Signature("string", 0, 1),
    "translate": Signature("string", 3, 3),
    "boolean": Signature("boolean", 1, 1),
    "not": Signature("boolean", 1, 1),
    "true": Signature("boolean", 0, 0),
    "false": Signature("boolean", 0, 0),
    "lang": Signature("boolean", 1, 1),
    "number": Signature("number", 0, 1),
    "sum": Signature("number", 1, 1, of_nodes=True),
    "floor": Signature("number", 1, 1),
    "ceiling": Signature("number", 1, 1),
    "round": Signature("number", 1, 1),
    "min": Signature("number", 1, 1, of_nodes=True, is_xpath2=True),
    "max": Signature("number", 1, 1, of_nodes=True, is_xpath2=True),
    "avg": Signature("number", 1, 1, of_nodes=True, is_xpath2=True),
    "abs": Signature("number", 1, 1, is_xpath2=True),
    "lower-case": Signature("string", 1, 1, is_xpath2=True),
    "upper-case": Signature("string", 1, 1, is_xpath2=True),
    "string-join": Signature("string", 1, 2, of_nodes=True, is_xpath2=True),
    "ends-with": Signature("boolean", 2, 2, is_xpath2=True),
    "exists": Signature("boolean", 1, 1, of_nodes=True, is_xpath2=True),
    "empty": Signature("boolean", 1, 1, of_nodes=True, is_xpath2=True),
    "distinct-values": Signature("strings", 1, 1, of_nodes=True, is_xpath2=True),
}
"""Functions that run on columns."""

SAXON_FUNCTIONS = {
    "matches": Signature("sequence", 2, 3, is_xpath2=True),
    "replace": Signature("sequence", 3, 4, is_xpath2=True),
    "tokenize": Signature("sequence", 1, 3, is_xpath2=True),
    "index-of": Signature("sequence", 2, 2, is_xpath2=True),
    "data": Signature("sequence", 1, 1, is_xpath2=True),
    "reverse": Signature("sequence", 1, 1, is_xpath2=True),
    "subsequence": Signature("sequence", 2, 3, is_xpath2=True),
    "insert-before": Signature("sequence", 3, 3, is_xpath2=True),
    "remove": Signature("sequence", 2, 2, is_xpath2=True),
    "compare": Signature("sequence", 2, 2, is_xpath2=True),
    "deep-equal": Signature("sequence", 2, 2, is_xpath2=True),
    "codepoints-to-string": Signature("sequence", 1, 1, is_xpath2=True),
    "string-to-codepoints": Signature("sequence", 1, 1, is_xpath2=True),
    "round-half-to-even": Signature("sequence", 1, 2, is_xpath2=True),
    "zero-or-one": Signature("sequence", 1, 1, is_xpath2=True),
    "one-or-more": Signature("sequence", 1, 1, is_xpath2=True),
    "exactly-one": Signature("sequence", 1, 1, is_xpath2=True),
    "root": Signature("sequence", 0, 1, is_xpath2=True),
    "unordered": Signature("sequence", 1, 1, is_xpath2=True),
}
"""Functions that only Saxon evaluates. They see nothing but their arguments and the document."""

SAFE_FUNCTIONS = FUNCTIONS | SAXON_FUNCTIONS
AGGREGATES = frozenset({"count", "sum", "min", "max", "avg", "exists", "empty", "distinct-values", "string-join"})
"""Functions that, around the whole expression, make one value of all documents together."""


def giving(*results: str) -> frozenset[str]:
    """Names of the functions on columns that give one of these."""
    return frozenset(name for name, signature in FUNCTIONS.items() if signature.result in results)
