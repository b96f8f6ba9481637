"""XPath from text to tree, in one pass over its tokens: recursive descent, operators by their levels.

XPath 1.0 §2 and §3, and of 2.0 and 3.1 what columns evaluate: sequences, `for`, `let`, `some`, `every`, `if`, ranges,
`||`, `!`, `=>`, comparisons of values, expressions as steps. Types, casts, comments and comparisons of nodes are left
to elementpath (`xpath31/written.py`).
"""

from __future__ import annotations

from mcml.errors import Place, QueryError
from mcml_service.xpath.language.arity import check_arity
from mcml_service.xpath.language.functions import SAFE_FUNCTIONS
from mcml_service.xpath.language.loops import Loops
from mcml_service.xpath.language.tokens import Token
from mcml_service.xpath.language.tree import (
    AXES,
    KIND_TESTS,
    LEVELS,
    VALUE_COMPARISONS,
    Call,
    Each,
    Expression,
    Filter,
    Function,
    If,
    Literal,
    Operation,
    Path,
    Sequence,
    Step,
    Variable,
)

ANY_NODE = Step("descendant-or-self", "node()")
_COMPARISONS = frozenset({"=", "!=", "<", "<=", ">", ">=", *VALUE_COMPARISONS})
_OPERATORS = frozenset(LEVELS) - {"negate", "|", "intersect", "except", "!", "/"}
_PREFIXES = ("fn", "math", "mo")


def read(text: str) -> Expression:
    """Return the tree of an expression, with unbound variables.

    Raises QueryError for expressions outside this grammar.
    """
    return _Reader(text).whole()


