"""Presence: people with an account who view or edit a document now.

Visitors without an account, and tokens without a person, are not listed.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from mcml_schemas.team.presence import PresenceRequest, Present, PresentList
from mcml_service.operations.arguments import DocumentId
from mcml_service.operations.call import Call
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

Tab = Annotated[str, Field(max_length=36, pattern="^[0-9a-zA-Z-]*$", description="The window", examples=["t1"])]


def list_present(call: Call, id: DocumentId) -> PresentList:
    """Lists everybody who reported presence within the last 90 seconds."""
    with call.database.read() as tx:
        return _list_present(tx, tx.documents.get(id))


def keep_presence(call: Call, id: DocumentId, presence: PresenceRequest) -> PresentList:
    """Valid for 90 seconds: repeat it before that. Returns the other people."""
    with call.database.write(call.author) as tx:
        stored = tx.documents.get(id)
        if call.account is not None:
            tx.presence.keep(stored, call.account, presence.tab, presence.doing)
        return _list_present(tx, stored, call.account)


def end_presence(call: Call, id: DocumentId, tab: Tab = "") -> None:
    """Without this call, presence ends after at most 90 seconds."""
    with call.database.write(call.author) as tx:
        stored = tx.documents.get(id)
        if call.account is not None:
            tx.presence.end(stored, call.account, tab)


def _list_present(tx: Transaction, stored: StoredDocument, but: str | None = None) -> PresentList:
    present: list[Any] = tx.presence.of(stored, but)
    return PresentList(items=[Present(**vars(person)) for person in present])
