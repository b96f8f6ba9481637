"""Import: files in, whole documents out. Each document is stored completely or not at all.

Reading, checking and compressing happen outside the write lock. A small clip is stored in one transaction; a large one
in several short ones under the state "importing", which no read sees, and a last one that makes it visible.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

from service.actions.check_names import check_frame_time, check_head, given_name, name_of_file
from service.actions.describe_clip import receipt
from service.actions.edit_header import checked_axis, checked_property, checked_unit, with_facts
from service.actions.gather_files import Clip, SkeletonLookup, gathered
from service.actions.import_options import ImportOptions
from service.actions.keep_upload import WORKERS, Upload
from service.errors import DocumentError, McmlError, Notice
from service.formats import FORMATS
from service.formats.format import Limits, ReadOptions, SourceFile
from service.mcml import joint_names, motion_names
from service.mcml.dtd import validate_by_shapes
from service.mcml.elements import Element, from_head, to_head
from service.mcml.joint_names import NamingReport
from service.mcml.reader import Limits as McmlLimits
from service.mcml.reader import read_document
from service.motion.clip import ClipHead, ClipStream
from service.settings import Settings
from service.storage.database import Database, Transaction
from service.storage.encoding import ClipEncoder
from service.storage.tracks import Piece

FLUSH_BYTES = 16 << 20
"""Rows of a clip that wait in memory before they are written in a transaction of their own."""


@dataclass(frozen=True)
class Imported:
    """uuid of a stored document. skipped: it was there already."""

    uuid: str
    name: str
    receipt: dict[str, Any]
    skipped: bool = False


@dataclass
class ImportResult:
    documents: list[Imported] = field(default_factory=list)
    problems: list[tuple[str, McmlError]] = field(default_factory=list)


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
        for clip in found.clips:
            chosen = options if len(found.clips) == 1 else replace(options, name=None)
            try:
                importer = _Importer(database, clip, chosen, settings, author, executor, progress)
                result.documents.append(importer.run())
            except McmlError as error:
                result.problems.append((clip.name, error.in_file(clip.name)))
    return result


def open_clip(
    clip: Clip, options: ImportOptions, settings: Settings
) -> tuple[Element, ClipStream, NamingReport | None]:
    """The `mcml` element without motion, the stream of frames, and how joints were named, of a clip's files."""
    if clip.format == "mcml":
        read = read_document(clip.files["mcml"].stream, _mcml_limits(settings), options.encoding)
        check_head(read.document, read.clip.head, settings.max_joints)
        document = with_facts(
            read.document,
            description=options.description or None,
            properties=options.properties or None,
            unit=options.unit,
            up=options.up,
        )
        return document, read.clip.with_head(to_head(document, read.clip.head.frame_time)), None
    reader = ReadOptions(encoding=options.encoding, translation=options.translation, limits=_limits(settings))
    stream = FORMATS[clip.format].read(clip.files, reader)
    skeleton, report = joint_names.named(stream.head.skeleton)
    fields = {"filename": clip.name.rsplit("/", 1)[-1]} | stream.head.fields
    if options.unit:
        fields["calibration_unit"] = checked_unit(options.unit)
    if options.up:
        fields["global_axis_of_gravity"] = checked_axis(options.up)
    head = replace(
        stream.head,
        skeleton=skeleton,
        fields=fields,
        description=options.description.strip(),
        properties=tuple(checked_property(*item) for item in options.properties),
    )
    return from_head(head), stream.with_head(head), report


def _limits(settings: Settings) -> Limits:
    return Limits(joints=settings.max_joints, frames=settings.max_frames, values=settings.max_values)


def _mcml_limits(settings: Settings) -> McmlLimits:
    return McmlLimits(max_bytes=settings.max_upload_bytes, max_frames=settings.max_frames)


class _StoredMeanwhile(Exception):  # noqa: N818
    """An equal clip was stored while this one was read."""

    def __init__(self, uuid: str) -> None:
        super().__init__(uuid)
        self.uuid = uuid


