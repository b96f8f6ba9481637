"""History forgotten: revisions before a commit, and the rows and files that only they needed."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import and_, delete, func, insert, select

from mcml.errors import NotFoundError
from mcml_service.storage.core.schema import CURRENT
from mcml_service.storage.core.seals import SEALS
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import (
    REVISIONED,
    commit,
    content,
    document,
    document_upload,
    revision,
    store,
    track,
    upload_block,
)
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.documents.bodies import Bodies
from mcml_service.storage.documents.thumbnails import Thumbnails
from mcml_service.storage.documents.uploads import Uploads

WHOLE_SINCE = "whole since commit"


@dataclass(frozen=True)
class Old:
    """A document with history before a commit. keep: the oldest revision that stays. at: the commit that made it.
    revisions: how many go. bytes: of tracks and files that go with them."""

    key: int
    keep: int
    at: int
    revisions: int
    bytes: int


_WHOLE_SINCE = Prepared(select(store.c.value).where(store.c.name == WHOLE_SINCE))


class Pruning:
    def __init__(self, tx: BaseTransaction, bodies: Bodies, thumbnails: Thumbnails, uploads: Uploads) -> None:
        self._tx = tx
        self._bodies = bodies
        self._thumbnails = thumbnails
        self._uploads = uploads

    def whole_since(self) -> int:
        """The first commit whose state is whole: earlier ones lack what was pruned or purged."""
        rows = self._tx.fetch_all(_WHOLE_SINCE)
        return int(rows[0][0]) if rows else 0

    def require_whole_since(self, commit: int) -> None:
        """Check that nothing was pruned or purged since a commit: otherwise further reads would lack data.

        Raises NotFoundError.
        """
        if self.whole_since() != commit:
            raise NotFoundError(
                "Some data read before has been purged or pruned since.",
                remedy="Ask again, without a cursor.",
            )

    def let_go(self, before: int) -> None:
        """Note that states before a commit are not whole any more."""
        if before > self.whole_since():
            self._tx.run(delete(store).where(store.c.name == WHOLE_SINCE))
            self._tx.run(insert(store).values(name=WHOLE_SINCE, value=str(before)))

    def commit_before(self, time: str) -> int:
        """The last commit before a time, 0 for none."""
        query = select(func.coalesce(func.max(commit.c.number), 0)).where(commit.c.time < time)
        return int(self._tx.fetch_value(query))

    def older(self, cut: int) -> list[Old]:
        """Return documents with revisions that later ones had replaced at commit `cut`."""
        last = (
            select(revision.c.document, func.max(revision.c.number).label("keep"))
            .where(revision.c.commit <= cut)
            .group_by(revision.c.document)
            .subquery()
        )
        query = (
            select(last.c.document, last.c.keep, revision.c.commit)
            .join(revision, and_(revision.c.document == last.c.document, revision.c.number == last.c.keep))
            .join(document, and_(document.c.id == last.c.document, document.c.state == "ready"))
            .order_by(last.c.document)
        )
        old = []
        for key, keep, at in self._tx.fetch_all(query):
            gone = select(func.count()).where(revision.c.document == key, revision.c.number < keep)
            count = int(self._tx.fetch_value(gone))
            if count:
                old.append(Old(key, keep, at, count, self._bytes(key, at)))
        return old

    def _bytes(self, key: int, at: int) -> int:
        closed = and_(track.c.document == key, track.c.to_commit <= at, track.c.to_commit < CURRENT)
        size = select(func.coalesce(func.sum(func.length(track.c.data)), 0)).where(closed)
        total = int(self._tx.fetch_value(size))
        if self._needs_files(key, at):
            return total
        own = select(document_upload.c.upload).where(document_upload.c.document == key)
        others = select(document_upload.c.upload).where(document_upload.c.document != key)
        files = select(func.coalesce(func.sum(func.length(upload_block.c.data)), 0))
        files = files.where(upload_block.c.upload.in_(own), upload_block.c.upload.not_in(others))
        return total + int(self._tx.fetch_value(files))

    def _needs_files(self, key: int, at: int) -> bool:
        """Tell whether a remaining revision still equals the upload."""
        query = select(content.c.document).where(content.c.document == key, content.c.to_commit > at, content.c.intact)
        return self._tx.fetch_one(query.limit(1)) is not None

    def forget(self, old: Old) -> None:
        """Remove what a document had before."""
        self.let_go(old.at)
        for table in REVISIONED:
            self._tx.run(delete(table).where(table.c.document == old.key, table.c.to_commit <= old.at))
        self._tx.run(delete(revision).where(revision.c.document == old.key, revision.c.number < old.keep))
        self._thumbnails.forget(old.key, old.keep)
        self._bodies.forget(old.key, old.keep)
        self._begin_with(old)
        if not self._needs_files(old.key, old.at):
            self._uploads.forget(old.key)

    def _begin_with(self, old: Old) -> None:
        """The oldest revision has none before it any more."""
        columns = SEALS[revision].columns
        mine = and_(revision.c.document == old.key, revision.c.number == old.keep)
        (row,) = self._tx.fetch_all(select(*(revision.c[name] for name in columns)).where(mine))
        self._tx.run(delete(revision).where(mine))
        self._tx.insert_rows(revision, [dict(zip(columns, row, strict=True)) | {"parent": None}])
