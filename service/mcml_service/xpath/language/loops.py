"""Loops and quantifiers, and FLWOR of XQuery 3.1 §3.12 in terms of them.

`for $a in A let $b := B where C order by K descending return R` is a loop over the sorted items of A that fulfil C;
`group by $k := K` is a loop over the distinct values of K, in which `$a` is all items of A with this value. Ordering
and grouping follow one `for`: XPath has no tuples of several variables. Several keys are several sorts, or loops within
loops; groups of several keys stay in the order of the items.
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


@dataclass(frozen=True)
class Key:
    """A key of `order by`."""

    expression: Expression
    is_descending: bool


class Loops(Cursor):
    """Parses expressions that begin with for, let, some or every."""

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
        """Parse the text after `order`, `stable` or `group`."""
        place = Place(column=word.start + 1)
        if [clause.kind for clause in clauses].count("for") != 1 or clauses[0].kind != "for":
            raise QueryError(
                f"{word.text!r} requires exactly one `for` with one variable before it",
                at=place,
                remedy="Loop over one sequence, and bind the others with let.",
            )
        if word.text == "group":
            self._word("by")
            clauses = self._read_groups(word, clauses)
            if self._at_word("return"):
                self._advance()
                return _nest(clauses, self._expression(), (word.start, self._end()))
            if [clause.kind for clause in clauses].count("for") > 1:
                raise self._unexpected("groups of several keys have no order; 'return' is missing")
            word = self._advance()
        if word.text == "stable":
            word = self._advance()
        if word.text != "order":
            raise QueryError(f"unexpected {word.text!r}", at=Place(column=word.start + 1))
        self._word("by")
        keys = self._read_keys()
        self._word("return")
        span = (word.start, self._end())
        return _nest(_order(clauses, keys, span), self._expression(), span)

    def _read_groups(self, word: Token, before: list[Clause]) -> list[Clause]:
        """Parse `$k := K, $l := L`, and the text up to `order` or `return`."""
        variable = before[0].variable
        clauses: list[Clause] = []
        while not clauses or self._accept(","):
            self._expect("$")
            name = self._variable_name()
            self._expect(":=")
            key = self._expression()
            span = (word.start, self._end())
            # A further key divides the groups of the one before.
            source = Variable(variable, span=span) if clauses else _select_items(before, span)
            clauses += _group(source, variable, name, _nest(_lets(before), key, span), span)
        while self._at_word("let", "where"):
            clauses += self._read_clause(self._advance().text)
        return clauses

    def _read_keys(self) -> list[Key]:
        """`K descending, L`"""
        keys: list[Key] = []
        while not keys or self._accept(","):
            expression = self._expression()
            is_descending = self._at_word("descending")
            if is_descending or self._at_word("ascending"):
                self._advance()
            keys.append(Key(expression, is_descending))
        return keys


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


def _order(clauses: list[Clause], keys: list[Key], span: Span) -> list[Clause]:
    """Return a loop over the items in the order of the first key, then of the next keys, then in their original
    order.
    """
    loop = clauses[0]
    source = _select_items(clauses, span)
    # Sorting is stable, so the last key comes first.
    for key in reversed(keys):
        function = Function(loop.variable, _nest(_lets(clauses), key.expression, span), span)
        if key.is_descending:
            # Equal items keep their order.
            source = Call("reverse", (source,), span)
        source = Call("sort", (source, Sequence((), span), function), span)
        if key.is_descending:
            source = Call("reverse", (source,), span)
    return [Clause("for", loop.variable, source), *_lets(clauses)]


def _group(source: Expression, variable: str, name: str, key: Expression, span: Span) -> list[Clause]:
    """A loop over the different keys of items, in which their variable is all items of one key."""
    keys = Call("distinct-values", (For(variable, source, key, span),), span)
    group = Variable(name, span=span)
    # NaN is a group too, although it equals nothing.
    is_none = Operation("and", (Operation("!=", (key, key), span), Operation("!=", (group, group), span)), span)
    is_same = Operation("or", (Operation("=", (key, group), span), is_none), span)
    item = Variable(variable, span=span)
    members = For(variable, source, If(is_same, item, Sequence((), span), span), span)
    return [Clause("for", name, keys), Clause("let", variable, members)]
