"""Clips of one call that are stored together, in the order of their files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

from mcml.errors import McmlError
from mcml_service.actions.importing.import_clip import Imported, Importer
from mcml_service.storage.database import Database

BATCH_BYTES, BATCH_CLIPS = 16 << 20, 48
"""Of files whose clips are stored in one transaction."""

EARLY_CLIPS = 24
"""For which a commit is worth while where the importer would wait otherwise."""


@dataclass
class ImportResult:
    documents: list[Imported] = field(default_factory=list)
    problems: list[tuple[str, McmlError]] = field(default_factory=list)


class Batch:
    """Clips that were read and wait to be stored together: a commit takes as long as it takes to read a short clip."""

    def __init__(self, database: Database, author: str, result: ImportResult) -> None:
        self._database = database
        self._author = author
        self._result = result
        self._waiting: list[Importer] = []
        self._bytes = 0

    def take(self, importer: Importer) -> None:
        """Read a clip; store waiting clips when there are enough, or if this one needs them stored."""
        with self._blaming(importer):
            importer.begin()
            if importer.skips_twins and any(importer.digests == other.digests for other in self._waiting):
                self.store()
            skipped = importer.read()
            if skipped is not None:
                self.store()
                self._result.documents.append(skipped)
                return
            self._waiting.append(importer)
            self._bytes += importer.size
        if len(self._waiting) >= BATCH_CLIPS or self._bytes >= BATCH_BYTES:
            self.store()

    def store_early(self, following: int) -> None:
        """Store while there is nothing else to do, unless it is too little for a commit.

        following: clips to come. Before the last clips less is enough, because the whole import waits for these.
        """
        if len(self._waiting) >= min(EARLY_CLIPS, following):
            self.store()

    def store(self) -> None:
        """Store all waiting clips: in one transaction, or each separately if that fails or one has begun."""
        waiting, self._waiting, self._bytes = self._waiting, [], 0
        for importer in waiting:
            importer.compress()
        ready = []
        for importer in waiting:
            with self._blaming(importer):
                importer.finish()
                ready.append(importer)
        if len(ready) > 1 and all(importer.key is None for importer in ready):
            with suppress(Exception):
                with self._database.write(self._author) as tx, tx.gathering():
                    done = [importer.store(tx) for importer in ready]
                self._result.documents += done
                return
        for importer in ready:
            with self._blaming(importer):
                self._result.documents.append(importer.store_alone())

    @contextmanager
    def _blaming(self, importer: Importer) -> Iterator[None]:
        """An error is a problem of this file, noted behind those of the files before it."""
        try:
            yield
        except McmlError as error:
            self.store()
            name = importer.clip.name
            self._result.problems.append((name, error.in_file(name)))
