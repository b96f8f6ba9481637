"""Thumbnails of random figures, and what they say, for the studio's reader."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from mcml.motion.pictures.figures import Figure
from mcml.motion.pictures.thumbnails import draw
from tests import thumbnails


def cases(seeds: range) -> list[dict[str, Any]]:
    return [_case(seed) for seed in seeds]


def _case(seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    points, loop, scrub = int(rng.integers(2, 30)), int(rng.integers(1, 20)), int(rng.integers(1, 12))
    markers, face = seed % 3 == 1, seed % 4 == 2
    bones = () if markers else tuple((int(rng.integers(0, one)), one) for one in range(1, points))
    sides = tuple(int(side) for side in rng.integers(0, 3, points))
    figure = Figure(tuple(range(points)), bones, sides, None if markers else 0, face=face, markers=markers)
    poses = rng.normal(size=(loop + scrub, points, 3)) * [40, 80, 20]
    poses[..., 0] += np.cumsum(rng.normal(3, 9, loop + scrub))[:, None]
    content = draw(figure, poses[:loop], poses[loop:], float(rng.uniform(0, 3)), np.eye(3))
    found = thumbnails.read(content)
    exact = np.frombuffer(content, np.uint8)[20 + 3 * len(bones) :][: loop * points * 2].reshape(loop, points * 2)
    away = ((exact - exact.mean(axis=0)) ** 2).sum(axis=1)
    ends = found.loop[:, found.bones[:, 1], 1].mean(axis=0) if len(bones) else np.empty(0)
    return {
        "bytes": base64.b64encode(content).decode(),
        "face": found.face,
        "markers": found.markers,
        "bones": found.bones.tolist(),
        "loop": found.loop.tolist(),
        "scrub": found.scrub.tolist(),
        "ground": found.ground.tolist(),
        "seconds": found.seconds,
        "aspect": found.aspect,
        "step": found.step,
        "farthest": np.flatnonzero(away >= away.max() - 1e-6).tolist(),
        "highest": found.bones[ends <= ends.min() + 1e-9, 1].tolist() if len(bones) else [-1],
    }
