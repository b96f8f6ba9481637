"""Loops and quantifiers, and FLWOR of XQuery 3.1 §3.12 in terms of them.

`for $a in A let $b := B where C order by K descending return R` is a loop over the sorted items of A that fulfil C;
`group by $k := K` is a loop over the distinct values of K, in which `$a` is all items of A with this value; the items
without a value of K are a group too, in which `$k` is empty. `count $n` is a loop with places over the items so far.
Several keys are several sorts, or loops within loops; groups of several keys stay in the order of the items. Tuples of
several variables are evaluated on trees (`xpath31/flwor.py`).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence as Seq
from dataclasses import dataclass, replace

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
    Literal,
    Operation,
    Quantified,
    Sequence,
    Span,
    Variable,
    free_variables,
)

ONE_ITEM = frozenset(
    (
        *("string", "concat", "count", "number", "boolean", "not", "exists", "empty", "name", "local-name", "sum"),
        *("string-length", "normalize-space", "lower-case", "upper-case", "substring", "substring-before"),
        *("substring-after", "translate", "starts-with", "ends-with", "contains", "matches"),
    )
)
"""Functions that always answer with one item."""
OF_ONE_ITEM = frozenset({"=", "!=", "<", "<=", ">", ">=", "and", "or", "||"})
CLAUSES = ("for", "let", "where", "order", "stable", "group", "count", "return")


@dataclass(frozen=True)
class Clause:
    """kind: "for", "let" or "where". variable: "" of a condition. position: the variable for the place of an item."""

    kind: str
    variable: str
    expression: Expression
    position: str = ""


@dataclass(frozen=True)
class Group:
    """A loop over the values of a key, `keys`. name: of the key; variable: of the items with one value, from `source`.

    rest: whether items without a value are a group, the "first" or the "last"; "" where every item has one.
    """

    name: str
    variable: str
    source: Expression
    key: Expression
    keys: Expression
    rest: str

    def members(self, condition: Expression, span: Span) -> Expression:
        item = Variable(self.variable, span=span)
        return For(self.variable, self.source, If(condition, item, Sequence((), span), span), span)

    def has_value(self, span: Span) -> Expression:
        """Whether the key of an item is the value. NaN is a value too, although it equals nothing."""
        key, value = self.key, Variable(self.name, span=span)
        is_none = Operation("and", (Operation("!=", (key, key), span), Operation("!=", (value, value), span)), span)
        return Operation("or", (Operation("=", (key, value), span), is_none), span)


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
            if word.text == "group":
                return self._read_group(word, clauses)
            if word.text in ("order", "stable"):
                clauses = _order(clauses, self._read_order(word, clauses), (word.start, self._end()))
            elif word.text == "count":
                clauses = self._read_count(word, clauses)
            else:
                clauses += self._read_clause(word.text)
            if not self._at_word(*CLAUSES):
                raise self._unexpected("'return' is missing")
            word_before, word = word, self._advance()
            if word.text == "return":
                return _nest(clauses, self._expression(), (word_before.start, self._end()))

    def _read_quantifier(self, word: Token) -> Expression:
        bound = self._read_bindings()
        self._word("satisfies")
        body = self._expression()
        span = (word.start, self._end())
        for name, source in reversed(bound):
            body = Quantified(word.text, name, source, body, span)
        return body

    def _read_clause(self, kind: str) -> list[Clause]:
        if kind == "where":
            return [Clause(kind, "", self._expression())]
        clauses: list[Clause] = []
        while not clauses or self._accept(","):
            self._expect("$")
            name, position = self._variable_name(), ""
            if kind == "for" and self._at_word("at"):
                self._advance()
                self._expect("$")
                position = self._variable_name()
                if position == name:
                    raise self._unexpected("an item and its place need two names")
            clauses.append(Clause(kind, name, self._source("in" if kind == "for" else ":="), position))
        return clauses

    def _read_bindings(self) -> list[tuple[str, Expression]]:
        """`$a in …, $b in …`"""
        bound: list[tuple[str, Expression]] = []
        while not bound or self._accept(","):
            self._expect("$")
            bound.append((self._variable_name(), self._source("in")))
        return bound

    def _source(self, sign: str) -> Expression:
        if sign == "in":
            self._word(sign)
        else:
            self._expect(sign)
        return self._expression()

    def _read_count(self, word: Token, clauses: list[Clause]) -> list[Clause]:
        """Parse `$n` after `count`: the loop over the items so far has their places."""
        _require_one_loop(word, clauses)
        self._expect("$")
        name = self._variable_name()
        _require_new(word, [*_names(clauses), name])
        source = _select_items(clauses, (word.start, self._end()))
        return [Clause("for", clauses[0].variable, source, name), *_lets(clauses)]

    def _read_order(self, word: Token, clauses: list[Clause]) -> list[Key]:
        """Parse the text after `order` or `stable`."""
        _require_one_loop(word, clauses)
        if word.text == "stable":
            word = self._advance()
        if word.text != "order":
            raise QueryError(f"unexpected {word.text!r}", at=Place(column=word.start + 1))
        self._word("by")
        return self._read_keys()

    def _read_group(self, word: Token, clauses: list[Clause]) -> Expression:
        """Parse the text after `group`."""
        _require_one_loop(word, clauses)
        self._word("by")
        before = {clause.variable for clause in _lets(clauses)}
        groups, clauses = self._read_groups(word, clauses)
        if self._at_word("return"):
            self._advance()
            body = self._expression()
            _require_known(word, before, [_nest(clauses, body, (word.start, self._end()))])
            return _nest([*groups, *clauses], body, (word.start, self._end()))
        if len(groups) > 1:
            raise self._unexpected("groups of several keys have no order; 'return' is missing")
        word = self._advance()
        keys = self._read_order(word, [Clause("for", groups[0].name, groups[0].keys)])
        self._word("return")
        span = (word.start, self._end())
        body = self._expression()
        _require_known(word, before, [_nest(clauses, each, span) for each in (body, *(key.expression for key in keys))])
        return _nest(_order_groups(groups[0], clauses, keys, span), body, span)

    def _read_groups(self, word: Token, before: list[Clause]) -> tuple[list[Group], list[Clause]]:
        """Parse `$k := K, $l := L`, and the clauses up to `order` or `return`."""
        variable = before[0].variable
        groups: list[Group] = []
        while not groups or self._accept(","):
            self._expect("$")
            name = self._variable_name()
            _require_new(word, [*_names(before), *(group.name for group in groups), name])
            self._expect(":=")
            key = self._expression()
            span = (word.start, self._end())
            rest = "" if _has_one_item(key, _lets(before)) else "last"
            key = _nest(_lets(before), key, span)
            # A further key divides the groups of the one before.
            source = Variable(variable, span=span) if groups else _select_items(before, span)
            keys = Call("distinct-values", (For(variable, source, key, span),), span)
            groups.append(Group(name, variable, source, key, keys, rest))
        clauses: list[Clause] = []
        while self._at_word("let", "where"):
            clauses += self._read_clause(self._advance().text)
        return groups, clauses

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


def _nest(clauses: Seq[Clause | Group], body: Expression, span: Span) -> Expression:
    for clause in reversed(clauses):
        if isinstance(clause, Group):
            body = _loop_over_groups(clause, body, span)
        elif clause.kind == "where":
            body = If(clause.expression, body, Sequence((), span), span)
        elif clause.kind == "for":
            body = For(clause.variable, clause.expression, body, span, clause.position)
        else:
            body = Let(clause.variable, clause.expression, body, span)
    return body


def _require_one_loop(word: Token, clauses: list[Clause]) -> None:
    """Raise QueryError for a stream of several variables, which is evaluated on trees (`xpath31/flwor.py`)."""
    loops = [clause for clause in clauses if clause.kind == "for"]
    if len(loops) != 1 or loops[0] is not clauses[0] or loops[0].position:
        raise QueryError(
            f"{word.text!r} requires exactly one `for` with one variable before it",
            at=Place(column=word.start + 1),
            remedy="Loop over one sequence, and bind the others with let.",
        )
    _require_new(word, _names(clauses))


def _names(clauses: list[Clause]) -> list[str]:
    return [clause.variable for clause in clauses if clause.variable]


def _require_new(word: Token, names: list[str]) -> None:
    """Raise QueryError where a variable takes the name of another one, which trees tell apart (`xpath31/flwor.py`)."""
    if len(set(names)) < len(names):
        raise QueryError(f"two variables before {word.text!r} have the same name", at=Place(column=word.start + 1))


def _require_known(word: Token, before: set[str], after: list[Expression]) -> None:
    """Raise QueryError for a variable of let that is used after a group: it has the values of all items then, which
    only trees give it (`xpath31/flwor.py`).
    """
    for expression in after:
        for name in before & free_variables(expression):
            raise QueryError(f"${name} is of the items before they are grouped", at=Place(column=word.start + 1))


def _loop_over_groups(group: Group, body: Expression, span: Span) -> Expression:
    members = group.members(group.has_value(span), span)
    loop = For(group.name, group.keys, Let(group.variable, members, body, span), span)
    if not group.rest:
        return loop
    nothing = Sequence((), span)
    others = group.members(Call("empty", (group.key,), span), span)
    are_some = Call("exists", (Variable(group.variable, span=span),), span)
    rest = Let(group.name, nothing, Let(group.variable, others, If(are_some, body, nothing, span), span), span)
    return Sequence((rest, loop) if group.rest == "first" else (loop, rest), span)


def _has_one_item(expression: Expression, lets: list[Clause]) -> bool:
    """Whether its form alone makes it one item."""
    if isinstance(expression, Variable):
        bound = next((clause for clause in reversed(lets) if clause.variable == expression.name), None)
        return bound is not None and _has_one_item(bound.expression, lets[: lets.index(bound)])
    if isinstance(expression, Operation):
        if expression.operator in OF_ONE_ITEM:
            return True
        return expression.operator in ("+", "-", "*", "div", "mod", "negate") and all(
            _has_one_item(operand, lets) for operand in expression.operands
        )
    return isinstance(expression, Literal) or (isinstance(expression, Call) and expression.function in ONE_ITEM)


def _select_items(clauses: list[Clause], span: Span) -> Expression:
    """The items of the loop that fulfil its conditions."""
    item = Variable(clauses[0].variable, span=span)
    if not any(clause.kind == "where" for clause in clauses):
        return clauses[0].expression
    return _nest(clauses, item, span)


def _lets(clauses: list[Clause]) -> list[Clause]:
    return [clause for clause in clauses if clause.kind == "let"]


def _used_lets(clauses: list[Clause], expression: Expression) -> list[Clause]:
    """The lets that an expression needs: others, such as all items of a group, would be evaluated for each key."""
    used: list[Clause] = []
    needed = set(free_variables(expression))
    for clause in reversed(_lets(clauses)):
        if clause.variable in needed:
            needed |= set(free_variables(clause.expression))
            used.insert(0, clause)
    return used


def _order(clauses: list[Clause], keys: list[Key], span: Span) -> list[Clause]:
    """Return a loop over the items in the order of the first key, then of the next keys, then in their original
    order.
    """
    loop = clauses[0]
    source = _select_items(clauses, span)
    # Sorting is stable, so the last key comes first.
    for key in reversed(keys):
        function = Function(loop.variable, _nest(_used_lets(clauses, key.expression), key.expression, span), span)
        if key.is_descending:
            # Equal items keep their order.
            source = Call("reverse", (source,), span)
        source = Call("sort", (source, Sequence((), span), function), span)
        if key.is_descending:
            source = Call("reverse", (source,), span)
    return [Clause("for", loop.variable, source), *_lets(clauses)]


def _order_groups(group: Group, clauses: list[Clause], keys: list[Key], span: Span) -> list[Clause | Group]:
    """Return the loop over groups in the order of keys. QueryError where the group without a value would have no
    place in it.
    """
    members = Clause("let", group.variable, group.members(group.has_value(span), span))
    ordered, *_ = _order([Clause("for", group.name, group.keys), members, *clauses], keys, span)
    first = keys[0].expression
    if isinstance(first, Call) and first.function == "string" and first.arguments:
        first = first.arguments[0]
    if group.rest and not (isinstance(first, Variable) and first.name == group.name):
        raise QueryError(
            f"${group.name} may be empty, and the order does not say where the group without a value goes",
            at=Place(column=span[0] + 1),
            remedy=f"Group by a text, ${group.name} := string(…), or order by ${group.name} first.",
        )
    # Nothing is less than any value.
    rest = group.rest and ("last" if keys[0].is_descending else "first")
    return [replace(group, keys=ordered.expression, rest=rest), *clauses]
