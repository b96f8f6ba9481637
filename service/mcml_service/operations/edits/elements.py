"""Elements of a document, addressed by XPath: read, changed, deleted, replaced, inserted, moved."""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal

from pydantic import Field

from mcml.answers import Content
from mcml.errors import DocumentError, LimitError, NotFoundError
from mcml.language.fragment import MOST_BYTES, read_fragment
from mcml_schemas.elements import (
    ChangeEdit,
    Child,
    ChildPage,
    DeleteEdit,
    ElementChange,
    ElementEdited,
    ElementEdits,
    MoveEdit,
    ReplaceEdit,
)
from mcml_schemas.elements import Edit as AnyEdit
from mcml_schemas.examples import ADDRESS, FRAME_BONE, NODE
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.actions.checking.describe_problem import PreconditionError
from mcml_service.actions.editing import element_edits as editing
from mcml_service.actions.editing.element_edits import Deletion, ElementEdit, Insertion, Replacement
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.reading import list_children as listing
from mcml_service.actions.reading.read_element import read_element
from mcml_service.operations.arguments import MOST, AtRevision, DocumentId, IfMatch, at_revision, find_for_write, tag
from mcml_service.operations.call import Call
from mcml_service.operations.operation import Body, gives
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

MOST_ELEMENTS = 10_000
_ADDRESS = re.compile(
    r"/mcml/motion/frame\[[1-9]\d{0,8}\](?:/@id|/(?:frame_bone|motion_name)\[[1-9]\d{0,8}\](?:/@\w+)?)?"
)
"""An expression that can select only one node, and is its address: it needs no query.

The edit checks that the node exists.
"""

One = Annotated[
    str,
    Field(min_length=1, max_length=10_000, description="Selects exactly one element or attribute", examples=[ADDRESS]),
]
Many = Annotated[bool, Field(description="The expression may select several elements; each is edited so")]
Renumber = Annotated[bool, Field(description="Ids of frames that counted up by one do so again")]
Fragment = Annotated[
    bytes,
    Body({"application/xml": FRAME_BONE}, most=MOST_BYTES),
    Field(description="Elements as MCML, without a document around them"),
]


@dataclass(frozen=True)
class Edit:
    """The revision and the options of an edit."""

    merge: Annotated[
        bool,
        Field(description="If the revision is stale: edit anyway if these elements have not changed"),
    ] = False
    gaps: Annotated[
        Literal["allow", "refuse"], Field(description="Whether ids of frames may skip numbers after the edit")
    ] = "allow"
    if_match: IfMatch = None

    @property
    def base(self) -> int | None:
        """The revision that edits are made for where they are to be merged, None for the current one."""
        match = re.fullmatch(r'"(\d{1,9})(?:-[a-z-]+)?"', (self.if_match or "").strip())
        return int(match[1]) if self.merge and match is not None else None

    def check(self, tx: Transaction, uuid: str) -> tuple[StoredDocument, int | None]:
        """The document, locked; and the older revision that the edits were made for, if they are to be merged."""
        try:
            return find_for_write(tx, uuid, self.if_match), None
        except PreconditionError as error:
            if error.status != 412 or self.base is None:
                raise
            return find_for_write(tx, uuid, "*"), self.base


@gives("The element, or the text of the attribute", {"application/xml": FRAME_BONE, "text/plain": NODE["value"]})
def get_element(call: Call, id: DocumentId, xpath: One, revision: AtRevision = None) -> Content:
    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        address = _addresses(call, id, xpath, False, revision)[0]
        content = read_element(then, stored, address)
    call.tag = tag(stored, "element")
    return Content(iter([content]), "text/plain; charset=utf-8" if "/@" in address else "application/xml")


def list_children(
    call: Call,
    id: DocumentId,
    address: Annotated[
        str,
        Field(min_length=1, max_length=1000, description="Of the element, canonical", examples=["/mcml/motion"]),
    ] = "/mcml",
    first: Annotated[int, Field(ge=1, le=MOST, description="Number of the first child", examples=[3])] = 1,
    limit: Annotated[int, Field(ge=1, description="Most children", examples=[20])] = 100,
    revision: AtRevision = None,
) -> ChildPage:
    """Only the requested children are read, for a motion of any length.

    Frames are the last children of `/mcml/motion`, after `frames` and the optional `frametime`. With a `revision` the
    answer never changes and can be cached.
    """
    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        asked = zlib.crc32(address.encode())
        call.set_tag(tag(stored, f"children-{asked}-{first}-{limit}"), lasting=revision is not None)
        most = min(limit, call.settings.page_limit)
        total, children = listing.list_children(then, stored, address, first, most)
    items = [
        Child(
            address=child.address, name=child.tag, attributes=child.attributes, text=child.text, children=child.children
        )
        for child in children
    ]
    return ChildPage(address=address, total=total, first=first, items=items)


