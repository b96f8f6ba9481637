"""What an answer about bodies in motion rests on, and what it had to leave out: warnings for who asks."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence

import numpy as np

from service.errors import LimitError, McmlError, QueryError
from service.motion.bodies.quantities import QUANTITIES, joints_of
from service.storage.columns import Listed
from service.storage.transaction import Transaction
from service.xpath.language.motion_functions import MOTION_FUNCTIONS, PREFIX, TOP
from service.xpath.language.reach import HeadPart
from service.xpath.language.tree import Call, Expression, Literal, walk
from service.xpath.library.bodies import Bodies
from service.xpath.library.body_facts import BodyFacts
from service.xpath.library.caches import Caches
from service.xpath.library.forest import Forest
from service.xpath.library.groups import Group
from service.xpath.library.listing import Scope
from service.xpath.nodes.numbering import Bools

OF_LENGTHS = frozenset({"m", "m/s", "m/s2"})
WITH_FLOOR = frozenset({"mo:height", "mo:contact"})
WITH_UP = WITH_FLOOR | {"mo:tilt", "mo:heading", "mo:pose-distance", "mo:motion-distance"}
OF_UPRIGHT = frozenset({"trunk", "pelvis"})
"""Parts whose angles are those to the vertical."""
OF_TIMES = frozenset({"s", "m/s", "m/s2", "per s"})


def motion_calls(tree: Expression) -> list[Call]:
    """The calls of functions of bodies in motion."""
    return [part for part in walk(tree) if isinstance(part, Call) and part.function in MOTION_FUNCTIONS]


def notes(tx: Transaction, caches: Caches, scope: Scope, calls: Sequence[Call]) -> list[str]:
    """Of the documents that were looked at: how many have no unit, no times or not the joints, and how many rest on
    guesses."""
    if not calls:
        return []
    pairs = [(group, facts) for group in scope.groups() if (facts := _facts(tx, caches, group)) is not None]
    return list(_notes([facts for _, facts in pairs], calls, [listed.name for group, _ in pairs for listed in group]))


def require_saxon(calls: Sequence[Call], *, is_later: bool) -> None:
    """Refuses calls in a question to which columns have no answer, and Saxon has none either. is_later: whether it is
    asked at all, in XPath 2.0; libxml2 knows no bodies."""
    if any(call.function == TOP for call in calls):
        raise QueryError(
            "mo:top is of the whole scope: it stands in no predicate or union, not with per=document, and not with what"
            " only Saxon evaluates, document by document.",
            remedy="Write it around the whole, or before a path: mo:top(3, //frame[…])/frame_bone.",
        )
    if calls and not is_later:
        raise LimitError(
            "This question about bodies reaches too much at once.",
            remedy="Ask fewer documents, or put what is asked of a frame into a predicate of //frame.",
            code="query-too-large",
        )


def looked_at(tx: Transaction, caches: Caches, scope: Scope) -> list[BodyFacts]:
    """What is known of the documents whose bodies were looked at."""
    return [found for group in scope.groups() if (found := _facts(tx, caches, group)) is not None]


def _facts(tx: Transaction, caches: Caches, group: Group) -> BodyFacts | None:
    return Forest(tx, group, caches, head_part=HeadPart.MOTION).body_facts(None)


def without_guesses(
    tx: Transaction, caches: Caches, groups: Sequence[Group], calls: Sequence[Call], check: Callable[[], None]
) -> list[Listed]:
    """The documents of which nothing that the answer depends on is a guess."""
    found: list[Listed] = []
    needed = rested_on(calls)
    for group in groups:
        facts = Bodies(Forest(tx, group, caches, head_part=HeadPart.MOTION), check).facts()
        found += [
            listed
            for listed, guessed in zip(group, facts.rests_on_guesses(needed).tolist(), strict=True)
            if not guessed
        ]
    return found


def _notes(parts: Sequence[BodyFacts], calls: Sequence[Call], names: Sequence[str]) -> Iterator[str]:
    """names: of the documents of all parts."""
    units = {MOTION_FUNCTIONS[call.function].unit for call in calls}
    many = f"of {sum(map(len, parts)):,} documents"

    def told(masks: Iterable[Bools], why: str, remedy: str = "") -> Iterator[str]:
        mask = np.concatenate([np.empty(0, bool), *masks])
        if count := int(mask.sum()):
            yield f"{count:,} {many} left out: {why} ({named(names, mask)}){remedy}."

    if units & OF_LENGTHS:
        yield from told((~part.unit for part in parts), "their unit is not known", "; set it in their header")
    if units & OF_TIMES:
        yield from told((~part.times for part in parts), "their frame time is not known")
    for call in dict.fromkeys(calls):
        yield from told((_lacking(part, call) for part in parts), f"they lack joints of {_written(call)}")
    needed = rested_on(calls)
    if count := sum(int(part.rests_on_guesses(needed).sum()) for part in parts):
        yield f"{count:,} {many} rest on a guessed {_listed(needed)}; guesses=no leaves them out."


NAMED = 3
"""Documents that are named at most where some are left out."""


def named(names: Sequence[str], mask: Bools) -> str:
    """The names of the first documents of a mask, and how many others there are."""
    chosen = np.flatnonzero(mask).tolist()
    more = f" and {len(chosen) - NAMED:,} more" if len(chosen) > NAMED else ""
    return ", ".join(repr(names[place]) for place in chosen[:NAMED]) + more


def rested_on(calls: Sequence[Call]) -> frozenset[str]:
    """The values of calibrations (`body_facts.GUESSES`) that the answer depends on."""
    found: set[str] = set()
    for call in calls:
        if MOTION_FUNCTIONS[call.function].unit in OF_LENGTHS:
            found.add("metres")
        texts = [each.value for each in call.arguments if isinstance(each, Literal) and isinstance(each.value, str)]
        of_body = any(text.split("-")[0] in OF_UPRIGHT or text in ("up", "front", "left") for text in texts)
        if call.function in WITH_UP or of_body:
            found.add("up")
        if call.function in WITH_FLOOR:
            found.add("floor")
    return frozenset(found)


def _listed(names: Collection[str]) -> str:
    words = [word for name, word in (("metres", "unit"), ("up", "up axis"), ("floor", "floor")) if name in names]
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def _lacking(facts: BodyFacts, call: Call) -> Bools:
    """Which documents have not all joints that a quantity is made from."""
    name = call.function.removeprefix(PREFIX)
    texts = [each.value for each in call.arguments if isinstance(each, Literal) and isinstance(each.value, str)]
    if name not in QUANTITIES or len(texts) < len(call.arguments):
        return np.zeros(len(facts), bool)
    try:
        asked = len(dict.fromkeys(QUANTITIES[name].joints(texts)))
        lacks = [len(joints_of(name, texts, names)) < asked for names in facts.names]
    except McmlError:
        return np.zeros(len(facts), bool)
    return np.asarray(np.array(lacks, bool)[facts.kind], bool)


def _written(call: Call) -> str:
    texts = ", ".join(f"'{each.value}'" for each in call.arguments if isinstance(each, Literal))
    return f"{call.function}({texts})"
