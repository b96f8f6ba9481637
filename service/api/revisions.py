"""Revisions compared."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from schemas.revisions import Difference
from service.actions.reading.compare_revisions import compare_revisions
from service.api.dependencies import MOST, DatabaseDep, DocumentId, at_revision

router = APIRouter(tags=["documents"])


@router.get("/documents/{id}/difference", operation_id="compare_revisions", response_model_exclude_none=True)
def difference(
    id: DocumentId,
    database: DatabaseDep,
    before: Annotated[int, Query(ge=1, le=MOST, description="The earlier revision", examples=[1])],
    after: Annotated[
        int | None, Query(ge=1, le=MOST, description="The later revision; default the current one", examples=[3])
    ] = None,
) -> Difference:
    """What differs between two revisions: elements of the head, frames, labels, samples, angles between poses."""
    with database.read() as tx:
        then, one = at_revision(tx, id, before)
        now, other = at_revision(tx, id, after)
        return compare_revisions(then, one, now, other)
