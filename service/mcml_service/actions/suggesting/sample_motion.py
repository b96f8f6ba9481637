"""A small sample of the bodies in motion of a library."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, zip_longest

import numpy as np

from mcml.motion.bodies.activities.signals import JOINTS
from mcml.motion.bodies.quantities import compute, joints_of, quantity_of
from mcml.motion.bodies.stretch import known
from mcml.motion.skeleton import Array
from mcml_service.clips.bodies import Body
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.listing import Scope
from mcml_service.xpath.limits import Limits

MOST_CLIPS = 32
MOST_FRAMES = 6000
"""Longer clips are not in a sample."""


@dataclass(frozen=True)
class MotionSample:
    """Clips of a library with their bodies. is_whole: False if the time was up before all clips were read."""

    clips: tuple[tuple[Listed, Body], ...]
    is_whole: bool

    @property
    def documents(self) -> list[str]:
        return [listed.uuid for listed, _ in self.clips]

    def choose_clip(self) -> str | None:
        """The clip whose body has most of the joints by which activities are recognised; None without clips."""
        best = max(self.clips, key=lambda clip: sum(name in JOINTS for name in clip[1].names), default=None)
        return None if best is None else best[0].uuid

    def values(self, name: str, arguments: Sequence[str]) -> list[Array]:
        """Known values of a quantity of bodies, in m, s and degrees, of each clip that has any."""
        needs = quantity_of(name, arguments).joints(arguments)
        found = []
        for _, body in self.clips:
            if all(known(each, body.names) is not None for each in needs):
                numbers = compute(name, arguments, body.stretch(joints_of(name, arguments, body.names)))
                found.append(numbers[~np.isnan(numbers)])
        return [numbers for numbers in found if len(numbers)]


def sample_motion(tx: Transaction, caches: Caches, project: str | None, limits: Limits) -> MotionSample:
    """Read the bodies of at most 32 visible clips, as many of each project as possible, spread evenly by name.

    limits: reading ends when its time is up. Raises NotFoundError for an unknown project.
    """
    listed = [one for one in Scope(tx, caches.listing, project=project).documents() if 0 < one.frames <= MOST_FRAMES]
    clips = []
    chosen = list(_spread_over_projects(listed))[:MOST_CLIPS]
    for one in chosen:
        if limits.over:
            break
        clips.append((one, caches.bodies.read(tx, [one])[0]))
    return MotionSample(tuple(clips), len(clips) == len(chosen))


def _spread_over_projects(listed: Sequence[Listed]) -> Iterator[Listed]:
    projects: dict[int, list[Listed]] = {}
    for one in listed:
        projects.setdefault(one.project, []).append(one)
    spread = [[every[place] for place in _places(len(every))] for every in projects.values()]
    return (one for one in chain.from_iterable(zip_longest(*spread)) if one is not None)


def _places(length: int) -> list[int]:
    """Places that are spread evenly, in an order in which the first ones are too: halves, then quarters."""
    count = min(length, MOST_CLIPS)
    even = [place * length // count for place in range(count)]
    return [even[place] for place in sorted(range(count), key=lambda place: int(f"{place:06b}"[::-1], 2))]
