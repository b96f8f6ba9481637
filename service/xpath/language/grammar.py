"""XPath 1.0 from text to tree, in one pass over its tokens: recursive descent, operators by their levels.

Beyond the grammar of XPath 1.0 §2 and §3, as later versions have it: functions of XPath 2.0 that take such arguments,
predicates after `.` and `..`, numbers with an exponent.
"""

from __future__ import annotations

from service.errors import Place, QueryError
from service.xpath.language.functions import FUNCTIONS, SAXON_FUNCTIONS
from service.xpath.language.tokens import Token, tokens
from service.xpath.language.tree import (
    AXES,
    KIND_TESTS,
    LEVELS,
    Call,
    Expression,
    Filter,
    Literal,
    Operation,
    Path,
    Step,
)

ANY_NODE = Step("descendant-or-self", "node()")
_COMPARISONS = frozenset({"=", "!=", "<", "<=", ">", ">="})
_OPERATORS = frozenset(LEVELS) - {"negate", "|"}


class ArityError(QueryError):
    """A function is called with a number of arguments that it does not take."""


def read(text: str) -> Expression:
    """The tree of an expression, variables as calls of `$name`. QueryError for what is no XPath 1.0."""
    return _Reader(text).whole()


class _Reader:
    def __init__(self, text: str) -> None:
        self._tokens = tokens(text)
        self._place = 0
        self._next = self._tokens[0]

    # -- tokens ----------------------------------------------------------------------------------------------------

    def _advance(self) -> Token:
        token = self._next
        self._place += 1
        self._next = self._tokens[min(self._place, len(self._tokens) - 1)]
        return token

    def _at(self, *symbols: str) -> bool:
        return self._next.kind == "symbol" and self._next.text in symbols

    def _accept(self, symbol: str) -> bool:
        if self._at(symbol):
            self._advance()
            return True
        return False

    def _expect(self, symbol: str) -> None:
        if not self._accept(symbol):
            raise self._unexpected(f"{symbol!r} is missing")

    def _follows(self, symbol: str) -> bool:
        """Whether this symbol follows the next token."""
        after = self._tokens[min(self._place + 1, len(self._tokens) - 1)]
        return after.kind == "symbol" and after.text == symbol

    def _unexpected(self, wanted: str) -> QueryError:
        token = self._next
        if token.kind == "end":
            last = self._tokens[self._place - 1] if self._place else token
            return QueryError(f"the expression ends early: {wanted}", at=Place(column=last.start + 1))
        if token.text == ":":
            return QueryError("a prefix cannot be used here", at=Place(column=token.start + 1))
        return QueryError(f"unexpected {token.text!r}: {wanted}", at=Place(column=token.start + 1))

    # -- operators -------------------------------------------------------------------------------------------------

    def whole(self) -> Expression:
        expression = self._expression()
        if self._next.kind != "end":
            raise self._unexpected("an operator is missing before it")
        return expression

    def _expression(self) -> Expression:
        # Operators that wait for their right operand stand in a list, so that a long sum is no deep recursion.
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
        for start in reversed(signs):
            operand = Operation("negate", (operand,), (start, operand.span[1]))
        return operand

    def _union(self) -> Expression:
        operands = [self._path()]
        while self._accept("|"):
            operands.append(self._path())
        if len(operands) == 1:
            return operands[0]
        return Operation("|", tuple(operands), (operands[0].span[0], operands[-1].span[1]))

    # -- paths -----------------------------------------------------------------------------------------------------

    def _path(self) -> Expression:
        begin = self._next.start
        if not self._starts_primary():
            absolute = self._at("/", "//")
            steps = self._relative(first=not absolute)
            return Path(steps, absolute, span=(begin, self._tokens[self._place - 1].end))
        start = self._primary()
        if self._at("["):
            start = Filter(start, self._predicates(), (begin, self._tokens[self._place - 1].end))
        if not self._at("/", "//"):
            return start
        steps = self._relative(first=False)
        span = (begin, self._tokens[self._place - 1].end)
        if isinstance(start, Path) and start.start is None:
            return Path((*start.steps, *steps), start.absolute, span=span)
        return Path(steps, start=start, span=span)

    def _relative(self, *, first: bool) -> tuple[Step, ...]:
        """Steps; first: the first one has no slash before it, else it has."""
        steps: list[Step] = []
        while first or self._at("/", "//"):
            if not first and self._advance().text == "//":
                steps.append(ANY_NODE)
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
        return Step(axis, name, predicates, (begin, self._tokens[self._place - 1].end))

    def _test(self) -> str:
        if self._accept("*"):
            return "*"
        if self._next.kind != "name":
            raise self._unexpected("a node test is missing")
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
            found.append(self._expression())
            self._expect("]")
        return tuple(found)

    # -- primary expressions ---------------------------------------------------------------------------------------

    def _starts_primary(self) -> bool:
        if self._next.kind == "name":
            return self._follows("(") and self._next.text not in KIND_TESTS
        return self._next.kind in ("number", "string") or self._at("(", "$")

    def _primary(self) -> Expression:
        token = self._advance()
        span = token.start, token.end
        if token.kind == "number":
            return Literal(float(token.text), span)
        if token.kind == "string":
            return Literal(token.text[1:-1], span)
        if token.kind == "name":
            return self._call(token)
        if token.text == "(":
            inner = self._expression()
            self._expect(")")
            return inner
        if self._next.kind != "name":
            raise self._unexpected("the name of a variable is missing")
        name = self._advance()
        return Call(f"${name.text}", (), (token.start, name.end))

    def _call(self, token: Token) -> Expression:
        signature = FUNCTIONS.get(token.text)
        if signature is None:
            what = "has no place in XPath 1.0" if token.text in SAXON_FUNCTIONS else f"unknown function {token.text!r}"
            raise QueryError(what, at=Place(column=token.start + 1))
        self._expect("(")
        arguments: list[Expression] = []
        if not self._at(")"):
            arguments.append(self._expression())
            while self._accept(","):
                arguments.append(self._expression())
        self._expect(")")
        check_arity(token.text, len(arguments), token.start + 1)
        return Call(token.text, tuple(arguments), (token.start, self._tokens[self._place - 1].end))


def _binds_first(left: str, right: str) -> bool:
    """Whether of `a left b right c` the left operator joins b. Operators of which one node holds all operands wait."""
    if LEVELS[left] == LEVELS[right]:
        # `1 = 1 = 1` compares the truth of the first comparison with the last operand.
        return left != right or left in _COMPARISONS
    return LEVELS[left] > LEVELS[right]


def _joined(operator: str, operands: list[Expression], last: Expression) -> Operation:
    return Operation(operator, (*operands, last), (operands[0].span[0], last.span[1]))


def check_arity(name: str, count: int, column: int) -> None:
    """ArityError where a function does not take so many arguments."""
    signature = (FUNCTIONS | SAXON_FUNCTIONS)[name]
    if not signature.takes(count):
        given = "1 is given" if count == 1 else f"{count} are given"
        raise ArityError(f"{name}() takes {signature.words}, {given}", at=Place(column=column))
