"""Recognise the MCML joints of a rig: by words, by the position of joints in the tree, and by the rest pose.

No convention is listed anywhere. A joint without a name keeps its own, and so does a doubtful one: a missing name costs
an answer, a wrong one gives a wrong answer. Left and right come from words if there are any, else from the toes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from mcml.motion.rigs.creatures import creature_by_limbs, creature_by_posture, creature_by_words, limb_ends
from mcml.motion.rigs.fingers import find_fingers
from mcml.motion.rigs.lengths import slots_by_length
from mcml.motion.rigs.limbs import Limb, drop_unlike, fill_gap, find_limb
from mcml.motion.rigs.pairs import Pair, arms_and_legs, find_pairs, head_by_length, way_to_head
from mcml.motion.rigs.postures import Posture, first_standing, left_of, side_of, stands
from mcml.motion.rigs.readings import CORE, LIMBS, Reading, read_names
from mcml.motion.rigs.tree import Tree
from mcml.motion.rigs.trunk import Claim, Trunk, find_trunk
from mcml.motion.rigs.vocabulary import APPENDAGES
from mcml.motion.rigs.words import SIDES, read_words
from mcml.motion.skeleton import Array

PERSON, PART, NOBODY, UNKNOWN = "person", "part of a person", "not a person", "unknown"
DOUBTFUL = 0.7
"""A joint that is less sure is a guess."""
_BY_WORDS, _BY_TOES = 0.75, 0.6
_BOTH = ("left", "right")


@dataclass(frozen=True, slots=True)
class NamedJoint:
    """A joint, MCML's name for it, how sure that is (0 to 1) and by what: "word", "tree" or "rest pose"."""

    joint: int
    name: str
    confidence: float
    how: str


@dataclass(frozen=True)
class Recognition:
    """The recognition of a rig.

    joints: joints with a name, in the order of the rig. verdict: PERSON, PART, NOBODY or UNKNOWN; the latter two have
    no names. reason: why it is not a person. told: sentences for the receipt. asks_for_frames: whether poses of the
    motion could help, because the rest pose is not a standing body.
    """

    joints: tuple[NamedJoint, ...]
    verdict: str
    reason: str = ""
    told: tuple[str, ...] = ()
    asks_for_frames: bool = False


@dataclass
class _Rig:
    """The state of a recognition."""

    tree: Tree
    readings: Sequence[Reading]
    sides: list[str]
    out: list[bool]
    limbs: dict[tuple[str, str], Limb] = field(default_factory=dict)
    candidates: dict[tuple[str, str], list[int]] = field(default_factory=dict)
    trunk: Trunk = field(default_factory=Trunk)
    told: list[str] = field(default_factory=list)

    def core(self, kind: str) -> list[int]:
        """How many joints of the core each limb of a kind has."""
        return [self.limbs[side, kind].core() for side in _BOTH]

    def posture(self) -> Posture:
        """The joints by which poses are judged."""
        top = next((self.trunk.at(name) for name in ("Head", "neck1", "torso7") if self.trunk.at(name) >= 0), -1)
        top = top if top >= 0 else self.trunk.carrier
        legs = []
        for side in _BOTH:
            limb = self.limbs[side, "leg"]
            ends = limb_ends(limb, ("up_leg", "low_leg"), ("foot", "toes", "low_leg"))
            if ends is not None:
                legs.append((*ends, limb.at("toes") if ends[1] != limb.at("toes") else -1))
        bottom = self.trunk.at("Root")
        if bottom < 0:
            bottom = self.tree.common([start for start, _, _ in legs])
        return Posture(bottom, top if top != bottom else -1, tuple(legs) if len(legs) == 2 else ())


