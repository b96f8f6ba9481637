"""USD: a UsdSkel skeleton, its animation, and a visible body. Needs the extra `usd`.

The stage states `metersPerUnit` and `upAxis` as the document does, else by a guess; numbers are the source's. One time
code a frame.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from mcml.errors import ConversionError, UnsupportedError
from mcml.formats.colours import to_linear
from mcml.formats.format import FileKind
from mcml.formats.scenes.body import Body, body_of
from mcml.formats.scenes.scene import TIPS
from mcml.formats.scenes.stage import Stage, look_through, turn_to_y
from mcml.formats.target_names import legal_names
from mcml.motion.clip import ClipStream
from mcml.motion.rotations import to_matrix

_MOST = 5_000_000
"""Places of joints, over all frames, that the library is given at once."""
_BLOCK = 1 << 20
_CENTIMETRE = 0.01
_LETTERS = frozenset("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_0123456789")


class _NotIdentifiers:
    """Characters that are illegal in USD names: all except ASCII letters and digits, and `_`."""

    def __contains__(self, character: object) -> bool:
        return character not in _LETTERS


class Usd:
    """The formats `usd` (binary) and `usda` (text); see `mcml.formats.format.Writer`."""

    convention = None
    bodies, markers = True, True
    needs = frozenset({"frame_time"})
    assumes = "cm"

    def __init__(self, name: str, title: str, extensions: tuple[str, ...]) -> None:
        self.name = name
        self.title = title
        self.label = "USD" if name == "usd" else "USD (text)"
        self.parts = (FileKind(name, extensions, "Skeleton, motion and a simple body"),)
        self.media_type = "model/vnd.usda" if name == "usda" else "model/vnd.usd"

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        try:
            import pxr  # noqa: F401  # asks whether it is installed
        except ImportError:
            raise UnsupportedError(
                "USD needs a library that is not installed.",
                remedy="Install the extra: pip install 'mcml-repository[usd]'.",
            ) from None
        stage = look_through(clip, "USD", "`metersPerUnit` is 0.01, USD's own default")
        if stage.frames * len(stage.skeleton) > _MOST:
            raise ConversionError(
                f"{stage.frames} frames of {len(stage.skeleton)} joints are more than USD is written of at once",
                remedy=f"Export a part, `first` and `last`: no more than {_MOST // len(stage.skeleton)} frames.",
            )
        return _write(stage, text=part == "usda")


def _write(stage: Stage, *, text: bool) -> Iterator[bytes]:
    # The stage owns its layer.
    scene = _scene(stage)
    with tempfile.TemporaryDirectory(prefix="mcml-usd-") as folder:
        path = Path(folder) / f"scene.{'usda' if text else 'usdc'}"
        scene.GetRootLayer().Export(str(path))
        del scene
        with path.open("rb") as stream:
            while block := stream.read(_BLOCK):
                yield block


def _scene(clip: Stage) -> Any:
    """The stage with everything in it."""
    from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt

    skeleton = clip.skeleton
    stage = Usd.Stage.CreateInMemory()
    # USD's up axis is Y or Z: other axes are rotated below. Both are always written, because USD's checker requires
    # them.
    UsdGeom.SetStageUpAxis(stage, "Z" if clip.up == "Z" else "Y")
    UsdGeom.SetStageMetersPerUnit(stage, _CENTIMETRE if clip.metres is None else clip.metres)
    stage.SetTimeCodesPerSecond(1 / clip.seconds)
    stage.SetFramesPerSecond(1 / clip.seconds)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(max(0, clip.frames - 1))
    root = UsdSkel.Root.Define(stage, "/Clip")
    stage.SetDefaultPrim(root.GetPrim())
    if clip.up not in (None, "Y", "Z"):
        x, y, z, w = turn_to_y(clip.up).tolist()
        root.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(w, x, y, z))
    if not len(skeleton):
        return stage
    bones = UsdSkel.Skeleton.Define(stage, "/Clip/Skeleton")
    bones.CreateJointsAttr(_paths(clip))
    bones.CreateJointNamesAttr([joint.name for joint in skeleton.joints])
    if clip.tips:
        # As text: custom data of USD has no lists of lists.
        bones.GetPrim().SetCustomDataByKey(TIPS, json.dumps([(joint, tip.tolist()) for joint, tip in clip.tips]))
    rest = np.tile(np.eye(4), (len(skeleton), 1, 1))
    rest[:, 3, :3] = clip.rest
    body = body_of(clip)
    bind = rest.copy()
    # Matrices of USD are for rows.
    bind[:, :3, :3] = to_matrix(body.turns).transpose(0, 2, 1)
    bind[:, 3, :3] = body.places
    bones.CreateRestTransformsAttr(Vt.Matrix4dArray.FromNumpy(rest))
    bones.CreateBindTransformsAttr(Vt.Matrix4dArray.FromNumpy(bind))
    _add_animation(stage, bones, clip)
    _add_body(stage, bones, body)
    return stage


def _paths(clip: Stage) -> list[str]:
    """Each joint's name behind those above it; the original names are in `jointNames`."""
    digits = "0123456789"
    names = legal_names(clip.skeleton, _NotIdentifiers(), digits, (), clip.clip.notices, "USD")
    paths: list[str] = []
    for name, joint in zip(names, clip.skeleton.joints, strict=True):
        paths.append(f"{paths[joint.parent]}/{name}" if joint.parent >= 0 else name)
    return paths


