"""Names of joints: what a project adds to those that are known, and documents that get the present ones."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Response

from schemas.examples import PROJECT
from schemas.names import AliasTable, AppliedNames, SavedAliases
from service.actions.naming.apply_names import apply_names, renames
from service.actions.naming.keep_aliases import alias_table, keep_aliases, remove_aliases
from service.api.dependencies import AuthorDep, DatabaseDep, DocumentId, IfMatch, checked_for_write

router = APIRouter(tags=["catalogues"])

OfProject = Annotated[
    str, Query(min_length=1, max_length=256, description="Project whose files call joints so", examples=[PROJECT])
]


@router.get("/aliases", operation_id="get_aliases")
def get_aliases(response: Response, database: DatabaseDep, project: OfProject = "default") -> AliasTable:
    """What a project calls joints, beside the names that are known."""
    with database.read() as tx:
        return _answer(alias_table(tx.aliases.of(project)), response)


@router.put("/aliases", operation_id="save_aliases")
def put_aliases(
    aliases: SavedAliases,
    response: Response,
    database: DatabaseDep,
    author: AuthorDep,
    project: OfProject = "default",
    if_match: IfMatch = None,
) -> AliasTable:
    """Save all aliases of a project, for imports to come. A present table is changed with `If-Match`, its version."""
    with database.write(author) as tx:
        return _answer(alias_table(keep_aliases(tx, project, aliases.items, if_match, author)), response)


@router.delete("/aliases", status_code=204, operation_id="delete_aliases")
def delete_aliases(
    database: DatabaseDep, author: AuthorDep, project: OfProject = "default", if_match: IfMatch = None
) -> Response:
    """Take all aliases of a project away. Documents keep the names that they have."""
    with database.write(author) as tx:
        remove_aliases(tx, project, if_match)
    return Response(status_code=204)


@router.post("/documents/{id}/names", operation_id="apply_names", tags=["documents"])
def post_names(
    id: DocumentId,
    database: DatabaseDep,
    author: AuthorDep,
    dry_run: Annotated[bool, Query(description="Say what would be renamed; change nothing")] = False,
    if_match: IfMatch = None,
) -> AppliedNames:
    """Give joints of a document the names that an import would give them now, as a revision that undo takes back."""
    if dry_run:
        with database.read() as tx:
            stored = tx.documents.get(id)
            items = renames(tx, stored)[1]
    else:
        with database.write(author) as tx:
            stored, items = apply_names(tx, checked_for_write(tx, id, if_match))
    return AppliedNames(document=id, revision=stored.revision, items=items)


def _answer(aliases: AliasTable, response: Response) -> AliasTable:
    response.headers["etag"] = f'"{aliases.version}"'
    return aliases
