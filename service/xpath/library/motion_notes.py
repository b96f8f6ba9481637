"""What an answer about bodies in motion rests on, and what it had to leave out: warnings for who asks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from service.errors import LimitError, McmlError, QueryError
from service.motion.bodies.quantities import QUANTITIES, joints_of
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.language.motion_functions import MOTION_FUNCTIONS, PREFIX, TOP
from service.xpath.language.reach import HeadPart
from service.xpath.language.tree import Call, Expression, Literal, walk
from service.xpath.library.bodies import Bodies, Facts, known_of
from service.xpath.library.caches import Caches
from service.xpath.library.forest import Forest
from service.xpath.library.groups import Group
from service.xpath.library.listing import Scope

OF_LENGTHS = frozenset({"m", "m/s", "m/s2"})
OF_TIMES = frozenset({"s", "m/s", "m/s2", "per s"})


def motion_calls(tree: Expression) -> list[Call]:
    """The calls of functions of bodies in motion."""
    return [part for part in walk(tree) if isinstance(part, Call) and part.function in MOTION_FUNCTIONS]


def notes(caches: Caches, scope: Scope, calls: Sequence[Call]) -> list[str]:
    """Of the documents that were looked at: how many have no unit, no times or not the joints, and how many rest on
    guesses."""
    return list(_notes(looked_at(caches, scope), calls)) if calls else []


def refused(calls: Sequence[Call]) -> McmlError:
    """Why a question with such calls has no answer, where columns have none: bodies are not in the XML."""
    if any(call.function == TOP for call in calls):
        return QueryError(
            "mo:top is of the whole scope: it stands in no predicate or union, and not with per=document.",
            remedy="Write it around the whole, or before a path: mo:top(3, //frame[…])/frame_bone.",
        )
    return LimitError(
        "This question about bodies reaches too much at once, or asks for what columns have no answer to.",
        remedy="Ask fewer documents, or put what is asked of a frame into a predicate of //frame.",
        code="query-too-large",
    )


def looked_at(caches: Caches, scope: Scope) -> list[Facts]:
    """What is known of the documents whose bodies were looked at."""
    return [one for group in scope.groups() for one in caches.samples.find(known_of(group)) or ()]


def without_guesses(
    tx: Transaction, caches: Caches, groups: Sequence[Group], check: Callable[[], None]
) -> list[Listed]:
    """The documents whose unit, up axis and floor are no guesses."""
    found: list[Listed] = []
    for group in groups:
        facts = Bodies(Forest(tx, group, caches, head_part=HeadPart.MOTION), check).facts()
        found += [listed for listed, one in zip(group, facts, strict=True) if not one.guessed]
    return found


def _notes(facts: Sequence[Facts], calls: Sequence[Call]) -> Iterator[str]:
    units = {MOTION_FUNCTIONS[call.function].unit for call in calls}
    many = f"of {len(facts):,} documents"
    if units & OF_LENGTHS and (count := sum(not one.unit for one in facts)):
        yield f"{count:,} {many} left out: their unit is not known; set it in their calibration."
    if units & OF_TIMES and (count := sum(not one.times for one in facts)):
        yield f"{count:,} {many} left out: their frame time is not known."
    for call in dict.fromkeys(calls):
        if count := sum(_lacks(one, call) for one in facts):
            yield f"{count:,} {many} left out: they have not the joints of {_written(call)}."
    if count := sum(one.guessed for one in facts):
        yield f"{count:,} {many} rest on a guessed unit, up axis or floor; guesses=no leaves them out."


def _lacks(facts: Facts, call: Call) -> bool:
    """Whether a body has not all joints that a quantity is made from."""
    name = call.function.removeprefix(PREFIX)
    texts = [each.value for each in call.arguments if isinstance(each, Literal) and isinstance(each.value, str)]
    if name not in QUANTITIES or len(texts) < len(call.arguments):
        return False
    try:
        asked = QUANTITIES[name].joints(texts)
        return len(joints_of(name, texts, facts.names)) < len(dict.fromkeys(asked))
    except McmlError:
        return False


def _written(call: Call) -> str:
    texts = ", ".join(f"'{each.value}'" for each in call.arguments if isinstance(each, Literal))
    return f"{call.function}({texts})"
