"""Saved mappings of joints: which joint of one rig is which of another."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Response

from schemas.examples import PROJECT
from schemas.retarget import Mapping, MappingPage, SavedMapping
from service.actions.checking.preconditions import check_match
from service.actions.composing.keep_mapping import keep_mapping, mapping_answer
from service.api.dependencies import (
    AuthorDep,
    DatabaseDep,
    IfMatch,
    PageDep,
    ProjectQuery,
    decode_cursor,
    encode_cursor,
)

router = APIRouter(tags=["compose"])

MappingName = Annotated[
    str, Path(min_length=1, max_length=1024, description="Name of the mapping", examples=["cmu to robot"])
]
InProject = Annotated[
    str, Query(min_length=1, max_length=256, description="Project that keeps the mapping", examples=[PROJECT])
]


@router.get("/mappings", operation_id="list_mappings", response_model_exclude_none=True)
def list_mappings(database: DatabaseDep, page: PageDep, project: ProjectQuery = None) -> MappingPage:
    """Saved mappings of joints, by project and name."""
    after = None
    if page.cursor is not None:
        first, second = decode_cursor(page.cursor, str, str)
        after = str(first), str(second)
    with database.read() as tx:
        found = tx.mappings.page(project, after, page.limit + 1)
    shown = found[: page.limit]
    more = encode_cursor(shown[-1].project, shown[-1].name) if len(found) > len(shown) else None
    return MappingPage(items=[mapping_answer(item) for item in shown], next_cursor=more)


@router.get("/mappings/{name:path}", operation_id="get_mapping")
def get_mapping(
    name: MappingName, response: Response, database: DatabaseDep, project: InProject = "default"
) -> Mapping:
    """One saved mapping."""
    with database.read() as tx:
        return _answer(mapping_answer(tx.mappings.get(project, name)), response)


@router.put(
    "/mappings/{name:path}",
    operation_id="save_mapping",
    responses={201: {"model": Mapping, "description": "A new mapping"}},
)
def put_mapping(
    name: MappingName,
    mapping: SavedMapping,
    response: Response,
    database: DatabaseDep,
    author: AuthorDep,
    project: InProject = "default",
    if_match: IfMatch = None,
) -> Mapping:
    """Save a mapping under a name; a present one is changed with `If-Match` and its version."""
    with database.write(author) as tx:
        made = mapping_answer(keep_mapping(tx, project, name, mapping.pairs, if_match, author))
    if made.version == 1:
        response.status_code = 201
    return _answer(made, response)


@router.delete("/mappings/{name:path}", status_code=204, operation_id="delete_mapping")
def delete_mapping(
    name: MappingName,
    database: DatabaseDep,
    author: AuthorDep,
    project: InProject = "default",
    if_match: IfMatch = None,
) -> Response:
    """Delete a saved mapping. What was made with it stays."""
    with database.write(author) as tx:
        tx.dialect.order_commits(tx.connection)
        stored = tx.mappings.get(project, name)
        check_match(if_match, stored.version, "mapping", "version")
        tx.mappings.remove(stored)
    return Response(status_code=204)


def _answer(mapping: Mapping, response: Response) -> Mapping:
    response.headers["etag"] = f'"{mapping.version}"'
    return mapping
