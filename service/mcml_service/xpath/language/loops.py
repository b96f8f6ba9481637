"""Loops and quantifiers, and FLWOR of XQuery 3.1 §3.12 in terms of them.

`for $a in A let $b := B where C order by K descending return R` is a loop over what `sort` makes of those of A that
fulfil C; `group by $k := K` is a loop over the different values of K, in which `$a` is all of A that have this one.
Ordering and grouping stand behind one `for`: of several variables XPath has no tuples.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

from mcml.errors import Place, QueryError
from mcml_service.xpath.language.cursor import Cursor
from mcml_service.xpath.language.tokens import Token
from mcml_service.xpath.language.tree import (
    Call,
    Expression,
    For,
    Function,
    If,
    Let,
    Operation,
    Quantified,
    Sequence,
    Span,
    Variable,
)

CLAUSES = ("for", "let", "where", "order", "stable", "group", "return")


@dataclass(frozen=True)
class Clause:
    """kind: "for", "let" or "where". variable: "" of a condition."""

    kind: str
    variable: str
    expression: Expression


class Loops(Cursor):
    """Reads what begins with for, let, some or every."""

    @abstractmethod
    def _expression(self) -> Expression:
        """One expression."""

    def _binding(self, word: Token) -> Expression:
        if word.text in ("some", "every"):
            return self._read_quantifier(word)
        clauses: list[Clause] = []
        while True:
            clauses += self._read_clause(word.text)
            if not self._at_word(*CLAUSES):
                raise self._unexpected("'return' is missing")
            word_before, word = word, self._advance()
            if word.text == "return":
                return _nest(clauses, self._expression(), (word_before.start, self._end()))
            if word.text in ("order", "stable", "group"):
                return self._read_order(word, clauses)

    def _read_quantifier(self, word: Token) -> Expression:
        bound = self._read_bindings("in")
        self._word("satisfies")
        body = self._expression()
        span = (word.start, self._end())
        for name, source in reversed(bound):
            body = Quantified(word.text, name, source, body, span)
        return body

    def _read_clause(self, kind: str) -> list[Clause]:
        if kind == "where":
            return [Clause(kind, "", self._expression())]
        return [Clause(kind, name, source) for name, source in self._read_bindings("in" if kind == "for" else ":=")]

    def _read_bindings(self, sign: str) -> list[tuple[str, Expression]]:
        """`$a in …, $b in …`"""
        bound: list[tuple[str, Expression]] = []
        while not bound or self._accept(","):
            self._expect("$")
            name = self._variable_name()
            if sign == "in":
                self._word(sign)
            else:
                self._expect(sign)
            bound.append((name, self._expression()))
        return bound

    def _read_order(self, word: Token, clauses: list[Clause]) -> Expression:
        """What follows `order`, `stable` or `group`."""
        place = Place(column=word.start + 1)
        if [clause.kind for clause in clauses].count("for") != 1 or clauses[0].kind != "for":
            raise QueryError(
                f"{word.text!r} stands behind one `for` with one variable",
                at=place,
                remedy="Loop over one sequence, and look the others up with let.",
            )
        if word.text == "group":
            self._word("by")
            self._expect("$")
            name = self._variable_name()
            self._expect(":=")
            clauses = _group(clauses, name, self._expression(), (word.start, self._end()))
            following: list[Clause] = []
            while self._at_word("let", "where"):
                following += self._read_clause(self._advance().text)
            clauses += following
            if self._at_word("return"):
                self._advance()
                return _nest(clauses, self._expression(), (word.start, self._end()))
            word = self._advance()
        if word.text == "stable":
            word = self._advance()
        if word.text != "order":
            raise QueryError(f"unexpected {word.text!r}", at=Place(column=word.start + 1))
        self._word("by")
        key = self._expression()
        is_descending = self._at_word("descending")
        if is_descending or self._at_word("ascending"):
            self._advance()
        if self._at(","):
            raise self._unexpected("one key is sorted by")
        self._word("return")
        span = (word.start, self._end())
        return _nest(_order(clauses, key, span, is_descending=is_descending), self._expression(), span)


def _nest(clauses: list[Clause], body: Expression, span: Span) -> Expression:
    for clause in reversed(clauses):
        if clause.kind == "where":
            body = If(clause.expression, body, Sequence((), span), span)
        else:
            body = (For if clause.kind == "for" else Let)(clause.variable, clause.expression, body, span)
    return body


def _select_items(clauses: list[Clause], span: Span) -> Expression:
    """The items of the loop that fulfil its conditions."""
    item = Variable(clauses[0].variable, span=span)
    if not any(clause.kind == "where" for clause in clauses):
        return clauses[0].expression
    return _nest(clauses, item, span)


def _lets(clauses: list[Clause]) -> list[Clause]:
    return [clause for clause in clauses if clause.kind == "let"]


def _order(clauses: list[Clause], key: Expression, span: Span, *, is_descending: bool) -> list[Clause]:
    """A loop over the items in the order of a key, then of their own."""
    loop = clauses[0]
    source = _select_items(clauses, span)
    if is_descending:
        # Equal ones stay in their order.
        source = Call("reverse", (source,), span)
    function = Function(loop.variable, _nest(_lets(clauses), key, span), span)
    source = Call("sort", (source, Sequence((), span), function), span)
    if is_descending:
        source = Call("reverse", (source,), span)
    return [Clause("for", loop.variable, source), *_lets(clauses)]


def _group(clauses: list[Clause], name: str, key: Expression, span: Span) -> list[Clause]:
    """A loop over the different keys, in which the variable is all items of one."""
    loop = clauses[0]
    source, own = _select_items(clauses, span), _nest(_lets(clauses), key, span)
    keys = Call("distinct-values", (For(loop.variable, source, own, span),), span)
    group = Variable(name, span=span)
    # What is no number is a group too, though it equals nothing.
    is_none = Operation("and", (Operation("!=", (own, own), span), Operation("!=", (group, group), span)), span)
    is_same = Operation("or", (Operation("=", (own, group), span), is_none), span)
    item = Variable(loop.variable, span=span)
    members = For(loop.variable, source, If(is_same, item, Sequence((), span), span), span)
    return [Clause("for", name, keys), Clause("let", loop.variable, members)]
