"""Documents that fulfil conditions, at the revisions they are at."""

from __future__ import annotations

from mcml_schemas.jobs import Selection
from mcml_schemas.querying.queries import QueryRequest, ScalarItem
from mcml_service.actions.composing.load_motions import Input
from mcml_service.actions.importing.store_clip import PROVENANCE
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.analysis.interface import AnalysisError
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter, parse_condition
from mcml_service.xpath.queries import Queries

MOST = 1_000_000


def select_documents(database: Database, queries: Queries, selection: Selection) -> tuple[list[Input], set[str]]:
    """The documents and their present revisions, in the order of their ids; and the projects they are in."""
    if not (selection.documents or selection.project or selection.motion_name or selection.property or selection.xpath):
        raise AnalysisError("nothing-selected", "No documents are selected.", remedy="Name documents or a project.")
    wanted = DocumentFilter(
        project=selection.project,
        motion_name=selection.motion_name,
        properties=tuple(parse_condition(text) for text in selection.property),
    )
    with database.read() as tx:
        selection = selection.model_copy(update={"documents": tx.saved.expand(selection.documents)})
        if selection.project:
            tx.projects.get(selection.project)
        if selection.documents and not (selection.project or selection.motion_name or selection.property):
            stored = [tx.documents.get(uuid) for uuid in dict.fromkeys(selection.documents)]
        else:
            named = {tx.documents.get(uuid).uuid for uuid in selection.documents}
            stored = [
                item for item in tx.documents.page(wanted, after=None, limit=MOST) if not named or item.uuid in named
            ]
    if selection.xpath:
        hits = _where(queries, selection.xpath, [item.uuid for item in stored])
        stored = [item for item in stored if item.uuid in hits]
    inputs: list[Input] = [{"document": item.uuid, "revision": item.revision} for item in stored]
    return sorted(inputs, key=lambda item: str(item["document"])), {item.project for item in stored}


def select_captured(database: Database, selection: Selection, found: list[Input]) -> list[Input]:
    """Return selected documents without those that an analysis made, because these are not captured motion.

    All are returned if documents are named by their ids, or with `include_made`. Compositions and retargeted clips of
    captured motion count as captured motion.
    """
    if selection.documents or selection.include_made:
        return found
    # As `store_stream` writes them.
    beginnings = tuple(f'{{"analysis":"{name}"' for name in ANALYSES)
    with database.read() as tx:
        recorded = tx.documents.with_property(PROVENANCE, '{"analysis":')
    made = {uuid for uuid, text in recorded if text.startswith(beginnings)}
    return [item for item in found if item["document"] not in made]


def _where(queries: Queries, expression: str, documents: list[str]) -> set[str]:
    """The documents of these in which the expression is true or finds something."""
    hits: set[str] = set()
    cursor: str | None = None
    while documents:
        request = QueryRequest(q=f"boolean({expression})", document=documents, limit=1000, cursor=cursor)
        answer = queries.answer(request)
        if answer.value is not None:
            return set(documents) if answer.value else set()
        hits |= {item.document for item in answer.items or () if isinstance(item, ScalarItem) and item.value}
        cursor = answer.next_cursor
        if cursor is None:
            break
    return hits
