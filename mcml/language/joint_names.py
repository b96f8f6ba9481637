"""Names of joints: Table 1 of the paper as data, and how a rig's own names become MCML's.

The same word means different bones: `LeftShoulder` is the clavicle of one rig and the upper arm of another. So a rig is
recognised as a whole (`mcml.motion.rigs`). An MCML name is given to at most one joint; every other joint keeps its own
name. Rows 20 to 49 of the table are reconstructed: the printed table leaves them out.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache, lru_cache

from mcml.errors import Notice, VocabularyError
from mcml.motion.landmarks.centres import bodies_of, centres_of
from mcml.motion.rigs.recognise import DOUBTFUL, Recognition
from mcml.motion.rigs.roles import find_roles
from mcml.motion.rigs.skeletons import recognise_skeleton, rig_of
from mcml.motion.rigs.vocabulary import vocabulary
from mcml.motion.skeleton import TRANSLATIONS, Convention, Joint, Skeleton, unique_names
from mcml.resources import joint_names_path

TABLE_1 = ("asf", "bvh1", "bvh2", "htr")
"""Formats that Table 1 has a column for; `translate` takes these and "mcml"."""

TRUNK = ("waist", "torso2", "torso3", "torso4", "torso5", "torso6", "torso7")


@dataclass(frozen=True, slots=True)
class JointName:
    """One row of Table 1.

    number: its row, from 1. name: MCML's. reconstructed: whether the printed table leaves the row out.
    columns: the names that formats of the paper use, by the heads of `joint_names.csv`; "" for none.
    """

    number: int
    name: str
    reconstructed: bool
    columns: Mapping[str, str]


MCML, MARKERS = "mcml", "markers"
"""Kinds of joints other than the verdicts of a recognition: already named in MCML, or points."""
_ROOTS = frozenset({"root", "pelvis", "hip"})
"""Parts that a joint is called which may move the figure."""
_NEARLY_ALL = 0.8
"""Of the joints: others are props, or faces."""
_SHARED = ("hip", "shoulder", "foot", "wrist", "hand", "toes")
"""Parts that other rigs call by the same names, and may mean others by."""
_FOREIGN = frozenset(
    side + part for side in ("left", "right", "l", "r") for part in ("knee", "ankle", "elbow", "collar")
)


@dataclass(frozen=True, slots=True)
class SureName:
    """A joint with a recognised name.

    source: its own name. name: MCML's. confidence: 0 to 1. how: the evidence: "word", "tree", "rest pose", or "alias"
    for a project's own.
    """

    source: str
    name: str
    confidence: float
    how: str


@dataclass(frozen=True, slots=True)
class NamingReport:
    """The result of naming, for the receipt.

    kind: kind of the joints: PERSON, PART, NOBODY or UNKNOWN (`mcml.motion.rigs.recognise`), MCML or MARKERS. named:
    joints with a name of MCML's. unmapped: (source name, kept name, reason) of others, without markers on landmarks.
    refused: reason why it is not a person. told: sentences about missing joints, doubts and contradictions. landmarks:
    of markers, by their own names.
    """

    kind: str
    named: tuple[SureName, ...]
    unmapped: tuple[tuple[str, str, str], ...]
    refused: str = ""
    told: tuple[str, ...] = ()
    landmarks: tuple[tuple[str, str], ...] = ()

    @property
    def mapped(self) -> dict[str, str]:
        """Source name → MCML's."""
        return {each.source: each.name for each in self.named}

    def notices(self) -> list[Notice]:
        """The report as lines of a receipt."""
        if self.kind in (MARKERS, MCML):
            return [
                Notice("guess" if "contradict" in told or "may be wrong" in told else "note", f"markers: {told}")
                for told in self.told
            ]
        if self.refused:
            return [Notice("guess", f"joint names: not a person ({self.refused}), so joints keep their own names")]
        lines = [Notice("guess" if "disagree" in told else "note", f"joint names: {told}") for told in self.told]
        doubtful = [f"{each.source} as {each.name}" for each in self.named if each.confidence < DOUBTFUL]
        if doubtful:
            lines.append(Notice("guess", f"joint names: guessed: {', '.join(doubtful)}"))
        return lines


@cache
def table() -> tuple[JointName, ...]:
    """The 53 rows of Table 1, in order."""
    with joint_names_path().open(encoding="utf-8", newline="") as stream:
        return tuple(
            JointName(int(row.pop("number")), row.pop("name"), row.pop("reconstructed") == "yes", row)
            for row in csv.DictReader(stream)
        )


