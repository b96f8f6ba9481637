"""Where frames of earlier revisions are in the current one."""

from __future__ import annotations

from sqlalchemy import select

from mcml.errors import NotFoundError
from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.tables import timeline
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.timelines import Run, common_frames
from mcml_service.storage.documents.tracks import Piece
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.undo.frame_pairs import compose_pairs, pair_frames


class FrameHistory:
    """The timelines of a document since its first revision; they are read once."""

    def __init__(self, tx: Transaction, stored: StoredDocument) -> None:
        self._tx, self._stored = tx, stored
        columns = (timeline.c[name] for name in ("first", "slot", "count", "from_commit", "to_commit"))
        query = select(*columns).where(timeline.c.document == stored.key, timeline.c.from_commit <= tx.at)
        self._rows = [row[:5] for row in tx.fetch_all(verify(query, timeline))]
        self._changes = sorted({row[3] for row in self._rows} | {row[4] for row in self._rows if row[4] <= tx.at})
        self._now = self._at(tx.at)
        self._same: dict[int, list[Run]] = {}
        self._followed: dict[int, list[Run]] = {}

    def find(self, revision: int, first: int, last: int) -> tuple[int, int] | None:
        """The smallest range of the current revision with the frames first to last of another one.

        Frames that an edit replaced by as many others count as these. None if no frame is left, or if that revision is
        no longer kept.
        """
        try:
            commit = self._tx.documents.commit_of(self._stored.key, revision)
        except NotFoundError:
            return None
        if commit not in self._same:
            self._same[commit] = common_frames(self._at(commit), self._now)
        found = follow_range(self._same[commit], first, last)
        if found is not None and found[1] - found[0] == last - first:
            return found
        # An edit and its undo leave frames the same, where one after the other loses them; replaced ones are not.
        if commit not in self._followed:
            self._followed[commit] = self._follow(commit)
        ranges = [one for one in (found, follow_range(self._followed[commit], first, last)) if one is not None]
        return (min(start for start, _ in ranges), max(end for _, end in ranges)) if ranges else None

    def _at(self, commit: int) -> list[Piece]:
        valid = [row[:3] for row in self._rows if row[3] <= commit < row[4]]
        return [Piece(*row) for row in sorted(valid)]

    def _follow(self, commit: int) -> list[Run]:
        before = self._at(commit)
        runs = pair_frames(before, before)
        for change in self._changes:
            if change > commit:
                after = self._at(change)
                runs = compose_pairs(runs, pair_frames(before, after))
                before = after
        return runs


def follow_range(runs: list[Run], first: int, last: int) -> tuple[int, int] | None:
    """The smallest range, in the later state, of the frames first to last that it has; None if it has none of them."""
    kept = [
        (run.after + start - run.before, run.after + end - run.before)
        for run in runs
        if (start := max(first, run.before)) <= (end := min(last, run.before + run.count - 1))
    ]
    return (min(start for start, _ in kept), max(end for _, end in kept)) if kept else None
