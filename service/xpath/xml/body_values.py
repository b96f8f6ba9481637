"""Functions of bodies in motion for Saxon, which knows none of them and sees XML, in which no bodies are.

A call becomes a look into a table with a number for every frame, which columns work out as for any other question. The
tables are variables of the request, so nothing is added to the document that an expression could see.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from service.errors import LimitError, McmlError, QueryError
from service.motion.bodies.quantities import AXES, QUANTITIES
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.engine.columns import Columns
from service.xpath.engine.context import Context
from service.xpath.engine.functions import NotOnColumnsError
from service.xpath.engine.motions import most_between
from service.xpath.language.calls import WrittenCall, written_calls
from service.xpath.language.motion_functions import ANGLE, JOINTS, MOTION_FUNCTIONS, RATE, RUNS, WINDOW
from service.xpath.language.reach import HeadPart
from service.xpath.language.tree import Call, Literal, Written, walk
from service.xpath.language.types import is_of_variables, type_of
from service.xpath.language.unparse import unparse
from service.xpath.library.caches import Caches
from service.xpath.library.forest import Forest
from service.xpath.library.groups import Group
from service.xpath.limits import Limits
from service.xpath.nodes.numbering import first_of_documents
from service.xpath.nodes.pairs import TooWideError

Values: TypeAlias = Mapping[str, str | float | bool]
Numbers: TypeAlias = NDArray[Any]
_PREFIX = "$mo-"
"""Of variables that are ours."""
_BETWEEN = "\n"
_TEXT = re.compile(r"""'([^']*)'|"([^"]*)\"""")
_MAPS, _ARRAYS = (f"Q{{http://www.w3.org/2005/xpath-functions/{kind}}}" for kind in ("map", "array"))
# A column ends with the number of what is in no frame. In 1.0-compatibility mode, sums are no integers.
_FUNCTIONS = f"""let $mo-frames := array {{ /mcml/motion/frame }},
$mo-places := {_MAPS}merge(
  for $i in 1 to {_ARRAYS}size($mo-frames) return {_MAPS}entry(generate-id($mo-frames($i)), $i)),
$mo-heads := xs:integer({_ARRAYS}size($mo-frames) + 1),
$mo-place := function($node) {{
  if ($node instance of node()) then ($mo-places(generate-id($node/ancestor-or-self::frame)), $mo-heads)[1]
  else error((), 'a function of bodies is asked with a value as context, which is in no frame; bind it with for') }},
$mo-name := function($named) {{
  string(head($named) ! (if (. instance of node()) then @name else .)) }},
$mo-joint := function($named, $joints) {{
  let $name := $mo-name($named) return if ($joints($name)) then $name else '' }},
$mo-column := function($numbers) {{ array {{ tokenize($numbers, ' ') ! number(.) }} }},
$mo-value := function($columns, $key, $node) {{
  let $column := $columns($key)
  return if (exists($column)) then $column($mo-place($node))
  else error((), concat('an angle, or an axis, is named in the question itself, and not made there: ', $key)) }},
$mo-window := function($columns, $node) {{
  let $first := $mo-value($columns, 'first', $node), $last := $mo-value($columns, 'last', $node)
  return (xs:integer($first) to xs:integer($last)) ! $mo-frames(.) }},
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
    """Of the documents of some groups. limits: of the question; its elements are the most numbers of a document."""

    def __init__(self, tx: Transaction, caches: Caches, groups: Sequence[Group], limits: Limits) -> None:
        self._columns = [
            Columns(Forest(tx, group, caches, head_part=HeadPart.ALL), limits.check, is_later=True) for group in groups
        ]
        self._places = {
            listed.key: (number, place) for number, group in enumerate(groups) for place, listed in enumerate(group)
        }
        self._most = limits.max_elements

    def given(self, text: str, variables: Values, stored: Listed) -> tuple[str, Values]:
        """What Saxon is asked of a document in place of an expression, and with which variables.

        Raises QueryError for what only columns can answer, LimitError for too many numbers.
        """
        number, place = self._places[stored.key]
        asked = _Asked(self._columns[number], place, text, variables, self._most)
        body = asked.rewritten(text)
        return (text, variables) if body == text else (asked.around(body), {**variables, **asked.numbers})


class _Asked:
    """An expression, asked of one document. numbers: the columns that it needs, as texts."""

    def __init__(self, columns: Columns, place: int, text: str, variables: Values, most: int) -> None:
        self._motions = columns.motions
        document = np.array([place], np.int64)
        frames = columns.forest.all_frames(document)[1]
        self._context = Context(np.concatenate([frames, first_of_documents(document)]))
        self._place = place
        self._variables = variables
        self._texts = [one or other for one, other in _TEXT.findall(text)] + list(map(str, variables.values()))
        self._left = most
        self._prefix = _PREFIX
        while self._prefix in text:
            self._prefix += "-"
        self._tables: dict[str, str] = {}
        self._columns: dict[Call, str] = {}
        self.numbers: dict[str, str] = {}

    def rewritten(self, text: str) -> str:
        """The expression with a look into a table for each call."""
        pieces, end = [], 0
        for found in written_calls(text, self._variables):
            pieces += [text[end : found.span[0]], self._look(found)]
            end = found.span[1]
        return "".join([*pieces, text[end:]])

    def around(self, body: str) -> str:
        """A rewritten expression with all that it needs."""
        tables = [f"{name} := {table}" for table, name in self._tables.items()]
        return ",\n".join([_FUNCTIONS.replace(_PREFIX, self._prefix), *tables]) + f"\nreturn ({body})"

    def _look(self, found: WrittenCall) -> str:
        call = found.call
        if call.function == RUNS:
            least, gap = self._motions.lengths(call.arguments[1:])
            seconds = self._motions.bodies.seconds[[self._place]]
            bounds = [f"number('{_written(each)}')" for each in ([least], most_between(gap, seconds), seconds)]
            return f"{self._prefix}runs(({self.rewritten(found.arguments[0])}), {', '.join(bounds)})"
        if call.function == WINDOW:
            first, last = self._motions.reach(call, self._context.nodes)
            ends = {"first": self._column(call, first), "last": self._column(Call("last", (call,)), last)}
            return f"{self._prefix}window({self._table(ends)}, .)"
        return self._number(found)

    def _number(self, found: WrittenCall) -> str:
        """Of a function that has a value in each frame. What an argument names may be another joint wherever it stands:
        then there is a column for each that it can be."""
        call = found.call
        if call.function == RATE:
            if any(isinstance(part, Written) for part in walk(call)):
                raise _of_rates()
            chosen: list[list[str | None]] = [[None]]
        else:
            chosen = [self._choices(call, place) for place in range(len(call.arguments))]
        columns = {}
        for texts in product(*chosen):
            given = [old if new is None else Literal(new) for old, new in zip(call.arguments, texts, strict=True)]
            key = _BETWEEN.join(text for text in texts if text is not None)
            columns[key] = self._column(Call(call.function, tuple(given)))
        keys = [self._key(found, place, choices) for place, choices in enumerate(chosen) if choices != [None]]
        key = f"string-join(({', '.join(keys)}), '{_BETWEEN}')" if keys else "''"
        look = f"{self._prefix}value({self._table(columns)}, {key}, .)"
        return f"({look} = 1)" if type_of(call) == "boolean" else look

    def _choices(self, call: Call, place: int) -> list[str | None]:
        """What an argument can name; [None] if it is the same wherever it stands."""
        if is_of_variables(call.arguments[place]):
            return [None]
        if _is_joint(call, place):
            facts = self._motions.bodies.facts()
            # No name is that of no joint, which any other text is too.
            return ["", *facts.names[facts.kind[self._place]]]
        return [*AXES] if call.function != ANGLE else [text for text in dict.fromkeys(self._texts) if is_angle(text)]

    def _key(self, found: WrittenCall, place: int, choices: list[str | None]) -> str:
        said = f"({self.rewritten(found.arguments[place])})"
        if not _is_joint(found.call, place):
            return f"{self._prefix}name({said})"
        names = ", ".join(unparse(Literal(name)) for name in choices if name)
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
                    "The question can ask for more numbers of a document than XPath 2.0 may be given.",
                    remedy="Name the joints as texts, ask smaller documents, or raise MCML_QUERY_ELEMENTS.",
                    code="query-too-large",
                )
            if numbers is None:
                numbers = self._values(call)
            name = f"{self._prefix}n{len(self._columns)}"
            self.numbers[name.removeprefix("$")] = _written(np.asarray(numbers, np.float64).tolist())
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


def is_angle(text: str) -> bool:
    """Whether it is the name of an angle."""
    try:
        QUANTITIES["angle"].joints([text])
    except McmlError:
        return False
    return True


def _written(numbers: Iterable[float]) -> str:
    return " ".join(map(repr, map(float, numbers))).replace("nan", "NaN").replace("inf", "INF")


def _of_rates() -> QueryError:
    return QueryError(
        "mo:rate looks at the frames around one, in which variables of loops, and what only Saxon evaluates, are not "
        "known.",
        remedy="Ask in mo:rate for what a frame alone tells, such as mo:rate(mo:height('Root')).",
    )