class _Reader(Loops):
    # -- sequences, loops and branches -----------------------------------------------------------------------------

    def whole(self) -> Expression:
        expression = self._sequence()
        if self._next.kind != "end":
            raise self._unexpected("an operator is missing before it")
        return expression

    def _sequence(self) -> Expression:
        """One expression, or several between commas."""
        first = self._expression()
        if not self._at(","):
            return first
        items = [first]
        while self._accept(","):
            items.append(self._expression())
        return Sequence(tuple(items), (first.span[0], self._end()))

    def _expression(self) -> Expression:
        if self._at_word("for", "let", "some", "every") and self._follows("$"):
            return self._binding(self._advance())
        if self._at_word("if") and self._follows("("):
            return self._branch(self._advance())
        return self._operations()

    def _branch(self, word: Token) -> Expression:
        self._expect("(")
        test = self._sequence()
        self._expect(")")
        self._word("then")
        then = self._expression()
        self._word("else")
        return If(test, then, self._expression(), (word.start, self._end()))

    # -- operators -------------------------------------------------------------------------------------------------

    def _operations(self) -> Expression:
        # Operators that wait for their right operand are in a list, so that a long sum needs no deep recursion.
        waiting: list[tuple[str, list[Expression]]] = []
        right = self._signed()
        while (operator := self._operator()) is not None:
            while waiting and _binds_first(waiting[-1][0], operator):
                right = _joined(*waiting.pop(), right)
            if waiting and waiting[-1][0] == operator:
                waiting[-1][1].append(right)
            else:
                waiting.append((operator, [right]))
            right = self._signed()
        while waiting:
            right = _joined(*waiting.pop(), right)
        return right

    def _operator(self) -> str | None:
        if self._next.kind in ("symbol", "name") and self._next.text in _OPERATORS:
            return self._advance().text
        return None

    def _signed(self) -> Expression:
        """A union with minus signs before it, which bind less tightly."""
        signs = []
        while self._at("-"):
            signs.append(self._advance().start)
        if self._at("+"):
            raise QueryError("XPath has no unary plus", at=Place(column=self._next.start + 1), remedy="Leave it out.")
        operand = self._union()
        while self._accept("=>"):
            name = self._advance()
            if name.kind != "name":
                raise self._unexpected("the name of a function is missing")
            operand = self._call(name, operand)
        for start in reversed(signs):
            operand = Operation("negate", (operand,), (start, operand.span[1]))
        return operand

    def _union(self) -> Expression:
        operands = [self._intersection()]
        while self._at("|") or self._at_word("union"):
            self._advance()
            operands.append(self._intersection())
        if len(operands) == 1:
            return operands[0]
        return Operation("|", tuple(operands), (operands[0].span[0], operands[-1].span[1]))

    def _intersection(self) -> Expression:
        found = self._simple_map()
        while self._at_word("intersect", "except"):
            operator = self._advance().text
            found = Operation(operator, (found, self._simple_map()), (found.span[0], self._end()))
        return found

    def _simple_map(self) -> Expression:
        found = self._path()
        while self._accept("!"):
            found = Each(found, self._path(), span=(found.span[0], self._end()))
        return found

    # -- paths -----------------------------------------------------------------------------------------------------

    def _path(self) -> Expression:
        begin = self._next.start
        if self._starts_primary():
            found = self._postfix()
        else:
            absolute = self._at("/", "//")
            steps = self._relative(first=not absolute)
            found = Path(steps, absolute, span=(begin, self._end()))
        while self._at("/", "//"):
            if self._next.text == "/" and self._starts_primary(1):
                self._advance()
                found = Each(found, self._postfix(), is_step=True, span=(begin, self._end()))
                continue
            steps, span = self._relative(first=False), (begin, self._end())
            if isinstance(found, Path) and found.start is None:
                found = Path((*found.steps, *steps), found.absolute, span=span)
            else:
                found = Path(steps, start=found, span=span)
        return found

    def _postfix(self) -> Expression:
        """A primary expression with its predicates."""
        begin = self._next.start
        primary = self._primary()
        return Filter(primary, self._predicates(), (begin, self._end())) if self._at("[") else primary

    def _relative(self, *, first: bool) -> tuple[Step, ...]:
        """Steps; first: the first one has no slash before it, else it has."""
        steps: list[Step] = []
        while first or (self._at("/", "//") and not (self._at("/") and steps and self._starts_primary(1))):
            if not first and self._advance().text == "//":
                steps.append(ANY_NODE)
                if self._starts_primary():
                    raise self._unexpected("a step such as frame is missing; write //. /f() for a call on all nodes")
            elif not first and not steps and not self._starts_step():
                # The slash alone is the document.
                break
            steps.append(self._step())
            first = False
        return tuple(steps)

    def _starts_step(self) -> bool:
        return self._next.kind == "name" or self._at("*", ".", "..", "@")

    def _step(self) -> Step:
        begin = self._next.start
        if not self._starts_step():
            raise self._unexpected("a step such as frame or @Rx is missing")
        axis = "child"
        if self._at(".", ".."):
            axis, name = ("self" if self._advance().text == "." else "parent"), "node()"
        else:
            if self._accept("@"):
                axis = "attribute"
            elif self._next.kind == "name" and self._follows("::"):
                if self._next.text not in AXES:
                    raise self._unexpected("XPath has no such axis")
                axis = self._advance().text
                self._advance()
            name = self._test()
        predicates = self._predicates()
        return Step(axis, name, predicates, (begin, self._end()))

    def _local(self) -> str:
        if self._next.kind != "name":
            raise self._unexpected("a name is missing")
        return self._advance().text

    def _qualified(self) -> str:
        """`Q{}name`, `Q{}*`: of no namespace."""
        self._advance(), self._advance()
        if not self._accept("}"):
            raise QueryError(
                "MCML has no namespaces",
                at=Place(column=self._next.start + 1),
                remedy="Write Q{} before the name, or the name alone.",
            )
        return "*" if self._accept("*") else self._local()

    def _test(self) -> str:
        if self._accept("*"):
            # Of any namespace: MCML has none.
            return self._local() if self._accept(":") else "*"
        if self._next.kind != "name":
            raise self._unexpected("a node test is missing")
        if self._next.text == "Q" and self._follows("{"):
            return self._qualified()
        if not self._follows("("):
            name = self._advance().text
            if self._at(":"):
                raise self._unexpected("")
            return name
        if self._next.text not in KIND_TESTS:
            raise self._unexpected("a call cannot follow a slash")
        kind = self._advance().text
        self._advance()
        target = ""
        if kind == "processing-instruction" and self._next.kind == "string":
            target = f"'{self._advance().text[1:-1]}'"
        self._expect(")")
        return f"{kind}({target})"

    def _predicates(self) -> tuple[Expression, ...]:
        found = []
        while self._accept("["):
            found.append(self._sequence())
            self._expect("]")
        return tuple(found)

    # -- primary expressions ---------------------------------------------------------------------------------------

    def _starts_primary(self, ahead: int = 0) -> bool:
        """Whether the next token, or one further on, begins an expression that is no step."""
        token = self._tokens[min(self._place + ahead, len(self._tokens) - 1)]
        if token.kind == "name":
            is_prefix = token.text in _PREFIXES and self._follows(":", ahead + 1)
            return is_prefix or (self._follows("(", ahead + 1) and token.text not in KIND_TESTS)
        return token.kind in ("number", "string") or (token.kind == "symbol" and token.text in ("(", "$"))

    def _primary(self) -> Expression:
        token = self._advance()
        span = token.start, token.end
        if token.kind == "number":
            return Literal(float(token.text), span)
        if token.kind == "string":
            return Literal(token.text[1:-1], span)
        if token.kind == "name":
            return self._function(token) if token.text == "function" else self._call(token)
        if token.text == "(":
            if self._accept(")"):
                return Sequence((), (token.start, self._end()))
            inner = self._sequence()
            self._expect(")")
            return inner
        name = self._variable_name()
        return Variable(name, span=(token.start, self._end()))

    def _call(self, token: Token, first: Expression | None = None) -> Expression:
        """first: the argument before `=>`."""
        name, last = token.text, token
        if name in _PREFIXES and self._accept(":"):
            last = self._advance()
            name = last.text if name == "fn" else f"{name}:{last.text}"
        if name not in SAFE_FUNCTIONS:
            raise QueryError(f"unknown function {name!r}", at=Place(column=last.start + 1))
        self._expect("(")
        arguments = [] if first is None else [first]
        if not self._at(")"):
            arguments.append(self._expression())
            while self._accept(","):
                arguments.append(self._expression())
        self._expect(")")
        check_arity(name, len(arguments), token.start + 1)
        begin = token.start if first is None else first.span[0]
        return Call(name, tuple(arguments), (begin, self._end()))

    def _function(self, token: Token) -> Expression:
        """`function($item) { … }`, as `sort` takes it."""
        self._expect("(")
        self._expect("$")
        name = self._variable_name()
        self._expect(")")
        self._expect("{")
        body = self._sequence()
        self._expect("}")
        return Function(name, body, (token.start, self._end()))


def _binds_first(left: str, right: str) -> bool:
    """Whether of `a left b right c` the left operator joins b. Operators of which one node holds all operands wait."""
    if LEVELS[left] == LEVELS[right]:
        # `1 = 1 = 1` compares the truth of the first comparison with the last operand.
        return left != right or left in _COMPARISONS
    return LEVELS[left] > LEVELS[right]


def _joined(operator: str, operands: list[Expression], last: Expression) -> Operation:
    return Operation(operator, (*operands, last), (operands[0].span[0], last.span[1]))
