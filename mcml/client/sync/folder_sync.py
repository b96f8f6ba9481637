"""One round of a sync: new files are imported, changed files replace the frames of their documents."""

from __future__ import annotations

import posixpath
import shutil
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from mcml.answers import UploadError
from mcml.client.client import Client
from mcml.client.folders import ARCHIVES
from mcml.client.sync.bindings import Binding, Bindings
from mcml.client.sync.events import ENDING, Event
from mcml.client.sync.fetching import PARTS, Fetcher
from mcml.client.sync.looks import Look, Looker
from mcml.client.sync.units import Unit, make_batches, make_unit, make_units
from mcml.errors import ConflictError, McmlError, NotFoundError, UnsupportedError
from mcml.files.gather_files import gathered
from mcml.files.limits import FileLimits
from mcml.files.on_disk import name_of, opened_files
from mcml_schemas.documents import DocumentDetail, ImportedDocument, UploadResult
from mcml_schemas.revisions import FileReplaced


class FolderSync:
    """The sync of a folder with a project; each `run` is a round.

    bindings: the record of the folder. options: of the operation upload_documents. both: documents are also written
    into the folder. told: receives files done, of how many, and a name.
    """

    def __init__(
        self,
        client: Client,
        folder: Path,
        bindings: Bindings,
        project: str,
        options: dict[str, Any],
        told: Callable[[int, int, str], None],
        *,
        both: bool = False,
    ) -> None:
        self.unchanged = 0
        self._client = client
        self._folder = folder
        self._bindings = bindings
        self._options = options | {"project": project, "on_duplicate": "skip"}
        self._told = told
        self._looker = Looker(folder)
        self._fetcher = Fetcher(client, folder, bindings, self._looker, project) if both else None
        self._refused: set[tuple[object, ...]] = set()
        self._reported: set[Event] = set()

    def run(self) -> Iterator[Event]:
        """Sync once. Events that are true for longer, such as conflicts, come once. Raises errors of the repository."""
        for leftover in self._folder.glob(f"{PARTS}*"):
            shutil.rmtree(leftover, ignore_errors=True)
        look = self._looker.look(self._told)
        self._bindings.finish_downloads(look.sums)
        for event in self._sync(look):
            lasting = event.action not in ("stored", "skipped", "replaced", "fetched")
            if not lasting or event not in self._reported:
                yield event
            if lasting:
                self._reported.add(event)

    def _sync(self, look: Look) -> Iterator[Event]:
        yield from (Event("waiting", path) for path in sorted(look.busy))
        yield from (Event("failed", path, detail=f"cannot be read: {why}.") for path, why in look.faults.items())
        changed = list(self._find_changed(look))
        units = self._find_new(look)
        most = len(changed) + sum(map(len, units))
        for done, binding in enumerate(changed):
            self._told(done, most, next(reversed(binding.files)))
            yield from self._replace(binding, look)
        for unit in {self._paths_of(binding) for binding in changed if binding.take is not None}:
            yield from self._import_new_takes(unit, look)
        done = len(changed)
        for batch in make_batches(self._folder, units):
            self._told(done, most, batch[0][-1])
            yield from self._import(batch, look)
            done += sum(map(len, batch))
        yield from self._find_gone(look)
        if self._fetcher is not None:
            yield from self._fetcher.fetch(look.sums)

    def _find_changed(self, look: Look) -> Iterator[Binding]:
        self.unchanged = 0
        for binding in self._bindings.all():
            paths = self._paths_of(binding)
            if all(path in look.sums for path in paths):
                if {path: look.sums[path] for path in paths} == binding.files:
                    self.unchanged += 1
                elif binding.is_copy:
                    # Its files are new again.
                    self._bindings.remove(binding)
                else:
                    yield binding

    def _paths_of(self, binding: Binding) -> Unit:
        """The files of a binding; a changed glTF may name other buffers."""
        path = next(reversed(binding.files))
        if not path.lower().endswith(".gltf"):
            return tuple(binding.files)
        return make_unit(self._folder, path)

    def _find_new(self, look: Look) -> list[Unit]:
        new = [path for path in look.sums if not self._bindings.of_path(path)]
        units = make_units(self._folder, new, look.sums, complete=not look.busy and not look.faults)
        return [
            unit
            for unit in units
            if all(path in look.sums for path in unit) and (self._key(unit, look) not in self._refused)
        ]

    def _key(self, paths: Unit, look: Look, document: str = "") -> tuple[object, ...]:
        return (document, *((path, look.sums[path]) for path in paths))

    def _find_gone(self, look: Look) -> Iterator[Event]:
        here = {*look.sums, *look.busy, *look.faults}
        for binding in self._bindings.all():
            gone = [path for path in binding.files if path not in here]
            copies = [each for each in self._bindings.of_document(binding.document) if here.issuperset(each.files)]
            if gone and copies:
                self._bindings.remove(binding)
                copies[0].is_copy = copies[0].is_copy and any(not each.is_copy for each in copies)
                self._bindings.save()
            elif gone:
                remedy = f"The document stays. To delete it: mcml delete {binding.document}"
                yield from (Event("gone", path, binding.document, remedy=remedy) for path in gone)

    def _open(self, paths: Unit) -> AbstractContextManager[list[Any]]:
        return opened_files([self._folder / path for path in paths])

    def _import_new_takes(self, unit: Unit, look: Look) -> Iterator[Event]:
        """Import the takes that a changed file has beside those that are documents."""
        known = {binding.take for binding in self._bindings.of_path(unit[-1])}
        with self._open(unit) as files, gathered(files, FileLimits()) as clips:
            takes = [clip.take for clip in clips.clips if clip.take is not None and clip.take not in known]
        for take in takes:
            yield from self._import([unit], look, take)

    def _import(self, batch: list[Unit], look: Look, take: str | None = None) -> Iterator[Event]:
        """Send the files of some clips in one call, and record their documents. take: one of the motions in them."""
        paths = tuple(dict.fromkeys(path for unit in batch for path in unit))
        try:
            with self._open(paths) as files:
                result: UploadResult = self._client.call("upload_documents", file=files, take=take, **self._options)
        except UploadError as error:
            result = UploadResult(documents=[], problems=error.problems)
        except ENDING:
            raise
        except McmlError as error:
            if len(batch) > 1:
                for unit in batch:
                    yield from self._import([unit], look)
            elif self._are_still(paths):
                self._refused.add(self._key(paths, look))
                yield Event.of_error("failed", paths[-1], error)
            else:
                yield Event("waiting", paths[-1])
            return
        bound: set[object] = set()
        for document in result.documents:
            yield from self._bind(document, batch, bound, look)
        self._bindings.save()
        by_name = {name_of(Path(path)): path for path in paths}
        for problem in result.problems:
            path = by_name.get(problem.file)
            if path is not None and not self._are_still((path,)):
                yield Event("waiting", path)
                continue
            fault = problem.problem
            line = f"line {fault.where.line}: " if fault.where and fault.where.line else ""
            place = path or f"{paths[-1]}: {problem.file}"
            yield Event("failed", place, detail=f"{line}{fault.detail}", remedy=fault.remedy or "")
            self._refused.update(self._key(unit, look) for unit in batch if path in unit)

    def _are_still(self, paths: Unit) -> bool:
        """Whether the files are as they were looked at."""
        return all(self._looker.is_still(path) for path in paths)

    def _bind(self, document: ImportedDocument, batch: list[Unit], bound: set[object], look: Look) -> Iterator[Event]:
        """Record the document of a unit. bound: units of the batch that have theirs, with the take."""
        detail: DocumentDetail = self._client.call("get_document", id=document.id)
        take = next((file.part.partition("#")[2] for file in detail.files if "#" in file.part), None)
        units = [unit for unit in batch if _match_files(detail, unit, look, alone=len(batch) == 1)]
        unit = next((unit for unit in units if (unit, take) not in bound), units[0] if units else None)
        if unit is None:
            return
        bound.add((unit, take))
        files = _match_files(detail, unit, look, alone=len(batch) == 1)
        # The file has the frames of the import, not those of later edits.
        revision = detail.revision if detail.original or not document.skipped else 1
        for binding in self._bindings.of_document(document.id):
            if binding.files.keys() == files.keys():
                self._bindings.remove(binding)
        others = self._bindings.of_document(document.id)
        is_copy = document.skipped and any(all(path in look.sums for path in each.files) for each in others)
        self._bindings.add(Binding(document.id, revision, files, take, is_copy))
        yield Event("skipped" if document.skipped else "stored", unit[-1], document.id, detail.revision)

    def _replace(self, binding: Binding, look: Look) -> Iterator[Event]:
        """Replace the frames of a document by those of its changed files, where the document did not change."""
        uuid, paths = binding.document, self._paths_of(binding)
        path = paths[-1]
        try:
            detail: DocumentDetail = self._client.call("get_document", id=uuid)
        except NotFoundError:
            remedy = f"Restore it (mcml restore {uuid}), or rename the file to store it as a new document."
            yield Event("conflict", path, uuid, detail="The file changed, and its document is deleted.", remedy=remedy)
            return
        key = self._key(paths, look, f"{uuid} {detail.revision}")
        if key in self._refused:
            return
        try:
            self._check_alone(binding)
            revision, is_new = self._send_frames(binding, detail.revision)
        except ENDING:
            raise
        except McmlError as error:
            if self._are_still(paths):
                self._refused.add(key)
                yield Event.of_error("conflict" if isinstance(error, ConflictError) else "failed", path, error, uuid)
            else:
                yield Event("waiting", path)
            return
        # A file that changed while it was sent is sent again.
        still = self._are_still(paths)
        self._bindings.update(binding, revision, {each: look.sums[each] if still else "" for each in paths})
        self._bindings.save()
        if is_new:
            yield Event("replaced", path, uuid, revision)
        else:
            self.unchanged += 1

    def _check_alone(self, binding: Binding) -> None:
        """Raise UnsupportedError for an archive with several clips."""
        path = next(reversed(binding.files))
        clips = {each.document for each in self._bindings.of_path(path) if each.take is None}
        if len(clips) > 1 and Path(path).suffix.lower() in ARCHIVES:
            raise UnsupportedError(
                f"The archive changed and has {len(clips)} clips.", remedy="Put its files into the folder in its place."
            )

    def _send_frames(self, binding: Binding, current: int) -> tuple[int, bool]:
        """Return the revision that has the frames of the files, and whether it is a new one.

        Raises ConflictError where the document changed too, UnsupportedError for another skeleton or rate.
        """
        uuid, paths = binding.document, self._paths_of(binding)
        stated: dict[str, Any] = {"id": uuid, "take": binding.take, "encoding": self._options.get("encoding")}
        # Of another revision, the file may be the cause: sent before an interruption, or by `mcml import --as`.
        is_ours = current == binding.revision
        match = f'"{binding.revision}"' if is_ours else None
        try:
            with self._open(paths) as files:
                made: FileReplaced = self._client.call(
                    "replace_file", file=files, dry_run=not is_ours, if_match=match, **stated
                )
        except ConflictError as error:
            detail: DocumentDetail = self._client.call("get_document", id=uuid)
            if detail.revision != binding.revision:
                raise _make_conflict(uuid, detail.revision) from None
            raise UnsupportedError(error.what, remedy="Rename the file to store it as a new document.") from error
        if not is_ours and made.first is not None:
            raise _make_conflict(uuid, current)
        return made.revision, is_ours and made.first is not None


def _make_conflict(uuid: str, revision: int) -> ConflictError:
    return ConflictError(
        f"The file changed, and the document {uuid} too (revision {revision}).",
        remedy=f"To take the file: mcml import FILE --as {uuid}. To keep both: rename the file.",
    )


def _match_files(detail: DocumentDetail, unit: Unit, look: Look, *, alone: bool) -> dict[str, str]:
    """The sums of the files of a unit, by path, where the document is made of them; else nothing.

    alone: whether nothing else was sent, so that it is made of them in any case: of an archive, or of files that
    changed while they were sent.
    """
    digests = {file.sha256 for file in detail.files}
    if all(look.sums[path] in digests for path in unit):
        return {path: look.sums[path] for path in unit}
    stored = {file.name: file.sha256 for file in detail.files}
    return {path: stored.get(posixpath.basename(path), look.sums[path]) for path in unit} if alone else {}
