"""Motion matching over stored clips: the library of a selection, and documents in which a body follows a path."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.errors import DocumentError, RequestError
from mcml.motion.matching.following import Followed, Run, follow
from mcml.motion.matching.library import ROWS_AHEAD, MatchingLibrary
from mcml.motion.matching.paths import Path
from mcml.motion.matching.tracks import JOINTS, RATE, Track, ground_axes, track_of
from mcml.motion.skeleton import Array
from mcml_schemas.compose import ComposeRequest, Place, Segment
from mcml_schemas.matching import (
    FollowRequest,
    LeftOut,
    MatchingClip,
    MatchingFacts,
    MatchingSelection,
    PathDistance,
    PathFollowed,
)
from mcml_service.actions.composing.compose_frames import compose_frames
from mcml_service.actions.composing.select_documents import select_documents
from mcml_service.actions.reading.preview_motion import Window
from mcml_service.clips.bodies import Body
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.queries import Queries

MOST_ROWS = 400_000
"""Of a library: nearly four hours of motion, 160 bytes a row."""
MOST_SEGMENTS = 1000
"""That one request for a composition takes."""
_TOGETHER = 32
"""Bodies in memory at a time."""
_LONGEST = 2000.0
"""Metres of a path."""


@dataclass(frozen=True)
class StoredLibrary:
    """documents: of the clips of the library, in order. metres: of a unit of their lengths. up: their axis up."""

    library: MatchingLibrary
    documents: tuple[Listed, ...]
    metres: tuple[float, ...]
    up: str
    left_out: tuple[LeftOut, ...]

    def facts(self) -> MatchingFacts:
        starts = self.library.starts.tolist()
        clips = [
            MatchingClip(
                document=document.uuid,
                revision=document.revision,
                name=document.name,
                first=first,
                last=end - 1,
                frames=document.frames,
                seconds_per_frame=track.frame_time,
                skipped=track.skipped,
                metres=metres,
            )
            for document, track, metres, first, end in zip(
                self.documents, self.library.tracks, self.metres, starts, starts[1:], strict=False
            )
        ]
        axes = ground_axes(self.up)
        return MatchingFacts(
            rate=RATE,
            rows=len(self.library),
            up=self.up,
            axes="".join("XYZ"[axis] for axis in axes[:2]),
            scales=self.library.scales.tolist(),
            ahead=list(ROWS_AHEAD),
            speed=self.library.usual_speed,
            clips=clips,
            left_out=list(self.left_out),
        )

    def rows(self) -> NDArray[np.float32]:
        """(rows, 31): the features, the place of the root (2), its facing, and 1 where a cut may lead."""
        library = self.library
        columns = (library.features, library.place, library.facing[:, None], library.targets[:, None])
        return np.concatenate(columns, axis=1).astype(np.float32)


def read_library(database: Database, queries: Queries, request: MatchingSelection) -> StoredLibrary:
    """The library of the selected documents that have one skeleton. DocumentError where none can be used."""
    selected, _ = select_documents(database, queries, request.selection)
    chosen = {str(item["document"]) for item in selected}
    left_out: list[LeftOut] = []
    used: list[tuple[Listed, Track, float, str]] = []
    with database.read() as tx:
        listed = sorted((one for one in tx.columns.documents() if one.uuid in chosen), key=lambda one: one.uuid)
        if not listed:
            raise DocumentError("The selection has no documents.", remedy="Select clips of one skeleton.")
        wanted = None
        if request.skeleton is not None:
            wanted = tx.columns.documents([tx.documents.get(request.skeleton).key])[0].skeleton
        rows = 0
        for document, body in _bodies(tx, queries, [one for one in listed if wanted in (None, one.skeleton)]):
            track, known = track_of(body.stretch(JOINTS)), body.calibration
            if track is None or known.metres is None:
                left_out.append(_leave(document, _reason(body.names, known.metres, body.frame_time)))
                continue
            rows += len(track)
            if rows > MOST_ROWS:
                raise DocumentError(
                    f"The selection has more than {MOST_ROWS / RATE / 3600:.1f} hours of motion.",
                    remedy="Select fewer clips, such as those of one label.",
                )
            used.append((document, track, known.metres, known.up))
    skeleton = _most_rows(used) if wanted is None else wanted
    other = {one.uuid for one in listed if one.skeleton != skeleton}
    left_out = [one for one in left_out if one.document not in other]
    left_out += [_leave(one, "it has another skeleton: retarget it first") for one in listed if one.uuid in other]
    used = [one for one in used if one[0].uuid not in other]
    ups = [up for *_, up in used]
    up = max(set(ups), key=lambda one: (ups.count(one), one), default="Y")
    left_out += [_leave(one[0], f"{one[3]} points up in it, not {up}: set its up axis") for one in used if one[3] != up]
    used = [one for one in used if one[3] == up]
    try:
        library = MatchingLibrary.of([track for _, track, *_ in used])
    except ValueError:
        reasons = [f"{one.name}: {one.reason}" for one in left_out[:5]]
        reasons += [f"{one[0].name}: it is too short" for one in used[:5]]
        raise DocumentError(
            f"No selected clip can be used for motion matching. {'; '.join(reasons)}.",
            remedy="Select clips of a second or more, of a body with hips and feet, with a frame rate and a unit.",
        ) from None
    return StoredLibrary(library, tuple(one[0] for one in used), tuple(one[2] for one in used), up, tuple(left_out))


def follow_path(
    database: Database,
    queries: Queries,
    settings: Settings,
    request: FollowRequest,
    author: str,
    check: Callable[[], None],
    window: Window | None = None,
) -> PathFollowed:
    """Make the document, or in a preview only describe it."""
    path = _path(request.path)
    stored = read_library(database, queries, request)
    first, second, _ = ground_axes(stored.up)
    if first > second:
        path = path[:, ::-1]
    speed = max(stored.library.usual_speed, 0.05) if request.speed is None else request.speed
    followed = follow(
        stored.library,
        Path.through(path),
        speed=speed,
        facing=np.radians(request.facing),
        steering=np.radians(request.steering),
        most_runs=MOST_SEGMENTS,
        check=check,
    )
    segments = [segment for run in followed.runs if (segment := _segment(stored, run)) is not None]
    composed = compose_frames(
        database,
        queries,
        settings,
        ComposeRequest(
            segments=segments,
            seconds=request.seconds,
            style="inertial",
            lock_feet=request.lock_feet,
            labels=request.labels,
            name=request.name,
            project=request.project,
            preview=request.preview,
        ),
        author,
        window,
    )
    composed.notices[:0] = _notices(stored, followed)
    distances = followed.distances
    return PathFollowed(
        **dict(composed),
        metres=followed.way,
        complete=followed.complete,
        speed=speed,
        distance=PathDistance(
            mean=float(distances.mean()),
            percentile_90=float(np.percentile(distances, 90)),
            largest=float(distances.max()),
        ),
        composition=segments,
        left_out=list(stored.left_out),
    )


def _most_rows(used: list[tuple[Listed, Track, float, str]]) -> int | None:
    """The skeleton of which most motion can be used; None without any."""
    rows: dict[int, int] = {}
    for document, track, *_ in used:
        rows[document.skeleton] = rows.get(document.skeleton, 0) + len(track)
    return max(rows, key=lambda one: (rows[one], -one), default=None)


def _bodies(tx: Transaction, queries: Queries, listed: list[Listed]) -> Iterator[tuple[Listed, Body]]:
    for start in range(0, len(listed), _TOGETHER):
        some = listed[start : start + _TOGETHER]
        yield from zip(some, queries.caches.bodies.read(tx, some), strict=True)


def _path(points: list[list[float]]) -> Array:
    path = np.array(points)
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    if not 0.1 <= length <= _LONGEST:
        raise RequestError(
            f"The path is {length:.4g} m long.", remedy=f"Give points whose lines are 0.1 to {_LONGEST:,.0f} m long."
        )
    return path


def _segment(stored: StoredLibrary, run: Run) -> Segment | None:
    """The frames of a run, where they are placed; None for none."""
    track, document = stored.library.tracks[run.clip], stored.documents[run.clip]
    first, last = track.frame(run.first), min(track.frame(run.last + 1), document.frames) - 1
    if last < first:
        return None
    axes = ground_axes(stored.up)
    shift = np.zeros(3)
    shift[list(axes[:2])] = run.shift / stored.metres[run.clip]
    # A turn is about the axis itself, also where that points down.
    degrees = np.degrees(run.angle) * (-1 if stored.up.startswith("-") else 1)
    return Segment(
        document=document.uuid,
        revision=document.revision,
        first=first + 1,
        last=last + 1,
        place=Place(degrees=float((degrees + 180) % 360 - 180), shift=shift.tolist()),
    )


def _notices(stored: StoredLibrary, followed: Followed) -> list[str]:
    notices = []
    if not followed.complete:
        notices.append(
            f"The end of the path was not reached: {followed.way:.1f} m of it were covered. Clips that turn and stop "
            "as it asks are missing, or `speed` is not theirs."
        )
    if stored.left_out:
        notices.append(f"{len(stored.left_out)} selected documents were left out.")
    return notices


def _leave(document: Listed, reason: str) -> LeftOut:
    return LeftOut(document=document.uuid, name=document.name, reason=reason)


def _reason(names: tuple[str, ...], metres: float | None, seconds: float | None) -> str:
    lacking = [name for name in JOINTS if name not in names]
    if lacking:
        return f"it has no {', '.join(lacking)}"
    if metres is None:
        return "its unit of length is unknown: set it"
    if seconds is None:
        return "its frame rate is unknown: set it"
    return "it is too short, or shows no upright body"