class _Importer:
    """The import of one clip."""

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
        self.committed = False
        self.uploads: list[Upload] = []
        self.rows: list[dict[str, Any]] = []
        self.row_bytes = 0
        self.name = options.name or name_of_file(clip.name)

    def run(self) -> Imported:
        """Store the clip; what was written of one that fails is removed."""
        try:
            return self._run()
        except _StoredMeanwhile as meanwhile:
            self._discard()
            return self._stored(meanwhile.uuid)
        except BaseException:
            self._discard()
            raise

    def _discard(self) -> None:
        # Where the store itself fails, the rows stay invisible and are swept when their lease has ended.
        with suppress(Exception):
            # A key of a transaction that was rolled back may be another document's by now.
            if self.key is not None and self.committed:
                with self.database.write(self.author) as tx:
                    tx.documents.remove_import(self.key)
                    for upload in self.uploads:
                        upload.abandon(tx)

    def _stored(self, uuid: str) -> Imported:
        with self.database.read() as tx:
            stored = tx.documents.get(uuid)
            return Imported(stored.uuid, stored.name, json.loads(tx.documents.receipt(stored.key)), skipped=True)

    def _run(self) -> Imported:
        self.uploads = uploads = [Upload.begin(part, file, self.executor) for part, file in self.clip.files.items()]
        twins = self._twins(uploads)
        if twins and self.options.on_duplicate == "skip":
            return self._stored(twins[0])
        document, stream, report = open_clip(self.clip, self.options, self.settings)
        encoder = ClipEncoder(self.executor)
        for block in stream.blocks():
            self._keep(encoder.add(block))
            if self.progress is not None:
                self.progress(self.clip.name, encoder.frames, stream.frames)
        encoder.close()
        frame_time = self._frame_time(stream)
        head = replace(stream.head, frame_time=frame_time)
        if self.clip.format != "mcml":
            validate_by_shapes(document, [(shape, 1) for shape in encoder.shapes], head.skeleton.names)
        self._make_names_canonical(encoder, stream)
        self._add_labels(encoder)
        facts = receipt(head, encoder.frames, report, stream.notices)
        facts["twins"] = twins
        self._keep(encoder.rest())
        return self._store(document, head, encoder, frame_time, facts, uploads)

    def _twins(self, uploads: list[Upload]) -> list[str]:
        """Documents made from equal files; notes which files are kept already."""
        with self.database.read() as tx:
            for upload in uploads:
                upload.kept = tx.uploads.find(upload.sha256, upload.size) is not None
            project = tx.projects.find(self.options.project) if all(upload.kept for upload in uploads) else None
            if project is None:
                return []
            return tx.uploads.twins({upload.part: upload.sha256 for upload in uploads}, project)

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
                    self._flush(tx)
                self.committed = True

    def _begin(self, tx: Transaction) -> int:
        """The document's key, its lease renewed where an earlier transaction made it."""
        if self.key is None:
            self.project = tx.projects.get_or_add(self.options.project)
            self.key, self.uuid = tx.documents.begin(self.project, self.name, self.clip.format)
        else:
            tx.documents.renew_lease(self.key)
        return self.key

    def _flush(self, tx: Transaction) -> int:
        key = self._begin(tx)
        tx.tracks.write_chunks(key, self.rows, 0)
        self.rows, self.row_bytes = [], 0
        return key

    def _store(
        self,
        document: Element,
        head: ClipHead,
        encoder: ClipEncoder,
        frame_time: str | None,
        facts: dict[str, Any],
        uploads: list[Upload],
    ) -> Imported:
        for upload in uploads:
            self._prepare(upload)
        header, forest = document.children[0], document.children[1:]
        with self.database.write(self.author) as tx:
            key = self._flush(tx)
            tx.tracks.write_shapes(key, encoder.shapes)
            tx.tracks.write_shape_runs(key, encoder.shape_rows, 0)
            tx.tracks.write_frame_runs(key, encoder.ids.rows, 0)
            tx.tracks.write_timeline(key, [Piece(1, 0, encoder.frames)] if encoder.frames else [], 0)
            tx.spans.write(key, encoder.spans.rows, 0)
            skeleton = tx.heads.add_skeleton(self.project, forest, len(head.skeleton))
            tx.heads.write_header(key, header, 0)
            tx.heads.write_bones(key, list(head.skeleton.names), 0)
            tx.documents.write_content(
                key,
                0,
                skeleton=skeleton,
                version=document.attributes["version"],
                frames=encoder.frames,
                frame_time=frame_time,
                intact=frame_time == self._source_frame_time(head, frame_time),
            )
            for upload in uploads:
                upload.attach(tx, key)
            self._skip_twins(tx)
            tx.documents.publish(
                key, next_slot=encoder.frames, receipt=json.dumps(facts, ensure_ascii=False), message=self.clip.name
            )
        return Imported(self.uuid, self.name, facts)

    def _skip_twins(self, tx: Transaction) -> None:
        """An equal import that became visible since this one began counts as stored already, too."""
        if self.options.on_duplicate == "skip":
            tx.dialect.order_commits(tx.connection)
            digests = {upload.part: upload.sha256 for upload in self.uploads}
            twins = [uuid for uuid in tx.uploads.twins(digests, self.project) if uuid != self.uuid]
            if twins:
                raise _StoredMeanwhile(twins[0])

    def _source_frame_time(self, head: ClipHead, frame_time: str | None) -> str | None:
        # A stated frame time changes what BVH holds; AMC and HTR files have no place for it.
        return frame_time if self.options.frame_time is None or head.format != "bvh" else None

    def _prepare(self, upload: Upload) -> None:
        """Compress what is not stored yet; a large file goes into the store in transactions of its own."""
        if upload.kept:
            return
        pending: list[bytes] = []
        pending_bytes = 0
        for block in upload.compressed(self.executor):
            pending.append(block)
            pending_bytes += len(block)
            if pending_bytes >= FLUSH_BYTES:
                with self.database.write(self.author) as tx:
                    self._begin(tx)
                    upload.add(tx, pending)
                self.committed = True
                pending, pending_bytes = [], 0
        upload.blocks = pending


def _skeleton_lookup(database: Database, uuid: str) -> SkeletonLookup:
    def lookup() -> SourceFile | None:
        from service.actions.export_motion import skeleton_file

        with database.read() as tx:
            return skeleton_file(tx, tx.documents.get(uuid))

    return lookup
