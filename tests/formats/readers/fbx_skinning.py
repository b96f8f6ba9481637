"""A program that prints where ufbx itself puts the vertices of the first skinned mesh of an FBX file.

Its input is the file, its argument the number of frames. It prints the corners of each face, vertices by number, and
in each frame the places of these vertices in the world, as JSON.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

import ufbx


def main() -> None:
    scene: Any = ufbx.load_memory(sys.stdin.buffer.read())
    frames, held = int(sys.argv[1]), []
    number = next(index for index in range(len(scene.meshes)) if len(scene.meshes[index].skin_deformers))
    stack, rate = scene.anim_stacks[0], scene.settings.frames_per_second
    faces: list[list[int]] = []
    places = []
    for frame in range(frames):
        posed: Any = ufbx.evaluate_scene(scene, stack.anim, stack.time_begin + frame / rate, evaluate_skinning=True)
        mesh = posed.meshes[number]
        instance = mesh.instances[0]
        held += [posed, mesh, instance]
        values, indices = mesh.skinned_position.values, mesh.vertex_indices
        if not faces:
            for face in (mesh.faces[index] for index in range(len(mesh.faces))):
                begin = face.index_begin
                faces.append([indices[corner] for corner in range(begin, begin + face.num_indices)])
        matrix = instance.geometry_to_world
        found = []
        for index in range(mesh.num_vertices):
            point = values[index]
            if mesh.skinned_is_local:
                point = [
                    sum(getattr(matrix, f"c{column}")[axis] * point[column] for column in range(3)) + matrix.c3[axis]
                    for axis in range(3)
                ]
            found.append([float(value) for value in point])
        places.append(found)
    sys.stdout.write(json.dumps({"faces": faces, "places": places}))
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
