"""The import of one clip: read, checked, encoded, stored."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import orjson

from mcml.errors import McmlError
from mcml.files.clip_files import Clip
from mcml.files.import_options import ImportOptions
from mcml.files.open_clip import OpenClip
from mcml_service.actions.importing.encode_clip import EncodedClip, Progress, encode_clip
from mcml_service.actions.importing.keep_upload import Upload
from mcml_service.actions.importing.read_apart import ReadApart
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.encoding import DATA_PLACE, ClipEncoder, TrackRow
from mcml_service.storage.documents.tracks import Piece
from mcml_service.storage.transaction import Transaction

FLUSH_BYTES = 16 << 20
"""Limit of a clip's rows in memory before they are written in a separate transaction."""


@dataclass(frozen=True)
class Imported:
    """uuid of a stored document. file: the name of the file with the motion. skipped: it was there already."""

    uuid: str
    name: str
    file: str
    receipt: dict[str, Any]
    skipped: bool = False


class _StoredMeanwhile(Exception):  # noqa: N818
    """An equal clip was stored while this one was read."""

    def __init__(self, uuid: str) -> None:
        super().__init__(uuid)
        self.uuid = uuid


class Importer:
    """The import of one clip: `begin`, `read`, then `store` it, once or again.

    apart: the result of another process, if one has read the clip. made: the clip, if its files were written here. key:
    of the document, if a committed transaction already has a part of it.
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
        made: OpenClip | None = None,
    ) -> None:
        self.database = database
        self.clip = clip
        self.options = options
        self.settings = settings
        self.author = author
        self.executor = executor
        self.progress = progress
        self.apart = apart
        self.made = made
        self.encoder = ClipEncoder(executor)
        self.key: int | None = None
        self.uuid = ""
        self.project = 0
        self.uploads: list[Upload] = []
        self.rows: list[TrackRow] = []
        self.row_bytes = 0
        self.name = options.name or clip.document_name

    def begin(self) -> None:
        """Take the digests of the files, and let them be compressed."""
        if self.apart is not None:
            self.uploads = [Upload.of_packed(self.clip.kept_files[made.part], made) for made in self.apart.uploads]
            return
        self.uploads = [Upload.begin(part, file, self.executor) for part, file in self.clip.kept_files.items()]

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
                return self._store(twins[0])
            self._found = self._encode() if self.apart is None else self._take(self.apart)
        return None

    def _encode(self) -> EncodedClip:
        return encode_clip(self.clip, self.options, self.settings, self.encoder, self._keep, self.progress, self.made)

    def _take(self, apart: ReadApart) -> EncodedClip:
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
        """Wait for the compression; for a large clip, begin to store it."""
        with self._whole_or_absent():
            self._keep(self.encoder.rest())
            for upload in self.uploads:
                self._prepare(upload)

    def store_alone(self) -> Imported:
        """Store the clip in a separate transaction; if it fails, earlier written parts are removed."""
        try:
            with self._whole_or_absent(), self.database.write(self.author) as tx:
                return self.store(tx)
        except _StoredMeanwhile as meanwhile:
            return self._store(meanwhile.uuid)

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

    def _store(self, uuid: str) -> Imported:
        with self.database.read() as tx:
            stored = tx.documents.get(uuid)
            return Imported(
                stored.uuid, stored.name, self.clip.name, orjson.loads(tx.documents.receipt(stored.key)), skipped=True
            )

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
        encoded = self._found
        key = self._flush(tx)
        tx.tracks.write_shapes(key, encoded.shapes)
        tx.tracks.write_shape_runs(key, encoded.shape_rows, 0)
        tx.tracks.write_frame_runs(key, encoded.frame_runs, 0)
        tx.tracks.write_timeline(key, [Piece(1, 0, encoded.frames)] if encoded.frames else [], 0)
        tx.spans.write(key, encoded.spans, 0)
        tx.heads.write_header(key, encoded.header, 0)
        tx.heads.write_bones(key, encoded.bones, 0)
        tx.documents.write_content(
            key,
            0,
            skeleton=tx.heads.add_skeleton(self.project, encoded.skeleton, len(encoded.bones)),
            version=encoded.version,
            frames=encoded.frames,
            frame_time=encoded.frame_time,
            intact=encoded.intact,
        )
        if encoded.thumbnail is not None:
            tx.thumbnails.add(key, 1, encoded.thumbnail.data, encoded.thumbnail.facts)
        if self.skips_twins:
            # Wait for a concurrent import of an equal clip.
            tx.order()
        kept = [upload.attach(tx, key) for upload in self.uploads]
        twins = tx.uploads.twins(self.digests, self.project) if all(kept) else []
        if twins and self.skips_twins:
            raise _StoredMeanwhile(twins[0])
        facts = encoded.facts | {"twins": twins}
        receipt = orjson.dumps(facts).decode()
        tx.documents.publish(
            key, self.name, self.project, next_slot=encoded.frames, receipt=receipt, message=self.clip.name
        )
        return Imported(self.uuid, self.name, self.clip.name, facts)

    def _prepare(self, upload: Upload) -> None:
        """Compress new files; a large file is stored in separate transactions."""
        if upload.blocks is not None:
            return
        if upload.size and not upload.early:
            with self.database.read() as tx:
                if tx.uploads.find(upload.sha256, upload.size) is not None:
                    return
        pending: list[bytes] = []
        pending_bytes = 0
        for block in upload.compress_blocks(self.executor):
            pending.append(block)
            pending_bytes += len(block)
            if pending_bytes >= FLUSH_BYTES:
                with self.database.write(self.author) as tx:
                    key = self._begin(tx)
                    upload.add(tx, pending)
                self.key = key
                pending, pending_bytes = [], 0
        upload.blocks = pending
