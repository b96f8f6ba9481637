"""Import: files in, whole documents out. Each document is stored completely or not at all.

Reading, checking and compressing happen outside the write lock. Small clips of one call are stored several to a
transaction; a large one in several short ones under the state "importing", which no read sees, and a last one that
makes it visible.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any

from service.actions.check_names import check_frame_time, given_name, name_of_file
from service.actions.gather_files import Clip, SkeletonLookup, gathered
from service.actions.import_batch import Batch, Imported, ImportResult
from service.actions.import_options import ImportOptions
from service.actions.keep_upload import WORKERS, Upload
from service.actions.open_clip import open_clip
from service.errors import DocumentError, Notice
from service.formats.format import SourceFile
from service.mcml import motion_names
from service.mcml.elements import Element
from service.motion.clip import ClipHead, ClipStream
from service.settings import Settings
from service.storage.database import Database, Transaction
from service.storage.encoding import ClipEncoder
from service.storage.rows import SkeletonRows, skeleton_rows
from service.storage.tracks import Piece

FLUSH_BYTES = 16 << 20
"""Rows of a clip that wait in memory before they are written in a transaction of their own."""

Progress = Callable[[str, int, int | None], None]
"""Called with a file name, frames done, and frames in all if known; may raise to stop the import."""


def import_files(
    database: Database,
    files: list[SourceFile],
    options: ImportOptions,
    settings: Settings,
    *,
    author: str = "local",
    progress: Progress | None = None,
) -> ImportResult:
    """Store every clip among the files; a bad one is a problem in the result and stops no other."""
    options = replace(
        options,
        project=given_name(options.project, "project"),
        name=given_name(options.name, "document") if options.name else None,
    )
    lookup = _skeleton_lookup(database, options.skeleton) if options.skeleton else None
    result = ImportResult()
    with gathered(files, settings, lookup) as found, ThreadPoolExecutor(WORKERS) as executor:
        result.problems += found.problems
        batch = Batch(database, author, result)
        try:
            for clip in found.clips:
                chosen = options if len(found.clips) == 1 else replace(options, name=None)
                batch.take(Importer(database, clip, chosen, settings, author, executor, progress))
        finally:
            # What was read before the import was stopped is stored.
            batch.store()
    return result


class _StoredMeanwhile(Exception):  # noqa: N818
    """An equal clip was stored while this one was read."""

    def __init__(self, uuid: str) -> None:
        super().__init__(uuid)
        self.uuid = uuid


@dataclass(frozen=True)
class _Read:
    """What was read of a clip, all but its rows. facts: the receipt."""

    document: Element
    skeleton: SkeletonRows
    head: ClipHead
    encoder: ClipEncoder
    facts: dict[str, Any]


class Importer:
    """The import of one clip: `begin`, `read`, then `store` it, once or again.

    key: of the document where a transaction that is committed already holds a part of it.
    """

    def __init__(
        self,
        database: Database,
        clip: Clip,
        options: ImportOptions,
        settings: Settings,
        author: str,
        executor: ThreadPoolExecutor,
        progress: Progress | None,
    ) -> None:
        self.database = database
        self.clip = clip
        self.options = options
        self.settings = settings
        self.author = author
        self.executor = executor
        self.progress = progress
        self.key: int | None = None
        self.uuid = ""
        self.project = 0
        self.uploads: list[Upload] = []
        self.rows: list[dict[str, Any]] = []
        self.row_bytes = 0
        self.name = options.name or name_of_file(clip.name)

    def begin(self) -> None:
        """Take the digests of the files, and let them be compressed."""
        self.uploads = [Upload.begin(part, file, self.executor) for part, file in self.clip.files.items()]

    @property
    def digests(self) -> dict[str, str]:
        """Of the files, by part."""
        return {upload.part: upload.sha256 for upload in self.uploads}

    @property
    def skips_twins(self) -> bool:
        return self.options.on_duplicate == "skip"

    @property
    def size(self) -> int:
        """Bytes of the files."""
        return sum(upload.size for upload in self.uploads)

    def read(self) -> Imported | None:
        """Read, check and encode the clip; answers the stored document where an equal one counts instead."""
        with self._whole_or_absent():
            twins = self._twins() if self.skips_twins else []
            if twins:
                return self._stored(twins[0])
            opened = open_clip(self.clip, self.options, self.settings)
            stream = opened.stream
            encoder = ClipEncoder(self.executor)
            for block in stream.blocks():
                self._keep(encoder.add(block))
                if self.progress is not None:
                    self.progress(self.clip.name, encoder.frames, stream.frames)
            encoder.close()
            head = replace(stream.head, frame_time=self._frame_time(stream))
            opened.check(encoder.shapes)
            self._make_names_canonical(encoder, stream)
            self._add_labels(encoder)
            forest = opened.document.children[1:]
            rows = skeleton_rows(forest) if opened.shared is None else opened.shared.rows
            facts = opened.receipt(head, encoder.frames)
            self._found = _Read(opened.document, rows, head, encoder, facts)
        return None

    def compress(self) -> None:
        """Let the numbers be compressed that wait for it."""
        self._found.encoder.compress()

    def finish(self) -> None:
        """Wait for what is still being compressed; a large clip begins to be stored."""
        with self._whole_or_absent():
            self._keep(self._found.encoder.rest())
            for upload in self.uploads:
                self._prepare(upload)

    def store_alone(self) -> Imported:
        """Store the clip in a transaction of its own; what was written before of one that fails is removed."""
        try:
            with self._whole_or_absent(), self.database.write(self.author) as tx:
                return self.store(tx)
        except _StoredMeanwhile as meanwhile:
            return self._stored(meanwhile.uuid)

    @contextmanager
    def _whole_or_absent(self) -> Iterator[None]:
        try:
            yield
        except BaseException:
            # Where the store itself fails, the rows stay invisible and are swept when their lease has ended.
            with suppress(Exception):
                if self.key is not None:
                    with self.database.write(self.author) as tx:
                        tx.documents.remove_import(self.key)
                        for upload in self.uploads:
                            upload.abandon(tx)
            raise

    def _stored(self, uuid: str) -> Imported:
        with self.database.read() as tx:
            stored = tx.documents.get(uuid)
            return Imported(stored.uuid, stored.name, json.loads(tx.documents.receipt(stored.key)), skipped=True)

    def _twins(self) -> list[str]:
        """Documents made from equal files."""
        with self.database.read() as tx:
            project = tx.projects.find(self.options.project)
            return [] if project is None else tx.uploads.twins(self.digests, project)

    def _frame_time(self, stream: ClipStream) -> str | None:
        stated = self.options.frame_time
        if stated is None:
            return stream.head.frame_time
        check_frame_time(stated)
        return stated

    def _make_names_canonical(self, encoder: ClipEncoder, stream: ClipStream) -> None:
        """Motion names that the document itself has are stored as labels are: canonically, and none impossible."""
        for row in encoder.spans.rows:
            said = row["name"]
            row["name"] = motion_names.canonical(said, strict=self.options.strict_names)
            if row["name"] != said:
                notice = Notice("note", f"motion name {said!r} is stored as {row['name']!r}")
                if notice not in stream.notices:
                    stream.notices.append(notice)

    def _add_labels(self, encoder: ClipEncoder) -> None:
        for label in self.options.labels:
            name = motion_names.canonical(label.name, strict=self.options.strict_names)
            first = 1 if label.first is None else label.first
            last = encoder.frames if label.last is None else label.last
            if not 1 <= first <= last <= encoder.frames:
                raise DocumentError(
                    f"The label {label.name!r} lies on frames {first} to {last}, the clip has {encoder.frames}.",
                    remedy="Give positions from 1 to the number of frames.",
                )
            overlapping = [row["rank"] for row in encoder.spans.rows if row["first"] <= last and row["last"] >= first]
            rank = max(overlapping, default=-1) + 1
            encoder.spans.rows.append({"name": name, "rank": rank, "first": first, "last": last})

    def _keep(self, chunks: Iterator[list[dict[str, Any]]]) -> None:
        for rows in chunks:
            self.rows += rows
            self.row_bytes += sum(len(row["data"]) + 200 for row in rows)
            if self.row_bytes >= FLUSH_BYTES:
                with self.database.write(self.author) as tx:
                    key = self._flush(tx)
                self.key = key
                self.rows, self.row_bytes = [], 0

    def _begin(self, tx: Transaction) -> int:
        """The document's key, its lease renewed where an earlier transaction made it."""
        if self.key is not None:
            tx.documents.renew_lease(self.key)
            return self.key
        self.project = tx.projects.get_or_add(self.options.project)
        key, self.uuid = tx.documents.begin(self.project, self.name, self.clip.format)
        return key

    def _flush(self, tx: Transaction) -> int:
        key = self._begin(tx)
        tx.tracks.write_chunks(key, self.rows, 0)
        return key

    def store(self, tx: Transaction) -> Imported:
        """Write what is not written yet and make the document visible. Changes nothing here: it may be repeated."""
        document, head, encoder = self._found.document, self._found.head, self._found.encoder
        key = self._flush(tx)
        tx.tracks.write_shapes(key, encoder.shapes)
        tx.tracks.write_shape_runs(key, encoder.shape_rows, 0)
        tx.tracks.write_frame_runs(key, encoder.ids.rows, 0)
        tx.tracks.write_timeline(key, [Piece(1, 0, encoder.frames)] if encoder.frames else [], 0)
        tx.spans.write(key, encoder.spans.rows, 0)
        tx.heads.write_header(key, document.children[0], 0)
        tx.heads.write_bones(key, list(head.skeleton.names), 0)
        tx.documents.write_content(
            key,
            0,
            skeleton=tx.heads.add_skeleton(self.project, self._found.skeleton, len(head.skeleton)),
            version=document.attributes["version"],
            frames=encoder.frames,
            frame_time=head.frame_time,
            # A stated frame time changes what BVH holds; AMC and HTR files have no place for it.
            intact=head.frame_time is None or self.options.frame_time is None or head.format != "bvh",
        )
        if self.skips_twins:
            # Whoever stores an equal clip at this moment is waited for.
            tx.dialect.order_commits(tx.connection)
        kept = [upload.attach(tx, key) for upload in self.uploads]
        twins = tx.uploads.twins(self.digests, self.project) if all(kept) else []
        if twins and self.skips_twins:
            raise _StoredMeanwhile(twins[0])
        facts = self._found.facts | {"twins": twins}
        packed = json.dumps(facts, ensure_ascii=False)
        tx.documents.publish(key, next_slot=encoder.frames, receipt=packed, message=self.clip.name)
        return Imported(self.uuid, self.name, facts)

    def _prepare(self, upload: Upload) -> None:
        """Compress what is not stored yet; a large file goes into the store in transactions of its own."""
        if upload.size and not upload.early:
            with self.database.read() as tx:
                if tx.uploads.find(upload.sha256, upload.size) is not None:
                    return
        pending: list[bytes] = []
        pending_bytes = 0
        for block in upload.compressed(self.executor):
            pending.append(block)
            pending_bytes += len(block)
            if pending_bytes >= FLUSH_BYTES:
                with self.database.write(self.author) as tx:
                    key = self._begin(tx)
                    upload.add(tx, pending)
                self.key = key
                pending, pending_bytes = [], 0
        upload.blocks = pending


def _skeleton_lookup(database: Database, uuid: str) -> SkeletonLookup:
    def lookup() -> SourceFile | None:
        from service.actions.export_motion import skeleton_file

        with database.read() as tx:
            return skeleton_file(tx, tx.documents.get(uuid))

    return lookup
