"""Scenes read in a process of their own, for libraries that damaged files may crash.

The numbers of the answer (`mcml.processes.scene_answer`) stay on the disk and are mapped into memory.
"""

from __future__ import annotations

import json
from functools import partial
from typing import Any, BinaryIO

import numpy as np

from mcml.errors import FormatError, LimitError, Notice
from mcml.formats.format import Limits, ReadOptions, SourceFile
from mcml.formats.scenes.scene import MOST_TAKES, REMEDY, Rig, Scene, Take, read_tips
from mcml.motion.frames import Rows
from mcml.motion.nodes import sort_by_tree
from mcml.motion.skeleton import Array
from mcml.processes.programs import run_reader
from mcml.processes.scene_answer import MEMORY, SECONDS

_POSE = 12


def read_apart(module: str, file: SourceFile, options: ReadOptions) -> Scene:
    """The scene that a program makes of a file. Raises FormatError and LimitError."""
    with _run(module, file, options, poses=True) as answer:
        head = read_head(answer)
        start = answer.tell()
        values = (answer.seek(0, 2) - start) // 8
        sizes = [take["frames"] * _count(head["rigs"][take["rig"]]) for take in head["takes"]]
        if values != sum(sizes):
            raise FormatError("the file is damaged: its reader ended early", remedy="Save it again.")
        numbers = np.memmap(answer, np.float64, "r", start, (values,)) if values else np.empty(0)
    return _make_scene(head, numbers, options.limits)


_FACE = "the file has no skeleton: the nodes of its blend shapes are taken as joints"


def _count(rig: dict[str, Any]) -> int:
    """How many numbers a frame has."""
    return _POSE * len(rig["names"]) + len(rig["shapes"])


def list_takes_apart(module: str, file: SourceFile, options: ReadOptions) -> list[str]:
    """The names of the takes of a file, without their poses. Raises FormatError and LimitError."""
    with _run(module, file, options, poses=False) as answer:
        return [take["name"] for take in read_head(answer)["takes"]]


def _run(module: str, file: SourceFile, options: ReadOptions, *, poses: bool) -> BinaryIO:
    limits = options.limits
    facts = {"rate": options.rate, "takes": MOST_TAKES, "poses": poses}
    facts |= {"joints": limits.joints, "frames": limits.frames, "values": limits.values}
    return run_reader(module, json.dumps(facts), stream=file.stream, seconds=SECONDS, memory=MEMORY)


def read_head(answer: BinaryIO) -> dict[str, Any]:
    """Return the first line of an answer. Raises FormatError or LimitError where it holds an error."""
    head: dict[str, Any] = json.loads(answer.readline())
    if "error" in head:
        kind = LimitError if head["kind"] == "limit" else FormatError
        raise kind(head["error"], remedy=head["remedy"] or None)
    return head


def _make_scene(head: dict[str, Any], numbers: Array, limits: Limits) -> Scene:
    orders = [sort_by_tree(rig["parents"], limits.depth) for rig in head["rigs"]]
    parts = []
    at = 0
    for take in head["takes"]:
        count = _count(head["rigs"][take["rig"]])
        parts.append(numbers[at : at + count * take["frames"]].reshape(take["frames"], count))
        at += parts[-1].size
    moving = [_find_moving(number, head, parts) for number in range(len(orders))]
    rigs = [make_rig(*each, limits) for each in zip(head["rigs"], orders, moving, strict=True)]
    faces = [rig["face"] for rig in head["rigs"]]
    if any(face and not len(shapes) for face, shapes in zip(faces, moving, strict=True)):
        raise FormatError("the file has no skeleton: no node is a bone, and no blend shape moves", remedy=REMEDY)
    takes = []
    for take, frames in zip(head["takes"], parts, strict=True):
        limits.check_name(take["name"])
        rig, order, shapes = rigs[take["rig"]], orders[take["rig"]], moving[take["rig"]]
        split = _POSE * len(rig)
        poses = partial(_read_frames, frames[:, :split], order)
        weights = partial(_read_weights, frames[:, split:], shapes) if len(shapes) else None
        notices = _notices([*take["notices"], *([_FACE] if faces[take["rig"]] else [])])
        takes.append(Take(take["name"], rig, take["frames"], take["rate"], poses, notices, weights=weights))
    return Scene(tuple(takes), head["unit"], head["up"], _notices(head["notices"]), 8 * at)


