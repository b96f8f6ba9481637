"""Search the library for poses or motions similar to a given one: from a document, a file that is not stored, or
positions of joints.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from mcml.errors import LimitError, McmlError, NotFoundError, RequestError
from mcml.files.edit_header import checked_axis
from mcml.files.gather_files import gathered
from mcml.files.import_options import ImportOptions
from mcml.files.open_clip import offering, open_clip
from mcml.formats.format import SourceFile
from mcml.language.elements import to_head
from mcml.motion.bodies.clip_body import body_at, body_of
from mcml.motion.bodies.poses import FEWEST, JOINTS, NEEDS, ORIGIN, pose_features
from mcml.motion.clip import ClipHead, FrameBlock
from mcml.motion.frames import rows_of
from mcml.motion.markers import marker_skeleton
from mcml_schemas.querying.search import MOST_FRAMES, SearchAnswer, SearchHit
from mcml_service.clips.bodies import Body, read_bodies
from mcml_service.settings import Settings
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.likeness import Asked
from mcml_service.xpath.library.listing import Scope
from mcml_service.xpath.library.motion_notes import named
from mcml_service.xpath.library.search import search
from mcml_service.xpath.limits import Limits

MOST_READ = 100_000
"""Limit of frames of a file, of which some are used."""


@dataclass(frozen=True)
class Where:
    """The searched documents, and the number of hits.

    apart: seconds between hits in one document, None: 1, or the length of the motion.
    """

    documents: tuple[str, ...]
    project: str | None
    limit: int
    apart: float | None


def ask_document(tx: Transaction, stored: StoredDocument, first: int, last: int | None) -> Asked:
    """The pose of a frame of a document, or the motion to `last`. NotFoundError outside of it."""
    (listed,) = tx.columns.documents([stored.key])
    return _ask(read_bodies(tx, [listed])[stored.key], stored.name, first, last)


def ask_file(files: list[SourceFile], settings: Settings, first: int, last: int | None) -> Asked:
    """The same of a clip that files hold, as an import would read them; nothing is stored."""
    with gathered(files, settings.file_limits) as gathering:
        for name, error in gathering.problems:
            raise error.in_file(name)
        if len(gathering.clips) != 1:
            raise RequestError(f"The files hold {len(gathering.clips)} clips.", remedy="Send the files of one clip.")
        (clip,) = gathering.clips
        try:
            with offering(clip):
                opened = open_clip(clip, ImportOptions(), settings.file_limits)
                head = to_head(opened.document, opened.stream.head.frame_time)
                body = Body.pack(body_of(head, _until(opened.stream.blocks(), last or first)))
        except McmlError as error:
            raise error.in_file(clip.name) from None
    return _ask(body, clip.name, first, last)


def ask_positions(
    joints: list[str], positions: list[list[list[float] | None]], seconds: float | None, up: str | None
) -> Asked:
    """The same of joints (MCML's names) at positions of each frame, in any unit. RequestError where they are no
    body."""
    lacking = [name for name in NEEDS if (name == ORIGIN or name.endswith(("_leg", "_foot"))) and name not in joints]
    if lacking:
        raise RequestError(
            f"A pose needs the positions of {', '.join(lacking)}.",
            remedy=f"Legs tell its size, hips where it faces; give these, and {FEWEST} or more of {', '.join(JOINTS)}.",
        )
    if len(set(joints)) < len(joints):
        raise RequestError("A joint is named twice.", remedy="Name each joint once.")
    nowhere = [np.nan] * 3
    points = np.array([[nowhere if point is None else point for point in frame] for frame in positions], np.float64)
    fields = {"global_axis_of_gravity": checked_axis(up)} if up else {}
    head = ClipHead("trc", marker_skeleton(joints), fields, None if seconds is None else repr(seconds))
    return _ask(Body.pack(body_at(head, points)), "the positions", 1, len(points) if len(points) > 1 else None)


def find_alike(tx: Transaction, caches: Caches, asked: Asked, where: Where, limits: Limits) -> SearchAnswer:
    """Find the most similar poses or motions."""
    lasts = len(asked.poses) * (asked.seconds or 0.0) if asked.moves else 1.0
    nearest = search(
        tx,
        caches,
        Scope(tx, caches.listing, where.documents, where.project),
        asked,
        wanted=where.limit,
        apart=lasts if where.apart is None else where.apart,
        check=limits.check,
    )
    hits = [
        SearchHit(
            document=hit.listed.uuid,
            name=hit.listed.name,
            revision=hit.listed.revision,
            first=hit.first,
            last=hit.last,
            distance=hit.distance,
        )
        for hit in nearest.hits
    ]
    warnings = []
    if nearest.unlike:
        warnings.append(
            f"{len(nearest.unlike):,} of {nearest.documents:,} documents left out: they have no frames, share fewer "
            f"than {FEWEST} joints with the example{', or their frame time is not known' if asked.moves else ''} "
            f"({named(nearest.unlike, np.ones(len(nearest.unlike), bool))})."
        )
    joints = [
        name for name, points in zip(JOINTS, asked.poses.transpose(1, 0, 2), strict=True) if np.isfinite(points).all()
    ]
    return SearchAnswer(frames=len(asked.poses), joints=joints, hits=hits, warnings=warnings)


def _ask(body: Body, name: str, first: int, last: int | None) -> Asked:
    end = first if last is None else last
    if not first <= end <= body.frames:
        raise NotFoundError(
            f"Frames {first} to {end} are not in {name!r}, a clip of {body.frames} frames.",
            remedy="Frame numbers are positions, from 1, both ends included.",
        )
    if end - first >= MOST_FRAMES:
        raise LimitError(f"An example motion has at most {MOST_FRAMES:,} frames.", remedy="Ask a part of it.")
    poses = pose_features(body.stretch(NEEDS))[first - 1 : end]
    known = np.isfinite(poses).all(axis=2).sum(axis=1)
    if known.min() < FEWEST:
        lacking = [name for name in NEEDS if name not in body.names]
        why = f"it lacks {', '.join(lacking)}" if lacking else "its joints or the way it faces are not known there"
        raise RequestError(
            f"Frame {first + int(known.argmin())} of {name!r} shows no pose: {why}.",
            remedy=f"A pose needs Root, both legs, and {FEWEST} or more of the joints of a body, with MCML's names.",
        )
    if last is not None and body.frame_time is None:
        raise RequestError(f"The frame time of {name!r} is not known.", remedy="Ask a single frame, or set it.")
    return Asked(poses, last is not None, body.frame_time)


def _until(blocks: Iterable[FrameBlock], last: int) -> Iterator[FrameBlock]:
    """The frames to the one at a position."""
    if last > MOST_READ:
        raise LimitError(
            f"Of a file the first {MOST_READ:,} frames can be searched for.", remedy="Store it, and ask it then."
        )
    frames = 0
    for block in blocks:
        yield block if frames + len(block) <= last else rows_of(block, 0, last - frames)
        frames += len(block)
        if frames >= last:
            return
