"""Documents: upload, list, read, change, delete, restore, revisions."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, File, Form, Query, Request, Response, UploadFile
from fastapi.responses import JSONResponse

from schemas.documents import (
    DocumentChange,
    DocumentDetail,
    DocumentPage,
    FileProblem,
    InspectResult,
    Revision,
    RevisionPage,
    UploadResult,
)
from schemas.examples import DOCUMENT, MOTION_NAME, PROJECT
from service.actions.checking.describe_problem import problem_of
from service.actions.composing.select_documents import parse_condition
from service.actions.editing.change_document import (
    change_document,
    delete_document,
    restore_document,
    restore_revision,
    undo_revision,
)
from service.actions.importing.upload_files import upload_files
from service.actions.reading.describe_document import detail, summary
from service.actions.reading.import_options import ImportOptions, parse_label, parse_property
from service.actions.reading.inspect_files import inspect_files
from service.api.dependencies import (
    MOST,
    AuthorDep,
    DatabaseDep,
    DocumentId,
    IfMatch,
    PageDep,
    ProjectQuery,
    RevisionQuery,
    SettingsDep,
    at_revision,
    checked_for_write,
    decode_cursor,
    encode_cursor,
    etag,
)
from service.api.streaming import unchanged
from service.formats.format import SourceFile
from service.storage.filtering import DocumentFilter

router = APIRouter(tags=["documents"])

Files = Annotated[
    list[UploadFile],
    File(description="BVH, ASF and AMC, HTR, C3D, TRC, MCML, or zips of them", examples=[["walk.bvh"]]),
]


Encoding = Annotated[str | None, Form(description="Text encoding, if it is not UTF-8", examples=["cp949"])]


@router.post("/documents", status_code=201, operation_id="upload_documents", response_model=UploadResult)
def upload_documents(
    database: DatabaseDep,
    settings: SettingsDep,
    author: AuthorDep,
    file: Files,
    project: Annotated[str, Form(min_length=1, max_length=256, examples=[PROJECT])] = "default",
    name: Annotated[
        str | None, Form(max_length=1024, description="Name of the document; default the file's", examples=["walk"])
    ] = None,
    description: Annotated[str, Form(max_length=100_000, examples=["A walk on flat ground."])] = "",
    label: Annotated[
        list[str] | None,
        Form(description="NAME or NAME:FIRST-LAST; may be repeated", examples=[[f"{MOTION_NAME}:100-142"]]),
    ] = None,
    property: Annotated[
        list[str] | None,
        Form(description="NAME=VALUE or NAME=VALUE UNIT; may be repeated", examples=[["age=23 year"]]),
    ] = None,
    encoding: Encoding = None,
    translation: Annotated[Literal["auto", "absolute", "relative"], Form()] = "auto",
    unit: Annotated[
        str | None, Form(description="Length unit of the files: mm, cm, m, inch …", examples=["cm"])
    ] = None,
    up: Annotated[str | None, Form(description="Axis that points up", examples=["Y"])] = None,
    frame_time: Annotated[
        str | None, Form(description="Seconds a frame, where the files do not say", examples=["0.0083333"])
    ] = None,
    skeleton: Annotated[
        str | None, Form(description="Stored document whose ASF an AMC alone shall use", examples=[DOCUMENT])
    ] = None,
    on_duplicate: Annotated[Literal["new", "skip"], Form()] = "new",
    strict_names: Annotated[bool, Form(description="Refuse labels that are no anatomical movement")] = False,
    movements: Annotated[
        float | None,
        Form(
            ge=0,
            le=1,
            description="Name anatomical movements found in the motion with at least this confidence",
            examples=[0.7],
        ),
    ] = None,
) -> Response:
    """Store files as documents. Each document is stored whole or not at all; problems name the files that were not."""
    options = ImportOptions(
        project=project,
        name=name,
        description=description,
        labels=tuple(parse_label(text) for text in label or ()),
        properties=tuple(parse_property(text) for text in property or ()),
        encoding=encoding,
        translation=translation,
        unit=unit,
        up=up,
        frame_time=frame_time,
        skeleton=skeleton,
        on_duplicate=on_duplicate,
        strict_names=strict_names,
        movements=movements,
    )
    result = upload_files(database, _sources(file), options, settings, author=author)
    if not result.documents and result.problems:
        problem = result.problems[0].problem
        body = problem.model_dump(exclude_none=True) | {"problems": result.model_dump(exclude_none=True)["problems"]}
        return JSONResponse(body, problem.status, media_type="application/problem+json")
    headers = {"location": f"/api/v1/documents/{result.documents[0].id}"} if result.documents else {}
    return JSONResponse(result.model_dump(), 201, headers)


@router.post("/inspect", operation_id="inspect_files")
def inspect(settings: SettingsDep, file: Files, encoding: Encoding = None) -> InspectResult:
    """What an upload of these files would find. Nothing is stored."""
    clips, problems = inspect_files(_sources(file), ImportOptions(encoding=encoding), settings)
    return InspectResult(
        clips=clips, problems=[FileProblem(file=name, problem=problem_of(error)) for name, error in problems]
    )


@router.get("/documents", operation_id="list_documents")
def list_documents(
    database: DatabaseDep,
    page: PageDep,
    project: ProjectQuery = None,
    q: Annotated[str | None, Query(description="Part of the name", examples=["walk"])] = None,
    motion_name: Annotated[
        str | None, Query(description="Documents with a frame of this name", examples=[MOTION_NAME])
    ] = None,
    format: Annotated[str | None, Query(description="Source format", examples=["bvh"])] = None,
    skeleton: Annotated[
        int | None, Query(ge=0, le=MOST, description="Number of the skeleton, as lists give it", examples=[3])
    ] = None,
    property: Annotated[
        list[str] | None,
        Query(description="age:20..30 or take:calm; may be repeated", examples=[["age:20..30", "take:calm"]]),
    ] = None,
    deleted: Annotated[bool, Query(description="List deleted documents instead, which can be restored")] = False,
    sort: Literal["name", "newest"] = "name",
) -> DocumentPage:
    """Documents, by name or newest first."""
    wanted = DocumentFilter(
        project=project,
        text=q,
        motion_name=motion_name,
        format=format,
        skeleton=skeleton,
        properties=tuple(parse_condition(text) for text in property or ()),
        deleted=deleted,
    )
    after = None if page.cursor is None else decode_cursor(page.cursor, str, int)
    with database.read() as tx:
        found = tx.documents.page(
            wanted,
            after=None if after is None else (after[0], after[1]),
            limit=page.limit + 1,
            newest_first=sort == "newest",
        )
        total = tx.documents.count(wanted)
    shown = found[: page.limit]
    more = encode_cursor(shown[-1].name, shown[-1].key) if len(found) > page.limit else None
    return DocumentPage(items=[summary(stored) for stored in shown], next_cursor=more, total=total)


@router.get("/documents/{id}", operation_id="get_document", response_model=DocumentDetail)
def get_document(
    id: DocumentId, request: Request, response: Response, database: DatabaseDep, revision: RevisionQuery = None
) -> Any:
    """Everything about a document but its frames."""
    with database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        tag = etag(stored, "json")
        cached = unchanged(request, tag)
        if cached is not None:
            return cached
        response.headers["etag"] = tag
        return detail(then, stored)


@router.patch("/documents/{id}", operation_id="change_document")
def patch_document(
    id: DocumentId,
    change: DocumentChange,
    response: Response,
    database: DatabaseDep,
    author: AuthorDep,
    if_match: IfMatch = None,
) -> DocumentDetail:
    """Change name, project, description, properties, unit, up axis or frame time. Makes a revision."""
    with database.write(author) as tx:
        stored = checked_for_write(tx, id, if_match)
        facts = change.model_dump(exclude_unset=True, exclude={"message", "properties"})
        if change.properties is not None:
            facts["properties"] = [(item.name, item.value, item.unit) for item in change.properties]
        changed = change_document(tx, stored, message=change.message, **facts)
        response.headers["etag"] = etag(changed, "json")
        return detail(tx, changed)


@router.delete("/documents/{id}", status_code=204, operation_id="delete_document")
def remove_document(id: DocumentId, database: DatabaseDep, author: AuthorDep, if_match: IfMatch = None) -> Response:
    """Hide a document. Nothing is lost: `POST /documents/{id}/restore` brings it back."""

    def delete() -> None:
        with database.write(author) as tx:
            delete_document(tx, checked_for_write(tx, id, if_match))

    database.reserve.spend(delete)
    return Response(status_code=204)


@router.post("/documents/{id}/restore", operation_id="restore_document")
def restore(
    id: DocumentId,
    response: Response,
    database: DatabaseDep,
    author: AuthorDep,
    revision: Annotated[
        int | None,
        Query(ge=1, le=MOST, description="Make the content of this revision current again", examples=[1]),
    ] = None,
    if_match: IfMatch = None,
) -> DocumentDetail:
    """Bring a deleted document back, or make an earlier revision current (as a new revision)."""
    with database.write(author) as tx:
        stored = checked_for_write(tx, id, if_match, deleted=True)
        changed = restore_document(tx, stored) if revision is None else restore_revision(tx, stored, revision)
        response.headers["etag"] = etag(changed, "json")
        return detail(tx, changed)


@router.post("/documents/{id}/undo", operation_id="undo_revision")
def undo(
    id: DocumentId,
    response: Response,
    database: DatabaseDep,
    author: AuthorDep,
    revision: Annotated[
        int | None, Query(ge=1, le=MOST, description="What to take back; default the last one", examples=[2])
    ] = None,
    if_match: IfMatch = None,
) -> DocumentDetail:
    """Take back what one revision did, as a new revision. Later ones stay; 409 where they touched the same.

    An undo can be undone.
    """
    with database.write(author) as tx:
        stored = checked_for_write(tx, id, if_match)
        changed = undo_revision(tx, stored, stored.revision if revision is None else revision)
        response.headers["etag"] = etag(changed, "json")
        return detail(tx, changed)


@router.get("/documents/{id}/revisions", operation_id="list_revisions")
def list_revisions(id: DocumentId, database: DatabaseDep, page: PageDep) -> RevisionPage:
    """The history of a document, newest first."""
    before = None if page.cursor is None else int(decode_cursor(page.cursor, int)[0])
    with database.read() as tx:
        stored = tx.documents.get(id)
        found = tx.documents.revisions(stored.key, before=before, limit=page.limit + 1)
    items = [
        Revision(
            number=item.number,
            parent=item.parent,
            operation=item.operation,
            message=item.message,
            name=item.name,
            project=item.project,
            time=item.time,
            author=item.author,
        )
        for item in found[: page.limit]
    ]
    more = encode_cursor(items[-1].number) if len(found) > page.limit else None
    return RevisionPage(items=items, next_cursor=more)


def _sources(files: list[UploadFile]) -> list[SourceFile]:
    return [SourceFile(file.filename or "unnamed", file.file) for file in files]
