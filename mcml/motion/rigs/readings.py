"""The meaning of a joint's words: its side, its possible slots in a limb or in the trunk, and the confidence.

A word such as shoulder, hip or leg means different joints in different rigs. It gives a value to each slot that it may
mean; the chain of the joint decides which of them it gets (`limbs`).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from mcml.motion.rigs.vocabulary import APPENDAGES, HELPERS
from mcml.motion.rigs.words import SIDES, Words

ARM = ("shoulder", "up_arm", "low_arm", "wrist", "hand")
LEG = ("hip", "up_leg", "low_leg", "foot", "toes")
LIMBS = {"arm": ARM, "leg": LEG}
CORE = {"arm": ("up_arm", "low_arm", "hand"), "leg": ("up_leg", "low_leg", "foot")}
FINGERS = ("thumb", "index", "middle", "ring", "pinky")

_SLOTS: dict[str, tuple[str, dict[str, float]]] = {
    "clavicle": ("arm", {"shoulder": 1.0}),
    "shoulder": ("arm", {"up_arm": 0.6, "shoulder": 0.5}),
    "upper_arm": ("arm", {"up_arm": 1.0}),
    "arm": ("arm", {"up_arm": 0.8, "low_arm": 0.35, "hand": 0.1}),
    "forearm": ("arm", {"low_arm": 1.0}),
    "wrist": ("arm", {"hand": 0.9, "wrist": 0.5}),
    "hand": ("arm", {"hand": 1.0}),
    "palm": ("arm", {"hand": 0.35}),
    "hip": ("leg", {"up_leg": 0.7, "hip": 0.45}),
    "pelvis": ("leg", {"hip": 0.8, "up_leg": 0.4}),
    "hip_connector": ("leg", {"hip": 1.0, "up_leg": 0.1}),
    "thigh": ("leg", {"up_leg": 1.0}),
    "leg": ("leg", {"low_leg": 0.55, "up_leg": 0.5, "foot": 0.1, "toes": 0.05}),
    "shin": ("leg", {"low_leg": 1.0}),
    "ankle": ("leg", {"foot": 1.0}),
    "foot": ("leg", {"foot": 0.8, "toes": 0.6}),
    "toe": ("leg", {"toes": 1.0}),
    "metatarsal": ("leg", {"toes": 0.5}),
}
"""Of each part its limb, and how much its word speaks for a slot."""

_TRUNK = ("head", "neck", "chest", "spine", "waist", "pelvis", "root", "nose")
_UNKNOWN, _LETTER, _HALF, _OFFSET = 0.75, 0.95, 0.3, 0.9
"""Factors of a joint's weight for unknown words, single letters, twist bones and offset joints."""
_VERTEBRAE = {"l": (5, "spine"), "vl": (5, "spine"), "t": (12, "chest"), "vt": (12, "chest")} | {
    "c": (7, "neck"),
    "vc": (7, "neck"),
}


@dataclass(frozen=True, slots=True)
class Reading:
    """The meaning of the words of a name.

    side: "left", "right", "centre" or "". part: the part of a limb, "" for none; limb: "arm", "leg" or "". slots: slot
    of the limb → value. trunk: "head", "neck", "chest", "spine", "waist", "pelvis", "root", "nose" or "". finger: 1 to
    5 for a named finger, 0 for a numbered or unnumbered one, -1 for none. metacarpal: whether it is a metacarpal.
    helper: whether it is not part of the body. end: whether it ends a chain. half: twist bones and similar. weight: 0
    to 1. both_sides: its name says left and right. numbers: its digits. key: its words without the side, to find its
    mirror. words: all words; parts: the parts that they name.
    """

    side: str = ""
    part: str = ""
    limb: str = ""
    slots: Mapping[str, float] | None = None
    trunk: str = ""
    finger: int = -1
    metacarpal: bool = False
    helper: bool = False
    end: bool = False
    half: bool = False
    weight: float = 1.0
    both_sides: bool = False
    numbers: tuple[int, ...] = ()
    key: tuple[str, ...] = ()
    words: frozenset[str] = frozenset()
    parts: frozenset[str] = frozenset()

    def value(self, slot: str) -> float:
        """How much the words speak for a slot, 0 to 1."""
        return (self.slots or {}).get(slot, 0.0) * self.weight


def read_names(names: Sequence[str], words: Sequence[Words]) -> list[Reading]:
    """The reading of each name. words: of each name, by `read_words`."""
    connecting = _find_connectors(names)
    return [
        replace(reading, helper=True, parts=reading.parts | {"connector"}) if name in connecting else reading
        for name, reading in zip(names, map(_read, names, words), strict=True)
    ]


def _find_connectors(names: Sequence[str]) -> set[str]:
    """The names of bones that only lead to another one, such as `Hips_to_LeftUpLeg`.

    Half of such names or more have the name of another joint at an end; a rig that names all bones by both ends has no
    joints of these names.
    """
    ends = {name: [_plain(end) for end in _TO.split(_own(name))] for name in names if _TO.search(_own(name))}
    others = {_plain(_own(name)) for name in names if name not in ends}
    meet = sum(not others.isdisjoint(pair) for pair in ends.values())
    return set(ends) if 2 * meet >= len(ends) else set()


_TO = re.compile(r"(?<=[^\W_])[_ .-]to[_ .-](?=[^\W_])", re.IGNORECASE)


