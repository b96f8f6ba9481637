"""The program that evaluates an FBX file: joints, rest, and the world transform of each joint in each frame.

The Python layer of ufbx gives an element without taking a reference where it was given before, and an element that
outlives its scene crashes. So each list is read once, by index, and one process reads one file.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO

import ufbx

from mcml.motion.nodes import choose_joints, parents_among
from mcml.processes.scene_answer import (
    SEND,
    UnreadableError,
    WrittenRig,
    WrittenTake,
    check_motion,
    check_takes,
    run_program,
    write_scene,
)

_UNITS = ((0.01, "cm"), (1.0, "m"), (0.0254, "in"), (0.3048, "ft"), (0.001, "mm"), (0.1, "dm"))
_AXES = ("X", "-X", "Y", "-Y", "Z", "-Z", "")
_FRONT = 4


def main() -> None:
    """Read the standard input; see `mcml.processes.scene_answer`."""
    run_program(_evaluate)


def _evaluate(options: Mapping[str, Any], source: BinaryIO, target: BinaryIO) -> None:
    try:
        scene = ufbx.load_memory(source.read(), ignore_geometry=True, ignore_embedded=True)
    except ufbx.UfbxError as error:
        raise UnreadableError(
            f"the FBX file is damaged or cut off: {error}", "Send it whole, or save it again."
        ) from None
    nodes, clusters, stacks = (_once(each) for each in (scene.nodes, scene.skin_clusters, scene.anim_stacks))
    bound: dict[int, list[float]] = {}
    for cluster in clusters:
        bone = cluster.bone_node
        if bone is not None:
            bound.setdefault(bone.typed_id, _rows(cluster.bind_to_world))
    parents = [-1 if node.parent is None else node.parent.typed_id for node in nodes]
    bones = {number for number, node in enumerate(nodes) if node.bone is not None} | set(bound)
    joints = choose_joints(parents, bones)
    if not joints:
        raise UnreadableError(f"the file has no skeleton: {len(nodes)} nodes, none is a bone", SEND)
    check_takes(len(stacks), len(joints), options["takes"])
    rate = options["rate"] or scene.settings.frames_per_second
    takes = [
        WrittenTake(stack.name, 0, round((stack.time_end - stack.time_begin) * rate) + 1, rate) for stack in stacks
    ]
    check_motion(options, sum(take.frames for take in takes), len(joints), len(scene.blend_channels))
    shapes = [channel.name or f"shape_{place}" for place, channel in enumerate(_once(scene.blend_channels))]
    rig = WrittenRig(
        [nodes[node].name or f"node_{node}" for node in joints],
        parents_among(joints, parents),
        [_rows(nodes[node].node_to_world) for node in joints],
        [bound.get(node) for node in joints],
        shapes,
    )
    unit, up, notices = _facts(scene.settings)
    poses = _poses(scene, stacks, takes, joints) if options["poses"] else ()
    write_scene(target, [rig], takes, poses, unit=unit, up=up, notices=notices)


def _once(elements: Any) -> list[Any]:
    return [elements[index] for index in range(len(elements))]


def _rows(matrix: Any) -> list[float]:
    """The 12 numbers of a transform, row by row, of ufbx' columns."""
    return [column[axis] for axis in range(3) for column in matrix]


def _facts(settings: Any) -> tuple[str, str, list[str]]:
    """Unit, up axis, and notices."""
    notices = []
    metres = settings.unit_meters
    unit = next((name for size, name in _UNITS if abs(metres - size) < 1e-6 * size), "")
    if not unit:
        notices.append(f"the unit of the file is {metres:g} m, which has no name: the unit is not stated")
    up = _AXES[int(settings.axes.up)]
    if not up:
        notices.append("the file names no axes: Y is taken as up")
        up = "Y"
    elif int(settings.axes.front) != _FRONT:
        front = _AXES[int(settings.axes.front)]
        notices.append(f"the front axis of the file is {front}: programs that honour it show the motion turned")
    return unit, up, notices


def _poses(scene: Any, stacks: list[Any], takes: list[WrittenTake], joints: list[int]) -> Iterator[bytes]:
    """The numbers of each frame of each take."""
    for stack, take in zip(stacks, takes, strict=True):
        animation, begin = stack.anim, stack.time_begin
        for number in range(take.frames):
            posed = ufbx.evaluate_scene(scene, animation, begin + number / take.rate)
            # Held until all are read, and released before their scene.
            nodes, channels = _once(posed.nodes), _once(posed.blend_channels)
            numbers = array("d")
            for node in joints:
                numbers.extend(_rows(nodes[node].node_to_world))
            numbers.extend(channel.weight for channel in channels)
            del nodes, channels
            yield numbers.tobytes()
