"""The poses and the motions of a library that are most like one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from heapq import nsmallest
from itertools import islice

import numpy as np

from mcml.motion.bodies.pose_index import Singles
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.language.reach import HeadPart
from mcml_service.xpath.library.bodies import Bodies
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.likeness import Asked, nearest_first
from mcml_service.xpath.library.listing import Scope
from mcml_service.xpath.nodes.numbering import Floats, Ints

_UNKNOWN_SECONDS = 1 / 30
"""Of a frame, where a document does not say: only for the distance between its hits."""


@dataclass(frozen=True)
class Hit:
    """first, last: frames from 1; of a pose the same. distance: in leg lengths."""

    listed: Listed
    first: int
    last: int
    distance: float


@dataclass(frozen=True)
class Found:
    """hits: the nearest first.

    documents: number of searched ones. unlike: names of documents that cannot be compared, because they share too few
    joints or their frame time is unknown.
    """

    hits: list[Hit]
    documents: int
    unlike: list[str]


def search(
    tx: Transaction,
    caches: Caches,
    scope: Scope,
    asked: Asked,
    *,
    wanted: int,
    apart: float,
    check: Callable[[], None],
) -> Found:
    """Find a number of frames, or frame ranges, that are most similar to the given pose or motion.

    apart: least distance in seconds between hits in one document, or between their ends. check: called often; raises
    when time is up.
    """
    documents: list[Listed] = []
    bounds: list[Floats] = []
    times: list[Floats] = []
    for group in scope.groups():
        bodies = Bodies(Forest(tx, group, caches, head_part=HeadPart.MOTION), check)
        index = bodies.pose_index()
        least = asked.least(index, bodies.seconds, bodies.frames)
        bounds.append(_of_documents(least, index.starts, index.ends))
        documents += group
        times.append(bodies.seconds)
    every = np.concatenate([np.empty(0), *bounds])
    seconds = np.nan_to_num(np.concatenate([np.empty(0), *times]), nan=_UNKNOWN_SECONDS)
    best: list[Hit] = []

    def limit() -> float:
        return best[-1].distance if len(best) == wanted else np.inf

    for near in nearest_first([every], limit):
        places = [place for _, place in near]
        some = [documents[place] for place in places]
        for listed, place, distances in zip(some, places, asked.unlike(tx, caches, some, check), strict=True):
            ends = islice(_apart(apart / seconds[place], distances, limit()), wanted)
            best += [Hit(listed, end + 1, end + 1, float(distances[end])) for end in ends]
        best[:] = nsmallest(wanted, best, key=lambda hit: hit.distance)
    hits = [_from_its_start(tx, caches, asked, hit) for hit in best]
    return Found(hits, len(documents), [documents[place].name for place in np.flatnonzero(np.isinf(every))])


def _of_documents(least: Singles, starts: Ints, ends: Ints) -> Floats:
    """The least number of the segments of each document, infinite where it has none."""
    found = np.full(len(ends), np.inf)
    some = np.flatnonzero(ends > starts)
    if len(some):
        found[some] = np.minimum.reduceat(least, starts[some])
    return found


def _apart(frames: float, distances: Floats, limit: float) -> Iterator[int]:
    """Frames (from 0) in order of their distance as far as a limit, none of them near one before.

    frames: how many lie between two at least.
    """
    around = max(1, round(min(frames, len(distances))))
    left = np.where(np.isnan(distances), np.inf, distances)
    while len(left):
        at = int(left.argmin())
        if left[at] == np.inf or left[at] > limit:
            return
        yield at
        left[max(0, at + 1 - around) : at + around] = np.inf


def _from_its_start(tx: Transaction, caches: Caches, asked: Asked, hit: Hit) -> Hit:
    (poses,) = caches.poses.read(tx, [hit.listed])
    return Hit(hit.listed, asked.began(poses, hit.last - 1) + 1, hit.last, hit.distance)
