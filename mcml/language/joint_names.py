"""Names of joints: Table 1 of the paper as data, and how a rig's own names become MCML's.

The same word means different bones: `LeftShoulder` is the clavicle of one rig and the upper arm of another. So the
convention of the rig is recognised as a whole first, by words that only it uses, and only its column of
`joint_names.csv` is read. An MCML name is given to at most one joint; every other joint keeps its own name.
Rows 20 to 49 of the table are reconstructed: the printed table leaves them out.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import cache, lru_cache

from mcml.errors import Notice, VocabularyError
from mcml.language.animals import NOT_A_PERSON, not_a_person
from mcml.motion.skeleton import TRANSLATIONS, Convention, Joint, Skeleton, once_a_skeleton, unique_names
from mcml.resources import joint_names_path

TABLE_1 = ("asf", "bvh1", "bvh2", "htr")
"""Formats that Table 1 has a column for; `translate` takes these and "mcml"."""

TRUNK = ("waist", "torso2", "torso3", "torso4", "torso5", "torso6", "torso7")


@dataclass(frozen=True, slots=True)
class JointName:
    """One row of Table 1.

    number: its row, from 1. name: MCML's. reconstructed: whether the printed table leaves the row out.
    columns: the row's other columns, by the heads of `joint_names.csv`; aliases separated by `|`, an empty one
    keeps the place of a weaker claim.
    """

    number: int
    name: str
    reconstructed: bool
    columns: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Rig:
    """A way to name the joints of a body.

    column: of `joint_names.csv`. words: names (normalised) that only this rig uses; each counts one vote.
    prefix: a pattern that begins the rig's names; each name counts one vote. trunk: names of the trunk from the
    pelvis up, where a rig has as many as it likes: the first becomes waist, the last torso7. needs: names without which
    others mean something else. below: a name that means something else without another.
    """

    column: str
    words: frozenset[str]
    prefix: str = ""
    trunk: tuple[str, ...] = ()
    needs: frozenset[str] = frozenset()
    below: tuple[str, str] | None = None


_NECK = re.compile(r"h?(?:upper|lower)?neck(?:joint|upper|lower)?[0-9]{0,2}")
"""Necks (normalised) of rigs with several, whatever else their convention calls them."""


def _both_sides(*words: str) -> frozenset[str]:
    """Words of the left side and their mirror images."""
    right = [re.sub("^l(?!eft)", "r", re.sub("left", "right", re.sub("(?<=arm|leg)l$", "r", word))) for word in words]
    return frozenset(words) | frozenset(right)


_SPINES = tuple(f"spine{number or ''}" for number in range(10))

RIGS: tuple[Rig, ...] = (
    # Its feet are toes, below ankles.
    Rig(
        "smpl",
        _both_sides("leftcollar", "leftelbow", "leftknee", "lefthip"),
        trunk=_SPINES,
        needs=frozenset({"leftankle", "leftfoot"}),
    ),
    Rig(
        "motionbuilder",
        _both_sides("leftarm", "leftforearm", "leftupleg", "lefttoebase"),
        trunk=("lowerback", *_SPINES, "chest", "upperchest"),
    ),
    Rig(
        "biovision",
        _both_sides("leftcollar", "leftelbow", "leftknee", "lefthip", "leftuparm", "leftlowarm", "leftlowleg"),
        trunk=("lowerback", "ab", *_SPINES, "chest", "chest2", "chest3", "chest4"),
    ),
    Rig("acclaim", _both_sides("lclavicle", "lhumerus", "lfemur", "ltibia", "hleftuparm", "hleftupleg")),
    Rig("vicon", _both_sides("lshoulderjoint", "lhumerus", "lfemur", "ltibia") | {"neckjoint"}),
    Rig("biped", frozenset(), prefix=r"bip0?01", trunk=_SPINES),
    Rig("xsens", _both_sides("leftupperarm", "leftupperleg", "leftlowerleg") | {"l5", "l3", "t12", "t8"}),
    Rig(
        "max",
        _both_sides("lupperarm", "lforearm", "llowerarm", "lcalf", "lupperleg", "llowerleg", "lfinger0", "ltoe0"),
        trunk=("lowerback", "abdomen", *_SPINES, "chest", "upperchest"),
    ),
    Rig("motive", _both_sides("luarm", "lfarm", "lshin"), trunk=("ab", "chest")),
    Rig("motionanalysis", _both_sides("lupperarm", "luparm", "llowarm", "llowleg") | {"lowertorso", "uppertorso"}),
    Rig("hanim", frozenset({"humanoidroot", "lacromioclavicular", "racromioclavicular", "vl5", "vt1", "skullbase"})),
    Rig("poser", _both_sides("lshldr", "lforearm", "lshin", "lbuttock") | {"abdomen"}, trunk=("abdomen", "chest")),
    Rig("smpl", frozenset({"lcollar", "rcollar"}), trunk=_SPINES, below=("lfoot", "lankle")),
    Rig("bandai", _both_sides("upperarml", "lowerarml", "upperlegl", "lowerlegl"), trunk=(*_SPINES, "chest")),
)
"""Every convention that is recognised. On equal votes the earlier one wins."""

_NEARLY_ALL = 0.8
"""Of the joints: others are props, or faces."""
_SHARED = ("hip", "shoulder", "foot", "wrist", "hand", "toes")
"""Parts that other rigs call by the same names, and may mean others by."""
_FOREIGN = _both_sides("leftknee", "leftankle", "leftelbow", "leftcollar", "lknee", "lankle", "lelbow", "lcollar")

UNKNOWN = Rig("any", frozenset())
"""No convention recognised: only names that mean the same everywhere are mapped."""


@dataclass(frozen=True, slots=True)
class NamingReport:
    """What naming did, for the receipt.

    convention: the rig recognised ("any": none; "mcml": the names already were MCML's; "markers"; NOT_A_PERSON).
    mapped: (source name, MCML name). unmapped: (source name, name kept, why). refused: why nothing is mapped.
    """

    convention: str
    mapped: tuple[tuple[str, str], ...]
    unmapped: tuple[tuple[str, str, str], ...]
    refused: str = ""

    def notices(self) -> list[Notice]:
        """The report as lines of a receipt."""
        if self.convention == "markers":
            return []
        if self.refused:
            return [Notice("guess", f"joint names: not a person ({self.refused}), so joints keep their own names")]
        total = len(self.mapped) + len(self.unmapped)
        lines = [Notice("note", f"joint names: {self.convention} rig, {len(self.mapped)} of {total} joints mapped")]
        if self.unmapped:
            kept = ", ".join(f"{source} ({why})" for source, _, why in self.unmapped)
            lines.append(Notice("note", f"joints that keep their own name: {kept}"))
        return lines


@cache
def table() -> tuple[JointName, ...]:
    """The 53 rows of Table 1, in order."""
    with joint_names_path().open(encoding="utf-8", newline="") as stream:
        return tuple(
            JointName(int(row.pop("number")), row.pop("name"), row.pop("reconstructed") == "yes", row)
            for row in csv.DictReader(stream)
        )


def detect(skeleton: Skeleton) -> Rig:
    """The convention most of the joints' words vote for; UNKNOWN where none gets a vote."""
    raw = [_bare(joint.source_name) for joint in skeleton.joints]
    keys = set(_keys(skeleton))
    if _is_mcml([joint.source_name for joint in skeleton.joints], keys):
        return Rig("mcml", frozenset())
    votes = [
        len(keys & rig.words) + (sum(1 for name in raw if re.match(rig.prefix, name)) if rig.prefix else 0)
        if _is_possible(rig, keys)
        else 0
        for rig in RIGS
    ]
    best = max(range(len(RIGS)), key=lambda index: votes[index])
    return RIGS[best] if votes[best] else UNKNOWN


def _is_possible(rig: Rig, keys: Set[str]) -> bool:
    return rig.needs <= keys and (rig.below is None or rig.below[0] not in keys or rig.below[1] in keys)


def _is_mcml(names: Sequence[str], keys: Set[str]) -> bool:
    """Whether names are MCML's own: nearly all are in Table 1, one of them is nobody else's, and none is a word that
    MCML does not use for a part of a limb. `left_hip`, `left_foot` and others are SMPL's and MediaPipe's too, where
    they mean other joints."""
    ours = {row.name for row in table()}
    own = sum(name in ours for name in names)
    return own >= _NEARLY_ALL * len(names) and not _mcml_only().isdisjoint(names) and keys.isdisjoint(_FOREIGN)


@once_a_skeleton
def root_candidates(skeleton: Skeleton) -> tuple[int, ...]:
    """The joints that the rig's convention, or any, calls Root and that can move the figure, parents first.

    Where there are several, which of them does is to be seen in the motion: see `named`.
    """
    rig = detect(skeleton)
    if rig.column == "mcml" or all(joint.convention is Convention.MARKER for joint in skeleton.joints):
        return ()
    keys, row = _keys(skeleton), table()[0]
    aliases = {_key(alias) for column in (rig.column, UNKNOWN.column) for alias in row.columns[column].split("|")}
    return tuple(
        index
        for index, joint in enumerate(skeleton.joints)
        if keys[index] in aliases and not set(joint.channels).isdisjoint(TRANSLATIONS)
    )


def translate(skeleton: Skeleton, to: str) -> Skeleton:
    """The skeleton with the source names of mapped joints replaced by those of another column of Table 1.

    to: "mcml", "bvh1", "bvh2", "asf" or "htr". A joint whose row has no name there keeps its source name; a name is
    given once, to the joint further from the root (`chest` of bvh1 is both waist and torso7).
    Raises VocabularyError for another word.
    """
    if to not in (*TABLE_1, "mcml"):
        raise VocabularyError(f"there are no joint names of {to!r}", remedy="Use mcml, bvh1, bvh2, asf or htr.")
    rows = {row.name: row for row in table()}
    given: dict[int, str] = {}
    for index in reversed(range(len(skeleton))):
        joint = skeleton.joints[index]
        if joint.mapped and joint.name in rows:
            columns = rows[joint.name].columns
            target = joint.name if to == "mcml" else columns.get(f"{to}_alias") or columns[to]
            if target and target not in given.values():
                given[index] = target
    names = _fill_in(given, [joint.source_name for joint in skeleton.joints])
    return _renamed(skeleton, lambda index, joint: replace(joint, source_name=names[index]))


def named(
    skeleton: Skeleton, extra: Sequence[tuple[str, str]] = (), root: int | None = None
) -> tuple[Skeleton, NamingReport]:
    """The skeleton with `name` and `mapped` of every joint set, and why joints stay unmapped.

    Source names stay as they are. extra: a team's own rows, (name in the source, name to give), which come first. Never
    fails: a joint that no row fits keeps its source name, with `#2` if that is taken.

    root: which of several `root_candidates` moves the figure; None: the first.
    """
    if skeleton.joints and all(joint.convention is Convention.MARKER for joint in skeleton.joints):
        return _with_names(skeleton, {}, "markers", {})
    rig = detect(skeleton)
    keys = _keys(skeleton)
    given: dict[int, str] = {}
    why: dict[int, str] = {}
    _claim([(_key(source), name) for source, name in extra], keys, given, why)
    if rig.column == "mcml":
        names = {row.name for row in table()}
        exact = [joint.source_name if joint.source_name in names else "" for joint in skeleton.joints]
        _claim([(name, name) for name in exact if name], exact, given, why)
    else:
        candidates = root_candidates(skeleton) if root is None else (root,)
        if candidates and "Root" not in given.values() and candidates[0] not in given:
            given[candidates[0]] = "Root"
        _claim_trunk(rig, keys, given)
        _claim_neck(rig, keys, skeleton, given, why)
        for claims in _ranks(rig.column):
            _claim(claims, keys, given, why)
        asked = {_key(source) for source, _ in extra}
        reason = not_a_person(skeleton, given)
        if reason is not None:
            own = {index: name for index, name in given.items() if keys[index] in asked}
            why = dict.fromkeys(given.keys() - own.keys(), reason)
            return _with_names(skeleton, own, NOT_A_PERSON, why, reason)
    return _with_names(skeleton, given, rig.column, why)


def _claim(claims: Sequence[tuple[str, str]], keys: list[str], given: dict[int, str], why: dict[int, str]) -> None:
    """Gives each name to the first joint with its key, if neither the joint nor the name has a match already."""
    places: dict[str, list[int]] = {}
    for index, key in enumerate(keys):
        places.setdefault(key, []).append(index)
    for key, name in claims:
        for index in places.get(key, ()):
            if index in given:
                continue
            if name in given.values():
                why.setdefault(index, f"{name} is taken")
            else:
                given[index] = name


def _claim_trunk(rig: Rig, keys: list[str], given: dict[int, str]) -> None:
    trunk = [index for index, key in enumerate(keys) if key in rig.trunk and index not in given]
    # torso7 carries the neck and the arms, waist is the first joint above the pelvis: the ends of the chain are known.
    middle = len(TRUNK) - 2
    for place, index in enumerate(trunk[: middle + 1]):
        given[index] = TRUNK[-1] if place and index == trunk[-1] else TRUNK[place]
    if len(trunk) > middle + 1:
        given[trunk[-1]] = TRUNK[-1]


def _claim_neck(rig: Rig, keys: list[str], skeleton: Skeleton, given: dict[int, str], why: dict[int, str]) -> None:
    """The upper neck is neck1 and the lower one neck2 (Table 1), by their places: of more, the ends."""
    words = {alias for claims in _ranks(rig.column) for alias, name in claims if name in ("neck1", "neck2")}
    chains: dict[int, tuple[int, int]] = {}  # of each neck: how many there are down to the lowest, and that one
    nearest: list[int] = []
    for index, (key, joint) in enumerate(zip(keys, skeleton.joints, strict=True)):
        below = nearest[joint.parent] if joint.parent >= 0 else -1
        is_neck = index not in given and (key in words or _NECK.fullmatch(key) is not None)
        if is_neck:
            count, lowest = chains.get(below, (0, index))
            chains[index] = count + 1, lowest
        nearest.append(index if is_neck else below)
    upper = max(chains, key=lambda index: chains[index][0], default=-1)
    for index, name in ((upper, "neck1"), (chains[upper][1] if chains else -1, "neck2")):
        if index >= 0 and index not in given and name not in given.values():
            given[index] = name
    for index in chains.keys() - given.keys():
        why.setdefault(index, "neck1 is taken")


@cache
def _ranks(column: str) -> tuple[tuple[tuple[str, str], ...], ...]:
    """The claims (normalised alias, MCML name) of a column, strongest first: first aliases, second aliases, …

    Table 1's own ASF names (`h_left_hand`) belong to the Acclaim column.
    """
    ranked: list[list[tuple[str, str]]] = []
    for row in table():
        aliases = row.columns[column].split("|")
        if column == "acclaim":
            aliases.append(row.columns["asf"])
        for rank, alias in enumerate(aliases):
            while len(ranked) <= rank:
                ranked.append([])
            if alias:
                ranked[rank].append((_key(alias), row.name))
    return tuple(tuple(claims) for claims in ranked)


def _with_names(
    skeleton: Skeleton, given: dict[int, str], convention: str, why: dict[int, str], refused: str = ""
) -> tuple[Skeleton, NamingReport]:
    names = _fill_in(given, [joint.source_name for joint in skeleton.joints])
    named = _renamed(skeleton, lambda index, joint: replace(joint, name=names[index], mapped=index in given))
    joints = skeleton.joints
    mapped = tuple((joints[index].source_name, names[index]) for index in sorted(given))
    unmapped = tuple(
        (joint.source_name, names[index], why.get(index, "not in Table 1"))
        for index, joint in enumerate(joints)
        if index not in given
    )
    return named, NamingReport(convention, mapped, unmapped, refused)


def _fill_in(given: Mapping[int, str], own: Sequence[str]) -> dict[int, str]:
    """Given names, and for the others their own, made unique against all before them and all given ones."""
    others = [index for index in range(len(own)) if index not in given]
    unique = unique_names([*given.values(), *(own[index] or "joint" for index in others)])
    return dict(given) | dict(zip(others, unique[len(given) :], strict=True))


def _renamed(skeleton: Skeleton, rename: Callable[[int, Joint], Joint]) -> Skeleton:
    return replace(skeleton, joints=tuple(rename(index, joint) for index, joint in enumerate(skeleton.joints)))


def _keys(skeleton: Skeleton) -> list[str]:
    """The normalised name of every joint: no namespace, no prefix that all of them share, no punctuation."""
    names = [_bare(joint.source_name) for joint in skeleton.joints]
    cut = 0
    if len(names) > 2:
        low, high = min(names), max(names)
        shared = next((place for place, letter in enumerate(low) if high[place] != letter), len(low))
        cut = max(low.rfind(mark, 0, shared) + 1 for mark in "_-. ")
        # "h_" marks Table 1's own ASF names (h_left_hand); it is no prefix of one file.
        cut = 0 if low[:cut] == "h_" else cut
    return [_key(name[cut:]) for name in names]


def _bare(name: str) -> str:
    return name.lower().rpartition(":")[2].strip()


@lru_cache(maxsize=4096)
def _key(name: str) -> str:
    bare = _bare(name)
    shorter = re.sub(r"^(?:mixamorig[0-9]*|bip0?01|character1_)[ _.-]*", "", bare)
    return re.sub(r"[\W_]+", "", shorter or bare)


def alias_key(name: str) -> str:
    """What of a name counts where names are compared: no namespace, prefix of a rig, case or punctuation."""
    return _key(name)


@cache
def _mcml_only() -> frozenset[str]:
    """Names of Table 1 that no other rig writes: of sides, without those that others use."""
    shared = {f"{side}_{part}" for side in ("left", "right") for part in _SHARED}
    sided = {row.name for row in table() if row.name.startswith(("left_", "right_"))}
    return frozenset((sided | set(TRUNK[1:])) - shared)