def change_element(
    call: Call, id: DocumentId, xpath: One, change: ElementChange, edit: Edit, many: Many = False
) -> ElementEdited:
    """Only the changed part is written; the rest of the document does not change."""
    new = Change(change.attributes, change.text)
    targets = _addresses(call, id, xpath, many, edit.base)
    return _edit(call, id, edit, [ElementEdit(address, new) for address in targets], change.message)


def delete_element(
    call: Call, id: DocumentId, xpath: One, edit: Edit, many: Many = False, renumber: Renumber = False
) -> ElementEdited:
    targets = _addresses(call, id, xpath, many, edit.base)
    return _edit(call, id, edit, [ElementEdit(address, Deletion(renumber)) for address in targets])


def replace_element(call: Call, id: DocumentId, xpath: One, fragment: Fragment, edit: Edit) -> ElementEdited:
    """The body is MCML without a document around it."""
    new = Replacement(tuple(read_fragment(fragment)))
    targets = _addresses(call, id, xpath, False, edit.base)
    return _edit(call, id, edit, [ElementEdit(address, new) for address in targets])


def insert_elements(
    call: Call,
    id: DocumentId,
    xpath: One,
    fragment: Fragment,
    edit: Edit,
    where: Annotated[
        Literal["before", "after", "into"],
        Field(description="Before or after the element, or into it, at its start or end"),
    ] = "into",
    renumber: Renumber = True,
) -> ElementEdited:
    """The body is MCML without a document around it, such as some frames."""
    new = Insertion(where, tuple(read_fragment(fragment)), renumber)
    targets = _addresses(call, id, xpath, False, edit.base)
    return _edit(call, id, edit, [ElementEdit(address, new) for address in targets])


def edit_elements(call: Call, id: DocumentId, request: ElementEdits, edit: Edit) -> ElementEdited:
    """Every expression refers to the document before the first edit."""
    edits = [
        made
        for item in request.edits
        for made in make_edits(call, id, item, edit.base, many=request.many, renumber=request.renumber)
    ]
    return _edit(call, id, edit, edits, request.message)


def _edit(call: Call, uuid: str, edit: Edit, edits: Sequence[ElementEdit], message: str = "") -> ElementEdited:
    """Make edits of elements by their canonical addresses."""
    with call.database.write(call.author) as tx:
        stored, base = edit.check(tx, uuid)
        if base is not None:
            then, was = at_revision(tx, uuid, base)
            moved = editing.carry_over(then, was, tx, stored, [each.address for each in edits])
            edits = [replace(each, address=address) for each, address in zip(edits, moved, strict=True)]
        changed = editing.edit_elements(tx, stored, edits, message, gapless=edit.gaps == "refuse")
    call.tag = tag(changed)
    return ElementEdited(address=edits[0].address, elements=len(edits), revision=changed.revision)


def make_edits(
    call: Call, uuid: str, item: AnyEdit, base: int | None, *, many: bool, renumber: bool
) -> list[ElementEdit]:
    """Resolve an edit by an expression to edits by canonical addresses.

    base: the revision that it refers to; default the current one.
    """
    targets = _addresses(call, uuid, item.xpath, many and item.do != "move", base)
    if isinstance(item, ChangeEdit):
        return [ElementEdit(address, Change(item.attributes, item.text)) for address in targets]
    if isinstance(item, DeleteEdit):
        return [ElementEdit(address, Deletion(item.renumber)) for address in targets]
    if isinstance(item, MoveEdit):
        with call.database.read() as tx:
            then, stored = at_revision(tx, uuid, base)
            moved = tuple(read_fragment(read_element(then, stored, targets[0])))
        (to,) = _addresses(call, uuid, item.to, False, base)
        return [ElementEdit(to, Insertion(item.where, moved, renumber)), ElementEdit(targets[0], Deletion())]
    elements = tuple(read_fragment(item.fragment.encode()))
    if isinstance(item, ReplaceEdit):
        return [ElementEdit(address, Replacement(elements)) for address in targets]
    return [ElementEdit(address, Insertion(item.where, elements, renumber)) for address in targets]


def _addresses(call: Call, uuid: str, xpath: str, many: bool, revision: int | None = None) -> list[str]:
    """Return the canonical addresses of the nodes that an expression selects: one node, or several."""
    if _ADDRESS.fullmatch(xpath):
        return [xpath]
    # Imported here: an address alone needs no engine.
    from mcml_service.xpath.finding import addresses

    limit = MOST_ELEMENTS + 1 if many else 2
    request = QueryRequest(q=xpath, document=[uuid], revision=revision, limit=limit)
    targets = [address.removesuffix("/text()") for address in addresses(call.queries, request)]
    if len(targets) > MOST_ELEMENTS:
        raise LimitError(f"The expression selects more than {MOST_ELEMENTS} nodes.", remedy="Edit them in parts.")
    if not targets:
        raise NotFoundError("The expression selects nothing.", remedy="Try it with GET /xpath first.")
    if len(targets) > 1 and not many:
        raise DocumentError(
            "The expression selects more than one node.", remedy="Narrow it to one, such as [1], or say many=true."
        )
    return targets
