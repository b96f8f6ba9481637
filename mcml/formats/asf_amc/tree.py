"""The :hierarchy of an ASF file: bones to a tree of joints."""

from __future__ import annotations

from dataclasses import dataclass

from mcml.errors import FormatError, LimitError, Notice, Place
from mcml.formats.format import Limits, note
from mcml.formats.text.lines import shown
from mcml.motion.skeleton import Convention, Joint, Skeleton, Triple


@dataclass(frozen=True, slots=True)
class Word:
    text: str
    at: Place


@dataclass
class Bone:
    """One bone of :bonedata, or the root, as read."""

    at: Place
    name: str = ""
    id: str | None = None
    direction: Triple | None = None
    length: str | None = None
    axis: Triple | None = None
    axis_order: str = ""
    channels: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    bodymass: str | None = None
    cofmass: str | None = None
    position: Triple | None = None


def build_skeleton(
    root: Bone, bones: list[Bone], hierarchy: list[list[Word]], limits: Limits, notices: list[Notice]
) -> Skeleton:
    """Bones in pre-order of the hierarchy. FormatError: unknown bones, two parents, cycles, bones left over."""
    index_of: dict[str, int] = {}
    for number, bone in enumerate(bones):
        if bone.name in index_of:
            raise FormatError(f"bone {bone.name!r} is defined twice", at=bone.at, remedy="Give it another name.")
        index_of[bone.name] = number
    children = _children(index_of, len(bones), hierarchy)
    order: list[int] = []
    parents: list[int] = []
    stack = [(number, 0, 1) for number in reversed(children[-1])]
    while stack:
        number, parent, depth = stack.pop()
        if depth > limits.depth:
            raise LimitError(f"bones are nested too deep: more than {limits.depth}", at=bones[number].at)
        order.append(number)
        parents.append(parent)
        stack += [(child, len(order), depth + 1) for child in reversed(children[number])]
    if len(order) < len(bones):
        _report_unreachable(bones, children, set(order))
    joints = [_root(root)]
    joints += [_joint(bones[number], parent, notices) for number, parent in zip(order, parents, strict=True)]
    place = {number: index + 1 for index, number in enumerate(order)}
    declared = (0, *(place[number] for number in range(len(bones))))
    return Skeleton(tuple(joints), () if declared == tuple(range(len(joints))) else declared)


def _children(index_of: dict[str, int], count: int, hierarchy: list[list[Word]]) -> dict[int, list[int]]:
    """Children of each bone in their order; those of the root under -1."""
    folded = {name.lower(): number for name, number in index_of.items()}
    children: dict[int, list[int]] = {number: [] for number in range(-1, count)}
    has_parent = [False] * count

    def find(word: Word) -> int:
        if word.text in index_of:
            return index_of[word.text]
        if word.text.lower() == "root":
            return -1
        if word.text.lower() not in folded:
            raise FormatError(
                f"hierarchy: unknown bone {shown(word.text)}",
                at=word.at,
                remedy="Define it in :bonedata, or remove it here.",
            )
        return folded[word.text.lower()]

    for words in hierarchy:
        parent = find(words[0])
        for word in words[1:]:
            child = find(word)
            if child < 0:
                raise FormatError("hierarchy: the root has a parent", at=word.at)
            if has_parent[child]:
                raise FormatError(
                    f"bone {shown(word.text)} has two parents", at=word.at, remedy="Name it once as a child."
                )
            has_parent[child] = True
            children[parent].append(child)
    return children


def _report_unreachable(bones: list[Bone], children: dict[int, list[int]], reached: set[int]) -> None:
    """Raises FormatError: a bone without parent, or else a cycle (every bone in it has one)."""
    with_parent = {child for own in children.values() for child in own}
    for number, bone in enumerate(bones):
        if number not in reached and number not in with_parent:
            raise FormatError(
                f"bone {bone.name!r} is not in the hierarchy", at=bone.at, remedy="Name it as a child of another bone."
            )
    # Every bone left has a parent that is left: walking up must come around.
    parent_of = {child: parent for parent, own in children.items() for child in own}
    number = next(number for number in range(len(bones)) if number not in reached)
    seen: set[int] = set()
    while number not in seen:
        seen.add(number)
        number = parent_of[number]
    raise FormatError(f"hierarchy: cycle at {bones[number].name!r}", at=bones[number].at)


def _root(root: Bone) -> Joint:
    return Joint(
        name="root",
        parent=-1,
        source_name="root",
        convention=Convention.FIXED,
        channels=root.channels,
        rotation_order="".join(channel[1].upper() for channel in root.channels if channel[0] == "R"),
        offset=root.position,
        axis=root.axis,
        axis_order=root.axis_order,
    )


def _joint(bone: Bone, parent: int, notices: list[Notice]) -> Joint:
    return Joint(
        name=bone.name,
        parent=parent,
        source_name=bone.name,
        convention=Convention.FIXED,
        channels=bone.channels,
        rotation_order=_rotation_order(bone, notices),
        direction=bone.direction,
        length=bone.length,
        axis=bone.axis,
        axis_order=bone.axis_order,
        limits=bone.limits,
        bodymass=bone.bodymass,
        cofmass=bone.cofmass,
        id=bone.id,
    )


def _rotation_order(bone: Bone, notices: list[Notice]) -> str:
    """The order of application: that of dof where all three are given, else that of axis."""
    letters = "".join(channel[1].upper() for channel in bone.channels if channel[0] == "R")
    axis = bone.axis_order.upper() or "XYZ"
    if len(letters) == 3:
        if letters != axis:
            note(
                notices, "guess", f"bone {bone.name!r}: dof order {letters} and axis order {axis} differ; dof is taken"
            )
        return letters
    return "".join(letter for letter in axis if letter in letters)
