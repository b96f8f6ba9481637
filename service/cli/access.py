"""The library a command works on: a store on this machine through actions, or a server through its REST API."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import httpx

from schemas.compose import Composed, ComposeRequest
from schemas.documents import (
    ChangedDocument,
    ChangedDocuments,
    DocumentDetail,
    DocumentPage,
    DocumentSummary,
    FileProblem,
    ImportedDocument,
    LabelPage,
    Receipt,
    UploadResult,
)
from schemas.documents import Label as WireLabel
from schemas.frames import FrameEdits, FramesEdited
from schemas.labels import LabelQuery, SuggestedLabels
from schemas.queries import QueryAnswer, QueryRequest
from schemas.retarget import Retargeted, RetargetRequest
from service.actions.change_document import add_labels
from service.actions.change_frames import edit_frames
from service.actions.check_names import file_name
from service.actions.describe_document import detail, summary
from service.actions.describe_problem import problem_of
from service.actions.edit_labels import label_by_query, label_table, write_label_table
from service.actions.export_motion import ExportOptions, export_document
from service.actions.import_motion import Progress, import_files
from service.actions.import_options import ImportOptions
from service.actions.set_properties import set_properties
from service.errors import AccessError, McmlError, NotFoundError, Place, StoreError
from service.formats.format import SourceFile
from service.settings import Settings
from service.storage.database import Database
from service.storage.documents import DocumentFilter, StoredDocument
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

    @abstractmethod
    def compose(self, request: ComposeRequest) -> Composed: ...

    @abstractmethod
    def retarget(self, uuid: str, request: RetargetRequest) -> Retargeted: ...

    @abstractmethod
    def edit_frames(self, uuid: str, request: FrameEdits) -> FramesEdited: ...

    @abstractmethod
    def set_properties(self, table: bytes, project: str | None) -> ChangedDocuments: ...

    @abstractmethod
    def label_by_query(self, request: LabelQuery) -> ChangedDocuments: ...

    @abstractmethod
    def label_table(self, project: str | None) -> str: ...

    @abstractmethod
    def write_label_table(
        self, table: bytes, project: str | None, *, strict: bool, replace: bool
    ) -> ChangedDocuments: ...

    @abstractmethod
    def suggested_labels(self, uuid: str, confidence: float) -> SuggestedLabels: ...

    @abstractmethod
    def label(self, uuid: str, labels: list[tuple[str, int, int]], *, strict: bool) -> LabelPage: ...


class LocalLibrary(Library):
    def __init__(self, database: Database, settings: Settings) -> None:
        self.database = database
        self.settings = settings

    def import_paths(self, paths: list[Path], options: ImportOptions, progress: Progress | None) -> UploadResult:
        with ExitStack() as stack:
            files = [SourceFile(name_of(path), stack.enter_context(path.open("rb"))) for path in paths]
            done = import_files(self.database, files, options, self.settings, progress=progress)
        return UploadResult(
            documents=[
                ImportedDocument(id=item.uuid, name=item.name, skipped=item.skipped, receipt=Receipt(**item.receipt))
                for item in done.documents
            ],
            problems=[FileProblem(file=name, problem=problem_of(error)) for name, error in done.problems],
        )

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

    def compose(self, request: ComposeRequest) -> Composed:
        # Imported late, as all mathematics: most commands need none.
        from service.actions.compose_frames import compose_frames

        queries = Queries(self.database, self.settings)
        try:
            return compose_frames(self.database, queries, self.settings, request, "local")
        finally:
            queries.close()

    def retarget(self, uuid: str, request: RetargetRequest) -> Retargeted:
        from service.actions.retarget_motion import retarget_motion

        return retarget_motion(self.database, self.settings, uuid, request, "local")

    def edit_frames(self, uuid: str, request: FrameEdits) -> FramesEdited:
        with self.database.write() as tx:
            stored = tx.documents.get(uuid)
            tx.documents.lock(stored.key)
            changed = edit_frames(tx, tx.documents.get(uuid), request)
        return FramesEdited(revision=changed.revision, frames=changed.frames)

    def set_properties(self, table: bytes, project: str | None) -> ChangedDocuments:
        with self.database.write() as tx:
            return _changed(set_properties(tx, table, project))

    def label_by_query(self, request: LabelQuery) -> ChangedDocuments:
        queries = Queries(self.database, self.settings)
        asked = QueryRequest(q=request.xpath, document=request.document, project=request.project)
        how = {"author": "local", "remove": request.remove, "strict": request.strict}
        try:
            return _changed(label_by_query(self.database, queries, asked, request.name, **how))  # type: ignore[arg-type]
        finally:
            queries.close()

    def label_table(self, project: str | None) -> str:
        with self.database.read() as tx:
            found = tx.documents.page(DocumentFilter(project=project), after=None, limit=1_000_000)
            return label_table(tx, found)

    def write_label_table(self, table: bytes, project: str | None, *, strict: bool, replace: bool) -> ChangedDocuments:
        with self.database.write() as tx:
            return _changed(write_label_table(tx, table, project, strict=strict, replace=replace))

    def suggested_labels(self, uuid: str, confidence: float) -> SuggestedLabels:
        from service.actions.suggest_labels import suggest_labels

        with self.database.read() as tx:
            return SuggestedLabels(items=suggest_labels(tx, tx.documents.get(uuid), confidence))

    def label(self, uuid: str, labels: list[tuple[str, int, int]], *, strict: bool) -> LabelPage:
        with self.database.write() as tx:
            stored = tx.documents.get(uuid)
            tx.documents.lock(stored.key)
            added = add_labels(tx, tx.documents.get(uuid), labels, strict=strict)
        return LabelPage(
            items=[WireLabel(id=s.key, name=s.name, first=s.first, last=s.last, rank=s.rank) for s in added]
        )


class RemoteLibrary(Library):
    def __init__(self, address: str, token: str | None) -> None:
        headers = {"authorization": f"Bearer {token}"} if token else {}
        self.http = httpx.Client(base_url=address.rstrip("/") + "/api/v1", headers=headers, timeout=600)

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
        for key in ("name", "encoding", "unit", "up", "frame_time", "skeleton"):
            if getattr(options, key) is not None:
                data[key] = getattr(options, key)
        with ExitStack() as stack:
            files = [("file", (name_of(path), stack.enter_context(path.open("rb")))) for path in paths]
            answer = self.send("POST", "/documents", data=data, files=files, accept=(201, 415, 422))
        body = answer.json()
        if answer.status_code != 201:
            if "problems" not in body:
                raise _error(answer)
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
            page = DocumentPage(**self.send("GET", "/documents", params=parameters).json())
            items += page.items
            if page.next_cursor is None or len(items) >= limit:
                return DocumentPage(items=items, total=page.total)
            parameters["cursor"] = page.next_cursor

    def document(self, uuid: str) -> DocumentDetail:
        return DocumentDetail(**self.send("GET", f"/documents/{uuid}").json())

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
        with self._stream(f"/documents/{uuid}/export", params=given) as answer:
            disposition = answer.headers.get("content-disposition", "")
            # Only a name: whatever the server says, nothing is written outside the folder that was asked for.
            name = file_name(unquote(disposition.rpartition("UTF-8''")[2]) or f"{uuid}.{options.format}")
            notices = [item for item in answer.headers.get("x-mcml-notices", "").split(" | ") if item]
            yield name, answer.iter_bytes(1 << 20), notices

    def query(self, request: QueryRequest) -> QueryAnswer:
        return QueryAnswer(**self.send("POST", "/xpath", json=request.model_dump(by_alias=True)).json())

    def query_stream(self, request: QueryRequest) -> Iterator[bytes]:
        with self._stream("/xpath", method="POST", json=request.model_dump(by_alias=True)) as answer:
            yield from answer.iter_bytes(1 << 20)

    def compose(self, request: ComposeRequest) -> Composed:
        return Composed(**self.send("POST", "/compose", json=request.model_dump(exclude_none=True)).json())

    def retarget(self, uuid: str, request: RetargetRequest) -> Retargeted:
        body = request.model_dump(exclude_none=True)
        return Retargeted(**self.send("POST", f"/documents/{uuid}/retarget", json=body).json())

    def edit_frames(self, uuid: str, request: FrameEdits) -> FramesEdited:
        body, headers = request.model_dump(exclude_none=True), {"if-match": "*"}
        return FramesEdited(**self.send("POST", f"/documents/{uuid}/frames", json=body, headers=headers).json())

    def set_properties(self, table: bytes, project: str | None) -> ChangedDocuments:
        parameters = {} if project is None else {"project": project}
        headers = {"content-type": "text/csv"}
        answer = self.send("POST", "/properties", content=table, headers=headers, params=parameters)
        return ChangedDocuments(**answer.json())

    def label_by_query(self, request: LabelQuery) -> ChangedDocuments:
        return ChangedDocuments(**self.send("POST", "/labels", json=request.model_dump(exclude_none=True)).json())

    def label_table(self, project: str | None) -> str:
        return self.send("GET", "/labels", params={} if project is None else {"project": project}).text

    def write_label_table(self, table: bytes, project: str | None, *, strict: bool, replace: bool) -> ChangedDocuments:
        parameters: dict[str, Any] = {"strict": strict, "replace": replace}
        parameters |= {} if project is None else {"project": project}
        headers = {"content-type": "text/csv"}
        return ChangedDocuments(**self.send("PUT", "/labels", content=table, headers=headers, params=parameters).json())

    def suggested_labels(self, uuid: str, confidence: float) -> SuggestedLabels:
        parameters = {"confidence": confidence}
        return SuggestedLabels(**self.send("GET", f"/documents/{uuid}/labels/suggested", params=parameters).json())

    def label(self, uuid: str, labels: list[tuple[str, int, int]], *, strict: bool) -> LabelPage:
        body = [{"name": name, "first": first, "last": last} for name, first, last in labels]
        headers = {"if-match": "*"}
        parameters = {"strict": strict}
        return LabelPage(
            **self.send("POST", f"/documents/{uuid}/labels", json=body, headers=headers, params=parameters).json()
        )

    @contextmanager
    def _stream(self, path: str, method: str = "GET", **request: Any) -> Iterator[httpx.Response]:
        try:
            with self.http.stream(method, path, **request) as answer:
                if answer.status_code != 200:
                    answer.read()
                    raise _error(answer)
                yield answer
        except httpx.HTTPError as error:
            raise StoreError(f"The server does not answer: {error}", remedy="Check --server.") from error

    def send(self, method: str, path: str, accept: tuple[int, ...] = (), **request: Any) -> httpx.Response:
        try:
            answer = self.http.request(method, path, **request)
        except httpx.HTTPError as error:
            raise StoreError(f"The server does not answer: {error}", remedy="Check --server.") from error
        if answer.is_success or answer.status_code in accept:
            return answer
        raise _error(answer)


def _changed(documents: list[StoredDocument]) -> ChangedDocuments:
    return ChangedDocuments(
        items=[ChangedDocument(id=item.uuid, name=item.name, revision=item.revision) for item in documents]
    )


def _error(answer: httpx.Response) -> McmlError:
    """A problem that the server answered, as an error."""
    try:
        body = answer.json()
    except ValueError:
        body = {"detail": f"The server answered {answer.status_code}."}
    kinds = {401: AccessError, 403: AccessError, 404: NotFoundError}
    kind = kinds.get(answer.status_code, McmlError)
    where = body.get("where")
    error = kind(body.get("detail", "refused"), at=Place(**where) if where else None, remedy=body.get("remedy"))
    if "code" in body:
        error.details |= {"code": body["code"]} | (body.get("details") or {})
    return error
