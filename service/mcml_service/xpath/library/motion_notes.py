"""Warnings of answers about bodies: documents that were left out, and guesses that the answer depends on."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np

from mcml.errors import McmlError, QueryError
from mcml.motion.bodies.limb_angles import anatomy_of, clinical_name
from mcml.motion.bodies.quantities import QUANTITIES, is_foot, joints_of
from mcml.motion.bodies.stretch import known
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.language.motion_functions import ACTIVITY, CONTACT, MOTION_FUNCTIONS, PREFIX, TOP
from mcml_service.xpath.language.reach import HeadPart
from mcml_service.xpath.language.tree import Call, Expression, Literal, walk
from mcml_service.xpath.library.bodies import Bodies
from mcml_service.xpath.library.body_facts import BONES, BodyFacts
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.nodes.numbering import Bools

OF_LENGTHS = frozenset({"m", "m/s", "m/s2"})
WITH_FLOOR = frozenset({"mo:height", CONTACT})
WITH_UP = WITH_FLOOR | {ACTIVITY, "mo:tilt", "mo:heading", "mo:pose-distance", "mo:motion-distance"}
OF_UPRIGHT = frozenset({"trunk", "pelvis"})
"""Parts whose angles are those to the vertical."""
OF_BODY = frozenset({"up", "front", "left"})
"""Axes and sides of a body."""
OF_TIMES = frozenset({"s", "m/s", "m/s2", "per s"})
WITH_TIMES = frozenset({CONTACT, ACTIVITY})
"""Functions that need times, in addition to those with a unit of time."""


def motion_calls(tree: Expression) -> list[Call]:
    """The calls of functions of bodies in motion."""
    return [part for part in walk(tree) if isinstance(part, Call) and part.function in MOTION_FUNCTIONS]


@dataclass(frozen=True, eq=False)
class GroupFacts:
    """Facts of the documents of a group. unstated: for calls of measurements and of contacts of a walker's feet, the
    documents without any value of them."""

    body: BodyFacts
    unstated: Mapping[Call, Bools]

    def __len__(self) -> int:
        return len(self.body)


class BodyScope:
    """The documents that a query about bodies looks at.

    calls: the calls of motion functions in the query. needed: the calls in conditions, which decide on the items of the
    answer; the other calls only show values.
    """

    def __init__(
        self,
        tx: Transaction,
        caches: Caches,
        calls: Sequence[Call],
        needed: Sequence[Call],
        check: Callable[[], None],
    ) -> None:
        self.calls = calls
        self._needed = needed
        self._tx = tx
        self._caches = caches
        self._check = check
        self._facts: dict[Group, GroupFacts] = {}

    def select(self, groups: Iterable[Group]) -> Iterator[Group]:
        """Yield the groups without documents in which a needed measurement is unknown."""
        for group in groups:
            found = self._select(group) if self.calls else group
            if found:
                yield found

    def notes(self) -> list[str]:
        """Return the warnings."""
        return list(_notes(self._facts, self.calls, self._needed)) if self.calls else []

    @property
    def documents(self) -> int:
        """The number of documents looked at."""
        return sum(map(len, self._facts.values()))

    def _select(self, group: Group) -> Group:
        facts = self._facts.get(group)
        bodies = self._bodies(group)
        stated = {call: texts for call in self.calls if (texts := _measurement(call))}
        if facts is None:
            unstated = {call: bodies.find_documents_without(*texts) for call, texts in stated.items()}
            facts = self._facts[group] = GroupFacts(bodies.facts(), unstated)
        lacks = _left_out(facts, self._needed)
        if not lacks.any():
            return group
        others = self._caches.listing.group([listed for listed, out in zip(group, lacks, strict=True) if not out])
        for texts in stated.values():
            self._bodies(others).take(bodies, ~lacks, *texts)
        return others

    def _bodies(self, group: Group) -> Bodies:
        return Bodies(Forest(self._tx, group, self._caches, head_part=HeadPart.MOTION), self._check)


def refuse_top(calls: Sequence[Call]) -> None:
    """Refuse functions of the whole scope in a query that is evaluated document by document."""
    if any(call.function == TOP for call in calls):
        raise QueryError(
            "mo:top is evaluated over the whole scope. It cannot be in a predicate or a union, beside functions on "
            "document trees, or with per=document.",
            remedy="Write it around the whole, or before a path: mo:top(3, //frame[…])/frame_bone.",
        )


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
            for listed, guessed in zip(
                group, (facts.rests_on_guesses(needed) | _in_doubt(facts, calls)).tolist(), strict=True
            )
            if not guessed
        ]
    return found


def _notes(looked: Mapping[Group, GroupFacts], calls: Sequence[Call], needed: Sequence[Call]) -> Iterator[str]:
    names = [listed.name for group in looked for listed in group]
    many = f"of {len(names):,} documents"
    shown = [call for call in calls if call not in needed]
    for some, what in ((needed, "left out"), (shown, "have no value")):
        masks: dict[tuple[str, str], list[Bools]] = {}
        for facts in looked.values():
            for why, remedy, lacks in _reasons(facts, some):
                masks.setdefault((why, remedy), []).append(lacks)
        for (why, remedy), parts in masks.items():
            mask = np.concatenate(parts)
            if count := int(mask.sum()):
                yield f"{count:,} {many} {what}: {why} ({named(names, mask)}){remedy}."
    guesses = rested_on(calls)
    asked = [(facts.body, ~_left_out(facts, needed)) for facts in looked.values()]
    if count := sum(int((body.rests_on_guesses(guesses) & kept).sum()) for body, kept in asked):
        yield f"{count:,} {many} rest on a guessed {_listed(guesses)}; guesses=no leaves them out."
    if count := sum(int((_in_doubt(body, calls) & kept).sum()) for body, kept in asked):
        yield f"{count:,} {many} rest on guessed names of joints; guesses=no leaves them out."
    yield from _notes_of_angles([facts.body for facts in looked.values()], calls, names, many)


def _notes_of_angles(
    looked: Sequence[BodyFacts], calls: Sequence[Call], names: Sequence[str], many: str
) -> Iterator[str]:
    """Yield warnings of angles as with a goniometer, and of clinical angles whose sign or zero is unknown."""
    for call in dict.fromkeys(calls):
        angle = _angle_of(call)
        person, colon, bare = angle.rpartition(":")
        if (clinical := clinical_name(bare)) is not None:
            of_person = person + colon + clinical
            yield f"{angle} is measured as with a goniometer; {of_person} is the clinical angle of the same movement."
        anatomy = anatomy_of(bare)
        # Of several people, only one may lack it.
        have = "may have" if person else "have"
        if not anatomy or not looked:
            continue
        mask = np.concatenate([facts.lacks_anatomy(anatomy) & ~_lacking(facts, call) for facts in looked])
        if count := int(mask.sum()):
            if angle.endswith(("-knee-flexion", "-knee-extension")):
                what = f"{have} {angle} without its sign, because no rotation or marker tells where the thigh's left is"
            elif set(anatomy) <= set(BONES):
                what = f"{have} no value: no rotation or marker tells where the left of {' and '.join(anatomy)} is"
            else:
                what = f"{have} {angle} in the frame of their joints, because no rest pose shows how they stand"
            yield f"{count:,} {many} {what} ({named(names, mask)})."


def _angle_of(call: Call) -> str:
    """The name of the angle that a call asks for in writing, "" for other calls."""
    name = call.function.removeprefix(PREFIX)
    texts = [each.value for each in call.arguments if isinstance(each, Literal) and isinstance(each.value, str)]
    return texts[0] if name == "angle" and len(texts) == len(call.arguments) == 1 else ""


def _left_out(facts: GroupFacts, calls: Sequence[Call]) -> Bools:
    """Tell which documents are left out, because a value of a call is unknown."""
    found = np.zeros(len(facts), bool)
    for _, _, lacks in _reasons(facts, calls):
        found |= lacks
    return found


def _reasons(known: GroupFacts, calls: Sequence[Call]) -> Iterator[tuple[str, str, Bools]]:
    """Return the reasons for unknown values, the remedies, and the documents."""
    facts = known.body
    functions = {call.function for call in calls}
    units = {MOTION_FUNCTIONS[function].unit for function in functions}
    if units & OF_LENGTHS:
        yield "their unit is not known", "; set it in their header", ~facts.unit
    if units & OF_TIMES or functions & WITH_TIMES:
        yield "their frame time is not known", "", ~facts.times
    if any(call.function in WITH_FLOOR and not _is_of_gait(call) for call in calls):
        yield "their floor is not known", "; mcml calibrate sets it", ~facts.floor
    for call in dict.fromkeys(calls):
        yield f"they lack joints of {_written(call)}", "", _lacking(facts, call)
        if call in known.unstated:
            why, remedy = f"their files have no values of {_written(call)}", "measurements lists what a file has"
            if _is_of_gait(call):
                why, remedy = f"no step tells {_written(call)}", "gait says why"
            yield why, f"; GET /documents/{{id}}/{remedy}", known.unstated[call]


NAMED = 3
"""Limit of names in a warning about excluded documents."""


def named(names: Sequence[str], mask: Bools) -> str:
    """Return the names of the first documents of a mask, and the number of others."""
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
        names = {text.rpartition(":")[2] for text in texts}
        of_body = any(name.split("-")[0] in OF_UPRIGHT for name in names) or not names.isdisjoint(OF_BODY)
        if call.function in WITH_UP or of_body:
            found.add("up")
        if call.function in WITH_FLOOR:
            found.add("floor")
    return frozenset(found)


def _listed(names: Collection[str]) -> str:
    words = [word for name, word in (("metres", "unit"), ("up", "up axis"), ("floor", "floor")) if name in names]
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def _in_doubt(facts: BodyFacts, calls: Sequence[Call]) -> Bools:
    """Tell which documents have guessed names among the joints of calls."""
    doubts = np.zeros(len(facts), bool)
    for call in dict.fromkeys(calls):
        name = call.function.removeprefix(PREFIX)
        texts = [each.value for each in call.arguments if isinstance(each, Literal) and isinstance(each.value, str)]
        with suppress(McmlError):
            if name in QUANTITIES and len(texts) == len(call.arguments):
                doubts |= facts.in_doubt(partial(joints_of, name, texts))
            else:
                doubts |= facts.in_doubt(lambda names: names)
    return doubts


def _lacking(facts: BodyFacts, call: Call) -> Bools:
    """Which documents have not all joints that a quantity is made from."""
    name = call.function.removeprefix(PREFIX)
    texts = [each.value for each in call.arguments if isinstance(each, Literal) and isinstance(each.value, str)]
    if name not in QUANTITIES or len(texts) < len(call.arguments):
        return np.zeros(len(facts), bool)
    try:
        needs = QUANTITIES[name].joints(texts)
        lacks = [any(known(each, names) is None for each in needs) for names in facts.names]
    except McmlError:
        return np.zeros(len(facts), bool)
    return np.asarray(np.array(lacks, bool)[facts.kind], bool)


def _measurement(call: Call) -> tuple[str, tuple[str, ...]] | None:
    """(function, arguments) of a call with written arguments of a measurement of the file, or of gait, otherwise
    None."""
    name = call.function.removeprefix(PREFIX)
    texts = tuple(each.value for each in call.arguments if isinstance(each, Literal) and isinstance(each.value, str))
    if name not in QUANTITIES or len(texts) < len(call.arguments):
        return None
    return (name, texts) if QUANTITIES[name].of_file or _is_of_gait(call) else None


def _is_of_gait(call: Call) -> bool:
    """Whether it asks for a foot of a walker, not for a joint."""
    texts = [each.value for each in call.arguments if isinstance(each, Literal) and isinstance(each.value, str)]
    return call.function == CONTACT and any(map(is_foot, texts))


def _written(call: Call) -> str:
    texts = ", ".join(f"'{each.value}'" for each in call.arguments if isinstance(each, Literal))
    return f"{call.function}({texts})"
