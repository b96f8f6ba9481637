"""Properties of many documents at once."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from starlette.concurrency import run_in_threadpool

from schemas.documents import ChangedDocument, ChangedDocuments
from service.actions.labelling.set_properties import set_properties
from service.api.dependencies import AuthorDep, DatabaseDep, ProjectQuery
from service.api.streaming import read_body

router = APIRouter(tags=["documents"])

MOST_BYTES = 16 << 20
_TABLE = "name,age (year),height (cm)\nwalk,23,172.4\n"
_BODY: dict[str, Any] = {
    "requestBody": {"required": True, "content": {"text/csv": {"schema": {"type": "string"}, "example": _TABLE}}}
}


@router.post("/properties", operation_id="set_properties", openapi_extra=_BODY)
async def post_properties(
    request: Request, database: DatabaseDep, author: AuthorDep, project: ProjectQuery = None
) -> ChangedDocuments:
    """Set properties of many documents from a CSV table: one line a document, one column a property.

    The first column is `document` (ids) or `name`; units stand in brackets in the headings: `age (year)`. Empty cells
    and properties that the table does not name stay as they are. All of the table is written, or nothing.
    """
    content = await read_body(request, MOST_BYTES)

    def write() -> ChangedDocuments:
        with database.write(author) as tx:
            changed = set_properties(tx, content, project)
        return ChangedDocuments(
            items=[ChangedDocument(id=item.uuid, name=item.name, revision=item.revision) for item in changed]
        )

    return await run_in_threadpool(write)