def _told_of_markers(skeleton: Skeleton) -> tuple[tuple[str, ...], tuple[tuple[str, str], ...]]:
    """Sentences about the landmarks of markers, and each marker with its landmark."""
    told, landmarks = [], []
    for body in bodies_of(skeleton):
        by = f"of the set {body.set_name}" if body.set_name else "by words"
        if body.set_name and body.by_words:
            by += f" ({len(body.by_words)} by words)"
        if body.are_centres:
            by += ", centres of joints; its left is the person's unless the image was mirrored"
        whose = f"{body.prefix}: " if body.prefix else ""
        told.append(f"{whose}{len(body.landmarks)} of {body.markers} are landmarks {by}")
        landmarks += [(skeleton.joints[index].source_name, name) for index, name in sorted(body.landmarks.items())]
    for centre in centres_of(skeleton):
        told.append(f"the centre {centre.name} is {centre.describe()}")
    return tuple(told), tuple(landmarks)


def _is_markers(skeleton: Skeleton) -> bool:
    return bool(skeleton.joints) and all(joint.convention is Convention.MARKER for joint in skeleton.joints)


def _is_literal(skeleton: Skeleton) -> bool:
    return _is_mcml([joint.own_name for joint in skeleton.joints], set(_keys(skeleton)))


def _is_mcml(names: Sequence[str], keys: Set[str]) -> bool:
    """Whether names are MCML's own: nearly all are in Table 1, one of them is unique to MCML, and none is a word
    that MCML does not use for a part of a limb. SMPL and MediaPipe also use `left_hip`, `left_foot` and others, for
    other joints.
    """
    ours = {row.name for row in table()}
    own = sum(name in ours for name in names)
    return own >= _NEARLY_ALL * len(names) and not _mcml_only().isdisjoint(names) and keys.isdisjoint(_FOREIGN)


def root_candidates(skeleton: Skeleton, recognition: Recognition) -> tuple[int, ...]:
    """Return possible Root joints that may move the figure, parents first: the recognised one, and each above it
    without another child and with a name such as root or hips. If there are several, the motion decides: see `named`.
    """
    if _is_literal(skeleton) or _is_markers(skeleton):
        return ()
    root = next((each.joint for each in recognition.joints if each.name == "Root"), -1)
    if root < 0:
        return ()
    children = Counter(joint.parent for joint in skeleton.joints)
    way = [root]
    while (parent := skeleton.joints[way[-1]].parent) >= 0 and children[parent] == 1:
        if _ROOTS.isdisjoint(vocabulary().parts(_key(skeleton.joints[parent].own_name))):
            break
        way.append(parent)
    moving = [joint for joint in way[::-1] if not set(skeleton.joints[joint].channels).isdisjoint(TRANSLATIONS)]
    return tuple(moving) or (root,)


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
    skeleton: Skeleton,
    extra: Sequence[tuple[str, str]] = (),
    root: int | None = None,
    recognition: Recognition | None = None,
) -> tuple[Skeleton, NamingReport]:
    """Set `name`, `mapped`, `confidence` and `role` of every joint; return the skeleton and why joints are not mapped.

    Source names do not change. extra: aliases, (name in the source, name to give), which come first. Never
    fails: a joint without a name of MCML's keeps its source name, with `#2` if that is taken.

    root: which of several `root_candidates` moves the figure; None: the first. recognition: the recognised rig, if
    poses of the motion were needed; None: recognise it by names and rest pose.
    """
    if _is_markers(skeleton):
        told, landmarks = _told_of_markers(skeleton)
        return _with_names(skeleton, {}, NamingReport(MARKERS, (), (), told=told, landmarks=landmarks), {})
    keys = _keys(skeleton)
    given: dict[int, tuple[str, float, str]] = {}
    why: dict[int, str] = {}
    _claim([(_key(source), name) for source, name in extra], keys, given, why, "alias")
    if _is_literal(skeleton):
        names = {row.name for row in table()}
        exact = [joint.own_name if joint.own_name in names else "" for joint in skeleton.joints]
        _claim([(name, name) for name in exact if name], exact, given, why, "word")
        return _with_names(skeleton, given, NamingReport(MCML, (), ()), why)
    rig = recognition or recognise_skeleton(skeleton)
    taken = {name for name, _, _ in given.values()}
    claims = {each.joint: (each.name, each.confidence, each.how) for each in rig.joints}
    if root is None:
        root = next(iter(root_candidates(skeleton, rig)), None)
    if root is not None and root not in claims:
        claims = {joint: claim for joint, claim in claims.items() if claim[0] != "Root"}
        claims[root] = ("Root", 0.9, "tree")
    for joint, claim in claims.items():
        if claim[0] in taken:
            why.setdefault(joint, f"{claim[0]} is taken")
        elif joint not in given:
            given[joint] = claim
    if rig.reason:
        why = {index: rig.reason for index in range(len(skeleton)) if index not in given}
    return _with_names(skeleton, given, NamingReport(rig.verdict, (), (), rig.reason, rig.told), why)


def check_name(name: str) -> None:
    """Raises VocabularyError for a name that is not MCML's."""
    known = [row.name for row in table()]
    if name not in known:
        near = get_close_matches(name, known, 1)
        raise VocabularyError(
            f"{name!r} is no joint of MCML.",
            remedy=f"Did you mean {near[0]!r}?" if near else "GET /joint-names lists all 53.",
        )


