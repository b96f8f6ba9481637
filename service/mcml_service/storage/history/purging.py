"""Remove documents permanently: all their rows of all revisions, in small steps that survive a crash.

A document that is being purged is in the state `purging`, which no read sees; the last step removes its own row.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sqlalchemy import and_, delete, func, or_, select

from mcml_service.storage.core.schema import CURRENT
from mcml_service.storage.core.seals import SEALS
from mcml_service.storage.core.tables import (
    commit,
    content,
    document,
    document_upload,
    property_,
    revision,
    skeleton,
    skeleton_element,
    track,
    upload_block,
)
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.documents.documents import Documents
from mcml_service.storage.documents.uploads import Uploads
from mcml_service.storage.history.pruning import Pruning
from mcml_service.storage.projects.activity import Activity
from mcml_service.storage.work.results import Results
from mcml_service.storage.work.tables import job, result, result_part

if TYPE_CHECKING:
    from mcml_service.storage.documents.documents import StoredDocument

CHUNKS = 32
"""Chunks of 256 frames whose tracks go in one transaction."""

PROVENANCE = "provenance"


@dataclass(frozen=True)
class Held:
    """The data of a document. bytes: of its tracks and of files that no other document uses."""

    revisions: int
    bytes: int
    deleted: str | None


class Purging:
    """Every method takes the key, or the uuid, of a document whose import was complete."""

    def __init__(
        self,
        tx: BaseTransaction,
        activity: Activity,
        documents: Documents,
        pruning: Pruning,
        results: Results,
        uploads: Uploads,
    ) -> None:
        self._tx = tx
        self._activity = activity
        self._documents = documents
        self._pruning = pruning
        self._results = results
        self._uploads = uploads

    def erase_what_goes(self) -> None:
        """Let the database overwrite what this transaction removes, where it would else only forget it."""
        self._tx.dialect.erase_what_goes(self._tx.connection)

    def find_deleted_before(self, time: str) -> list[str]:
        """UUIDs of documents that were deleted before a time, the oldest first."""
        gone = and_(document.c.state == "ready", document.c.deleted_commit < CURRENT)
        query = select(document.c.uuid).join(commit, commit.c.number == document.c.deleted_commit)
        query = query.where(gone, commit.c.time < time).order_by(document.c.deleted_commit)
        return self._tx.fetch_column(query)

    def measure(self, key: int) -> Held:
        tracks = select(func.coalesce(func.sum(func.length(track.c.data)), 0)).where(track.c.document == key)
        others = select(document_upload.c.upload).where(document_upload.c.document != key)
        files = (
            select(func.coalesce(func.sum(func.length(upload_block.c.data)), 0))
            .where(upload_block.c.upload.in_(select(document_upload.c.upload).where(document_upload.c.document == key)))
            .where(upload_block.c.upload.not_in(others))
        )
        revisions = select(func.count()).select_from(revision).where(revision.c.document == key)
        ended = select(commit.c.time).join(document, document.c.deleted_commit == commit.c.number)
        return Held(
            int(self._tx.fetch_value(revisions)),
            int(self._tx.fetch_value(tracks)) + int(self._tx.fetch_value(files)),
            self._tx.fetch_value(ended.where(document.c.id == key)),
        )

    def find_made_from(self, uuid: str) -> tuple[list[tuple[str, str]], list[tuple[str, str]], list[int]]:
        """(uuid, name) of documents, then of results, that were made from a document and others; keys of results that
        were made from it alone."""
        mentions = property_.c.text.contains(uuid)
        clips = select(document.c.uuid, document.c.name).join(property_, property_.c.document == document.c.id)
        clips = clips.where(
            property_.c.name == PROVENANCE, mentions, document.c.uuid != uuid, document.c.state == "ready"
        )
        own: list[int] = []
        shared: list[tuple[str, str]] = []
        query = select(result.c.id, result.c.uuid, result.c.name, result.c.inputs).where(result.c.inputs.contains(uuid))
        for key, result_uuid, name, inputs in self._tx.fetch_all(query):
            if {item["document"] for item in json.loads(inputs)} == {uuid}:
                own.append(key)
            else:
                shared.append((result_uuid, name))
        return [(row.uuid, row.name) for row in self._tx.fetch_all(clips.distinct())], shared, own

    def begin(self, stored: StoredDocument) -> None:
        """Make the document invisible, also for running servers: they list documents after each commit."""
        self._documents.set_state(stored.key, "purging")
        self._activity.note("document", "purge", project_key=stored.project_key, document=stored.uuid)
        self._pruning.let_go(self._tx.commit)

    def find_unfinished(self) -> list[tuple[int, str]]:
        """(key, uuid) of documents whose purge was interrupted."""
        query = select(document.c.id, document.c.uuid).where(document.c.state == "purging")
        return [(key, uuid) for key, uuid in self._tx.fetch_all(query)]

    def remove_tracks(self, key: int) -> bool:
        """Remove some tracks; return whether there are more."""
        first = self._tx.fetch_value(select(func.min(track.c.chunk)).where(track.c.document == key))
        if first is None:
            return False
        some = and_(track.c.document == key, track.c.chunk < first + CHUNKS)
        self._tx.run(delete(track).where(some))
        return True

    def finish(self, key: int, uuid: str) -> None:
        """Remove all other rows, and data that only this document needed: files, skeletons, results, ended jobs."""
        self._tx.dialect.retire_keys(self._tx.connection)
        _, _, own = self.find_made_from(uuid)
        for number in own:
            self._results.remove(number)
        ended = job.c.state.in_(("done", "failed", "cancelled"))
        self._tx.run(delete(job).where(or_(job.c.inputs.contains(uuid), job.c.problem.contains(uuid)), ended))
        self._forget_clip(key)
        self._documents.remove_purged(key)
        self._uploads.remove_orphans(0)
        unused = skeleton.c.id.not_in(select(content.c.skeleton))
        numbers = self._tx.fetch_column(select(skeleton.c.id).where(unused))
        self._tx.run(delete(skeleton_element).where(skeleton_element.c.skeleton.in_(numbers)))
        self._tx.run(delete(skeleton).where(skeleton.c.id.in_(numbers)))

    def _forget_clip(self, key: int) -> None:
        """Remove references from parts of results whose clip is the document."""
        columns = SEALS[result_part].columns
        query = select(*(result_part.c[name] for name in columns)).where(result_part.c.document == key)
        rows = [dict(zip(columns, row, strict=True)) | {"document": None} for row in self._tx.fetch_all(query)]
        self._tx.run(delete(result_part).where(result_part.c.document == key))
        self._tx.insert_rows(result_part, rows)
