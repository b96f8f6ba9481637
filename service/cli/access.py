"""The library a command works on: a store on this machine through actions, or a server through its REST API.

Only what short commands and whole folders of files do is here; all else asks the API itself (`service.cli.api`).
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from schemas.documents import (
    DocumentDetail,
    DocumentPage,
    DocumentSummary,
    FileProblem,
    UploadResult,
)
from schemas.queries import QueryAnswer, QueryRequest
from service.actions.checking.check_names import file_name
from service.actions.exporting.export_motion import ExportOptions, export_document
from service.actions.importing.encode_clip import Progress
from service.actions.importing.upload_files import upload_files
from service.actions.reading.describe_document import detail, summary
from service.actions.reading.import_options import ImportOptions
from service.cli.api import Api, error_of
from service.formats.format import SourceFile
from service.settings import Settings
from service.storage.database import Database
from service.storage.filtering import DocumentFilter
from service.xpath.run import Queries
from service.xpath.writing import STREAMS


def name_of(path: Path) -> str:
    """The name of a file as text. Names on disk are bytes: UTF-8, or what an older system wrote."""
    name = os.fsencode(path.name)
    for encoding in ("utf-8", "cp949"):
        with suppress(UnicodeDecodeError):
            return name.decode(encoding)
    return name.decode("latin-1")


class Library(ABC):
    """What commands do to a library, in the words of the REST API."""

    @abstractmethod
    def import_paths(self, paths: list[Path], options: ImportOptions, progress: Progress | None) -> UploadResult: ...

    @abstractmethod
    def documents(self, wanted: DocumentFilter, limit: int) -> DocumentPage: ...

    @abstractmethod
    def document(self, uuid: str) -> DocumentDetail: ...

    @abstractmethod
    def export(self, uuid: str, options: ExportOptions) -> Any:
        """A context manager: (file name, blocks of bytes, notices as a list that fills)."""

    @abstractmethod
    def query(self, request: QueryRequest) -> QueryAnswer: ...

    @abstractmethod
    def query_stream(self, request: QueryRequest) -> Iterator[bytes]:
        """The whole answer in the form `request.as_`: xml, ndjson or csv."""


class LocalLibrary(Library):
    def __init__(self, database: Database, settings: Settings) -> None:
        self.database = database
        self.settings = settings

    def import_paths(self, paths: list[Path], options: ImportOptions, progress: Progress | None) -> UploadResult:
        with ExitStack() as stack:
            files = [SourceFile(name_of(path), stack.enter_context(path.open("rb"))) for path in paths]
            return upload_files(self.database, files, options, self.settings, progress=progress)

    def documents(self, wanted: DocumentFilter, limit: int) -> DocumentPage:
        with self.database.read() as tx:
            found = tx.documents.page(wanted, after=None, limit=limit)
            return DocumentPage(items=[summary(stored) for stored in found], total=tx.documents.count(wanted))

    def document(self, uuid: str) -> DocumentDetail:
        with self.database.read() as tx:
            return detail(tx, tx.documents.get(uuid))

    @contextmanager
    def export(self, uuid: str, options: ExportOptions) -> Iterator[tuple[str, Iterator[bytes], list[str]]]:
        with self.database.read() as tx:
            export = export_document(tx, tx.documents.get(uuid), options)
            notices: list[str] = []

            def content() -> Iterator[bytes]:
                yield from export.content
                notices.extend(notice.what for notice in export.notices)

            yield export.file_name, content(), notices

    def query(self, request: QueryRequest) -> QueryAnswer:
        queries = Queries(self.database, self.settings)
        try:
            return queries.answer(request)
        finally:
            queries.close()

    def query_stream(self, request: QueryRequest) -> Iterator[bytes]:
        queries = Queries(self.database, self.settings)
        try:
            write, _ = STREAMS[request.as_]
            yield from write(queries.stream(request))
        finally:
            queries.close()


class RemoteLibrary(Library):
    def __init__(self, api: Api) -> None:
        self.api = api

    def import_paths(self, paths: list[Path], options: ImportOptions, progress: Progress | None) -> UploadResult:
        data: dict[str, Any] = {
            "project": options.project,
            "description": options.description,
            "translation": options.translation,
            "on_duplicate": options.on_duplicate,
            "strict_names": str(options.strict_names).lower(),
            "label": [
                label.name if label.first is None else f"{label.name}:{label.first}-{label.last}"
                for label in options.labels
            ],
            "property": [f"{name}={value} {unit}".strip() for name, value, unit in options.properties],
        }
        for key in ("name", "encoding", "unit", "up", "frame_time", "skeleton", "movements"):
            if getattr(options, key) is not None:
                data[key] = getattr(options, key)
        with ExitStack() as stack:
            files = [("file", (name_of(path), stack.enter_context(path.open("rb")))) for path in paths]
            answer = self.api.send("POST", "/documents", data=data, files=files, accept=(201, 415, 422))
        body = answer.json()
        if answer.status_code != 201:
            if "problems" not in body:
                raise error_of(answer)
            return UploadResult(documents=[], problems=[FileProblem(**item) for item in body["problems"]])
        return UploadResult(**body)

    def documents(self, wanted: DocumentFilter, limit: int) -> DocumentPage:
        parameters: dict[str, Any] = {"deleted": wanted.deleted}
        pairs = (("project", wanted.project), ("q", wanted.text), ("motion_name", wanted.motion_name))
        parameters.update({key: value for key, value in (*pairs, ("format", wanted.format)) if value is not None})
        items: list[DocumentSummary] = []
        while True:
            # The server decides how many one page holds.
            parameters["limit"] = limit - len(items)
            page = DocumentPage(**self.api.send("GET", "/documents", params=parameters).json())
            items += page.items
            if page.next_cursor is None or len(items) >= limit:
                return DocumentPage(items=items, total=page.total)
            parameters["cursor"] = page.next_cursor

    def document(self, uuid: str) -> DocumentDetail:
        return DocumentDetail(**self.api.send("GET", f"/documents/{uuid}").json())

    @contextmanager
    def export(self, uuid: str, options: ExportOptions) -> Iterator[tuple[str, Iterator[bytes], list[str]]]:
        parameters = {
            "format": options.format,
            "first": options.first,
            "last": options.last,
            "names": options.names,
            "unit": options.unit,
            "up": options.up,
            "original": options.original,
        }
        given = {key: value for key, value in parameters.items() if value is not None}
        with self.api.stream("GET", f"/documents/{uuid}/export", params=given) as answer:
            disposition = answer.headers.get("content-disposition", "")
            # Only a name: whatever the server says, nothing is written outside the folder that was asked for.
            name = file_name(unquote(disposition.rpartition("UTF-8''")[2]) or f"{uuid}.{options.format}")
            notices = [item for item in answer.headers.get("x-mcml-notices", "").split(" | ") if item]
            yield name, answer.iter_bytes(1 << 20), notices

    def query(self, request: QueryRequest) -> QueryAnswer:
        return QueryAnswer(**self.api.send("POST", "/xpath", json=request.model_dump(by_alias=True)).json())

    def query_stream(self, request: QueryRequest) -> Iterator[bytes]:
        with self.api.stream("POST", "/xpath", json=request.model_dump(by_alias=True)) as answer:
            yield from answer.iter_bytes(1 << 20)
