"""The program that evaluates a USD file: the joints of each UsdSkel skeleton, at rest and in each frame."""

from __future__ import annotations

import tempfile
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from mcml.motion.nodes import sort_by_tree
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
_ENDINGS = ((b"PXR-USDC", ".usdc"), (b"PK\x03\x04", ".usdz"), (b"#usda", ".usda"))
_DEPTH = 512
_MOST_TEXT = 1 << 20


def main() -> None:
    """Read the standard input; see `mcml.processes.scene_answer`."""
    run_program(_evaluate)


def _evaluate(options: Mapping[str, Any], source: BinaryIO, target: BinaryIO) -> None:
    from pxr import Tf, Usd, UsdGeom, UsdSkel

    with tempfile.TemporaryDirectory(prefix="mcml-usd-") as folder:
        data = source.read()
        ending = next((ending for mark, ending in _ENDINGS if data.startswith(mark)), ".usd")
        path = Path(folder) / f"scene{ending}"
        path.write_bytes(data)
        del data
        try:
            _check_alone(path)
            stage = Usd.Stage.Open(str(path))
        except Tf.ErrorException:
            # Its words name a file of this machine and a line of the library.
            raise UnreadableError("the USD file is damaged or cut off", "Save it again.") from None
        skeletons = _skeletons(stage, UsdSkel)
        if not skeletons:
            raise UnreadableError("the file has no skeleton: no UsdSkel skeleton with joints", SEND)
        check_takes(len(skeletons), 0, options["takes"])
        unit, up, notices = _facts(stage, UsdGeom)
        _write(options, target, stage, skeletons, (unit, up, notices))


def _check_alone(path: Path) -> None:
    """Raises UnreadableError where the layer names other files: none is opened."""
    from pxr import Sdf

    if path.suffix == ".usdz":
        return
    layer = Sdf.Layer.FindOrOpen(str(path))
    if layer is None:
        raise UnreadableError("the USD file is damaged or cut off", "Save it again.")
    others = [name for name in layer.GetCompositionAssetDependencies() if name]
    if others:
        raise UnreadableError(
            f"the file needs {others[0][:100]!r}, and other files are not opened",
            "Flatten the stage (usdcat --flatten), and send the result.",
        )


def _skeletons(stage: Any, skel: Any) -> list[Any]:
    """The query of each skeleton that has joints, or blend shapes that its animation moves."""
    from pxr import Usd

    cache = skel.Cache()
    found = []
    every = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
    for prim in stage.Traverse(every):
        if prim.IsA(skel.Root):
            cache.Populate(skel.Root(prim), every)
    for prim in stage.Traverse(every):
        if prim.IsA(skel.Skeleton):
            query = cache.GetSkelQuery(skel.Skeleton(prim))
            if query and (len(query.GetJointOrder()) or _shapes_of(query)):
                found.append(query)
    return found


def _facts(stage: Any, geometry: Any) -> tuple[str, str, list[str]]:
    metres = geometry.GetStageMetersPerUnit(stage)
    unit = next((name for size, name in _UNITS if abs(metres - size) < 1e-6 * size), "")
    notices = [] if unit else [f"the unit of the file is {metres:g} m, which has no name: the unit is not stated"]
    return unit, str(geometry.GetStageUpAxis(stage)), notices


