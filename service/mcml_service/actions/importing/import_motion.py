"""Import: files in, whole documents out. Each document is stored completely or not at all.

Reading, checking and compressing happen outside the write lock. Small clips of one call are stored several to a
transaction; a large one in several short ones under the state "importing", which no read sees, and a last one that
makes it visible.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import replace

import orjson

from mcml.errors import McmlError
from mcml.files.check_names import given_name, name_of_file
from mcml.files.gather_files import Clip, SkeletonLookup, gathered
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_service.actions.importing.encode_clip import EncodedClip, Progress, encode_clip
from mcml_service.actions.importing.import_batch import Batch, Imported, ImportResult
from mcml_service.actions.importing.import_pool import ImportPool, reading_ahead
from mcml_service.actions.importing.import_workers import FEWEST_CLIPS, MOST_BYTES, ReadApart, Task
from mcml_service.actions.importing.keep_upload import WORKERS, Upload, digest_of
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.encoding import DATA_PLACE, ClipEncoder, TrackRow
from mcml_service.storage.documents.tracks import Piece
from mcml_service.storage.transaction import Transaction

FLUSH_BYTES = 16 << 20
"""Rows of a clip that wait in memory before they are written in a transaction of their own."""


def import_files(
    database: Database,
    files: list[SourceFile],
    options: ImportOptions,
    settings: Settings,
    *,
    author: str = "local",
    progress: Progress | None = None,
    pool: ImportPool | None = None,
) -> ImportResult:
    """Store every clip among the files; a bad one is a problem in the result and stops no other.

    pool: processes that read, for a process that must not fork.
    """
    options = replace(
        options,
        project=given_name(options.project, "project"),
        name=given_name(options.name, "document") if options.name else None,
    )
    with database.read() as tx:
        options = replace(options, aliases=tx.aliases.of(options.project).pairs)
    lookup = _skeleton_lookup(database, options.skeleton) if options.skeleton else None
    result = ImportResult()
    with gathered(files, settings.file_limits, lookup) as found, ThreadPoolExecutor(WORKERS) as executor:
        result.problems += found.problems
        chosen = options if len(found.clips) == 1 else replace(options, name=None)
        batch = Batch(database, author, result)
        with reading_ahead(_tasks(database, found.clips, chosen), settings, pool) as workers:
            try:
                for number, clip in enumerate(found.clips):
                    if workers.is_behind(number):
                        batch.store_early(len(found.clips) - number)
                    apart = workers.take(number)
                    batch.take(Importer(database, clip, chosen, settings, author, executor, progress, apart))
            finally:
                # What was read before the import was stopped is stored.
                batch.store()
    return result


def _tasks(database: Database, clips: list[Clip], options: ImportOptions) -> dict[int, Task]:
    """The clips that another process may read, by their number: not those that are large, or stored already."""
    tasks = {
        number: Task(clip, options)
        for number, clip in enumerate(clips)
        if sum(file.stream.seek(0, os.SEEK_END) for file in clip.files.values()) <= MOST_BYTES
    }
    if options.on_duplicate != "skip" or len(tasks) < FEWEST_CLIPS:
        return tasks
    with database.read() as tx:
        project = tx.projects.find(options.project)
        if project is None:
            return tasks

        def is_stored(clip: Clip) -> bool:
            digests = {part: digest_of(file) for part, file in clip.files.items()}
            return bool(tx.uploads.twins(digests, project))

        return {number: task for number, task in tasks.items() if not is_stored(task.clip)}


class _StoredMeanwhile(Exception):  # noqa: N818
    """An equal clip was stored while this one was read."""

    def __init__(self, uuid: str) -> None:
        super().__init__(uuid)
        self.uuid = uuid


class Importer:
    """The import of one clip: `begin`, `read`, then `store` it, once or again.

    apart: what another process made of it, where one has read it.
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
        apart: ReadApart | None = None,
    ) -> None:
        self.database = database
        self.clip = clip
        self.options = options
        self.settings = settings
        self.author = author
        self.executor = executor
        self.progress = progress
        self.apart = apart
        self.encoder = ClipEncoder(executor)
        self.key: int | None = None
        self.uuid = ""
        self.project = 0
        self.uploads: list[Upload] = []
        self.rows: list[TrackRow] = []
        self.row_bytes = 0
        self.name = options.name or name_of_file(clip.name)

    def begin(self) -> None:
        """Take the digests of the files, and let them be compressed."""
        if self.apart is not None:
            self.uploads = [Upload.of_packed(self.clip.files[made.part], made) for made in self.apart.uploads]
            return
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
            self._found = self._encoded() if self.apart is None else self._taken(self.apart)
        return None

    def _encoded(self) -> EncodedClip:
        return encode_clip(self.clip, self.options, self.settings, self.encoder, self._keep, self.progress)

    def _taken(self, apart: ReadApart) -> EncodedClip:
        if isinstance(apart.encoded, McmlError):
            raise apart.encoded
        self.rows = apart.rows
        if self.progress is not None:
            self.progress(self.clip.name, apart.encoded.frames, apart.encoded.frames)
        return apart.encoded

    def compress(self) -> None:
        """Let the numbers be compressed that wait for it."""
        self.encoder.compress()

    def finish(self) -> None:
        """Wait for what is still being compressed; a large clip begins to be stored."""
        with self._whole_or_absent():
            self._keep(self.encoder.rest())
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
            return Imported(stored.uuid, stored.name, orjson.loads(tx.documents.receipt(stored.key)), skipped=True)

    def _twins(self) -> list[str]:
        """Documents made from equal files."""
        with self.database.read() as tx:
            project = tx.projects.find(self.options.project)
            return [] if project is None else tx.uploads.twins(self.digests, project)

    def _keep(self, chunks: Iterator[list[TrackRow]]) -> None:
        for rows in chunks:
            self.rows += rows
            self.row_bytes += sum(len(row[DATA_PLACE]) + 200 for row in rows)
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
        found = self._found
        key = self._flush(tx)
        tx.tracks.write_shapes(key, found.shapes)
        tx.tracks.write_shape_runs(key, found.shape_rows, 0)
        tx.tracks.write_frame_runs(key, found.frame_runs, 0)
        tx.tracks.write_timeline(key, [Piece(1, 0, found.frames)] if found.frames else [], 0)
        tx.spans.write(key, found.spans, 0)
        tx.heads.write_header(key, found.header, 0)
        tx.heads.write_bones(key, found.bones, 0)
        tx.documents.write_content(
            key,
            0,
            skeleton=tx.heads.add_skeleton(self.project, found.skeleton, len(found.bones)),
            version=found.version,
            frames=found.frames,
            frame_time=found.frame_time,
            intact=found.intact,
        )
        if found.thumbnail is not None:
            tx.thumbnails.add(key, 1, found.thumbnail.data, found.thumbnail.facts)
        if self.skips_twins:
            # Whoever stores an equal clip at this moment is waited for.
            tx.order()
        kept = [upload.attach(tx, key) for upload in self.uploads]
        twins = tx.uploads.twins(self.digests, self.project) if all(kept) else []
        if twins and self.skips_twins:
            raise _StoredMeanwhile(twins[0])
        facts = found.facts | {"twins": twins}
        said = orjson.dumps(facts).decode()
        tx.documents.publish(key, self.name, self.project, next_slot=found.frames, receipt=said, message=self.clip.name)
        return Imported(self.uuid, self.name, facts)

    def _prepare(self, upload: Upload) -> None:
        """Compress what is not stored yet; a large file goes into the store in transactions of its own."""
        if upload.blocks is not None:
            return
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
        from mcml_service.actions.exporting.export_motion import skeleton_file

        with database.read() as tx:
            return skeleton_file(tx, tx.documents.get(uuid))

    return lookup