def recognise(tree: Tree, poses: Sequence[Array] = ()) -> Recognition:
    """Name the joints of a rig.

    poses: (J, 3) places of joints in some frames spread over a clip; used only if the rest pose is not a standing body.
    Never fails; takes time that grows with the number of joints.
    """
    words, _ = read_words(tree.names)
    readings = read_names(tree.names, words)
    rig = _Rig(tree, readings, _sides(tree, readings), _out(tree, readings))
    _find_limbs(rig)
    reason = creature_by_words(tree.names, words, readings)
    if not reason:
        _find_trunk(rig)
        _find_by_shape(rig, poses)
        reason = creature_by_limbs(tree, readings, rig.candidates, rig.limbs) or _no_arms(rig)
    every = [tree.places, *poses]
    posture = rig.posture() if rig.trunk.names else None
    if posture is not None and not reason:
        reason = creature_by_posture(posture, rig.limbs, every, _has(readings, "tail"))
    if reason:
        return Recognition((), NOBODY, reason)
    arms, legs = rig.core("arm"), rig.core("leg")
    if max(*arms, *legs) < 2:
        told = (*rig.told, *(sentence for limb in rig.limbs.values() for sentence in limb.told))
        return Recognition((), UNKNOWN, told=(*told, "no two arms or legs are recognised: nothing is mapped"))
    asks = posture is not None and tree.has_lengths and not stands(posture, tree.places) and not len(poses)
    if posture is not None:
        _check_sides(rig, posture, every)
    verdict = PERSON if min(*arms, *legs) >= 2 else PART
    return Recognition(tuple(_joints(rig)), verdict, told=tuple(_sentences(rig, verdict)), asks_for_frames=asks)


def _sides(tree: Tree, readings: Sequence[Reading]) -> list[str]:
    """Of each joint its side; a joint without one has that of the nearest joint of a limb above it."""
    sides, carried = [], list[str]()
    for reading, parent in zip(readings, tree.parents, strict=True):
        above = carried[parent] if parent >= 0 else ""
        own = reading.side if reading.side in SIDES else ""
        is_trunk = reading.trunk != "" or reading.side == "centre"
        side = own or ("" if is_trunk or reading.both_sides else above)
        sides.append(side)
        carried.append(own if own and (reading.limb or reading.finger >= 0) else "" if is_trunk else above)
    return sides


def _out(tree: Tree, readings: Sequence[Reading]) -> list[bool]:
    """Whether each joint is a helper, or hangs from one without a word for a part of the body."""
    carries = [False] * len(tree)
    for index in range(len(tree) - 1, -1, -1):
        parent, reading = tree.parents[index], readings[index]
        known = bool(reading.limb) and not reading.helper and not reading.end
        if parent >= 0 and (known or carries[index]):
            carries[parent] = True
    out: list[bool] = []
    for index, (reading, parent) in enumerate(zip(readings, tree.parents, strict=True)):
        ends = reading.end and not (reading.part in ("arm", "leg") and carries[index])
        named = bool(reading.limb or reading.trunk or reading.finger >= 0)
        out.append(reading.helper or ends or (parent >= 0 and out[parent] and not named))
    return out


def _find_limbs(rig: _Rig) -> None:
    for side in _BOTH:
        for kind in LIMBS:
            rig.candidates[side, kind] = [
                joint
                for joint, reading in enumerate(rig.readings)
                if reading.limb == kind and rig.sides[joint] == side and not rig.out[joint]
            ]
            rig.limbs[side, kind] = find_limb(rig.tree, rig.readings, rig.candidates[side, kind], side, kind)
    for kind in LIMBS:
        left, right = (rig.limbs[side, kind] for side in _BOTH)
        rig.told += drop_unlike(rig.tree, rig.readings, left, right)
    for limb in rig.limbs.values():
        taken = {joint for joint, _, _ in limb.joints.values()}
        free = {joint for joint, is_out in enumerate(rig.out) if not is_out} - taken
        fill_gap(rig.tree, limb, free.__contains__)
    for name, reading in zip(rig.tree.names, rig.readings, strict=True):
        if reading.both_sides and reading.limb:
            rig.told.append(f"{name} says left and right: not mapped")


