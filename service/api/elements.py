"""Single elements of a document, addressed by an XPath that selects exactly one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Response

from schemas.elements import ElementChange, ElementEdited
from schemas.examples import ADDRESS, FRAME_BONE, NODE
from schemas.queries import NodeItem, QueryRequest
from service.actions.edit_element import Change, change_element, delete_element, read_element
from service.api.dependencies import (
    AuthorDep,
    DatabaseDep,
    DocumentId,
    IfMatch,
    QueriesDep,
    RevisionQuery,
    at_revision,
    checked_for_write,
    etag,
)
from service.errors import DocumentError, NotFoundError
from service.storage.database import Transaction
from service.storage.documents import StoredDocument
from service.xpath.run import Queries

router = APIRouter(tags=["elements"])

One = Annotated[
    str,
    Query(
        alias="xpath",
        min_length=1,
        max_length=10_000,
        description="Selects exactly one element or attribute",
        examples=[ADDRESS],
    ),
]
_XML: dict[int | str, dict[str, Any]] = {
    200: {
        "content": {"application/xml": {"example": FRAME_BONE}, "text/plain": {"example": NODE["value"]}},
        "description": "The element, or the text of the attribute",
    }
}


@router.get("/documents/{id}/elements", operation_id="get_element", response_class=Response, responses=_XML)
def get_element(
    id: DocumentId, xpath: One, database: DatabaseDep, queries: QueriesDep, revision: RevisionQuery = None
) -> Response:
    """One element of a document as XML, or the value of one attribute as text."""
    with database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        address = xpath if revision is not None else _address(queries, id, xpath)
        content = read_element(then, stored, address)
        media = "text/plain; charset=utf-8" if "/@" in address else "application/xml"
        return Response(content, media_type=media, headers={"etag": etag(stored, "element")})


@dataclass(frozen=True)
class Edit:
    """What every edit of an element says: where, by whom, and for which revision."""

    id: DocumentId
    xpath: One
    response: Response
    database: DatabaseDep
    queries: QueriesDep
    author: AuthorDep
    if_match: IfMatch = None

    def run(self, edit: Callable[[Transaction, StoredDocument, str], StoredDocument]) -> ElementEdited:
        """Make the edit, given the transaction, the document and the canonical address of the element."""
        address = _address(self.queries, self.id, self.xpath)
        with self.database.write(self.author) as tx:
            changed = edit(tx, checked_for_write(tx, self.id, self.if_match), address)
        self.response.headers["etag"] = etag(changed, "json")
        return ElementEdited(address=address, revision=changed.revision)


EditDep = Annotated[Edit, Depends()]


@router.patch("/documents/{id}/elements", operation_id="change_element")
def patch_element(edit: EditDep, change: ElementChange) -> ElementEdited:
    """Change attributes or text of one element. Only what is touched is written; the rest of the document stays."""
    new = Change(change.attributes, change.text)
    return edit.run(lambda tx, stored, address: change_element(tx, stored, address, new, change.message))


@router.delete("/documents/{id}/elements", operation_id="delete_element")
def remove_element(edit: EditDep) -> ElementEdited:
    """Delete one element or attribute, unless `mcml.dtd` or the frames need it."""
    return edit.run(delete_element)


def _address(queries: Queries, uuid: str, xpath: str) -> str:
    """The canonical address of the one node that an expression selects."""
    answer = queries.answer(QueryRequest(q=xpath, document=[uuid], limit=2))
    nodes = [item for item in answer.items or [] if isinstance(item, NodeItem)]
    if answer.type != "nodes":
        raise DocumentError("The expression gives a value, not an element.", remedy="Write a path to one element.")
    if not nodes:
        raise NotFoundError("The expression selects nothing.", remedy="Try it with GET /xpath first.")
    if len(nodes) > 1:
        raise DocumentError("The expression selects more than one node.", remedy="Narrow it to one, for example [1].")
    return nodes[0].address.removesuffix("/text()")