def _find_moving(rig: int, head: dict[str, Any], parts: list[Array]) -> Rows:
    """The blend shapes of a rig whose weight changes within its takes, or from one to another."""
    facts = head["rigs"][rig]
    own = [part for part, take in zip(parts, head["takes"], strict=True) if take["rig"] == rig and len(part)]
    if not facts["shapes"] or not own:
        return np.empty(0, np.intp)
    split = _POSE * len(facts["names"])
    low = np.min([part[:, split:].min(axis=0) for part in own], axis=0)
    high = np.max([part[:, split:].max(axis=0) for part in own], axis=0)
    return np.flatnonzero(high != low)


def _notices(sentences: list[str]) -> tuple[Notice, ...]:
    return tuple(Notice("note", sentence) for sentence in sentences)


def _read_frames(poses: Array, order: list[int], first: int, end: int) -> Array:
    return np.array(poses[first:end]).reshape(end - first, len(order), 3, 4)[:, order]


def _read_weights(weights: Array, shapes: Rows, first: int, end: int) -> Array:
    return np.array(weights[first:end])[:, shapes]


def make_rig(rig: dict[str, Any], order: list[int], moving: Rows, limits: Limits) -> Rig:
    for name in (*rig["names"], *rig["shapes"]):
        limits.check_name(name)
    place = {joint: index for index, joint in enumerate(order)}
    parents = [place.get(rig["parents"][joint], -1) for joint in order]
    default = np.array([rig["rest"][joint] for joint in order], np.float64).reshape(-1, 3, 4)
    bound = [rig["bound"][joint] for joint in order]
    names = tuple(rig["names"][joint] for joint in order)
    return Rig(
        names,
        np.array(parents, np.intp),
        _find_rest(default, bound, parents),
        tuple(rig["shapes"][shape] for shape in moving),
        tuple((place[joint], tip) for joint, tip in _read_tips(rig["tips"]) if joint in place),
    )


def _read_tips(text: str) -> list[tuple[int, Array]]:
    """Tips of bones with their joints, as numbered in the file; nothing for a text that is no such list."""
    try:
        pairs = json.loads(text) if text else []
    except (ValueError, RecursionError):
        return []
    fit = [pair for pair in pairs if isinstance(pair, list) and len(pair) == 2] if isinstance(pairs, list) else []
    return [(joint, tip) for joint, value in fit if isinstance(joint, int) for tip in read_tips([value])]


def _find_rest(default: Array, bound: list[list[float] | None], parents: list[int]) -> Array:
    """(J, 3, 4) in the world: where a skin was bound; of other joints where the file has them in their parents."""
    rest = default.copy()
    for joint, parent in enumerate(parents):
        found = bound[joint]
        if found is not None:
            rest[joint] = np.reshape(found, (3, 4))
        elif parent >= 0:
            rest[joint] = multiply_affine(rest[parent], multiply_affine(invert_affine(default[parent]), default[joint]))
    return rest


def multiply_affine(first: Array, second: Array) -> Array:
    """The product of two affine transforms (3, 4)."""
    return np.column_stack([first[:, :3] @ second[:, :3], first[:, :3] @ second[:, 3] + first[:, 3]])


def invert_affine(matrix: Array) -> Array:
    """The inverse of an affine transform (3, 4); a flat one has a pseudo-inverse."""
    linear = np.linalg.pinv(matrix[:, :3])
    return np.column_stack([linear, -linear @ matrix[:, 3]])
