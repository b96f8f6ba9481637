"""The functions of XPath: what they give and how many arguments they take. XPath 1.0 §4, XPath 2.0 functions."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Signature:
    """result: "nodes", "number", "string", "boolean", "strings" or "sequence". least, most: arguments; most None: any
    number. of_nodes: the first argument is a node set. later: came with XPath 2.0."""

    result: str
    least: int
    most: int | None
    of_nodes: bool = False
    later: bool = False

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
    "min": Signature("number", 1, 1, of_nodes=True, later=True),
    "max": Signature("number", 1, 1, of_nodes=True, later=True),
    "avg": Signature("number", 1, 1, of_nodes=True, later=True),
    "abs": Signature("number", 1, 1, later=True),
    "lower-case": Signature("string", 1, 1, later=True),
    "upper-case": Signature("string", 1, 1, later=True),
    "string-join": Signature("string", 1, 2, of_nodes=True, later=True),
    "ends-with": Signature("boolean", 2, 2, later=True),
    "exists": Signature("boolean", 1, 1, of_nodes=True, later=True),
    "empty": Signature("boolean", 1, 1, of_nodes=True, later=True),
    "distinct-values": Signature("strings", 1, 1, of_nodes=True, later=True),
}
"""Functions that run on columns."""

SAXON_FUNCTIONS = {
    "matches": Signature("sequence", 2, 3, later=True),
    "replace": Signature("sequence", 3, 4, later=True),
    "tokenize": Signature("sequence", 1, 3, later=True),
    "index-of": Signature("sequence", 2, 2, later=True),
    "data": Signature("sequence", 1, 1, later=True),
    "reverse": Signature("sequence", 1, 1, later=True),
    "subsequence": Signature("sequence", 2, 3, later=True),
    "insert-before": Signature("sequence", 3, 3, later=True),
    "remove": Signature("sequence", 2, 2, later=True),
    "compare": Signature("sequence", 2, 2, later=True),
    "deep-equal": Signature("sequence", 2, 2, later=True),
    "codepoints-to-string": Signature("sequence", 1, 1, later=True),
    "string-to-codepoints": Signature("sequence", 1, 1, later=True),
    "round-half-to-even": Signature("sequence", 1, 2, later=True),
    "zero-or-one": Signature("sequence", 1, 1, later=True),
    "one-or-more": Signature("sequence", 1, 1, later=True),
    "exactly-one": Signature("sequence", 1, 1, later=True),
    "root": Signature("sequence", 0, 1, later=True),
    "unordered": Signature("sequence", 1, 1, later=True),
}
"""Functions that only Saxon evaluates. They see nothing but their arguments and the document."""

SAFE_FUNCTIONS = FUNCTIONS | SAXON_FUNCTIONS
AGGREGATES = frozenset({"count", "sum", "min", "max", "avg", "exists", "empty", "distinct-values", "string-join"})
"""Functions that, around the whole expression, make one value of all documents together."""


def giving(*results: str) -> frozenset[str]:
    """Names of the functions on columns that give one of these."""
    return frozenset(name for name, signature in FUNCTIONS.items() if signature.result in results)
