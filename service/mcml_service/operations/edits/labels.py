"""Labels: the motion_name elements of frames, as spans; of one document, by query, and as tables."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mcml.answers import Content
from mcml_schemas.documents import ChangedDocuments, Label, LabelPage, LabelRequest
from mcml_schemas.examples import DOCUMENT, MOTION_NAME
from mcml_schemas.labels import LabelChange, LabelQuery, SuggestedLabels
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.actions.editing import whole_document as changes
from mcml_service.actions.exporting.write_tables import TYPES, About, batches_of, write_table
from mcml_service.actions.labelling import edit_labels
from mcml_service.actions.labelling import suggest_labels as suggesting
from mcml_service.operations.arguments import (
    MOST,
    AtRevision,
    DocumentId,
    Documents,
    IfMatch,
    InProject,
    Page,
    Raw,
    at_revision,
    find_for_write,
    tag,
)
from mcml_service.operations.call import Call
from mcml_service.operations.documents import describe_changed
from mcml_service.operations.operation import Body, gives
from mcml_service.storage.documents.spans import StoredSpan
from mcml_service.storage.lists.filtering import DocumentFilter

TABLE = f"document,label,first,last\n{DOCUMENT},{MOTION_NAME},100,142\n"
LabelId = Annotated[int, Field(le=MOST, description="Id of the label, as the list gives it", examples=[12])]
Strict = Annotated[bool, Field(description="Refuse names that are no anatomical movement")]


def list_labels(
    call: Call,
    id: DocumentId,
    page: Page,
    revision: AtRevision = None,
    name: Annotated[str | None, Field(description="Only this motion name", examples=[MOTION_NAME])] = None,
) -> LabelPage:
    after = page.after(int)
    start = 0 if after is None else after[0]
    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        spans = [span for span in then.spans.of(stored.key) if name is None or span.name == name]
    shown, more = page.cut(call, spans[start:], lambda _: (start + page.most(call),))
    return LabelPage(items=[_label(span) for span in shown], next_cursor=more)


def suggest_labels(
    call: Call,
    id: DocumentId,
    kind: Annotated[
        Literal["activities", "movements"],
        Field(
            description="activities: of the body in everyday words, such as walk or turn left; movements: of joints in "
            "the words of anatomy, such as left-knee-flexion",
            examples=["activities"],
        ),
    ] = "activities",
    confidence: Annotated[float, Field(ge=0, le=1, description="The least, 0 to 1", examples=[0.6])] = 0.5,
    facing: Annotated[
        Literal["X", "-X", "Y", "-Y", "Z", "-Z"] | None,
        Field(
            description="For movements: facing direction of the upright body, if the joint names have no sides",
            examples=["Z"],
        ),
    ] = None,
) -> SuggestedLabels:
    """Nothing is written; POST those to accept."""
    with call.database.read() as tx:
        stored = tx.documents.get(id)
        if kind == "movements":
            return SuggestedLabels(items=suggesting.suggest_movement_names(tx, stored, confidence, facing))
        found, unknown = suggesting.suggest_activities(tx, stored, confidence)
        return SuggestedLabels(items=found, warnings=unknown)


def add_labels(
    call: Call, id: DocumentId, labels: list[LabelRequest], strict: Strict = False, if_match: IfMatch = None
) -> LabelPage:
    """All of the list, or nothing, becomes one revision."""
    with call.database.write(call.author) as tx:
        stored = find_for_write(tx, id, if_match)
        added = changes.add_labels(tx, stored, [(item.name, item.first, item.last) for item in labels], strict=strict)
        call.tag = tag(tx.documents.get(id))
    return LabelPage(items=[_label(span) for span in added])


def change_label(
    call: Call, id: DocumentId, label: LabelId, change: LabelChange, if_match: IfMatch = None
) -> LabelPage:
    """Answers what it has become; it has another id then."""
    with call.database.write(call.author) as tx:
        stored = find_for_write(tx, id, if_match)
        made = edit_labels.change_label(tx, stored, label, **change.model_dump())
        call.tag = tag(tx.documents.get(id))
    return LabelPage(items=[_label(span) for span in made])


def delete_label(call: Call, id: DocumentId, label: LabelId, if_match: IfMatch = None) -> None:
    with call.database.write(call.author) as tx:
        changes.remove_labels(tx, find_for_write(tx, id, if_match), label)
        call.tag = tag(tx.documents.get(id))


def label_by_query(call: Call, request: LabelQuery) -> ChangedDocuments:
    asked = QueryRequest(q=request.xpath, document=request.document, project=request.project)
    changed = edit_labels.label_by_query(
        call.database,
        call.queries,
        asked,
        request.name,
        author=call.author,
        remove=request.remove,
        strict=request.strict,
        instead_of=request.instead_of,
    )
    return describe_changed(changed)


@gives("The table", {"text/csv": TABLE, TYPES["arrow"]: None, TYPES["parquet"]: None})
def export_labels(
    call: Call,
    project: InProject = None,
    document: Documents = None,
    format: Annotated[
        Literal["csv", "arrow", "parquet"], Field(description="Text, or columns (with the extra `arrow`)")
    ] = "csv",
    raw: Raw = False,
) -> Content:
    with call.database.read() as tx:
        if document:
            documents = [tx.documents.get(uuid) for uuid in tx.saved.expand(document)]
        else:
            documents = tx.documents.page(DocumentFilter(project=project), after=None, limit=MOST)
        rows = list(edit_labels.label_rows(tx, documents))
    if format == "csv":
        return Content(iter([edit_labels.label_table(rows, raw=raw).encode()]), "text/csv; charset=utf-8", "labels.csv")
    kinds = dict(zip(edit_labels.HEADINGS, ("string", "string", "int64", "int64"), strict=True))
    table = write_table(format, batches_of(iter(rows), list(kinds)), About(kinds))
    return Content(table, TYPES[format], f"labels.{format}")


def import_labels(
    call: Call,
    content: Annotated[
        bytes,
        Body({"text/csv": TABLE}, most=64 << 20),
        Field(description="Table: document (or name), label, first, last"),
    ],
    project: Annotated[str | None, Field(description="Project in which names are looked up", examples=["gait"])] = None,
    strict: Strict = False,
    replace: Annotated[bool, Field(description="The labels that these documents had go")] = False,
) -> ChangedDocuments:
    """A column `name` may replace `document`. The whole table is imported, or nothing."""
    with call.database.write(call.author) as tx:
        return describe_changed(edit_labels.write_label_table(tx, content, project, strict=strict, replace=replace))


def _label(span: StoredSpan) -> Label:
    return Label(id=span.key, name=span.name, first=span.first, last=span.last, rank=span.rank)
