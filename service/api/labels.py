"""Labels: the motion_name elements of frames, as spans."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Query, Request, Response
from starlette.concurrency import run_in_threadpool

from schemas.documents import ChangedDocument, ChangedDocuments, Label, LabelPage, LabelRequest
from schemas.examples import DOCUMENT, MOTION_NAME
from schemas.labels import LabelChange, LabelQuery, SuggestedLabels
from schemas.queries import QueryRequest
from service.actions.editing.change_document import add_labels, remove_labels
from service.actions.labelling.edit_labels import change_label, label_by_query, label_table, write_label_table
from service.actions.labelling.suggest_labels import suggest_labels
from service.api.dependencies import (
    MOST,
    AuthorDep,
    DatabaseDep,
    DocumentId,
    IfMatch,
    PageDep,
    ProjectQuery,
    QueriesDep,
    RevisionQuery,
    at_revision,
    checked_for_write,
    decode_cursor,
    encode_cursor,
)
from service.api.streaming import attachment, read_body
from service.storage.documents import StoredDocument
from service.storage.filtering import DocumentFilter
from service.storage.spans import StoredSpan

router = APIRouter(tags=["labels"])

MOST_BYTES = 64 << 20
_EXAMPLE = f"document,label,first,last\n{DOCUMENT},{MOTION_NAME},100,142\n"
_TABLE: dict[int | str, dict[str, Any]] = {200: {"content": {"text/csv": {"example": _EXAMPLE}}}}
_BODY: dict[str, Any] = {
    "requestBody": {"required": True, "content": {"text/csv": {"schema": {"type": "string"}, "example": _EXAMPLE}}}
}

LabelId = Annotated[int, Path(le=MOST, description="Id of the label, as the list gives it", examples=[12])]


@router.get("/documents/{id}/labels", operation_id="list_labels")
def list_labels(
    id: DocumentId,
    database: DatabaseDep,
    page: PageDep,
    revision: RevisionQuery = None,
    name: Annotated[str | None, Query(description="Only this motion name", examples=[MOTION_NAME])] = None,
) -> LabelPage:
    """The motion names of a document and the frames that carry them, in order."""
    start = 0 if page.cursor is None else int(decode_cursor(page.cursor, int)[0])
    with database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        found = [span for span in then.spans.of(stored.key) if name is None or span.name == name]
    shown = found[start : start + page.limit]
    more = encode_cursor(start + page.limit) if len(found) > start + page.limit else None
    return LabelPage(items=[_label(span) for span in shown], next_cursor=more)


@router.get("/documents/{id}/labels/suggested", operation_id="suggest_labels")
def get_suggestions(
    id: DocumentId,
    database: DatabaseDep,
    confidence: Annotated[float, Query(ge=0, le=1, description="The least", examples=[0.6])] = 0.5,
    facing: Annotated[
        Literal["X", "-X", "Y", "-Y", "Z", "-Z"] | None,
        Query(description="Where the body faces as it stands upright, where names tell no sides", examples=["Z"]),
    ] = None,
) -> SuggestedLabels:
    """Anatomical movements found in the motion, as names for its frames. Nothing is written; POST those to accept."""
    with database.read() as tx:
        return SuggestedLabels(items=suggest_labels(tx, tx.documents.get(id), confidence, facing))


@router.post("/documents/{id}/labels", status_code=201, operation_id="add_labels")
def post_labels(
    id: DocumentId,
    labels: list[LabelRequest],
    response: Response,
    database: DatabaseDep,
    author: AuthorDep,
    strict: Annotated[bool, Query(description="Refuse names that are no anatomical movement")] = False,
    if_match: IfMatch = None,
) -> LabelPage:
    """Name ranges of frames. All of the list, or nothing, becomes one revision."""
    with database.write(author) as tx:
        stored = checked_for_write(tx, id, if_match)
        added = add_labels(tx, stored, [(item.name, item.first, item.last) for item in labels], strict=strict)
        response.headers["etag"] = f'"{tx.documents.get(id).revision}-json"'
    return LabelPage(items=[_label(span) for span in added])


@router.patch("/documents/{id}/labels/{label}", operation_id="change_label")
def patch_label(
    id: DocumentId,
    label: LabelId,
    change: LabelChange,
    response: Response,
    database: DatabaseDep,
    author: AuthorDep,
    if_match: IfMatch = None,
) -> LabelPage:
    """Rename a label, move its ends, or split it. Answers what it has become; it has another id then."""
    with database.write(author) as tx:
        stored = checked_for_write(tx, id, if_match)
        made = change_label(tx, stored, label, **change.model_dump())
        response.headers["etag"] = f'"{tx.documents.get(id).revision}-json"'
    return LabelPage(items=[_label(span) for span in made])


@router.delete("/documents/{id}/labels/{label}", status_code=204, operation_id="delete_label")
def delete_label(
    id: DocumentId, label: LabelId, database: DatabaseDep, author: AuthorDep, if_match: IfMatch = None
) -> Response:
    """Take a motion name off its frames."""
    with database.write(author) as tx:
        remove_labels(tx, checked_for_write(tx, id, if_match), label)
        tag = f'"{tx.documents.get(id).revision}-json"'
    return Response(status_code=204, headers={"etag": tag})


@router.post("/labels", operation_id="label_by_query")
def post_query(request: LabelQuery, database: DatabaseDep, queries: QueriesDep, author: AuthorDep) -> ChangedDocuments:
    """Name all frames that an XPath expression selects, in one document or many, or take the name off them."""
    asked = QueryRequest(q=request.xpath, document=request.document, project=request.project)
    changed = label_by_query(
        database,
        queries,
        asked,
        request.name,
        author=author,
        remove=request.remove,
        strict=request.strict,
        instead_of=request.instead_of,
    )
    return _changed(changed)


@router.get("/labels", operation_id="export_labels", response_class=Response, responses=_TABLE)
def get_table(
    database: DatabaseDep,
    project: ProjectQuery = None,
    document: Annotated[list[str] | None, Query(description="Documents; default all", examples=[[DOCUMENT]])] = None,
) -> Response:
    """The labels of documents as a CSV table: document, label, first, last."""
    with database.read() as tx:
        if document:
            found = [tx.documents.get(uuid) for uuid in document]
        else:
            found = tx.documents.page(DocumentFilter(project=project), after=None, limit=MOST)
        text = label_table(tx, found)
    headers = {"content-disposition": attachment("labels.csv")}
    return Response(text, media_type="text/csv; charset=utf-8", headers=headers)


@router.put("/labels", operation_id="import_labels", openapi_extra=_BODY)
async def put_table(
    request: Request,
    database: DatabaseDep,
    author: AuthorDep,
    project: ProjectQuery = None,
    strict: Annotated[bool, Query(description="Refuse names that are no anatomical movement")] = False,
    replace: Annotated[bool, Query(description="The labels that these documents had go")] = False,
) -> ChangedDocuments:
    """Add labels from a CSV table, as GET writes it; `name` may stand for `document`. All of the table, or nothing."""
    content = await read_body(request, MOST_BYTES)

    def write() -> ChangedDocuments:
        with database.write(author) as tx:
            return _changed(write_label_table(tx, content, project, strict=strict, replace=replace))

    return await run_in_threadpool(write)


def _changed(documents: list[StoredDocument]) -> ChangedDocuments:
    return ChangedDocuments(
        items=[ChangedDocument(id=item.uuid, name=item.name, revision=item.revision) for item in documents]
    )


def _label(span: StoredSpan) -> Label:
    return Label(id=span.key, name=span.name, first=span.first, last=span.last, rank=span.rank)
