"""Functions of bodies in motion for elementpath, which does not have them and sees only XML, without bodies.

A call becomes a lookup in a table with a number for every frame, computed by columns as for any other query. The tables
are variables of the request, so nothing visible is added to the document.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import chain, product
from math import prod
from typing import Any, TypeAlias
from urllib.parse import quote, unquote
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from mcml.errors import LimitError, QueryError
from mcml.motion.bodies.quantities import FEET
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.engine.columns import Columns
from mcml_service.xpath.engine.context import Context
from mcml_service.xpath.engine.functions import NotOnColumnsError
from mcml_service.xpath.engine.motion.motions import most_between
from mcml_service.xpath.language.calls import WrittenCall, written_calls
from mcml_service.xpath.language.motion_functions import (
    ANGLE,
    JOINT_OR_SIDE,
    JOINTS,
    MOTION_FUNCTIONS,
    OF_NUMBERS,
    PREFIX,
    RUNS,
    WINDOW,
)
from mcml_service.xpath.language.reach import HeadPart
from mcml_service.xpath.language.tree import Atomic, Call, Literal, Written, walk
from mcml_service.xpath.language.types import is_of_variables, type_of
from mcml_service.xpath.language.unparse import unparse
from mcml_service.xpath.library.bodies import Bodies
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.nodes.pairs import TooWideError
from mcml_service.xpath.trees.evaluate import Items

Values: TypeAlias = Mapping[str, Atomic]
Numbers: TypeAlias = NDArray[Any]
Met: TypeAlias = dict[Call, dict[tuple[str, ...], None]]
"""Names in the variable arguments of a call."""
_PREFIX = "$mo-"
"""Prefix of internal variables."""
_MISSED = uuid4().hex
"""Begins the error that a table lacks a name. No text of others holds it."""
FEW = 100
"""Number of names, of joints or of pairs of them, up to which all are given at once, also unused ones."""
ONE_BY_ONE = 4
"""With more names, this many are added one after the other before all are given."""
_MAPS, _ARRAYS = (f"Q{{http://www.w3.org/2005/xpath-functions/{kind}}}" for kind in ("map", "array"))
# A column ends with the numbers for nodes outside the frames of each document. In 1.0-compatibility mode, sums are no
# integers.
_FUNCTIONS = f"""let $mo-frames := array {{ /mcml/motion/frame }},
$mo-places := {_MAPS}merge(
  for $i in 1 to {_ARRAYS}size($mo-frames) return {_MAPS}entry(generate-id($mo-frames($i)), $i)),
$mo-roots := array {{ / }},
$mo-heads := {_MAPS}merge(for $i in 1 to {_ARRAYS}size($mo-roots) return
  {_MAPS}entry(generate-id($mo-roots($i)), xs:integer({_ARRAYS}size($mo-frames) + $i))),
$mo-place := function($node) {{
  if ($node instance of node())
  then ($mo-places(generate-id($node/ancestor-or-self::frame)), $mo-heads(generate-id(root($node))))[1]
  else error((), 'a function of bodies is asked with a value as context, which is in no frame; bind it with for') }},
$mo-name := function($named) {{
  string(head($named) ! (if (. instance of node()) then (@name, name, .)[1] else .)) }},
$mo-joint := function($named, $joints) {{
  let $name := $mo-name($named) return if ($joints($name)) then $name else '' }},
$mo-column := function($numbers) {{ array {{ tokenize($numbers, ' ') ! number(.) }} }},
$mo-value := function($table, $columns, $names, $node) {{
  let $key := string-join($names ! encode-for-uri(.), ','), $column := $columns($key)
  return if (exists($column)) then $column($mo-place($node))
  else error((), concat('{_MISSED} ', $table, ':', $key, ';')) }},
$mo-window := function($columns, $node) {{
  let $place := $mo-place($node)
  return (xs:integer($columns('first')($place)) to xs:integer($columns('last')($place))) ! $mo-frames(.) }},
