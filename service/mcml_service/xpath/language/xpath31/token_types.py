"""How much of a document an expression of XPath 3.1 can see, by its tokens; `language/reach.py` has it for trees."""

from __future__ import annotations

from typing import Any

from mcml.language.vocabulary import FRAME
from mcml_service.xpath.language.functions import OF_CONTEXT
from mcml_service.xpath.language.reach import DOCUMENT, EVERYTHING, Analysis, Projection, Types
from mcml_service.xpath.language.tree import AXES, Step
from mcml_service.xpath.language.xpath31.scope import OF_BODIES, parts_of

_NOTHING: Types = frozenset()
_PASSING = frozenset(
    {
        *("head", "tail", "reverse", "subsequence", "remove", "insert-before", "sort", "unordered", "trace", "apply"),
        *("filter", "for-each", "for-each-pair", "fold-left", "fold-right", "outermost", "innermost", "exactly-one"),
        *("zero-or-one", "one-or-more", "merge", "entry", "get", "put", "flatten", "join", "append"),
    }
)
"""Functions that give items of their arguments, or of the results of functions in them."""
_DEEP = frozenset({"deep-equal", "serialize", "has-children", "path", "element-with-id", "id", "idref", "copy-of"})
"""Functions that look at all that is in a node, or around it."""
_OF_NODES_ALONE = frozenset(
    {"count", "exists", "empty", "boolean", "not", "name", "local-name", "namespace-uri", "node-name", "generate-id"}
)
"""Functions that do not take the text of nodes."""
_OF_VALUES = frozenset({"size", "keys", "contains", "position", "last", "data", "distinct-values", "number", "string"})
"""Further functions that give values."""
_TESTS = ("=", "!=", "<", "<=", ">", ">=", "eq", "ne", "lt", "le", "gt", "ge", "||", "to", "idiv")
_PASSES = 4
"""That the types of the parameters of functions in calls are followed."""


def projection_of(root: Any) -> Projection:
    """The least projection on which an expression has its value, nodes serialised. root: its token."""
    found = _TokenTypes()
    return found.analysis.projection(found.types(root, frozenset({DOCUMENT})))


