"""Elements of a document, addressed by XPath: read, changed, deleted, replaced, inserted, moved."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, Query, Request, Response
from starlette.concurrency import run_in_threadpool

from schemas.elements import (
    ChangeEdit,
    DeleteEdit,
    ElementChange,
    ElementEdited,
    ElementEdits,
    MoveEdit,
    ReplaceEdit,
)
from schemas.elements import Edit as AnyEdit
from schemas.examples import ADDRESS, FRAME_BONE, NODE
from schemas.queries import QueryRequest
from service.actions.checking.describe_problem import PreconditionError
from service.actions.editing.edit_element import Change, read_element
from service.actions.editing.edit_elements import (
    Deletion,
    ElementEdit,
    Insertion,
    Replacement,
    carried_over,
    edit_elements,
)
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
from service.api.streaming import read_body
from service.errors import DocumentError, LimitError, NotFoundError
from service.mcml.fragment import MOST_BYTES, read_fragment
from service.storage.database import Transaction
from service.storage.documents import StoredDocument
from service.xpath.run import Queries

router = APIRouter(tags=["elements"])

MOST_ELEMENTS = 10_000
_ADDRESS = re.compile(
    r"/mcml/motion/frame\[[1-9]\d{0,8}\](?:/@id|/(?:frame_bone|motion_name)\[[1-9]\d{0,8}\](?:/@\w+)?)?"
)
"""What can select but one node, and says which: nobody needs to be asked. Whether it is there, the edit finds out."""
_FRAGMENT: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {"application/xml": {"schema": {"type": "string"}, "example": FRAME_BONE}},
    }
}

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
        address = _addresses(queries, id, xpath, False, revision)[0]
        content = read_element(then, stored, address)
        media = "text/plain; charset=utf-8" if "/@" in address else "application/xml"
        return Response(content, media_type=media, headers={"etag": etag(stored, "element")})


@dataclass(frozen=True)
class Edit:
    """What every edit says: in which document, by whom, and for which revision."""

    id: DocumentId
    response: Response
    database: DatabaseDep
    queries: QueriesDep
    author: AuthorDep
    merge: Annotated[
        bool,
        Query(description="If the revision is stale: edit all the same where nobody changed these elements"),
    ] = False
    gaps: Annotated[
        Literal["allow", "refuse"], Query(description="Whether ids of frames may skip numbers after the edit")
    ] = "allow"
    if_match: IfMatch = None

    def run(self, edits: Sequence[ElementEdit], message: str = "") -> ElementEdited:
        """Make edits of elements by their canonical addresses."""
        with self.database.write(self.author) as tx:
            stored, base = self._checked(tx)
            if base is not None:
                then, was = at_revision(tx, self.id, base)
                moved = carried_over(then, was, tx, stored, [edit.address for edit in edits])
                edits = [replace(edit, address=address) for edit, address in zip(edits, moved, strict=True)]
            changed = edit_elements(tx, stored, edits, message, gapless=self.gaps == "refuse")
        self.response.headers["etag"] = etag(changed, "json")
        return ElementEdited(address=edits[0].address, elements=len(edits), revision=changed.revision)

    def _checked(self, tx: Transaction) -> tuple[StoredDocument, int | None]:
        """The document, locked; and the older revision that the edits were made for, if they are to be merged."""
        try:
            return checked_for_write(tx, self.id, self.if_match), None
        except PreconditionError as error:
            if error.status != 412 or self.base is None:
                raise
            return checked_for_write(tx, self.id, "*"), self.base

    def addresses(self, xpath: str, many: bool) -> list[str]:
        """What an expression selects, at the revision that the edits are made for."""
        return _addresses(self.queries, self.id, xpath, many, self.base)

    @property
    def base(self) -> int | None:
        """The revision that edits are made for where they are to be merged, None for the current one."""
        said = re.fullmatch(r'"(\d{1,9})(?:-[a-z-]+)?"', (self.if_match or "").strip())
        return int(said[1]) if self.merge and said is not None else None


EditDep = Annotated[Edit, Depends()]
Many = Annotated[bool, Query(description="The expression may select several elements; each is edited so")]


@router.patch("/documents/{id}/elements", operation_id="change_element")
def patch_element(edit: EditDep, xpath: One, change: ElementChange, many: Many = False) -> ElementEdited:
    """Change attributes or text of elements. Only what is touched is written; the rest of the document stays."""
    new = Change(change.attributes, change.text)
    return edit.run([ElementEdit(address, new) for address in edit.addresses(xpath, many)], change.message)


@router.delete("/documents/{id}/elements", operation_id="delete_element")
def remove_element(
    edit: EditDep,
    xpath: One,
    many: Many = False,
    renumber: Annotated[bool, Query(description="Ids of frames that counted up by one do so again")] = False,
) -> ElementEdited:
    """Delete elements or attributes, unless `mcml.dtd` or the frames need them."""
    return edit.run([ElementEdit(address, Deletion(renumber)) for address in edit.addresses(xpath, many)])


@router.put("/documents/{id}/elements", operation_id="replace_element", openapi_extra=_FRAGMENT)
async def put_element(edit: EditDep, xpath: One, request: Request) -> ElementEdited:
    """Put other elements in the place of one. The body is MCML without a document around it."""
    content = await read_body(request, MOST_BYTES)

    def write() -> ElementEdited:
        new = Replacement(tuple(read_fragment(content)))
        return edit.run([ElementEdit(address, new) for address in edit.addresses(xpath, False)])

    return await run_in_threadpool(write)


@router.post("/documents/{id}/elements", operation_id="insert_elements", openapi_extra=_FRAGMENT)
async def post_elements(
    edit: EditDep,
    xpath: One,
    request: Request,
    where: Annotated[
        Literal["before", "after", "into"], Query(description="Beside the element, or into it, at its end")
    ] = "into",
    renumber: Annotated[bool, Query(description="Ids of frames that counted up by one do so again")] = True,
) -> ElementEdited:
    """Put elements beside one, or into it. The body is MCML without a document around it, such as some frames."""
    content = await read_body(request, MOST_BYTES)

    def write() -> ElementEdited:
        new = Insertion(where, tuple(read_fragment(content)), renumber)
        return edit.run([ElementEdit(address, new) for address in edit.addresses(xpath, False)])

    return await run_in_threadpool(write)


@router.post("/documents/{id}/elements/batch", operation_id="edit_elements")
def post_batch(edit: EditDep, request: ElementEdits) -> ElementEdited:
    """Change, delete, replace, insert and move elements as one revision: all, or none.

    Every expression means the document as it was before the first edit.
    """
    return edit.run([made for item in request.edits for made in _made(edit, item, request)], request.message)


def _made(edit: Edit, item: AnyEdit, request: ElementEdits) -> list[ElementEdit]:
    found = edit.addresses(item.xpath, request.many and item.do != "move")
    if isinstance(item, ChangeEdit):
        return [ElementEdit(address, Change(item.attributes, item.text)) for address in found]
    if isinstance(item, DeleteEdit):
        return [ElementEdit(address, Deletion(item.renumber)) for address in found]
    if isinstance(item, MoveEdit):
        with edit.database.read() as tx:
            then, stored = at_revision(tx, edit.id, edit.base)
            moved = tuple(read_fragment(read_element(then, stored, found[0])))
        (to,) = edit.addresses(item.to, False)
        return [ElementEdit(to, Insertion(item.where, moved, request.renumber)), ElementEdit(found[0], Deletion())]
    elements = tuple(read_fragment(item.fragment.encode()))
    if isinstance(item, ReplaceEdit):
        return [ElementEdit(address, Replacement(elements)) for address in found]
    return [ElementEdit(address, Insertion(item.where, elements, request.renumber)) for address in found]


def _addresses(queries: Queries, uuid: str, xpath: str, many: bool, revision: int | None = None) -> list[str]:
    """The canonical addresses of what an expression selects: one node, or several."""
    if _ADDRESS.fullmatch(xpath):
        return [xpath]
    limit = MOST_ELEMENTS + 1 if many else 2
    request = QueryRequest(q=xpath, document=[uuid], revision=revision, limit=limit)
    found = [address.removesuffix("/text()") for address in queries.addresses(request)]
    if len(found) > MOST_ELEMENTS:
        raise LimitError(f"The expression selects more than {MOST_ELEMENTS} nodes.", remedy="Edit them in parts.")
    if not found:
        raise NotFoundError("The expression selects nothing.", remedy="Try it with GET /xpath first.")
    if len(found) > 1 and not many:
        raise DocumentError(
            "The expression selects more than one node.", remedy="Narrow it to one, such as [1], or say many=true."
        )
    return found
