"""Names of motions: the movements that a part of the body can perform (the paper, 4.4).

A name that reads as `[side-]part-movement` must be possible: nobody abducts a shoulder. Every other name (walk,
bar-3, hand-shake) is free. `motion_names.csv` holds the parts, their movements, and the synonyms of both; movements
without a part are included so that they are recognised and refused.
"""

from __future__ import annotations

import csv
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from mcml.errors import VocabularyError
from mcml.language.lexical import ILLEGAL, WHITE_SPACE
from mcml.resources import motion_names_path

SIDES = ("left", "right", "both")
MAX_BYTES = 1024
"""Of a motion name in UTF-8."""


@dataclass(frozen=True, slots=True)
class BodyPart:
    """A part of the body.

    sided: whether its names need left, right or both; if not, they must not have one. joints: of Table 1, `*` for
    the side. movements: its possible movements. instead: movements of this part that are stored under another (part,
    movement). near: parts to search for a suggested name.
    """

    name: str
    sided: bool
    joints: tuple[str, ...]
    movements: tuple[str, ...]
    instead: Mapping[str, tuple[str, str]]
    near: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Movement:
    """A kind of movement. near: movements that were perhaps meant where a part cannot perform this one."""

    name: str
    near: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class MotionName:
    """A motion name that reads as `[side-]part-movement`, synonyms resolved. side: "" without one."""

    side: str
    part: str
    movement: str

    def __str__(self) -> str:
        return "-".join(word for word in (self.side, self.part, self.movement) if word)

    def joints(self) -> tuple[str, ...]:
        """The MCML joints that perform it."""
        sides = ("left", "right") if self.side == "both" else (self.side,)
        return tuple(joint.replace("*", side) for side in sides for joint in parts()[self.part].joints)


def canonical(name: str, *, strict: bool = False) -> str:
    """The form in which the name is stored: synonyms resolved, words joined by hyphens; a free name is unchanged.

    Raises VocabularyError with the nearest possible name if no body can perform it, and, if strict, for every name that
    is not anatomical.

    >>> canonical("left-arm_abduction"), canonical("left-arm-front"), canonical("Bar 3")
    ('left-arm-abduction', 'left-arm-flexion', 'Bar 3')
    """
    # In NFC, as all names are: 걸음 and é are found in any Unicode form.
    name = unicodedata.normalize("NFC", name).strip(WHITE_SPACE)
    if not name:
        raise VocabularyError("a motion name is empty", remedy="Give it a name, or remove the element.")
    if ILLEGAL.search(name):
        raise VocabularyError(f"the motion name {name[:80]!r} holds a control character", remedy="Leave it out.")
    if len(name.encode()) > MAX_BYTES:
        raise VocabularyError(f"a motion name is longer than {MAX_BYTES} bytes", remedy="Give a shorter one.")
    meant = parse(name)
    if meant is not None:
        return str(meant)
    if strict:
        raise VocabularyError(
            f"{name!r} is not an anatomical movement, and only those are allowed here",
            remedy="Use [side-]part-movement, such as left-arm-flexion.",
        )
    return name


def parse(name: str) -> MotionName | None:
    """The name as side, part and movement, None if it is a free name. Raises VocabularyError if it is impossible.

    >>> parse("left-hand-pronation")
    MotionName(side='left', part='forearm', movement='pronation')
    >>> parse("walk") is None
    True
    """
    words = re.sub(r"[-_\s]+", "-", name.strip(WHITE_SPACE)).lower()
    side, _, rest = words.partition("-")
    if side not in SIDES:
        side, rest = "", words
    split = _split(rest)
    if split is None:
        return None
    part, movement = split
    kind = parts()[part]
    target_part, target_movement = kind.instead.get(movement, (part, movement))
    possible = target_movement in parts()[target_part].movements
    if possible and kind.sided == bool(side):
        return MotionName(side, target_part, target_movement)
    near = nearest(side, part, movement)
    if not possible:
        can = ", ".join(kind.movements or dict.fromkeys(kind.instead))
        why = f"{words!r} is not an anatomical movement: {part} allows {can}"
    elif kind.sided:
        why = f"{words!r} does not say which side"
    else:
        why = f"{words!r} gives {part} a side, but there is only one"
    raise VocabularyError(why, remedy=f"Did you mean {near}?", name=name, suggestion=near)


def nearest(side: str, part: str, movement: str) -> str:
    """The possible name nearest to an impossible one: a related movement of the part, else the same one nearby."""
    kind, related = parts()[part], movements()[movement].near
    if side and not kind.sided and f"{side}-{movement}" in kind.movements:
        return str(MotionName("", part, f"{side}-{movement}"))
    for other in (part, *kind.near):
        for wanted in (movement, *related) if other == part else (movement,):
            target = parts()[other].instead.get(wanted, (other, wanted))
            if target[1] in parts()[target[0]].movements:
                return str(_with_side(side, *target))
    for other in kind.near:
        for wanted in related:
            if wanted in parts()[other].movements:
                return str(_with_side(side, other, wanted))
    first = next(iter(kind.instead.values())) if kind.instead and not kind.movements else (part, kind.movements[0])
    return str(_with_side(side, *first))


@cache
def parts() -> dict[str, BodyPart]:
    """Parts of the body by name, in the order of the table."""
    return {
        row["name"]: BodyPart(
            row["name"],
            row["sided"] == "yes",
            _list(row["joints"]),
            _list(row["movements"]),
            dict(_instead(row["name"], entry) for entry in _list(row["instead"])),
            _list(row["near"]),
        )
        for row in _rows("part")
    }


@cache
def movements() -> dict[str, Movement]:
    """Movements by name, in the order of the table."""
    return {row["name"]: Movement(row["name"], _list(row["near"])) for row in _rows("movement")}


def _with_side(side: str, part: str, movement: str) -> MotionName:
    sided = parts()[part].sided
    return MotionName((side or "left") if sided else "", part, movement)


def _split(words: str) -> tuple[str, str] | None:
    """Part and movement of `part-movement`, the longest part first; None if it does not read so."""
    part_words, movement_words = _spellings("part"), _spellings("movement")
    cuts = [index for index, letter in enumerate(words) if letter == "-"]
    for cut in reversed(cuts):
        part, movement = part_words.get(words[:cut]), movement_words.get(words[cut + 1 :])
        if part and movement:
            return part, movement
    return None


@cache
def _spellings(kind: str) -> dict[str, str]:
    """Every spelling of a part or movement -> its name. A sided movement's synonym keeps its side."""
    return {spelling: row["name"] for row in _rows(kind) for spelling in (row["name"], *_list(row["aliases"]))}


@cache
def _rows(kind: str) -> tuple[dict[str, str], ...]:
    with motion_names_path().open(encoding="utf-8", newline="") as stream:
        return tuple(row for row in csv.DictReader(stream) if row["kind"] == kind)


def _instead(part: str, entry: str) -> tuple[str, tuple[str, str]]:
    said, _, stored = entry.partition("=")
    other, _, movement = stored.rpartition(":")
    return said, (other or part, movement)


def _list(text: str) -> tuple[str, ...]:
    return tuple(text.split("|")) if text else ()
