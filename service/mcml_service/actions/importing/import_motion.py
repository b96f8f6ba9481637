"""Import: files in, whole documents out. Each document is stored completely or not at all.

Reading, checking and compressing happen outside the write lock. Small clips of one call are stored several to a
transaction; a large one in several short ones under the state "importing", which no read sees, and a last one that
makes it visible.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from mcml.files.check_names import given_name
from mcml.files.clip_files import Clip
from mcml.files.gather_files import SkeletonLookup, gathered
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_service.actions.importing.encode_clip import Progress
from mcml_service.actions.importing.import_batch import Batch, ImportResult
from mcml_service.actions.importing.import_clip import Importer
from mcml_service.actions.importing.import_pool import FEWEST_CLIPS, MOST_BYTES, ImportPool, reading_ahead
from mcml_service.actions.importing.keep_upload import WORKERS, digest_of
from mcml_service.settings import Settings
from mcml_service.storage.database import Database


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
    lookup = skeleton_lookup(database, options.skeleton) if options.skeleton else None
    result = ImportResult()
    with gathered(files, settings.file_limits, lookup, options) as gathering, ThreadPoolExecutor(WORKERS) as executor:
        result.problems += gathering.problems
        chosen = options if len(gathering.clips) == 1 else replace(options, name=None)
        batch = Batch(database, author, result)
        with reading_ahead(_short_clips(database, gathering.clips, chosen), chosen, settings, pool) as workers:
            try:
                for number, clip in enumerate(gathering.clips):
                    if workers.is_behind(number):
                        batch.store_early(len(gathering.clips) - number)
                    apart = workers.take(number)
                    batch.take(Importer(database, clip, chosen, settings, author, executor, progress, apart))
            finally:
                # Clips that were read before the import was stopped are stored.
                batch.store()
    return result


def _short_clips(database: Database, clips: list[Clip], options: ImportOptions) -> dict[int, Clip]:
    """Return the clips that another process may read, by their number: not large or existing ones."""
    short = {
        number: clip
        for number, clip in enumerate(clips)
        if sum(file.stream.seek(0, os.SEEK_END) for file in clip.files.values()) <= MOST_BYTES
    }
    if options.on_duplicate != "skip" or len(short) < FEWEST_CLIPS:
        return short
    with database.read() as tx:
        project = tx.projects.find(options.project)
        if project is None:
            return short

        def is_stored(clip: Clip) -> bool:
            digests = {part: digest_of(file) for part, file in clip.kept_files.items()}
            return bool(tx.uploads.twins(digests, project))

        return {number: clip for number, clip in short.items() if not is_stored(clip)}


def skeleton_lookup(database: Database, uuid: str) -> SkeletonLookup:
    """Return what finds the ASF of a stored document."""

    def lookup() -> SourceFile | None:
        from mcml_service.actions.exporting.export_motion import skeleton_file

        with database.read() as tx:
            return skeleton_file(tx, tx.documents.get(uuid))

    return lookup
