"""Results of queries for further processing: documents, and addresses of elements."""

from __future__ import annotations

from mcml.errors import QueryError
from mcml_schemas.querying.queries import QueryRequest, ScalarItem
from mcml_service.xpath.answer.describe import describe_nodes
from mcml_service.xpath.answer.streams import Shown
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.types import type_of
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.nodes.numbering import MAX_DOCUMENTS
from mcml_service.xpath.queries import Queries


def documents_with(queries: Queries, expression: str, project: str | None, limits: Limits) -> set[str] | None:
    """The ids of documents in which an expression is true or finds something; None for all."""
    hits: set[str] = set()
    request = QueryRequest(q=f"boolean({expression})", project=project, limit=MAX_DOCUMENTS, per="document")
    while True:
        answer = queries.answer(request, limits)
        if answer.value is not None:
            return None if answer.value else set()
        hits |= {item.document for item in answer.items or () if isinstance(item, ScalarItem) and item.value}
        if answer.next_cursor is None:
            return hits
        request = request.model_copy(update={"cursor": answer.next_cursor})


def addresses(queries: Queries, request: QueryRequest) -> list[str]:
    """The canonical addresses of all nodes of an answer (or the first `limit`). Raises as `Queries.answer` does, and
    QueryError for an expression that gives values."""
    if type_of(parse(request.q, request.variables).tree) not in ("nodes", "sequence"):
        raise QueryError("The expression gives a value, not an element.", remedy="Write a path to one element.")
    found = queries.stream(request)
    if isinstance(found, Shown):
        return [node.address for nodes in found.nodes() for node in nodes]
    shown = found.shown(lambda forest, nodes: list(describe_nodes(forest, nodes)))
    return [address for some in shown for _, address in some]
