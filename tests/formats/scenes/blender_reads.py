"""Run by Blender: where the bones of files are in every frame. Arguments: a JSON file with what to read.

It holds a list of {"path", "rate", "frames", "out"}; `out` becomes an array of float64, (n, B, 3) in metres with Z up,
and beside it, as `out` with `.json`, the names of the bones and the extents (2, 3) of the mesh in the last frame, null
without one.
"""

import json
import sys

import bpy
import numpy as np


def _open(path):
    """Open a file; return the time code of its first frame."""
    if path.endswith(".bvh"):
        bpy.ops.import_anim.bvh(filepath=path, update_scene_fps=True, update_scene_duration=True)
        return 1
    if path.endswith((".usd", ".usda", ".usdc")):
        bpy.ops.wm.usd_import(filepath=path)
        return bpy.context.scene.frame_start
    # Debian's Blender 3.4 stumbles over its own NumPy where shading is taken from normals.
    bpy.ops.import_scene.gltf(filepath=path, import_shading="FLAT")
    return 0


def read(path, rate, frames, out):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    # Keys of glTF are placed by the rate of the scene: at whole frames, so that none is rounded.
    scene.render.fps = max(1, round(rate))
    scene.render.fps_base = scene.render.fps / rate
    first = _open(path)
    (armature,) = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    names = [bone.name for bone in armature.pose.bones]
    found = np.empty((frames, len(names), 3))
    for row in range(frames):
        scene.frame_set(first + row)
        for column, bone in enumerate(armature.pose.bones):
            found[row, column] = armature.matrix_world @ bone.head
    np.save(out, found)
    extents = None
    bodies = [item for item in bpy.data.objects if item.type == "MESH" and item.find_armature()]
    if bodies:
        shown = bodies[0].evaluated_get(bpy.context.evaluated_depsgraph_get())
        corners = np.array([shown.matrix_world @ vertex.co for vertex in shown.data.vertices])
        extents = [corners.min(axis=0).tolist(), corners.max(axis=0).tolist()]
    with open(out + ".json", "w") as stream:
        json.dump({"names": names, "extents": extents}, stream)


with open(sys.argv[-1]) as stream:
    for asked in json.load(stream):
        read(**asked)
