"""BVH files of one motion with other trees: children in another order, helpers, other channels, bones of a game engine.

Independent of the product's reader and writer.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Values = NDArray[np.float64]
ROTATIONS = ["Zrotation", "Xrotation", "Yrotation"]
POSITIONS = ["Xposition", "Yposition", "Zposition"]


@dataclass
class Node:
    """A joint. values: (n, channels). ends: offsets of End Sites."""

    name: str
    offset: list[float]
    channels: list[str]
    values: Values
    children: list[Node] = field(default_factory=list)
    ends: list[list[float]] = field(default_factory=list)

    def walk(self) -> Iterator[Node]:
        yield self
        for child in self.children:
            yield from child.walk()

    def moves(self) -> bool:
        return any(channel.endswith("position") for channel in self.channels)


@dataclass
class Tree:
    root: Node
    seconds: float

    def still(self, name: str, offset: list[float], *children: Node, positions: bool = False) -> Node:
        """A joint that never turns."""
        count = len(self.root.values)
        values, channels = np.zeros((count, 3)), ROTATIONS
        if positions:
            values, channels = np.hstack([np.tile(offset, (count, 1)), values]), [*POSITIONS, *ROTATIONS]
        return Node(name, offset, list(channels), values, list(children))


def read_tree(text: str, most: int = 300) -> Tree:
    """most: frames."""
    tokens = text.split()
    order: list[Node] = []

    def node(at: int) -> tuple[Node, int]:
        brace = tokens.index("{", at)
        found = Node(" ".join(tokens[at + 1 : brace]), [], [], np.empty(0))
        order.append(found)
        at = brace + 1
        while tokens[at] != "}":
            word = tokens[at]
            if word == "OFFSET":
                found.offset, at = [float(token) for token in tokens[at + 1 : at + 4]], at + 4
            elif word == "CHANNELS":
                count = int(tokens[at + 1])
                found.channels, at = tokens[at + 2 : at + 2 + count], at + 2 + count
            elif word == "End":
                at = tokens.index("OFFSET", at)
                found.ends.append([float(token) for token in tokens[at + 1 : at + 4]])
                at += 5
            else:
                child, at = node(at)
                found.children.append(child)
        return found, at + 1

    root, at = node(1)
    count = int(tokens[at + 2])
    rows = np.array(tokens[at + 6 :], dtype=float).reshape(count, -1)[:most]
    column = 0
    for each in order:
        each.values = rows[:, column : column + len(each.channels)]
        column += len(each.channels)
    return Tree(root, float(tokens[at + 5]))


def write_tree(tree: Tree) -> str:
    lines = ["HIERARCHY"]

    def add(node: Node, word: str) -> None:
        lines.extend((f"{word} {node.name}", "{", "OFFSET " + " ".join(map(repr, map(float, node.offset)))))
        lines.append(f"CHANNELS {len(node.channels)} {' '.join(node.channels)}")
        for child in node.children:
            add(child, "JOINT")
        for end in node.ends:
            lines.extend(("End Site", "{", "OFFSET " + " ".join(map(repr, map(float, end))), "}"))
        lines.append("}")

    add(tree.root, "ROOT")
    rows = np.hstack([node.values for node in tree.root.walk()])
    lines += ["MOTION", f"Frames: {len(rows)}", f"Frame Time: {tree.seconds!r}"]
    return "\n".join([*lines, *(" ".join(f"{value:.9f}" for value in row) for row in rows)]) + "\n"


def add_fingers(tree: Tree, seed: int = 0) -> None:
    """Three fingers for each hand, of two joints that turn: index, thumb, little finger."""
    rng = np.random.default_rng(seed)
    time = np.arange(len(tree.root.values))[:, None] * tree.seconds
    for hand in [node for node in tree.root.walk() if node.name.endswith("_hand")]:
        side = 1.0 if hand.name.startswith("left") else -1.0
        hand.ends = []
        for finger, offset in (("two", [3 * side, -6, 3]), ("one", [side, -2, 5]), ("five", [-side, -5, -4])):
            name = hand.name.replace("_hand", f"_finger_{finger}")
            tip = tree.still(f"{name}_tip", [0.0, -3, 0])
            base = tree.still(name, offset, tip)
            tip.ends = [[0.0, -2, 0]]
            for node in (base, tip):
                node.values = 20 * np.sin(time * rng.uniform(2, 9, 3) + rng.uniform(0, 6, 3))
            hand.children.append(base)


def shuffle_children(tree: Tree, rng: random.Random) -> None:
    for node in tree.root.walk():
        rng.shuffle(node.children)


def change_orders(tree: Tree, rng: random.Random) -> None:
    """Other orders of rotations."""
    for node in tree.root.walk():
        at = [index for index, channel in enumerate(node.channels) if channel.endswith("rotation")]
        if len(at) != 3:
            continue
        turns = Rotation.from_euler("".join(node.channels[index][0] for index in at), node.values[:, at], degrees=True)
        order = "".join(rng.sample("XYZ", 3))
        node.values = node.values.copy()
        node.values[:, at] = np.degrees(np.unwrap(np.radians(turns.as_euler(order, degrees=True)), axis=0))
        for index, letter in zip(at, order, strict=True):
            node.channels[index] = f"{letter}rotation"


def insert_links(tree: Tree, rng: random.Random) -> None:
    """Joints that never turn between some joints and those above, on any side."""
    for node in list(tree.root.walk()):
        for place, child in enumerate(node.children):
            if rng.random() < 0.3 and not child.moves():
                node.children[place] = tree.still(f"{node.name}_to_{child.name}", child.offset, child)
                child.offset = [0.0, 0.0, 0.0]


def hang_twists(tree: Tree, rng: random.Random) -> None:
    """Twist helpers half-way to a child, before it."""
    for node in list(tree.root.walk()):
        if node.children and rng.random() < 0.4:
            half = [value / 2 for value in node.children[0].offset]
            node.children.insert(0, tree.still(f"{node.name}_twist", half))


def add_positions(tree: Tree, rng: random.Random) -> None:
    """Positions for all joints."""
    for node in tree.root.walk():
        if not node.moves():
            node.values = np.hstack([np.tile(node.offset, (len(node.values), 1)), node.values])
            node.channels = [*POSITIONS, *node.channels]


def add_engine_root(tree: Tree, rng: random.Random) -> None:
    """The root of Unreal Engine's mannequin, with targets of inverse kinematics beside the body."""

    def still(name: str, *children: Node, x: float = 0.0) -> Node:
        return tree.still(name, [x, 0.0, 0.0], *children, positions=True)

    below = [
        tree.root,
        still("ik_foot_root", still("ik_foot_l", x=10.0), still("ik_foot_r", x=-10.0)),
        still("ik_hand_root", still("ik_hand_gun", still("ik_hand_l"), still("ik_hand_r"))),
    ]
    rng.shuffle(below)
    tree.root = still("root", *below)


def add_prefix(tree: Tree, rng: random.Random) -> None:
    for node in tree.root.walk():
        node.name = f"Actor_01:{node.name}"


REWRITES: dict[str, Callable[[Tree, random.Random], None]] = {
    "children in another order": shuffle_children,
    "other orders of rotations": change_orders,
    "links": insert_links,
    "twist helpers": hang_twists,
    "positions of all joints": add_positions,
    "root of an engine": add_engine_root,
    "prefix": add_prefix,
}


def rewrite(tree: Tree, name: str, seed: int) -> str:
    """The text of a BVH of the same motion."""
    made = deepcopy(tree)
    REWRITES[name](made, random.Random(seed))
    return write_tree(made)