def _find_trunk(rig: _Rig) -> None:
    tree = rig.tree
    tops = [min((joint for joint, _, _ in limb.joints.values()), key=lambda joint: tree.depth[joint])
            for limb in rig.limbs.values() if limb.core()]  # fmt: skip
    inside = [False] * len(tree)
    for joint, parent in enumerate(tree.parents):
        inside[joint] = joint in tops or (parent >= 0 and inside[parent])
    # Joints below a hand or foot never belong to the trunk, regardless of their names; in a list without a tree there
    # is no below.
    rig.trunk = find_trunk(tree, rig.readings, rig.limbs, rig.out.__getitem__, inside.__getitem__)


def _find_by_shape(rig: _Rig, poses: Sequence[Array]) -> None:
    """Name limbs that no word names, by pairs of like chains."""
    missing = [kind for kind in LIMBS if max(rig.core(kind)) < 2]
    if not missing or rig.tree.is_flat:
        return
    pairs = find_pairs(rig.tree, rig.out)
    upper = max((pair.above for pair in pairs), key=lambda joint: rig.tree.depth[joint], default=-1)
    if upper < 0:
        return
    way = way_to_head(rig.tree, upper, pairs, rig.out)
    kinds = arms_and_legs(rig.tree, pairs, way)
    if not kinds or any(not _fits(rig, kind, kinds[kind]) for kind in LIMBS if kind not in missing):
        return
    slots = {
        kind: [
            slots_by_length(rig.tree, chain, kind, twin[0])
            for chain, twin in ((pair.first, pair.second), (pair.second, pair.first))
        ]
        for kind, pair in kinds.items()
    }
    if any(not all(slots[kind]) for kind in missing):
        return
    head = (
        rig.trunk.at("Head")
        if "Head" in rig.trunk.names
        else head_by_length(rig.tree, way, rig.tree.distance(kinds["leg"].above, kinds["arm"].above))
    )
    order = _left_first(rig, kinds, slots, head, poses)
    for kind in missing:
        side_order = order.get(kind)
        if side_order is None:
            rig.told.append(f"{kind}s found by their place, but no toes or names tell left from right: not mapped")
            continue
        sure, is_first_left = side_order
        for side, chain in zip(_BOTH, slots[kind] if is_first_left else slots[kind][::-1], strict=True):
            limb = rig.limbs[side, kind]
            limb.joints = {slot: (joint, sure, "rest pose") for joint, slot in chain.items()}
    if all(max(rig.core(kind)) < 2 for kind in missing):
        return
    rig.told = [sentence for sentence in rig.told if "one word" not in sentence]
    _find_trunk(rig)
    if "Head" not in rig.trunk.names and head >= 0:
        rig.trunk.names["Head"] = (head, _BY_TOES, "rest pose")


def _fits(rig: _Rig, kind: str, pair: Pair) -> bool:
    """Whether a pair is the limbs that words name."""
    chains = {*pair.first, *pair.second}
    named = {joint for side in _BOTH for joint, _, _ in rig.limbs[side, kind].joints.values()}
    return bool(chains & named)


