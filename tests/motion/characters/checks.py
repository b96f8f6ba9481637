"""What every figure is: closed, right side out, near its bones, and with its joints in the middle of its limbs."""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from mcml.motion.hub import rest_of
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.skin import Character

SIDES = ("left", "right")
LIMBS = {"arm": ("up_arm", "low_arm"), "leg": ("up_leg", "low_leg", "foot")}


def check_mesh(made: Character) -> None:
    """Closed parts, each of the kind of a sphere, whose faces and normals look outwards."""
    assert 1500 <= len(made.faces) <= 6000
    edges = Counter((int(a), int(b)) for face in made.faces for a, b in zip(face, np.roll(face, -1), strict=True))
    assert max(edges.values()) == 1, "two faces run along an edge the same way"
    assert all((b, a) in edges for a, b in edges), "an edge has a face on one side alone"
    for part in parts_of(made.faces, len(made.points)):
        faces = made.faces[np.isin(made.faces[:, 0], part)]
        assert len(part) - len(faces) / 2 == 2, "not of the kind of a sphere"
        a, b, c = (made.points[faces[:, corner]] - made.points[part].mean(axis=0) for corner in range(3))
        assert np.einsum("ni,ni->n", a, np.cross(b, c)).sum() > 0, "inside out"
    assert np.allclose(np.linalg.norm(made.normals, axis=1), 1)
    across = np.cross(
        made.points[made.faces[:, 1]] - made.points[made.faces[:, 0]],
        made.points[made.faces[:, 2]] - made.points[made.faces[:, 0]],
    )
    assert (np.linalg.norm(across, axis=1) > 0).all(), "a face without area"
    toward = np.einsum("tki,ti->tk", made.normals[made.faces], across)
    assert (toward > 0).mean() > 0.98


def check_weights(made: Character, skeleton: Skeleton) -> None:
    assert (made.weights >= 0).all()
    assert np.allclose(made.weights.sum(axis=1), 1, atol=1e-12)
    assert made.joints.min() >= 0
    assert made.joints.max() < len(skeleton)
    first = np.argsort(-made.weights, axis=1, kind="stable")[:, 0]
    assert (first == 0).all(), "the largest weight is the first"


def check_limbs(
    made: Character,
    skeleton: Skeleton,
    positions: Array,
    rotations: Array,
    size: float,
    reach: float = 0.14,
    loose: float = 1e-6,
) -> None:
    """In any pose the rings at elbows and knees have the joint in their middle, and no vertex leaves its bones."""
    moved = made.move(positions, rotations)
    assert np.isfinite(moved).all()
    names = list(skeleton.names)
    for side in SIDES:
        for joint in (names.index(f"{side}_low_arm"), names.index(f"{side}_low_leg")):
            ring = ring_at(made, skeleton, joint)
            away = np.linalg.norm(moved[:, ring].mean(axis=1) - positions[:, joint], axis=1)
            assert away.max() < loose * size, f"{names[joint]}: {away.max() / size:.2g}"
    tips = rest_of(skeleton).tips
    ends_of = [positions[:, [joint]] + rotate(rotations[:, [joint]], vector) for joint, vector in tips]
    every = np.concatenate([positions, *ends_of], axis=1)
    lines = [(joint, len(skeleton) + number) for number, (joint, _) in enumerate(tips)]
    lines += [(parent, index) for index, parent in enumerate(skeleton.parents.tolist()) if parent >= 0]
    starts, ends = (every[:, [line[end] for line in lines]] for end in (0, 1))
    along = ends - starts
    square = np.maximum(np.einsum("nbi,nbi->nb", along, along), 1e-12)
    for frame in range(len(moved)):
        from_start = moved[frame][:, None] - starts[frame]
        part = np.clip(np.einsum("vbi,bi->vb", from_start, along[frame]) / square[frame], 0, 1)
        nearest = np.linalg.norm(from_start - part[..., None] * along[frame], axis=2).min(axis=1)
        assert nearest.max() < reach * size, f"a vertex is {nearest.max() / size:.3f} from every bone"


def ring_at(made: Character, skeleton: Skeleton, joint: int) -> NDArray[np.intp]:
    """Vertices that follow a joint and the one above it alike, in the plane through it."""
    parent = skeleton.joints[joint].parent
    pair = np.sort(made.joints[:, :2], axis=1)
    half = np.isclose(made.weights[:, 0], 0.5) & np.isclose(made.weights[:, 1], 0.5)
    found = np.flatnonzero(half & (pair == sorted((joint, parent))).all(axis=1))
    assert len(found) >= 8
    return found


def parts_of(faces: NDArray[np.int64], count: int) -> list[NDArray[np.intp]]:
    """The vertices of each connected part."""
    part = np.arange(count)
    while True:
        least = part[faces].min(axis=1)
        grown = part.copy()
        np.minimum.at(grown, faces.ravel(), np.repeat(least, 3))
        if (grown == part).all():
            return [np.flatnonzero(part == each) for each in np.unique(part)]
        part = grown