def _own(name: str) -> str:
    """A name without namespaces, also of its second end."""
    return re.sub(r"(^|(?<=_to_))(?:(?:(?!_to_)[^:])*:)+", "", name)


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "", name).casefold()


def _read(name: str, words: Words) -> Reading:
    numbers = tuple(int(word.text[:6]) for word in words if word.is_number)
    every = frozenset(word.text for word in words)
    weight = _OFFSET if name.startswith("__") else 1.0
    vertebra = _vertebra(words)
    if vertebra:
        return Reading(trunk=vertebra, weight=weight, numbers=numbers, key=tuple(w.text for w in words), words=every)
    named = [set(word.parts) for word in words]
    parts: set[str] = set().union(*named)
    sides = parts & SIDES
    side = next(iter(sides)) if len(sides) == 1 else ""
    if not sides and "centre" in parts:
        side = "centre"
    for word in words:
        if not word.parts and not word.is_number:
            weight *= _LETTER if len(word.text) == 1 else _UNKNOWN
    half = "half" in parts
    if half:
        weight *= _HALF
    key = tuple(word.text for word in words if not SIDES & set(word.parts))
    helper = bool(parts & (HELPERS | APPENDAGES))
    end = "end" in parts
    part, trunk, finger = _part(parts, named, side, every)
    numbers = numbers or tuple(_NUMBERS[word.text] for word in words if word.text in _NUMBERS)
    limb, slots = _SLOTS[part] if part else ("", {})
    return Reading(
        side=side,
        part=part,
        limb=limb,
        slots=slots,
        trunk=trunk,
        finger=finger,
        metacarpal="metacarpal" in parts,
        helper=helper,
        end=end,
        half=half,
        weight=weight,
        both_sides=len(sides) == 2,
        numbers=numbers,
        key=key,
        words=every,
        parts=frozenset(parts),
    )


_NUMBERS = {"one": 1, "two": 2, "three": 3, "four": 4, "five": 5}


def _vertebra(words: Words) -> str:
    """The part of the trunk that a name such as L5, T8_JNT or vc4 is, "" for another name."""
    if len(words) < 2 or any(not word.is_number for word in words[1:]) or not words[1].glued:
        return ""
    most, part = _VERTEBRAE.get(words[0].text, (0, ""))
    return part if 1 <= int(words[1].text[:6]) <= most else ""


def _part(parts: set[str], named: Sequence[set[str]], side: str, texts: frozenset[str]) -> tuple[str, str, int]:
    """(part of a limb, part of the trunk, finger) that words name together."""
    sided = side in SIDES
    upper, lower, fore = "upper" in parts, "lower" in parts, "fore" in parts
    limb = [next(iter(own & _SLOTS.keys())) for own in named if own & _SLOTS.keys()]
    kinds = set(limb)
    centre_word = not parts.isdisjoint({"middle"}) and "centre" in parts
    fingers = [number for number, word in enumerate(FINGERS, 1) if word in parts]
    if centre_word and fingers == [3] and (kinds - {"hand", "wrist", "palm"} or parts & set(_TRUNK) - {"root"}):
        fingers = []
    if "foot" in kinds and (fingers == [2] or fore):
        return "toe", "", -1
    if fingers and not kinds - {"hand", "palm", "wrist", "arm"} and not parts & {"toe", "head", "spine"}:
        return "", "", fingers[0]
    if "finger" in parts and not kinds - {"hand", "palm", "wrist", "arm"}:
        return "", "", 0
    if "metacarpal" in parts and not kinds - {"hand", "palm", "wrist"}:
        return "", "", 0
    trunk = _trunk(parts, kinds, sided, texts)
    if trunk:
        return "", trunk, -1
    if not kinds:
        return "", "", -1
    return _limb_part(limb, upper, lower, fore), "", -1


def _limb_part(limb: Sequence[str], upper: bool, lower: bool, fore: bool) -> str:
    kinds = set(limb)
    if kinds == {"arm"}:
        return "upper_arm" if upper else "forearm" if lower or fore else "arm"
    if kinds == {"leg"}:
        return "thigh" if upper else "shin" if lower or fore else "leg"
    specific = [part for part in limb if part not in ("arm", "leg", "palm")] or list(limb)
    if "hand" in specific:
        return "hand"
    for part in ("toe", "ankle", "foot", "shin", "thigh", "hip_connector", "forearm", "upper_arm", "clavicle"):
        if part in specific:
            return part
    return specific[-1]


def _trunk(parts: set[str], kinds: set[str], sided: bool, texts: frozenset[str]) -> str:
    """The part of the trunk that words name, "" where they name a part of a limb or nothing."""
    if kinds == {"shoulder"} and not sided and parts & {"spine", "centre"}:
        return "chest"
    if kinds - {"pelvis", "hip"} or (kinds and sided):
        return ""
    if "spine" in parts and "root" in parts:
        return "pelvis" if "base" in texts else ""
    if "lower" in parts:
        if parts & {"chest", "root"}:
            return "pelvis"
        if "spine" in parts:
            return "waist"
    if "upper" in parts and "root" in parts:
        return "chest"
    order = ("neck", "head", "nose", "chest", "waist", "spine")
    trunk = next((part for part in order if part in parts), "")
    if trunk or not kinds:
        return trunk or ("root" if "root" in parts else "")
    return "pelvis"
