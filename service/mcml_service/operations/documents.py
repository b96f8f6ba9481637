"""Documents: stored, listed, read, changed, deleted, brought back; their revisions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field

from mcml.errors import QueryError
from mcml_schemas.documents import (
    Card,
    ChangedDocument,
    ChangedDocuments,
    DocumentChange,
    DocumentDetail,
    DocumentPage,
    Revision,
    RevisionPage,
)
from mcml_schemas.examples import DOCUMENT, MOTION_NAME, QUERY
from mcml_schemas.revisions import Difference, FrameRange
from mcml_service.actions.editing import whole_document as changes
from mcml_service.actions.reading.describe_document import detail, summary
from mcml_service.operations.arguments import (
    MOST,
    AtRevision,
    DocumentId,
    IfMatch,
    InProject,
    Page,
    at_revision,
    find_for_write,
    tag,
)
from mcml_service.operations.call import Call
from mcml_service.operations.operation import Body, quick_if
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.history.revisions import StoredRevision
from mcml_service.storage.lists.filtering import DocumentFilter, Range, parse_condition, parse_range
from mcml_service.storage.lists.orders import TYPES, Order, Place, parse_order
from mcml_service.storage.transaction import Transaction

PLAIN = ("name", "key")
"""The order by name and key."""

TABLE = "name,age (year),height (cm)\nwalk,23,172.4\n"


def has_quick_filter(given: Mapping[str, Any]) -> bool:
    """Whether the expression that documents must fulfil is quick."""
    # Imported here: lists without an XPath need no engine.
    from mcml_service.xpath.quick import is_quick

    return is_quick(given["xpath"])


@dataclass(frozen=True)
class Wanted:
    """Which documents a list holds."""

    project: InProject = None
    q: Annotated[
        str | None,
        Field(
            max_length=1024,
            description="Words; each occurs in name, description, name of the file, a property or a motion name",
            examples=["reach 14"],
        ),
    ] = None
    name: Annotated[str | None, Field(description="Exactly this name", examples=["walk"])] = None
    id: Annotated[str | None, Field(description="Beginning of the id", examples=[DOCUMENT[:8]])] = None
    motion_name: Annotated[
        str | None, Field(description="Documents with a frame of this name", examples=[MOTION_NAME])
    ] = None
    format: Annotated[str | None, Field(description="Source format", examples=["bvh"])] = None
    skeleton: Annotated[
        int | None, Field(ge=0, le=MOST, description="Number of the skeleton, as lists give it", examples=[3])
    ] = None
    property: Annotated[
        list[str] | None,
        Field(description="age:20..30 or take:calm; may be repeated", examples=[["age:20..30", "take:calm"]]),
    ] = None
    length: Annotated[str | None, Field(description="Seconds, as LEAST..GREATEST", examples=["2..10"])] = None
    rate: Annotated[
        str | None,
        Field(description="Frames a second: a number, which rounded rates equal, or LEAST..GREATEST", examples=["120"]),
    ] = None
    xpath: Annotated[
        str | None,
        Field(max_length=10_000, description="Documents in which this finds something or is true", examples=[QUERY]),
    ] = None
    collection: Annotated[
        str | None,
        Field(max_length=2048, description="Documents of a collection: NAME, or PROJECT/NAME", examples=["bent legs"]),
    ] = None
    deleted: Annotated[bool, Field(description="List deleted documents instead, which can be restored")] = False

    def filter(self, call: Call) -> DocumentFilter:
        """Return the filter in the form of the store. Raises QueryError for an invalid condition."""
        return DocumentFilter(
            length=(None, None) if self.length is None else parse_range(self.length),
            rate=(None, None) if self.rate is None else _rate(self.rate),
            among=self._among(call),
            project=self.project,
            text=self.q,
            name=self.name,
            id=self.id,
            motion_name=self.motion_name,
            format=self.format,
            skeleton=self.skeleton,
            properties=tuple(parse_condition(text) for text in self.property or ()),
            deleted=self.deleted,
        )

    def _among(self, call: Call) -> tuple[int, ...] | None:
        """Keys of the documents of the collection in which the expression finds something; None for all."""
        if self.xpath is None and self.collection is None:
            return None
        # Imported here: lists without an XPath need no engine.
        from mcml_service.xpath.finding import documents_with

        hits = None if self.xpath is None else documents_with(call.queries, self.xpath, self.project, call.limits)
        with call.database.read() as tx:
            if self.collection is not None:
                members = set(tx.saved.members(tx.saved.collection(self.collection)))
                hits = members if hits is None else members & hits
            if hits is None:
                return None
            return tuple(tx.documents.keys_of(hits))


def _rate(text: str) -> Range:
    if ".." in text:
        return parse_range(text)
    least, _ = parse_range(f"{text}..")
    return (None, None) if least is None else (least - 0.5, least + 0.5)


Sort: TypeAlias = Literal[
    "name",
    "-name",
    "newest",
    "created",
    "-created",
    "modified",
    "-modified",
    "duration",
    "-duration",
    "frames",
    "-frames",
    "rate",
    "-rate",
    "format",
    "-format",
    "project",
    "-project",
    "skeleton",
    "-skeleton",
    "revision",
    "-revision",
]


@quick_if(has_quick_filter)
def list_documents(
    call: Call,
    wanted: Wanted,
    page: Page,
    sort: Annotated[
        Sort, Field(description="By which column; - before it: descending", examples=["-duration"])
    ] = "name",
    offset: Annotated[
        int,
        Field(ge=0, le=MOST, description="Number of documents to skip at the start", examples=[120]),
    ] = 0,
    with_: Annotated[
        str | None,
        Field(
            alias="with",
            pattern=r"^(thumbnail|labels|passport)(,(thumbnail|labels|passport))*$",
            description="Additional fields, separated by commas: thumbnail, labels, passport",
            examples=["thumbnail,labels"],
        ),
    ] = None,
) -> DocumentPage:
    """Documents with equal values are sorted by name; those without a length or rate are last in both directions.

    With `thumbnail` each has a moving picture (MT1, base64), with `labels` the spans of its motion names, with
    `passport` unit, up axis, rate and joints, and which of them are guesses. In a long list, thumbnails that are not
    made yet may be missing; the next list has them.
    """
    order = parse_order(sort)
    after = _after(page, order)
    conditions = wanted.filter(call)
    with call.database.read() as tx:
        listed = call.repository.register.page(tx, conditions, order, after, page.most(call) + 1, offset)
        places, more = page.cut(call, listed.places, lambda place: _cursor(place, order))
        shown = tx.documents.get_many([place.key for place in places])
        also = frozenset((with_ or "").split(",")) - {""}
        items = _cards(call, tx, shown, also)
    return DocumentPage(items=items, next_cursor=more, total=listed.total)


def _after(page: Page, order: Order) -> Place | None:
    """The place that the cursor names. QueryError where it is of another order."""
    if order.column in PLAIN:
        cursor = page.after(str, int)
        return None if cursor is None else Place(cursor[0], *cursor)
    cursor = page.after(str, bool, TYPES[order.column], str, int)
    if cursor is None:
        return None
    direction, is_known, value, name, key = cursor
    if direction != _direction(order):
        raise QueryError("This cursor is of a list in another order.", remedy="Begin again without a cursor.")
    return Place(value if is_known else None, name, key)


def _cursor(place: Place, order: Order) -> tuple[Any, ...]:
    if order.column in PLAIN:
        return place.name, place.key
    is_known = place.value is not None
    return _direction(order), is_known, place.value if is_known else TYPES[order.column](), place.name, place.key


def _direction(order: Order) -> str:
    return f"{'-' if order.descending else ''}{order.column}"


def _cards(call: Call, tx: Transaction, shown: Sequence[StoredDocument], also: frozenset[str]) -> list[Card]:
    if not also:
        return [Card(**vars(summary(stored))) for stored in shown]
    # Imported here: plain lists need no mathematics.
    from mcml_service.actions.reading.describe_cards import cards
    from mcml_service.actions.reading.show_thumbnails import keep_pictures, pictures_of

    pictures, made = pictures_of(tx, shown) if also & {"thumbnail", "passport"} else ({}, [])
    call.held.callback(keep_pictures, call.database, made)
    return cards(tx, shown, pictures, also)


def get_document(call: Call, id: DocumentId, revision: AtRevision = None) -> DocumentDetail:
    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        # The reference file belongs to no revision, and changes without one.
        media = tx.media.of(stored.key)
        call.set_tag(tag(stored, "json" if media is None else f"json-{media.sha256[:12]}-{media.offset!r}"))
        return detail(then, stored)


def change_document(call: Call, id: DocumentId, change: DocumentChange, if_match: IfMatch = None) -> DocumentDetail:
    """Makes a revision."""
    with call.database.write(call.author) as tx:
        stored = find_for_write(tx, id, if_match)
        facts = change.model_dump(exclude_unset=True, exclude={"message", "properties"})
        if change.properties is not None:
            facts["properties"] = [(item.name, item.value, item.unit) for item in change.properties]
        changed = changes.change_document(tx, stored, message=change.message, **facts)
        call.tag = tag(changed)
        return detail(tx, changed)


def delete_document(call: Call, id: DocumentId, if_match: IfMatch = None) -> None:
    """Nothing is lost: `POST /documents/{id}/restore` brings it back."""

    def delete() -> None:
        with call.database.write(call.author) as tx:
            changes.delete_document(tx, find_for_write(tx, id, if_match))

    call.database.reserve.spend(delete)


def restore_document(
    call: Call,
    id: DocumentId,
    revision: Annotated[
        int | None,
        Field(ge=1, le=MOST, description="Make the content of this revision current again", examples=[1]),
    ] = None,
    if_match: IfMatch = None,
) -> DocumentDetail:
    with call.database.write(call.author) as tx:
        stored = find_for_write(tx, id, if_match, deleted=True)
        if revision is None:
            changed = changes.restore_document(tx, stored)
        else:
            changed = changes.restore_revision(tx, stored, revision)
        call.tag = tag(changed)
        return detail(tx, changed)


def undo_revision(
    call: Call,
    id: DocumentId,
    revision: Annotated[
        int | None, Field(ge=1, le=MOST, description="Revision to revert; default: the last one", examples=[2])
    ] = None,
    if_match: IfMatch = None,
) -> DocumentDetail:
    """Later ones stay; 409 where they touched the same. An undo can be undone."""
    with call.database.write(call.author) as tx:
        stored = find_for_write(tx, id, if_match)
        changed = changes.undo_revision(tx, stored, stored.revision if revision is None else revision)
        call.tag = tag(changed)
        return detail(tx, changed)


def list_revisions(
    call: Call,
    id: DocumentId,
    page: Page,
    with_: Annotated[
        Literal["frames"] | None,
        Field(alias="with", description="Also which frames each of them touched, as it left them"),
    ] = None,
) -> RevisionPage:
    before = page.after(int)
    with call.database.read() as tx:
        stored = tx.documents.get(id)
        revisions = tx.revisions.of(stored.key, before=None if before is None else before[0], limit=page.most(call) + 1)
        items, more = page.cut(call, revisions, lambda item: (item.number,))
        shown = [Revision.model_validate(item, from_attributes=True) for item in items]
        if with_ is not None:
            for item, answer in zip(items, shown, strict=True):
                answer.touched = _find_touched(tx, stored, item)
    return RevisionPage(items=shown, next_cursor=more)


def _find_touched(tx: Transaction, stored: StoredDocument, revision: StoredRevision) -> list[FrameRange] | None:
    """Returns None for the first stored revision, which has no earlier one."""
    from mcml_service.storage.undo.changed_frames import find_changed_frames

    then = tx.at_commit(revision.commit).documents.get(stored.uuid, deleted=True)
    before = (
        None if revision.parent is None else tx.at_commit(revision.commit - 1).documents.find(stored.uuid, deleted=True)
    )
    if before is None:
        return None
    ranges = find_changed_frames(tx, stored.key, revision.commit, before.frames, then.frames)
    return [FrameRange(first=first, last=last) for first, last in ranges]


def compare_revisions(
    call: Call,
    id: DocumentId,
    before: Annotated[int, Field(ge=1, le=MOST, description="The earlier revision", examples=[1])],
    after: Annotated[
        int | None, Field(ge=1, le=MOST, description="The later revision; default the current one", examples=[3])
    ] = None,
) -> Difference:
    # Imported here: other operations on documents need no mathematics.
    from mcml_service.actions.reading import compare_revisions as comparing

    with call.database.read() as tx:
        then, stored = at_revision(tx, id, before)
        now, other = at_revision(tx, id, after)
        return comparing.compare_revisions(then, stored, now, other)


def set_properties(
    call: Call,
    content: Annotated[
        bytes, Body({"text/csv": TABLE}, most=16 << 20), Field(description="Table of properties, one line a document")
    ],
    project: InProject = None,
) -> ChangedDocuments:
    """One line for each document, one column for each property.

    The first column is `document` (ids) or `name`; units are in parentheses in the headings: `age (year)`. Empty cells
    and properties without a column do not change. The whole table is written, or nothing.
    """
    from mcml_service.actions.labelling import set_properties as setting

    with call.database.write(call.author) as tx:
        changed = setting.set_properties(tx, content, project)
    return describe_changed(changed)


def describe_changed(documents: list[StoredDocument]) -> ChangedDocuments:
    return ChangedDocuments(
        items=[ChangedDocument(id=item.uuid, name=item.name, revision=item.revision) for item in documents]
    )
