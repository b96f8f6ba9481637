"""Build columns in advance: those of every first query, then those that queries used lately.

They are stored on disk (`disk/sidecar.py`), group by group, so that interrupted work can be continued.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeAlias

import orjson

from mcml.motion.bodies.quantities import QUANTITIES
from mcml.motion.skeleton import CHANNELS
from mcml_service.clips.bodies import MADE
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.language.reach import HeadPart
from mcml_service.xpath.library.bodies import Bodies
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.disk.sidecar import DAY
from mcml_service.xpath.library.forest import OF_BODIES, SAMPLES, Forest, name_samples
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.library.listing import Scope
from mcml_service.xpath.library.track_values import MOST_TRACKS, track_values
from mcml_service.xpath.nodes.numbering import Floats

Progress: TypeAlias = Callable[[int, int], None]
"""Called with how many steps are done, and of how many; may raise to end the work."""

LATELY = 30 * DAY
"""Columns that a query used within this time in seconds are built for new documents."""
COMMON_BONES = (
    "Root",
    "Head",
    *(
        f"{side}_{part}"
        for part in ("up_leg", "low_leg", "foot", "up_arm", "low_arm", "hand")
        for side in ("left", "right")
    ),
)
ROTATIONS = tuple(CHANNELS.index(channel) for channel in ("Rx", "Ry", "Rz"))
TRANSLATIONS = tuple(CHANNELS.index(channel) for channel in ("Tx", "Ty", "Tz"))
COMMON_QUANTITIES = (
    *(("height", bone) for bone in ("Head", "left_hand", "right_hand", "left_foot", "right_foot")),
    ("activity", "walk"),
    ("contact", "left"),
    *(("speed", bone) for bone in ("left_hand", "right_hand")),
    *(("angle", name) for name in ("left-knee-flexion", "right-knee-flexion")),
)
"""With an activity come all, and with the contacts of a foot those of the other one."""
BASE = (*(f"head {part.name}" for part in HeadPart), "shapes", "labels", "ids", "tracks", "ends")
"""The columns on disk that do not depend on a bone."""


def prepare_columns(database: Database, caches: Caches, progress: Progress = lambda done, of: None) -> None:
    """Build the missing columns of all groups of documents until the file on disk is full.

    caches: of this work alone; they do not note its reads as queries.
    """
    sidecar = caches.sidecar
    if sidecar is None:
        return
    uses = sidecar.last_uses()
    sidecar.last_use = lambda name: uses.get(name, 0)
    columns = wanted_columns(uses, time.time())
    groups = lasting_groups(database, caches)
    for step in range(2 * len(groups)):
        progress(step, 2 * len(groups))
        if sidecar.trouble or sidecar.room() <= 0:
            return
        with database.read() as tx:
            if step < len(groups):
                _build_base(tx, caches, groups[step])
            else:
                _build_samples(tx, caches, groups[step - len(groups)], columns)
        sidecar.flush()


def prepare_bodies(database: Database, caches: Caches, progress: Progress = lambda done, of: None) -> None:
    """Build the indexes of poses, and quantities of bodies, of all groups. For documents whose bodies are stored."""
    sidecar = caches.sidecar
    uses = {} if sidecar is None else sidecar.last_uses()
    if sidecar is not None:
        sidecar.last_use = lambda name: uses.get(name, 0)
    quantities = wanted_quantities(uses, time.time())
    with database.read() as tx:
        groups = Scope(tx, caches.listing).groups()
    for number, group in enumerate(groups):
        progress(number, len(groups))
        with database.read() as tx:
            bodies = Bodies(Forest(tx, group, caches, head_part=HeadPart.MOTION), _never)
            bodies.pose_index()
            if group.lasting and sidecar is not None and sidecar.room() > 0:
                _ = bodies.facts(), bodies.seconds
                for name, *arguments in quantities:
                    bodies.quantity(name, tuple(arguments))
        if sidecar is not None:
            sidecar.flush()


def count_prepared(database: Database, caches: Caches) -> tuple[int, int]:
    """Count the groups of documents that have all columns of first queries on disk, and all groups."""
    sidecar = caches.sidecar
    groups = lasting_groups(database, caches)
    if sidecar is None:
        return 0, len(groups)
    return sum(sidecar.names(group.fingerprint).issuperset(BASE) for group in groups), len(groups)


def lasting_groups(database: Database, caches: Caches) -> list[Group]:
    """Return the groups of all documents whose columns are kept on disk."""
    with database.read() as tx:
        return [group for group in Scope(tx, caches.listing).groups() if group.lasting]


def wanted_columns(uses: Mapping[str, int], now: float) -> list[tuple[str, int]]:
    """Return the columns of samples to build: those used lately, the newest first, then those of common bones.

    uses: time of the last use of each part on disk. now: seconds since 1970.
    """
    lately = sorted((used, name) for name, used in uses.items() if name.startswith(SAMPLES) and used > now - LATELY)
    asked = [tuple(orjson.loads(name.removeprefix(SAMPLES))) for _, name in reversed(lately)]
    common = [
        (bone, channel)
        for bone in COMMON_BONES
        for channel in (*ROTATIONS, *(TRANSLATIONS if bone == COMMON_BONES[0] else ()))
    ]
    return list(dict.fromkeys([*((bone, channel) for bone, channel in asked if bone is not None), *common]))


def wanted_quantities(uses: Mapping[str, int], now: float) -> list[tuple[str, ...]]:
    """Return the quantities of bodies to build, each with its arguments: those used lately and common ones."""
    lately = sorted((used, name) for name, used in uses.items() if name.startswith(OF_BODIES) and used > now - LATELY)
    keys = [tuple(orjson.loads(name.removeprefix(OF_BODIES))) for _, name in reversed(lately)]
    asked = [tuple(key[1:]) for key in keys if key[0] == str(MADE) and key[1] in QUANTITIES]
    return list(dict.fromkeys([*asked, *COMMON_QUANTITIES]))


def _build_base(tx: Transaction, caches: Caches, group: Group) -> None:
    """Build what does not depend on a bone."""
    missing = set(BASE) - _names(caches, group)
    for part in HeadPart:
        if f"head {part.name}" in missing:
            _ = Forest(tx, group, caches, head_part=part).head
    forest = Forest(tx, group, caches, head_part=HeadPart.MOTION)
    for name in missing.intersection(("shapes", "labels", "ids", "tracks")):
        getattr(forest, name)
    if "ends" in missing:
        _ = forest.tracks


def _build_samples(tx: Transaction, caches: Caches, group: Group, columns: list[tuple[str, int]]) -> None:
    """Build columns of samples, all of one bone together."""
    kept = _names(caches, group)
    missing: dict[str, list[int]] = defaultdict(list)
    for bone, channel in columns:
        if name_samples((bone, channel)) not in kept:
            missing[bone].append(channel)
    if not missing:
        return
    forest = Forest(tx, group, caches, head_part=HeadPart.MOTION)
    for bone, channels in missing.items():
        tracks = forest.bone_columns(bone)
        if len(tracks) <= MOST_TRACKS:
            values = track_values(forest, tracks.table, tuple(channels))
            for channel, samples in zip(channels, values, strict=True):
                forest.samples(bone, channel, partial(_same, samples))


def _same(samples: Floats) -> Floats:
    return samples


def _never() -> None:
    """No query waits for this work."""


def _names(caches: Caches, group: Group) -> set[str]:
    return set() if caches.sidecar is None else caches.sidecar.names(group.fingerprint)
