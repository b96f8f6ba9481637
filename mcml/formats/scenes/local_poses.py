"""Transforms to the world made local: the motion of each joint in its parent. NumPy alone.

With P and Q the place and the rotation of a joint in the world, p its parent, T = Qp' (P - Pp) and L = Qp' Q. Q is the
orthogonal factor of the transform: of its polar decomposition (Higham, "Computing the polar decomposition", SIAM J.
Sci. Stat. Comput. 7, 1986), with the x axis flipped where the transform mirrors.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

ORTHOGONAL = 1e-12
"""Cosine between two axes below which they count as square to each other."""
FLAT = 1e-9
"""Length of an axis, of the longest, below which a transform has no rotation."""


def find_rotations(linear: Array, before: Array) -> tuple[Array, Array]:
    """The rotations (n, J, 3, 3) and scales (n, J, 3) of linear transforms (n, J, 3, 3).

    before: (J, 3, 3) rotations for a joint whose transform is flat, until one has a rotation.
    """
    mirrored = np.einsum("...i,...i->...", np.cross(linear[..., 0], linear[..., 1]), linear[..., 2]) < 0
    if mirrored.any():
        linear = linear.copy()
        linear[mirrored, :, 0] *= -1
    scales = np.sqrt(np.einsum("...ij,...ij->...j", linear, linear))
    longest = scales.max(axis=-1)
    flat = ~(scales.min(axis=-1) > FLAT * longest) & ~np.isnan(longest)
    safe = np.where(flat[..., None] | np.isnan(scales), 1.0, scales)
    rotations = linear / safe[..., None, :]
    x, y, z = rotations[..., 0], rotations[..., 1], rotations[..., 2]
    cosines = [np.abs(np.einsum("...i,...i->...", first, second)) for first, second in ((x, y), (y, z), (z, x))]
    oblique = (np.maximum.reduce(cosines) > ORTHOGONAL) & ~flat
    if oblique.any():
        left, _, right = np.linalg.svd(linear[oblique])
        rotations[oblique] = left @ right
    if flat.any():
        _hold(rotations, flat, before)
    return rotations, scales


def _hold(rotations: Array, flat: NDArray[np.bool_], before: Array) -> None:
    """Give flat transforms the rotation of the frame before."""
    extended = np.concatenate([before[None], rotations])
    frames = np.arange(len(extended))[:, None]
    source = np.where(np.vstack([np.zeros((1, flat.shape[1]), bool), flat]), 0, frames)
    np.maximum.accumulate(source, axis=0, out=source)
    rotations[:] = np.take_along_axis(extended, source[..., None, None], axis=0)[1:]


def make_local(places: Array, rotations: Array, parents: NDArray[np.intp]) -> tuple[Array, Array]:
    """Translations (n, J, 3) and rotations (n, J, 3, 3) of joints in their parents; of roots in the world."""
    translations, turned = places.copy(), rotations.copy()
    below = np.flatnonzero(parents >= 0)
    if len(below):
        above = np.swapaxes(rotations[:, parents[below]], -1, -2)
        away = places[:, below] - places[:, parents[below]]
        translations[:, below] = np.einsum("...ij,...j->...i", above, away)
        turned[:, below] = above @ rotations[:, below]
    return translations, turned