def _write(
    options: Mapping[str, Any],
    target: BinaryIO,
    stage: Any,
    skeletons: list[Any],
    facts: tuple[str, str, list[str]],
) -> None:
    rigs: list[WrittenRig] = []
    takes: list[WrittenTake] = []
    spans, orders = [], []
    codes = stage.GetTimeCodesPerSecond()
    rate = options["rate"] or codes
    for number, query in enumerate(skeletons):
        parents, joints = _tree(query)
        order = sort_by_tree(parents, _DEPTH)
        place = {joint: index for index, joint in enumerate(order)}
        names = [joints[joint] for joint in order]
        above = [place.get(parents[joint], -1) for joint in order]
        shapes = _shapes_of(query)
        begin, end, notices = _span(query)
        count = int((end - begin) * rate / codes + 1e-6) + 1
        check_motion(options, count + sum(take.frames for take in takes), len(order), len(shapes))
        rest = _world(query, None)
        face = not len(query.GetJointOrder())
        tips = str(query.GetPrim().GetCustomDataByKey("mcml_tips") or "")[:_MOST_TEXT]
        rigs.append(WrittenRig(names, above, [rest[joint] for joint in order], [None] * len(order), shapes, face, tips))
        takes.append(WrittenTake(str(query.GetPrim().GetPath()), number, count, rate, notices))
        spans.append((begin, codes / rate))
        orders.append(order)
    unit, up, notices = facts
    counts = [len(rig.shapes) for rig in rigs]
    poses = _poses(skeletons, takes, spans, orders, counts) if options["poses"] else ()
    write_scene(target, rigs, takes, poses, unit=unit, up=up, notices=notices)


def _tree(query: Any) -> tuple[list[int], list[str]]:
    """The parent of each joint, and the joints; of a face without joints the skeleton itself stands for its head."""
    joints = [str(joint) for joint in query.GetJointOrder()]
    if not joints:
        return [-1], [str(query.GetPrim().GetName())]
    return [int(parent) for parent in query.GetTopology().GetParentIndices()], joints


def _span(query: Any) -> tuple[float, float, list[str]]:
    """The first and the last time code of the motion, and notices."""
    animation = query.GetAnimQuery()
    samples = list(animation.GetJointTransformTimeSamples()) if animation else []
    if animation and _shapes_of(query):
        samples = sorted({*samples, *animation.GetBlendShapeWeightTimeSamples()})
    if not samples:
        why = "the animation has no time samples" if animation else "the skeleton has no animation"
        return 0.0, 0.0, [f"{why}: one frame is read"]
    return float(samples[0]), float(samples[-1]), []


def _shapes_of(query: Any) -> list[str]:
    """The names of the blend shapes that the animation of a skeleton moves."""
    animation = query.GetAnimQuery()
    if not animation or not len(animation.GetBlendShapeWeightTimeSamples()):
        return []
    return [str(name) for name in animation.GetBlendShapeOrder()]


def _weights(query: Any, time: float, count: int) -> list[float]:
    weights = query.GetAnimQuery().ComputeBlendShapeWeights(time)
    if weights is None or len(weights) != count:
        raise UnreadableError(f"the animation has no weights of its {count} blend shapes", "Save the file again.")
    return [float(weight) for weight in weights]


def _world(query: Any, time: float | None) -> list[list[float]]:
    """Of each joint 12 numbers, its transform to the world row by row; time: None for the rest pose."""
    from pxr import Usd, UsdGeom

    moment = Usd.TimeCode.EarliestTime() if time is None else Usd.TimeCode(time)
    cache = UsdGeom.XformCache(moment)
    local = cache.GetLocalToWorldTransform(query.GetPrim())
    if not len(query.GetJointOrder()):
        found = [local]
    elif time is None:
        found = [matrix * local for matrix in query.ComputeJointSkelTransforms(moment, True)]
    else:
        found = query.ComputeJointWorldTransforms(cache)
    if not found:
        raise UnreadableError("the transforms of the skeleton cannot be computed", "Save the file again.")
    # Row vectors, so the transforms stand transposed.
    return [[matrix[column][row] for row in range(3) for column in range(4)] for matrix in found]


def _poses(
    skeletons: list[Any],
    takes: list[WrittenTake],
    spans: list[tuple[float, float]],
    orders: list[list[int]],
    shapes: list[int],
) -> Iterator[bytes]:
    for query, take, (begin, step), order, count in zip(skeletons, takes, spans, orders, shapes, strict=True):
        for number in range(take.frames):
            world = _world(query, begin + number * step)
            numbers = array("d")
            for joint in order:
                numbers.extend(world[joint])
            if count:
                numbers.extend(_weights(query, begin + number * step, count))
            yield numbers.tobytes()
