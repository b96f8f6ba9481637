"""Labels: the motion_name elements of frames, as spans."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Response

from schemas.documents import Label, LabelPage, LabelRequest
from schemas.examples import MOTION_NAME
from service.actions.change_document import add_labels, remove_labels
from service.api.dependencies import (
    MOST,
    AuthorDep,
    DatabaseDep,
    DocumentId,
    IfMatch,
    PageDep,
    RevisionQuery,
    at_revision,
    checked_for_write,
    decode_cursor,
    encode_cursor,
)
from service.storage.spans import StoredSpan

router = APIRouter(tags=["labels"])

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


@router.delete("/documents/{id}/labels/{label}", status_code=204, operation_id="delete_label")
def delete_label(
    id: DocumentId, label: LabelId, database: DatabaseDep, author: AuthorDep, if_match: IfMatch = None
) -> Response:
    """Take a motion name off its frames."""
    with database.write(author) as tx:
        remove_labels(tx, checked_for_write(tx, id, if_match), label)
        tag = f'"{tx.documents.get(id).revision}-json"'
    return Response(status_code=204, headers={"etag": tag})


def _label(span: StoredSpan) -> Label:
    return Label(id=span.key, name=span.name, first=span.first, last=span.last, rank=span.rank)
