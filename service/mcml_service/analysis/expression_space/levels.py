"""Levels of detail: the frames that represent all others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.fuzzy_means import fuzzy_means, top_memberships
from mcml_service.analysis.expression_space.neighbours import nearest
from mcml_service.analysis.expression_space.options import Options

Places = NDArray[np.int32]


@dataclass(frozen=True)
class Level:
    """candidates: (c,) frames, all different.

    wanted: the requested number. unique: different frames nearest to centres, before filling up. coverage: greatest
    distance of a frame to its nearest candidate, map units. objective: J of each iteration. members, shares: (n, 3)
    candidates, by their indices in `candidates`, and memberships. nearest: (n,) the candidate nearest to each frame.
    centres: (k, p) map; stands: (k,) the candidate that represents each.
    """

    candidates: Places
    wanted: int
    unique: int
    coverage: float
    objective: Array
    members: Places
    shares: Array
    nearest: Places
    centres: Array
    stands: Places


def level_sizes(frames: int, first: int) -> list[int]:
    """first, twice as many, and so on; the last level has every frame."""
    sizes = [first]
    while sizes[-1] < frames:
        sizes.append(2 * sizes[-1])
    return [min(size, frames) for size in sizes]


def farthest_order(points: Array, count: int, chosen: NDArray[np.integer] | None = None) -> Places:
    """Frames such that each is the farthest from those before it; the first is the nearest to the mean (5.4).

    points: (n, p). chosen: frames that are taken already and not repeated. Ties: the lowest number.
    """
    if chosen is None or not len(chosen):
        chosen = np.array([((points - points.mean(axis=0)) ** 2).sum(axis=1).argmin()])
        order = [int(chosen[0])]
    else:
        order = []
    apart = nearest(points[chosen], points)[0][:, 0] ** 2
    apart[chosen] = -1.0
    while len(order) < count:
        new = int(apart.argmax())
        order.append(new)
        gap = points - points[new]
        np.minimum(apart, np.einsum("np,np->n", gap, gap), out=apart)
        # Equal frames are at no distance too, but may be chosen still.
        apart[new] = -1.0
    return np.array(order[:count], dtype=np.int32)


def make_levels(points: Array, options: Options, sizes: list[int]) -> Iterator[Level]:
    """Levels from coarse to fine. points: (n, p) of the map in which frames are grouped."""
    order = farthest_order(points, max([size for size in sizes if size < len(points)], default=0))
    centres: Array | None = None
    for size in sizes:
        if size >= len(points):
            everything = np.arange(len(points), dtype=np.int32)
            ones = np.ones((len(points), 1))
            yield Level(
                everything, size, size, 0.0, np.empty(0), everything[:, None], ones, everything, points, everything
            )
        elif options.grouping == "fps":
            yield _level(points, order[:size], size, size, np.empty(0), points[order[:size]], options, order[:size])
        else:
            centres, objective = _centres(points, size, centres, options)
            near = _nearest_frames(points, centres)
            unique = np.array(list(dict.fromkeys(near.tolist())), dtype=np.int32)
            more = farthest_order(points, size - len(unique), unique) if len(unique) < size else unique[:0]
            candidates = np.concatenate([unique, more])
            yield _level(points, candidates, size, len(unique), objective, centres, options, near)


def _centres(points: Array, size: int, coarser: Array | None, options: Options) -> tuple[Array, Array]:
    if options.method == "paper":
        memberships = np.random.default_rng(options.seed).random((size, len(points)))
        memberships /= memberships.sum(axis=0)
        means = fuzzy_means(
            points,
            memberships=memberships,
            fuzziness=options.fuzziness,
            iterations=options.iterations,
            tolerance=1e-5,
            relative=False,
        )
    else:
        known = points[:0] if coarser is None else coarser
        more = size - len(known)
        if len(known):
            together = np.concatenate([known, points])
            added = together[farthest_order(together, more, np.arange(len(known)))]
        else:
            added = points[farthest_order(points, more)]
        means = fuzzy_means(
            points, np.concatenate([known, added]), fuzziness=options.fuzziness, iterations=options.iterations
        )
    return means.centres, means.objective


def _nearest_frames(points: Array, centres: Array) -> Places:
    """The frame nearest to each centre, of equally near ones the lowest."""
    frames = nearest(points, centres)[0][:, 0]
    near = np.empty(len(centres), dtype=np.int32)
    for start in range(0, len(centres), 100):
        part = slice(start, start + 100)
        gap = centres[part, None] - points[None]
        apart = np.sqrt(np.einsum("cnp,cnp->cn", gap, gap))
        near[part] = (apart <= frames[part, None] * (1 + 1e-12)).argmax(axis=1)
    return near


def _level(
    points: Array,
    candidates: Places,
    wanted: int,
    unique: int,
    objective: Array,
    centres: Array,
    options: Options,
    near: Places,
) -> Level:
    which, share = top_memberships(points, centres, options.fuzziness)
    # Several centres may have one nearest frame: the candidate that represents each centre.
    place = {frame: number for number, frame in enumerate(candidates.tolist())}
    stands = np.array([place[frame] for frame in near.tolist()], dtype=np.int32)
    apart, owner = (column[:, 0] for column in nearest(points[candidates], points))
    return Level(
        candidates=candidates,
        wanted=wanted,
        unique=unique,
        coverage=float(apart.max()),
        objective=objective,
        members=stands[which],
        shares=share,
        nearest=owner.astype(np.int32),
        centres=centres,
        stands=stands,
    )