def _add_animation(stage: Any, bones: Any, clip: Stage) -> None:
    from pxr import UsdSkel, Vt

    animation = UsdSkel.Animation.Define(stage, "/Clip/Skeleton/Motion")
    binding = UsdSkel.BindingAPI.Apply(bones.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    animation.CreateJointsAttr(bones.GetJointsAttr().Get())
    places, turns = animation.CreateTranslationsAttr(), animation.CreateRotationsAttr()
    count = len(clip.skeleton)
    animation.CreateScalesAttr(Vt.Vec3hArray.FromNumpy(np.ones((count, 3), dtype=np.float16)))
    still = np.zeros((count, 4), dtype=np.float32)
    still[:, 3] = 1.0
    places.Set(Vt.Vec3fArray.FromNumpy(clip.rest.astype(np.float32)))
    turns.Set(Vt.QuatfArray.FromNumpy(still))
    frame = 0
    for translations, rotations in clip.blocks():
        moved, turned = translations.astype(np.float32), rotations.astype(np.float32)
        for row in range(len(moved)):
            if clip.moving.any():
                places.Set(Vt.Vec3fArray.FromNumpy(moved[row]), frame)
            if clip.turning.any():
                turns.Set(Vt.QuatfArray.FromNumpy(turned[row]), frame)
            frame += 1


def _add_body(stage: Any, bones: Any, body: Body) -> None:
    """Its points are in the source's axes, as the joints carry them in the pose that it is bound in."""
    from pxr import Gf, UsdGeom, UsdSkel, Vt

    mesh = UsdGeom.Mesh.Define(stage, "/Clip/Body")
    points = body.points.astype(np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray([3] * len(body.faces)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(body.faces.astype(np.int32).reshape(-1)))
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(np.stack([points.min(axis=0), points.max(axis=0)])))
    if body.colours is None:
        mesh.CreateDisplayColorAttr([Gf.Vec3f(0.36, 0.55, 0.78)])
    else:
        colours = Vt.Vec3fArray.FromNumpy(to_linear(body.colours).astype(np.float32))
        mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex).Set(colours)
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([bones.GetPath()])
    width = body.joints.shape[1]
    joints, weights = body.joints.astype(np.int32).reshape(-1), body.weights.astype(np.float32).reshape(-1)
    binding.CreateJointIndicesPrimvar(False, width).Set(Vt.IntArray.FromNumpy(joints))
    binding.CreateJointWeightsPrimvar(False, width).Set(Vt.FloatArray.FromNumpy(weights))
    if body.normals is not None:
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(body.normals.astype(np.float32)))
        mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d(1.0))
