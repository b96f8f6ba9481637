"""Documents that are new or changed in the repository, written into a folder."""

from __future__ import annotations

import hashlib
import os
import posixpath
import tempfile
import zipfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from mcml.answers import Content
from mcml.client.client import Client
from mcml.client.folders import ARCHIVES
from mcml.client.sync.bindings import Binding, Bindings, Coming
from mcml.client.sync.events import ENDING, Event
from mcml.client.sync.looks import Looker
from mcml.errors import ConversionError, FormatError, McmlError, NotFoundError
from mcml.files.check_names import file_name
from mcml.files.companions import COMPANION_ENDINGS
from mcml_schemas.documents import DocumentDetail, DocumentSummary

PARTS = ".mcml-sync-"
"""How the folders of unfinished downloads begin."""
MCML = ".mcml"
_MOST_PENDING = 64
_BLOCK = 1 << 20
_SECOND = (".asf", ".ast", *COMPANION_ENDINGS, ".xml")
"""Files that accompany the one with the motion."""


@dataclass
class _Part:
    """A file that is downloaded and has no name yet."""

    name: str
    path: Path
    digest: str


@dataclass
class _Download:
    """A document with all its files downloaded. parts: by path in the folder."""

    binding: Binding
    revision: int
    parts: dict[str, _Part]


