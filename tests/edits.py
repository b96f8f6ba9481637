"""Edits of one element, each a revision."""

from __future__ import annotations

from mcml_service.actions.editing.element_edits import Deletion, ElementEdit, edit_elements
from mcml_service.actions.editing.single_element import Change
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

OTHER_SEEDS = [(("sqlite", "postgresql")[seed % 2], seed) for seed in range(10)]
"""Of random stories: another one on each database. In `make fuzz` both have all."""


def change_element(
    tx: Transaction, stored: StoredDocument, address: str, change: Change, message: str = ""
) -> StoredDocument:
    """Change attributes or text of the element at an address."""
    return edit_elements(tx, stored, [ElementEdit(address, change)], message)


def delete_element(tx: Transaction, stored: StoredDocument, address: str) -> StoredDocument:
    """Delete the element or attribute at an address; frames behind it keep their ids."""
    return edit_elements(tx, stored, [ElementEdit(address, Deletion())])
