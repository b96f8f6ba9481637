"""Morph targets of glTF: the blend shapes of a mesh, by the names that most programs write.

Source: glTF 2.0 specification, section 3.7.2.2, Khronos Group 2021; names are in `extras.targetNames` of the mesh, as
its implementation note says.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mcml.errors import FormatError
from mcml.formats.gltf.document import DAMAGED, Document, as_number, as_numbers
from mcml.motion.skeleton import Array


@dataclass(frozen=True, eq=False)
class Morphs:
    """The morph targets of a node. weights: (n,) of the node or its mesh, where no animation changes them."""

    names: tuple[str, ...]
    weights: Array


def read_morphs(document: Document) -> dict[int, Morphs]:
    """Return the morph targets of each node whose mesh has some. Raises FormatError for damaged ones."""
    meshes = document.items("meshes")
    found: dict[int, Morphs] = {}
    for number, node in enumerate(document.items("nodes")):
        if "mesh" not in node:
            continue
        place = as_number(node["mesh"], "mesh")
        if place >= len(meshes):
            raise FormatError(f"node {number} names mesh {place}, which there is not", remedy=DAMAGED)
        mesh = meshes[place]
        count = _count_targets(mesh)
        if count:
            stated = node.get("weights", mesh.get("weights", [0] * count))
            weights = as_numbers(stated, count, f"the weights of node {number}")
            found[number] = Morphs(_names(mesh, place, count), weights)
    return found


def _count_targets(mesh: dict[str, Any]) -> int:
    primitives = mesh.get("primitives", [])
    for primitive in primitives if isinstance(primitives, list) else []:
        targets = primitive.get("targets") if isinstance(primitive, dict) else None
        if isinstance(targets, list) and targets:
            return len(targets)
    return 0


def _names(mesh: dict[str, Any], place: int, count: int) -> tuple[str, ...]:
    extras = mesh.get("extras")
    told = extras.get("targetNames") if isinstance(extras, dict) else None
    told = told if isinstance(told, list) else []
    own = mesh.get("name")
    stem = own if isinstance(own, str) and own.strip() else f"mesh_{place}"
    names = [told[index] if index < len(told) else None for index in range(count)]
    return tuple(
        name if isinstance(name, str) and name.strip() else f"{stem}_target_{index}" for index, name in enumerate(names)
    )
