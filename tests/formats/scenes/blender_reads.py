"""Run by Blender: where the bones of GLB files are in every frame. Arguments: a JSON file with what to read.

It holds a list of {"path", "times", "out"}; `out` becomes an array of float64, (n, B, 3) in metres with Z up, and
beside it, as `out` with `.json`, the names of the bones and the extents (2, 3) of the mesh in the last frame.
"""

import json
import sys

import bpy
import numpy as np


def read(path, times, out):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # Debian's Blender 3.4 stumbles over its own NumPy where shading is taken from normals.
    bpy.ops.import_scene.gltf(filepath=path, import_shading="FLAT")
    (armature,) = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    (body,) = [item for item in bpy.data.objects if item.type == "MESH" and item.find_armature()]
    scene = bpy.context.scene
    rate = scene.render.fps
    names = [bone.name for bone in armature.pose.bones]
    found = np.empty((len(times), len(names), 3))
    for row, time in enumerate(times):
        frame = int(time * rate)
        scene.frame_set(frame, subframe=time * rate - frame)
        for column, bone in enumerate(armature.pose.bones):
            found[row, column] = armature.matrix_world @ bone.head
    shown = body.evaluated_get(bpy.context.evaluated_depsgraph_get())
    corners = np.array([shown.matrix_world @ vertex.co for vertex in shown.data.vertices])
    np.save(out, found)
    with open(out + ".json", "w") as stream:
        json.dump({"names": names, "extents": [corners.min(axis=0).tolist(), corners.max(axis=0).tolist()]}, stream)


with open(sys.argv[-1]) as stream:
    for asked in json.load(stream):
        read(**asked)