def rename_joints(skeleton: Skeleton, chosen: Mapping[int, str | None]) -> Skeleton:
    """Return the skeleton with names of MCML's that a person chose for joints; None for the name of the source.

    Another joint that has a chosen name gets that of its source. Chosen names are sure. Raises VocabularyError for a
    name that is not MCML's, or that is chosen twice.
    """
    names = [name for name in chosen.values() if name is not None]
    for name in names:
        check_name(name)
        if names.count(name) > 1:
            raise VocabularyError(f"{name!r} is chosen for two joints.", remedy="Give each name once.")
    freed = {index for index, joint in enumerate(skeleton.joints) if joint.name in names} - chosen.keys()
    freed |= {index for index, name in chosen.items() if name is None}
    given = {index: joint.name for index, joint in enumerate(skeleton.joints) if index not in freed}
    given |= {index: name for index, name in chosen.items() if name is not None}
    every = _fill_in(given, [joint.own_name for joint in skeleton.joints])

    def rename(index: int, joint: Joint) -> Joint:
        if index not in freed and index not in chosen:
            return joint
        return replace(joint, name=every[index], mapped=index not in freed, confidence=None)

    return with_roles(_renamed(skeleton, rename))


def _claim(
    claims: Sequence[tuple[str, str]],
    keys: list[str],
    given: dict[int, tuple[str, float, str]],
    why: dict[int, str],
    how: str,
) -> None:
    """Gives each name to the first joint with its key, if neither the joint nor the name has a match already."""
    names = {name for name, _, _ in given.values()}
    places: dict[str, list[int]] = {}
    for index, key in enumerate(keys):
        places.setdefault(key, []).append(index)
    for key, name in claims:
        for index in places.get(key, ()):
            if index in given:
                continue
            if name in names:
                why.setdefault(index, f"{name} is taken")
            else:
                given[index] = (name, 1.0, how)
                names.add(name)


def _with_names(
    skeleton: Skeleton, given: Mapping[int, tuple[str, float, str]], report: NamingReport, why: Mapping[int, str]
) -> tuple[Skeleton, NamingReport]:
    joints = skeleton.joints
    own = [joint.name if joint.convention is Convention.MARKER else joint.own_name for joint in joints]
    names = _fill_in({index: claim[0] for index, claim in given.items()}, own)

    def rename(index: int, joint: Joint) -> Joint:
        sure = given[index][1] if index in given else 1.0
        doubt = f"{sure:g}" if sure < DOUBTFUL else None
        return replace(joint, name=names[index], mapped=index in given, confidence=doubt)

    mapped = tuple(SureName(joints[index].source_name, *given[index]) for index in sorted(given))
    on_landmarks = dict(report.landmarks)
    unmapped = tuple(
        (joint.source_name, names[index], why.get(index, "not recognised"))
        for index, joint in enumerate(joints)
        if index not in given and joint.source_name not in on_landmarks
    )
    return with_roles(_renamed(skeleton, rename)), replace(report, named=mapped, unmapped=unmapped)


def with_roles(skeleton: Skeleton) -> Skeleton:
    """The skeleton with the role of every joint that has no name of MCML's, where words and the tree tell one."""
    if _is_markers(skeleton):
        return skeleton
    named = {index: joint.name for index, joint in enumerate(skeleton.joints) if joint.mapped}
    roles = find_roles(rig_of(skeleton), named)
    return _renamed(skeleton, lambda index, joint: replace(joint, role=roles.get(index)))


def _fill_in(given: Mapping[int, str], own: Sequence[str]) -> dict[int, str]:
    """Given names, and for the others their own, made unique against all before them and all given ones."""
    others = [index for index in range(len(own)) if index not in given]
    unique = unique_names([*given.values(), *(own[index] or "joint" for index in others)])
    return dict(given) | dict(zip(others, unique[len(given) :], strict=True))


def _renamed(skeleton: Skeleton, rename: Callable[[int, Joint], Joint]) -> Skeleton:
    return replace(skeleton, joints=tuple(rename(index, joint) for index, joint in enumerate(skeleton.joints)))


def _keys(skeleton: Skeleton) -> list[str]:
    """The normalised name of every joint: no namespace, no prefix that all of them share, no punctuation."""
    names = [_bare(joint.own_name) for joint in skeleton.joints]
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
    """Return the part of a name that is compared: without namespace, rig prefix, case and punctuation."""
    return _key(name)


@cache
def _mcml_only() -> frozenset[str]:
    """Return the names of Table 1 that no other rig uses; for names with sides, without those that others use."""
    shared = {f"{side}_{part}" for side in ("left", "right") for part in _SHARED}
    sided = {row.name for row in table() if row.name.startswith(("left_", "right_"))}
    return frozenset((sided | set(TRUNK[1:])) - shared)