def _left_first(
    rig: _Rig, kinds: Mapping[str, Pair], slots: Mapping[str, list[dict[int, str]]], head: int, poses: Sequence[Array]
) -> dict[str, tuple[float, bool] | None]:
    """Of each kind of limb how sure its sides are, and whether the first of its pair is the left one."""
    found: dict[str, tuple[float, bool] | None] = {}
    legs: list[tuple[int, int, int]] = []
    for chain in slots["leg"]:
        at = {slot: joint for joint, slot in chain.items()}
        if "up_leg" not in at or "foot" not in at:
            legs = []
            break
        legs.append((at["up_leg"], at["foot"], at.get("toes", -1)))
    posture = Posture(kinds["leg"].above, head, tuple(legs))
    tips = [rig.tree.tips_of(end)[0] if rig.tree.tips_of(end) else None for _, end, _ in posture.legs]
    left, standing = None, None
    if legs and head >= 0:
        standing = first_standing(posture, [rig.tree.places, *poses])
        if standing is not None:
            left = left_of(posture, standing, tips if standing is rig.tree.places else ())
    for kind, pair in kinds.items():
        sides = [{rig.readings[joint].side for joint in chain} & SIDES for chain in (pair.first, pair.second)]
        if (len(sides[0] | sides[1]) == 2 and not sides[0] & sides[1]) or len(sides[0]) + len(sides[1]) == 1:
            found[kind] = (_BY_WORDS, "left" in sides[0] or "right" in sides[1])
        elif left is not None and standing is not None:
            towards = side_of(left, standing[list(pair.first)], standing[list(pair.second)])
            found[kind] = (_BY_TOES, towards > 0) if towards else None
        else:
            found[kind] = None
    return found


def _has(readings: Sequence[Reading], word: str) -> bool:
    return any(word in reading.words and reading.parts & APPENDAGES for reading in readings)


def _no_arms(rig: _Rig) -> str:
    if min(rig.core("arm")) >= 2 or max(rig.core("leg")) < 1:
        return ""
    away = any(reading.parts & APPENDAGES for reading in rig.readings)
    return "it has a tail or wings, and no two arms" if away else ""


def _check_sides(rig: _Rig, posture: Posture, poses: Sequence[Array]) -> None:
    """Tell where names of limbs and the toes disagree about left and right."""
    if len(posture.legs) != 2 or posture.top < 0 or any(toes < 0 for _, _, toes in posture.legs):
        return
    standing = first_standing(posture, poses)
    left = None if standing is None else left_of(posture, standing)
    if standing is None or left is None:
        return
    signs = []
    for kind, slots in CORE.items():
        pairs = [(rig.limbs["left", kind].at(slot), rig.limbs["right", kind].at(slot)) for slot in slots]
        pairs = [pair for pair in pairs if min(pair) >= 0]
        if pairs and all(rig.limbs[side, kind].joints for side in _BOTH):
            first, second = (standing[[pair[place] for pair in pairs]] for place in (0, 1))
            signs.append(side_of(left, first, second))
    if -1 in signs and 1 not in signs:
        rig.told.append(
            "names and toes disagree about left and right: the names are kept; the file may be mirrored or in a"
            " left-handed system"
        )
    elif -1 in signs:
        rig.told.append("some limbs named left stand on the right of the others")


def _joints(rig: _Rig) -> list[NamedJoint]:
    """Every joint with a name, each name and each joint once."""
    claims: dict[str, Claim] = dict(rig.trunk.names)
    for side in _BOTH:
        for kind in LIMBS:
            claims |= {f"{side}_{slot}": claim for slot, claim in rig.limbs[side, kind].joints.items()}
        fingers = find_fingers(rig.tree, rig.readings, rig.sides, rig.out, rig.limbs[side, "arm"])
        claims |= {f"{side}_{finger}": claim for finger, claim in fingers.items()}
    named: dict[int, NamedJoint] = {}
    for name, (joint, confidence, how) in claims.items():
        if joint not in named or confidence > named[joint].confidence:
            named[joint] = NamedJoint(joint, name, round(float(confidence), 3), how)
    return [named[joint] for joint in sorted(named)]


def _sentences(rig: _Rig, verdict: str) -> list[str]:
    told = list(rig.told)
    for limb in rig.limbs.values():
        told += limb.told
    missing = [name for name in ("Root", "Head") if name not in rig.trunk.names]
    for (side, kind), limb in rig.limbs.items():
        if limb.joints or verdict == PERSON:
            missing += [f"{side}_{slot}" for slot in CORE[kind] if slot not in limb.joints]
    if missing:
        told.append(f"not found: {', '.join(missing)}")
    return told
