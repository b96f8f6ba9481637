"""Trees of nodes as lists of parents, and which nodes are joints. Plain Python, for programs that start often."""

from __future__ import annotations

from collections.abc import Sequence, Set

from mcml.errors import FormatError, LimitError


def sort_by_tree(parents: Sequence[int], depth: int) -> list[int]:
    """The nodes of a forest, each before its children and with its whole subtree behind it.

    parents: of each node, -1 at a root; siblings stay in their order. depth: the most levels. Raises FormatError for
    a cycle, LimitError for too many levels.
    """
    children: dict[int, list[int]] = {}
    for node, parent in enumerate(parents):
        children.setdefault(parent, []).append(node)
    order: list[int] = []
    waiting = [(node, 1) for node in reversed(children.get(-1, []))]
    while waiting:
        node, level = waiting.pop()
        if level > depth:
            raise LimitError(f"joints are nested more than {depth} deep", remedy="Remove joints without motion.")
        order.append(node)
        waiting += [(child, level + 1) for child in reversed(children.get(node, []))]
    if len(order) != len(parents):
        lost = min(set(range(len(parents))) - set(order))
        raise FormatError(f"node {lost} is among its own ancestors", remedy="Save the file with another program.")
    return order


def choose_joints(parents: Sequence[int], bones: Set[int]) -> list[int]:
    """The joints among the nodes of a file: its bones, and every node between two of them. Sorted.

    parents: of each node, -1 at a root, without cycles. bones: the nodes that are bones or that a skin names.
    """
    chosen = set(bones)
    for bone in bones:
        way: list[int] = []
        node = parents[bone]
        while node >= 0:
            way.append(node)
            if node in bones:
                chosen.update(way)
                break
            node = parents[node]
    return sorted(chosen)


def parents_among(joints: Sequence[int], parents: Sequence[int]) -> list[int]:
    """The parent of each joint as its place among the joints; -1 where no node above is one."""
    place = {joint: index for index, joint in enumerate(joints)}
    found = []
    for joint in joints:
        node = parents[joint]
        while node >= 0 and node not in place:
            node = parents[node]
        found.append(place.get(node, -1))
    return found
