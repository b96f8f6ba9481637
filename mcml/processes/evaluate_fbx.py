"""The program that evaluates an FBX file: joints, rest, and the world transform of each joint in each frame."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO

import ufbx

from mcml.processes.fbx_scene import AXES, FbxScene, list_once, rows_of
from mcml.processes.scene_answer import (
    WrittenTake,
    check_motion,
    check_takes,
    run_program,
    write_scene,
)

_UNITS = ((0.01, "cm"), (1.0, "m"), (0.0254, "in"), (0.3048, "ft"), (0.001, "mm"), (0.1, "dm"))
_FRONT = 4
_STILL = "the file has a character and no animation: the only frame is its rest pose"


def main() -> None:
    """Read the standard input; see `mcml.processes.scene_answer`."""
    run_program(_evaluate)


def _evaluate(options: Mapping[str, Any], source: BinaryIO, target: BinaryIO) -> None:
    read = FbxScene(source, geometry=False)
    scene, stacks, joints = read.scene, read.stacks, read.joints
    is_still = not stacks and bool(read.clusters)
    check_takes(len(stacks) + is_still, len(joints), options["takes"])
    rate = options["rate"] or scene.settings.frames_per_second
    takes = [
        WrittenTake(stack.name, 0, round((stack.time_end - stack.time_begin) * rate) + 1, rate) for stack in stacks
    ]
    if is_still:
        takes = [WrittenTake("", 0, 1, rate, [_STILL])]
    check_motion(options, sum(take.frames for take in takes), len(joints), len(scene.blend_channels))
    channels = list_once(scene.blend_channels)
    shapes = [channel.name or f"shape_{place}" for place, channel in enumerate(channels)]
    rig = read.rig(shapes)
    unit, up, notices = _facts(scene.settings)
    poses = iter([_pose(read.nodes, channels, joints)]) if is_still else _poses(scene, stacks, takes, joints)
    write_scene(target, [rig], takes, poses if options["poses"] else (), unit=unit, up=up, notices=notices)


def _facts(settings: Any) -> tuple[str, str, list[str]]:
    """Unit, up axis, and notices."""
    notices = []
    metres = settings.unit_meters
    unit = next((name for size, name in _UNITS if abs(metres - size) < 1e-6 * size), "")
    if not unit:
        notices.append(f"the unit of the file is {metres:g} m, which has no name: the unit is not stated")
    up = AXES[int(settings.axes.up)]
    if not up:
        notices.append("the file names no axes: Y is taken as up")
        up = "Y"
    elif int(settings.axes.front) != _FRONT:
        front = AXES[int(settings.axes.front)]
        notices.append(f"the front axis of the file is {front}: programs that honour it show the motion turned")
    return unit, up, notices


def _poses(scene: Any, stacks: list[Any], takes: list[WrittenTake], joints: list[int]) -> Iterator[bytes]:
    """The numbers of each frame of each take."""
    for stack, take in zip(stacks, takes, strict=True):
        animation, begin = stack.anim, stack.time_begin
        for number in range(take.frames):
            posed = ufbx.evaluate_scene(scene, animation, begin + number / take.rate)
            numbers = _pose(list_once(posed.nodes), list_once(posed.blend_channels), joints)
            posed.free()
            yield numbers


def _pose(nodes: list[Any], channels: list[Any], joints: list[int]) -> bytes:
    """The numbers of one frame."""
    numbers = array("d")
    for node in joints:
        numbers.extend(rows_of(nodes[node].node_to_world))
    numbers.extend(channel.weight for channel in channels)
    return numbers.tobytes()