class _TokenTypes:
    """Types of the nodes that tokens give."""

    def __init__(self) -> None:
        self.analysis = Analysis()
        self._bound: dict[str, Types] = {}

    def types(self, token: Any, context: Types) -> Types:
        """The types of the nodes of its value; none where it has no nodes. context: the types of the context node."""
        step = _step_of(token)
        if step is not None:
            return self.analysis.step(context, step)
        symbol, parts = token.symbol, list(parts_of(token))
        if token.label == "function":
            return self._function(token, parts, context)
        if token.label == "inline function":
            return self._inline(token, EVERYTHING, context)
        if token.label in ("literal", "context item") or symbol == ".":
            return context if symbol == "." else _NOTHING
        if symbol == "$":
            return self._bound.get(str(parts[0].value), _NOTHING) if parts else _NOTHING
        if symbol in ("/", "//"):
            return self._path(token, parts, context)
        if symbol == "[" and token.label != "array":
            found = self.types(parts[0], context)
            self.analysis.use(found)
            self.analysis.use(self.types(parts[1], found))
            return found
        if symbol == "!":
            found = self.types(parts[0], context)
            self.analysis.use(found)
            return self.types(parts[1], found)
        if symbol in ("for", "let"):
            return self._flwor(token, context)
        if symbol in ("some", "every"):
            for name, source in zip(parts[:-1:2], parts[1:-1:2], strict=True):
                self._bind(str(name[0].value), self.types(source, context))
            self.analysis.use(self.types(parts[-1], context))
            return _NOTHING
        if symbol in ("instance", "castable", "cast", "treat"):
            found = self.types(parts[0], context)
            self.analysis.value(found)
            return found if symbol == "treat" else _NOTHING
        return self._other(token, parts, context)

    def _other(self, token: Any, parts: list[Any], context: Types) -> Types:
        found = [self.types(part, context) for part in parts]
        symbol = token.symbol
        joined = frozenset[str]().union(*found)
        if symbol in ("is", "<<", ">>", "and", "or"):
            self.analysis.use(joined)
            return _NOTHING
        if symbol in _TESTS or (symbol in ("+", "-", "*", "div", "mod") and parts):
            self.analysis.value(joined)
            return _NOTHING
        self.analysis.use(joined)
        if symbol == "if":
            return found[1] | found[2]
        if symbol in ("=>", "#"):
            name = str(parts[1 if symbol == "=>" else 0].value)
            self._taken(name, joined)
            return self._result_types(name, joined, token.parser.symbol_table.get(name))
        if token.label in ("constructor function", "sequence type"):
            self.analysis.value(joined)
            return _NOTHING
        if symbol == ":" and len(parts) == 2:
            # A function or type with a prefix.
            return found[1]
        if symbol not in ("(", ",", "|", "union", "intersect", "except", "?", "array", "map", "[", "Q{"):
            self.analysis.use(EVERYTHING)
            return EVERYTHING
        if symbol == "(" and len(parts) > 1:
            # A call of an unknown function, which may take the text of its arguments.
            self.analysis.value(joined)
        return joined

    def _path(self, token: Any, parts: list[Any], context: Types) -> Types:
        current = frozenset({DOCUMENT}) if len(parts) < 2 else self.types(parts[0], context)
        if token.symbol == "//":
            current = self.analysis.step(current, Step("descendant-or-self", "node()"))
        self.analysis.use(current if len(parts) < 2 and not parts else _NOTHING)
        return self.types(parts[-1], current) if parts else current

    def _flwor(self, token: Any, context: Types) -> Types:
        for clause in token.clauses:
            found = frozenset[str]().union(*(self.types(part, context) for part in clause.operands()))
            if token.binds(clause):
                self._bind(clause.names[0], found)
            else:
                # Keys are texts or numbers; a condition on nodes looks at them alone.
                self.analysis.value(found)
        return self.types(token[-1], context)

    def _function(self, token: Any, parts: list[Any], context: Types) -> Types:
        name = token.symbol
        inline = [part for part in parts if part.label == "inline function"]
        found = frozenset[str]().union(*(self.types(part, context) for part in parts if part not in inline))
        if not parts and (name in OF_CONTEXT or name in ("data", "root", "path", "has-children", "node-name")):
            found = context
        given = found
        for _ in range(_PASSES if inline else 0):
            given |= frozenset[str]().union(*(self._inline(part, given, context) for part in inline))
        if name == "root":
            return frozenset({DOCUMENT})
        self._taken(name, given)
        return self._result_types(name, given, token)

    def _taken(self, name: str, given: Types) -> None:
        """Note what a function of this name sees of its arguments."""
        if name in _OF_NODES_ALONE:
            self.analysis.use(given)
        else:
            self.analysis.value(given)

    def _result_types(self, name: str, given: Types, function: Any) -> Types:
        """The types of the result of a function of this name."""
        if name in _PASSING:
            return given
        if name.startswith(OF_BODIES):
            # They look into a table by the frame.
            self.analysis.use(frozenset({FRAME}))
            return frozenset({FRAME})
        result = (getattr(function, "sequence_types", None) or ("",))[-1]
        if name not in _DEEP and (result.startswith("xs:") or name in _OF_VALUES):
            return _NOTHING
        self.analysis.use(EVERYTHING)
        return EVERYTHING

    def _inline(self, token: Any, parameters: Types, context: Types) -> Types:
        for name in token.varnames:
            self._bind(str(name), parameters)
        return self.types(token.body, context)

    def _bind(self, name: str, types: Types) -> None:
        """For variables with the same name, the union of their types."""
        self.analysis.use(types)
        self._bound[name] = self._bound.get(name, _NOTHING) | types


def _step_of(token: Any) -> Step | None:
    """The step that a token is."""
    symbol, label = token.symbol, token.label
    if symbol == "(name)":
        return Step("child", str(token.value))
    if symbol == "..":
        return Step("parent", "node()")
    if symbol == "*" and not len(token):
        return Step("child", "*")
    if symbol == "@":
        return Step("attribute", _test(token[0]))
    if label == "axis" and symbol in AXES:
        return Step(symbol, _test(token[0]))
    return Step("child", _test(token)) if label == "kind test" else None


def _test(token: Any) -> str:
    """The test of a step; of kinds that steps do not have, any node."""
    if token.symbol == "(name)":
        return str(token.value)
    if token.symbol == "*":
        return "*"
    return f"{token.symbol}()" if token.symbol in ("text", "comment", "processing-instruction") else "node()"
