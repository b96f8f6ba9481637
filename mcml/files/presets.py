"""Presets of exports: the format, the unit and the axes that each program reads best.

docs/tasks/convert.md lists them with the documentation of the programs that they rest on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.errors import ConversionError, Notice, UnsupportedError
from mcml.formats import SKINNED, WRITERS
from mcml.formats.format import note
from mcml.formats.missing_facts import guess_unit, guess_up
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import scale, turn_up
from mcml.motion.frames import rows_of
from mcml.motion.guesses import stated_up
from mcml.motion.hub import HubReader, walked
from mcml.motion.rotations import IDENTITY
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.solving.marker_skeleton import has_markers
from mcml.motion.units import metres_of, metres_per_unit, reading_of


@dataclass(frozen=True)
class Shape:
    """How clips leave for a program.

    format: a name of `WRITERS`. unit, up: of its numbers, None to leave them. fps: frames a second, None to keep the
    rate of the clip.
    """

    format: str
    unit: str | None = None
    up: str | None = None
    fps: float | None = None


@dataclass(frozen=True)
class Preset:
    """A program that clips are exported for.

    bodies, markers: the shapes of clips of joints and of clips of markers. why: the reason in one sentence.
    """

    name: str
    title: str
    bodies: Shape
    markers: Shape
    why: str


_SCENE = Shape("glb", "m", "Y")

PRESETS: dict[str, Preset] = {
    preset.name: preset
    for preset in (
        Preset(
            "blender", "Blender", Shape("bvh", "m", "Y"), _SCENE,
            "Blender imports BVH as an armature with Y up and takes its numbers as metres; markers arrive by glTF.",
        ),
        Preset(
            "unreal", "Unreal Engine", _SCENE, _SCENE,
            "Unreal's Interchange imports the skeleton, the skin and the animation of glTF, and turns metres into cm.",
        ),
        Preset(
            "unity", "Unity", _SCENE, _SCENE,
            "Unity reads no BVH; its package glTFast imports glTF, in metres with Y up.",
        ),
        Preset("godot", "Godot", _SCENE, _SCENE, "Godot recommends glTF, in metres with Y up."),
        Preset(
            "maya", "Maya", Shape("usd", "cm", "Y"), Shape("usd", "cm", "Y"),
            "Maya reads no BVH; its USD plug-in imports skeletons, and Maya works in centimetres with Y up.",
        ),
        Preset(
            "motionbuilder", "MotionBuilder", Shape("bvh", "cm", "Y"), Shape("c3d", "mm"),
            "MotionBuilder imports BVH with numbers in centimetres and Y up, and markers as C3D.",
        ),
        Preset(
            "opensim", "OpenSim", Shape("mot"), Shape("trc", "m", "Y"),
            "OpenSim reads joint angles as MOT, and markers as TRC in metres with Y up.",
        ),
        Preset(
            "vrm", "VRM avatars", Shape("vrma", fps=30.0), Shape("vrma", fps=30.0),
            "VRM Animation moves any avatar in VRM; its specification suggests 30 frames a second.",
        ),
        Preset(
            "amass", "AMASS (SMPL)", Shape("smpl"), Shape("smpl"),
            "Programs for AMASS read axis-angles of SMPL's joints from NPZ, in metres with Z up.",
        ),
    )
}  # fmt: skip
"""Every preset, by its name."""


def find_preset(name: str) -> Preset:
    """Return a preset. Raises UnsupportedError, with all names, for an unknown one."""
    if name not in PRESETS:
        raise UnsupportedError(f"No preset is called {name!r}.", remedy=f"Use one of: {', '.join(PRESETS)}.")
    return PRESETS[name]


def choose_format(preset: Preset | None, format: str | None, *, character: bool) -> str | None:
    """Return the stated format of an export. For a body with a skin that the preset's own format cannot hold, it is the
    one of its scenes, if it has any; None leaves it to the preset."""
    if format is not None or not character or preset is None:
        return format
    return next((shape.format for shape in (preset.bodies, preset.markers) if shape.format in SKINNED), None)


def choose_shape(preset: Preset, skeleton: Skeleton, format: str | None = None) -> Shape:
    """Return the shape in which a clip leaves for a program.

    format: of the user, which wins. Raises UnsupportedError for a format in which documents are neither scaled nor
    turned.
    """
    if format in ("mcml", "csv", "original"):
        raise UnsupportedError(
            f"Presets such as {preset.name!r} change no {format} files.", remedy="Leave out `for`, or the format."
        )
    shape = preset.markers if has_markers(skeleton) else preset.bodies
    return shape if format is None else Shape(format, shape.unit, shape.up, shape.fps)


def fit_shape(clip: ClipStream, shape: Shape, preset: Preset, *, guesses: bool = True) -> ClipStream:
    """Return the clip with the unit and the up axis of a shape; a notice names them.

    A unit or an axis that the document does not state is guessed with a notice, if its body is a person's, else left.
    guesses: False refuses to, with ConversionError.
    """
    head, notices = clip.head, clip.notices
    metres, up = metres_of(head), stated_up(head)
    missing = ["unit"] if shape.unit and metres is None else []
    missing += ["up axis"] if shape.up and up is None else []
    if missing and not guesses:
        raise ConversionError(
            f"The document states no {' and no '.join(missing)}, and guesses are not wanted.",
            remedy="State them with `unit` and `up`, or allow guesses.",
        )
    if missing:
        places, told = _first_places(clip), list[Notice]()
        if "unit" in missing:
            metres = guess_unit(head, places, told, f"{preset.title} takes them as {shape.unit}")
        if "up axis" in missing:
            up = guess_up(head, places, told, preset.title)
        # Writers of scenes describe what stays unknown themselves.
        describes = bool(WRITERS[find_catalogue_name(shape.format)].assumes)
        notices += [notice for notice in told if notice.kind == "guess" or not describes]
    if shape.unit and metres is not None:
        clip = scale(clip, metres / metres_per_unit(shape.unit), unit=shape.unit)
    if shape.up and up is not None:
        clip = turn_up(clip, up, shape.up)
    note(notices, "note", _describe(shape, preset, metres, up))
    return clip


def find_catalogue_name(target: str) -> str:
    """Return the name in `WRITERS` of a format or of one of its parts, such as "asf"."""
    if target in WRITERS:
        return target
    return next(name for name, writer in WRITERS.items() if target in [part.name for part in writer.parts])


def _describe(shape: Shape, preset: Preset, metres: float | None, up: str | None) -> str:
    choices = [WRITERS[find_catalogue_name(shape.format)].label]
    choices += [f"lengths in {shape.unit}"] if shape.unit and metres is not None else []
    choices += [f"{shape.up} up"] if shape.up and up is not None else []
    choices += [f"{shape.fps:g} frames a second"] if shape.fps else []
    return f"for {preset.title}: {', '.join(choices)}"


def _first_places(clip: ClipStream) -> Array:
    """(J, 3) joints in the first frame, or at rest without frames."""
    skeleton = clip.head.skeleton
    hub = HubReader(skeleton, reading_of(clip.head))
    block = next((block for block in clip.blocks() if len(block)), None)
    if block is None:
        translations, rotations = hub.rest.offsets[None], np.tile(IDENTITY, (1, len(skeleton), 1))
    else:
        pose = hub.read(rows_of(block, 0, 1))
        translations, rotations = pose.translations, pose.rotations
    factor = float(clip.head.fields.get("scale_factor", "1"))
    places: Array = factor * walked(skeleton, translations, rotations)[0][0]
    return places