class Fetcher:
    """Writes documents of a project into a folder: the original files, or MCML of edited documents."""

    def __init__(self, client: Client, folder: Path, bindings: Bindings, looker: Looker, project: str) -> None:
        self._client = client
        self._folder = folder
        self._bindings = bindings
        self._looker = looker
        self._project = project
        self._sums: dict[str, str] = {}
        self._reserved: dict[str, str] = {}

    def fetch(self, sums: dict[str, str]) -> Iterator[Event]:
        """Write what the folder lacks. sums: of its files."""
        self._sums, self._reserved = dict(sums), {}
        try:
            items: list[DocumentSummary] = self._client.every("list_documents", project=self._project).items
        except NotFoundError:
            items = []
        wanted = [item for item in items if self._is_wanted(item)]
        if wanted:
            with tempfile.TemporaryDirectory(prefix=PARTS, dir=self._folder) as place:
                for start in range(0, len(wanted), _MOST_PENDING):
                    yield from self._fetch(wanted[start : start + _MOST_PENDING], Path(place))
        listed = {item.id for item in items}
        for binding in self._bindings.all():
            if binding.document not in listed:
                detail = f"The document is deleted, or not in project {self._project} any more. The file stays."
                yield Event("left", next(reversed(binding.files)), binding.document, detail=detail)

    def _is_wanted(self, item: DocumentSummary) -> bool:
        """Whether a document is new, or changed while its files did not."""
        bindings = self._bindings.of_document(item.id)
        if not bindings:
            return True
        own = _find_mcml(bindings)
        if max(binding.revision for binding in bindings) >= item.revision or (own and not self._is_unchanged(own)):
            return False
        return any(self._is_unchanged(binding) for binding in bindings)

    def _fetch(self, items: list[DocumentSummary], place: Path) -> Iterator[Event]:
        downloads = []
        for item in items:
            try:
                downloads.append(self._download(item, place / item.id))
            except ENDING:
                raise
            except McmlError as error:
                yield Event.of_error("failed", item.name, error, item.id)
        yield from self._finish(downloads)

    def _download(self, item: DocumentSummary, place: Path) -> _Download:
        bindings = self._bindings.of_document(item.id)
        if not bindings:
            return self._download_new(item, place)
        own = _find_mcml(bindings)
        target = next(iter(own.files)) if own is not None else self._free_name(_beside(bindings[0], item), item.id)
        part = self._save(self._export(item, "mcml"), place, posixpath.basename(target))
        return _Download(own or Binding(item.id, item.revision, {}), item.revision, self._reserve({target: part}))

    def _is_unchanged(self, binding: Binding) -> bool:
        return all(self._sums.get(path) == digest for path, digest in binding.files.items())

    def _free_name(self, target: str, uuid: str) -> str:
        if not os.path.lexists(self._folder / target) and target not in self._reserved:
            return target
        stem, extension = posixpath.splitext(target)
        return f"{stem}-{uuid}{extension}"

    def _export(self, item: DocumentSummary, form: str) -> Content:
        revision = item.revision if form == "mcml" else None
        content: Content = self._client.call("export_document", id=item.id, format=form, revision=revision)
        return content

    def _download_new(self, item: DocumentSummary, place: Path) -> _Download:
        detail: DocumentDetail = self._client.call("get_document", id=item.id)
        parts: list[_Part] | None = None
        if detail.original and detail.revision == 1 and detail.format != "mcml":
            parts = self._download_original(item, detail, place)
        if parts is None:
            name = f"{file_name(item.name)}{MCML}"
            parts = [self._save(self._export(item, "mcml"), place, name)]
        take = next((file.part.partition("#")[2] for file in detail.files if "#" in file.part), None)
        binding = Binding(item.id, item.revision, {}, take)
        return _Download(binding, item.revision, self._reserve(self._choose_names(parts, item.id)))

    def _download_original(self, item: DocumentSummary, detail: DocumentDetail, place: Path) -> list[_Part] | None:
        try:
            content = self._export(item, "original")
        except ConversionError:
            return None
        if len(detail.files) == 1:
            return [self._save(content, place, file_name(detail.files[0].name))]
        archive = self._save(content, place, "files.zip")
        parts = []
        sizes = {file_name(file.name): file.bytes for file in detail.files}
        with zipfile.ZipFile(archive.path) as members:
            for name, size in sizes.items():
                with members.open(name) as stream:
                    parts.append(_write_part(iter(lambda: stream.read(_BLOCK), b""), place / name, name, size))
        return sorted(parts, key=lambda part: not part.name.lower().endswith(_SECOND))

    def _save(self, content: Content, place: Path, name: str) -> _Part:
        place.mkdir(exist_ok=True)
        return _write_part(content.blocks, place / name, name, None)

    def _choose_names(self, parts: list[_Part], uuid: str) -> dict[str, _Part]:
        """Paths in the folder: where others have the names, in a folder of the document's own."""
        for prefix in ("", f"{posixpath.splitext(parts[-1].name)[0]}-{uuid[-6:]}/", f"{uuid}/"):
            named = {prefix + part.name: part for part in parts}
            if all(self._is_free(path, part) for path, part in named.items()):
                break
        return named

    def _is_free(self, path: str, part: _Part) -> bool:
        known = self._sums.get(path) or self._reserved.get(path)
        return known == part.digest if known is not None else not os.path.lexists(self._folder / path)

    def _reserve(self, parts: dict[str, _Part]) -> dict[str, _Part]:
        """The same, with their paths taken for later downloads."""
        self._reserved |= {path: part.digest for path, part in parts.items()}
        return parts

    def _finish(self, downloads: list[_Download]) -> Iterator[Event]:
        """Give downloads their names. The record has the intention first, so that an interruption loses nothing."""
        for download in downloads:
            files = {path: part.digest for path, part in download.parts.items()}
            download.binding.coming = Coming(download.revision, files)
            if not download.binding.files:
                self._bindings.add(download.binding)
        if downloads:
            self._bindings.save()
        for download in downloads:
            for path, part in download.parts.items():
                self._place(part, path, download.binding)
        self._bindings.finish_downloads(self._sums)
        if downloads:
            self._bindings.save()
        for download in downloads:
            if download.binding.revision == download.revision and download.binding.files:
                yield Event("fetched", [*download.parts][-1], download.binding.document, download.revision)

    def _place(self, part: _Part, path: str, binding: Binding) -> None:
        """Move a download to its path; a file that is there already stays if it is equal, or changed just now."""
        target = self._folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        if self._sums.get(path) != part.digest:
            if os.path.lexists(target) and not (path in binding.files and self._looker.is_still(path)):
                return
            part.path.replace(target)
            self._sums[path] = part.digest
            self._looker.know(path, part.digest)


def _find_mcml(bindings: list[Binding]) -> Binding | None:
    """The binding whose file is MCML: the one to write edits to."""
    return next((each for each in bindings if [*each.files][-1].lower().endswith(MCML)), None)


def _beside(binding: Binding, item: DocumentSummary) -> str:
    """The path of the MCML of an edited document: beside its file."""
    stem, extension = posixpath.splitext([*binding.files][-1])
    if extension.lower() in ARCHIVES:
        return posixpath.join(posixpath.dirname(stem), f"{file_name(item.name)}{MCML}")
    return f"{stem}{'-' + file_name(binding.take) if binding.take else ''}{MCML}"


def _write_part(blocks: Iterable[bytes | memoryview], path: Path, name: str, size: int | None) -> _Part:
    """Write a download. Raises FormatError for more bytes than `size`."""
    path.parent.mkdir(exist_ok=True)
    hashed = hashlib.sha256()
    length = 0
    with path.open("wb") as stream:
        for block in blocks:
            length += len(block)
            if size is not None and length > size:
                raise FormatError(f"{name} is longer than the {size} bytes that the repository states.")
            hashed.update(block)
            stream.write(block)
        stream.flush()
        os.fsync(stream.fileno())
    return _Part(name, path, hashed.hexdigest())
