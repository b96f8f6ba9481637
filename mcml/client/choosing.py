"""Find documents by id, beginning of an id, or name; or all that match conditions."""

from __future__ import annotations

import re
from typing import Any

from mcml.client.client import Client
from mcml.errors import ConflictError, NotFoundError
from mcml_schemas.documents import DocumentSummary

_ID = re.compile(r"[0-9a-fA-F]{8}(?:-[0-9a-fA-F]{4}){3}-[0-9a-fA-F]{12}")
MOST_NAMED = 5
"""Documents that a message names where a text means several."""


def find_document(client: Client, text: str, *, deleted: bool = False) -> DocumentSummary:
    """Return the document with this beginning of an id, or this name.

    Raises NotFoundError if there is none, ConflictError if there are several.
    """
    asked: dict[str, Any] = {"limit": MOST_NAMED + 1}
    if deleted:
        asked["deleted"] = True
    documents: list[DocumentSummary] = []
    if len(text) <= 36 and set(text.lower()) <= set("0123456789abcdef-"):
        documents = client.call("list_documents", id=text, **asked).items
    documents = documents or client.call("list_documents", name=text, **asked).items
    if not documents:
        kind = "deleted document" if deleted else "document"
        raise NotFoundError(
            f"There is no {kind} {text}.", remedy="List the documents to see their ids and names: `mcml ls`."
        )
    if len(documents) > 1:
        named = ", ".join(f"{item.name} {item.id}" for item in documents[:MOST_NAMED])
        more = ", …" if len(documents) > MOST_NAMED else ""
        raise ConflictError(f"{text!r} is more than one document: {named}{more}.", remedy="Give more of the id.")
    return documents[0]


def id_of(client: Client, text: str, *, deleted: bool = False) -> str:
    """Return the id of the document that a text names; whole ids, and collections of documents, are returned
    unchanged.
    """
    return (
        text
        if _ID.fullmatch(text) or text.startswith("collection:")
        else find_document(client, text, deleted=deleted).id
    )


def choose_documents(
    client: Client,
    texts: list[str] | None = None,
    *,
    project: str | None = None,
    motion_name: str | None = None,
    xpath: str | None = None,
    **conditions: Any,
) -> list[DocumentSummary]:
    """Documents that are named, or all that fulfil every condition, by name.

    xpath: in which it finds something, or is true. conditions: others of the operation list_documents.
    """
    if texts:
        return [find_document(client, text) for text in texts]
    documents: list[DocumentSummary] = client.every(
        "list_documents", project=project, motion_name=motion_name, xpath=xpath, **conditions
    ).items
    return documents