$mo-runs := function($nodes, $least, $between, $seconds) {{
  let $places := sort(distinct-values($nodes ! (
        if (. instance of element(frame)) then $mo-place(.) else error((), 'Runs are of frames')))),
      $starts := for $i in 1 to count($places) return
        if ($i = 1 or $places[$i] - $places[$i - 1] - 1 > $between) then $i else (),
      $ends := (tail($starts) ! (. - 1), count($places))
  return for-each-pair($starts, $ends, function($start, $end) {{
    if (($places[$end] - $places[$start] + 1 + 1e-6) * $seconds >= $least)
    then ($places[$start] to $places[$end]) ! $mo-frames(.) else () }}) }}"""


class BodyValues:
    """Values of bodies in the documents of some groups.

    limits: of the query; its elements limit the numbers of a document.
    """

    def __init__(self, tx: Transaction, caches: Caches, groups: Sequence[Group], limits: Limits) -> None:
        self._tx = tx
        self._caches = caches
        self._groups = groups
        self._limits = limits
        self._met: Met = {}
        self._noted: set[Forest] = set()

    @cached_property
    def _forests(self) -> dict[int, Forest]:
        """Of the group of each document, by its key."""
        found = {}
        for group in self._groups:
            forest = Forest(self._tx, group, self._caches, head_part=HeadPart.ALL)
            found.update(dict.fromkeys(group.keys, forest))
        return found

    def _columns(self, documents: Sequence[Listed]) -> Columns:
        """Of these documents alone: others may never be looked at."""
        for stored in documents:
            forest = self._forests[stored.key]
            if forest not in self._noted:
                # The warnings of an answer come from the facts of the bodies of a group.
                Bodies(forest, self._limits.check).facts()
                self._noted.add(forest)
        return Columns(forest.part(documents), self._limits.check, is_later=True)

    def answer(
        self, ask: Callable[[str, Values], Items], text: str, variables: Values, documents: Sequence[Listed]
    ) -> Items:
        """Return elementpath's answer to an expression about documents.

        ask: evaluates it, with variables. The joint of an argument such as in `mo:height(.)` is known only during the
        evaluation: the expression is then evaluated again with the missing numbers. Raises QueryError for expressions
        that only columns can answer, LimitError for too many numbers.
        """
        if PREFIX not in text:
            return ask(text, variables)
        columns = self._columns(documents)
        while True:
            asked = _Asked(columns, text, variables, self._limits.max_elements, self._met)
            try:
                return ask(asked.text, asked.variables)
            except QueryError as error:
                if not asked.learns(error.what):
                    raise


class _Asked:
    """An expression for elementpath, about some documents. text, variables: its input."""

    def __init__(self, columns: Columns, text: str, variables: Values, most: int, met: Met) -> None:
        self._motions = columns.motions
        source, frames = columns.forest.all_frames(np.arange(len(columns.forest)))
        self._context = Context(np.concatenate([frames, columns.documents().nodes]))
        # The place of the first frame of the document of each node, from 0.
        starts = np.searchsorted(source, np.arange(len(columns.forest)))
        self._starts = np.concatenate([starts[source], starts])
        self._left = most
        self._met = met
        self._given = variables
        self._prefix = _PREFIX
        while self._prefix in text:
            self._prefix += "-"
        self._calls: list[Call] = []
        self._columns: dict[Call, str] = {}
        self._tables: dict[str, str] = {}
        self._numbers: dict[str, str] = {}
        body = self._rewritten(text)
        self.text = body if body == text else self._whole(body)
        self.variables = {**variables, **self._numbers}

    def learns(self, refused: str) -> bool:
        """Tell whether the expression can succeed when it is evaluated again."""
        missed = re.search(rf"{_MISSED} (\d+):([^;]*);", refused)
        if missed is None:
            return False
        met = self._met.setdefault(self._calls[int(missed[1])], {})
        names = tuple(map(unquote, missed[2].split(",")))
        is_new = names not in met
        met[names] = None
        return is_new

    def _rewritten(self, text: str) -> str:
        """With a look into a table for each call."""
        pieces, end = [], 0
        for found in written_calls(text, self._given):
            pieces += [text[end : found.span[0]], self._look(found)]
            end = found.span[1]
        return "".join([*pieces, text[end:]])

    def _whole(self, body: str) -> str:
        """With all that the looks need."""
        tables = [f"{name} := {table}" for table, name in self._tables.items()]
        return ",\n".join([_FUNCTIONS.replace(_PREFIX, self._prefix), *tables]) + f"\nreturn ({body})"

    def _look(self, found: WrittenCall) -> str:
        call = found.call
        if call.function == RUNS:
            least, gap = self._motions.lengths(call.arguments[1:])
            seconds = self._motions.bodies.seconds
            bounds = [f"number('{_written(each)}')" for each in ([least], most_between(gap, seconds), seconds)]
            return f"{self._prefix}runs(({self._rewritten(found.arguments[0])}), {', '.join(bounds)})"
        if call.function == WINDOW:
            first, last = self._motions.reach(call, self._context.nodes)
            first, last = (np.asarray(end) + self._starts for end in (first, last))
            ends = {"first": self._column(call, first), "last": self._column(Call("last", (call,)), last)}
            return f"{self._prefix}window({self._table(ends)}, .)"
        if call.function in OF_NUMBERS and any(isinstance(part, Written) for part in walk(call)):
            raise _of_rates()
        return self._number(found)

    def _number(self, found: WrittenCall) -> str:
        """Of a function that has a value in each frame."""
        call = found.call
        # The argument of a rate is evaluated for frames: it is the same in every context.
        named = () if call.function in OF_NUMBERS else call.arguments
        places = [number for number, one in enumerate(named) if not is_of_variables(one)]
        columns = {}
        for names in self._keys(call, places):
            arguments = list(call.arguments)
            for place, name in zip(places, names, strict=True):
                arguments[place] = Literal(name)
            columns[",".join(quote(name, safe="") for name in names)] = self._column(
                Call(call.function, tuple(arguments))
            )
        self._calls.append(call)
        look = f"{self._prefix}value({len(self._calls) - 1}, {self._table(columns)}, "
        look += f"({', '.join(self._name(found, place) for place in places)}), .)"
        return f"({look} = 1)" if type_of(call) == "boolean" else look

    def _keys(self, call: Call, places: Sequence[int]) -> Iterable[tuple[str, ...]]:
        """Yield the names in the arguments at some positions: the known ones, or all possible ones."""
        met = self._met.get(call, {})
        chosen = [
            self._joints(call, place) if _is_joint(call, place) else list(dict.fromkeys(names[number] for names in met))
            for number, place in enumerate(places)
        ]
        if not places:
            return [()]
        few = prod(map(len, chosen)) <= FEW
        return product(*chosen) if few or len(met) > ONE_BY_ONE else met

    def _joints(self, call: Call, place: int) -> list[str]:
        """Return the joints of the documents, and an empty name for all others."""
        names = dict.fromkeys(chain.from_iterable(self._motions.bodies.facts().names))
        if MOTION_FUNCTIONS[call.function].parameters[place] != JOINT_OR_SIDE:
            return ["", *names]
        people = dict.fromkeys(["", *(name[: name.rfind(":") + 1] for name in names)])
        return ["", *(person + side for person in people for side in FEET), *names]

    def _name(self, found: WrittenCall, place: int) -> str:
        said = f"({self._rewritten(found.arguments[place])})"
        if not _is_joint(found.call, place):
            return f"{self._prefix}name({said})"
        names = ", ".join(unparse(Literal(name)) for name in self._joints(found.call, place) if name)
        return f"{self._prefix}joint({said}, {self._named(f'{_MAPS}merge(({names}) ! {_MAPS}entry(., true()))')})"

    def _table(self, columns: dict[str, str]) -> str:
        entries = (
            f"{_MAPS}entry({unparse(Literal(key))}, {self._prefix}column({name}))" for key, name in columns.items()
        )
        return self._named(f"{_MAPS}merge(({', '.join(entries)}))")

    def _named(self, table: str) -> str:
        """The variable of a table."""
        return self._tables.setdefault(table, f"{self._prefix}t{len(self._tables)}")

    def _column(self, call: Call, numbers: Numbers | None = None) -> str:
        """The variable of the numbers in all frames, and in heads. numbers: if they are no values of the call."""
        if call not in self._columns:
            self._left -= len(self._context)
            if self._left < 0:
                raise LimitError(
                    "The query needs more numbers of the frames of its documents than the limit allows.",
                    remedy="Name fewer joints, ask smaller documents, or raise MCML_QUERY_ELEMENTS.",
                    code="query-too-large",
                )
            if numbers is None:
                numbers = self._values(call)
            name = f"{self._prefix}n{len(self._columns)}"
            self._numbers[name.removeprefix("$")] = _written(np.asarray(numbers, np.float64).tolist())
            self._columns[call] = name
        return self._columns[call]

    def _values(self, call: Call) -> Numbers:
        try:
            return np.asarray(self._motions.value(call, self._context))
        except (NotOnColumnsError, TooWideError):
            raise _of_rates() from None


def _is_joint(call: Call, place: int) -> bool:
    parameter = MOTION_FUNCTIONS[call.function].parameters[place].rstrip("?")
    return parameter in JOINTS and not (call.function == ANGLE and len(call.arguments) == 1)


def _written(numbers: Iterable[float]) -> str:
    return " ".join(map(repr, map(float, numbers))).replace("nan", "NaN").replace("inf", "INF")


def _of_rates() -> QueryError:
    return QueryError(
        "mo:rate also reads neighbouring frames, where loop variables and functions on document trees are unknown.",
        remedy="Pass mo:rate an expression of a single frame, such as mo:rate(mo:height('Root')).",
    )
