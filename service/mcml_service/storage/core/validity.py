"""Validity of rows at a commit: the conditions that every statement shares.

Where no commit is named, it is the parameter `at` of a statement that is made once (`statements.Prepared`).
"""

from __future__ import annotations

from typing import TypeAlias

from sqlalchemy import BigInteger, BindParameter, ColumnElement, Table, and_, bindparam

from mcml_service.storage.core.tables import document

Commit: TypeAlias = BindParameter[int] | int

AT: BindParameter[int] = bindparam("at", type_=BigInteger)
DOCUMENT: BindParameter[int] = bindparam("document", type_=BigInteger)
"""Parameters: the commit, and the key of the document."""


def valid(table: Table, at: Commit = AT) -> ColumnElement[bool]:
    """Rows of a table with `from_commit` and `to_commit` that are valid."""
    return and_(table.c.from_commit <= at, table.c.to_commit > at)


def of_document(table: Table) -> ColumnElement[bool]:
    """Valid rows of the one document."""
    return and_(table.c.document == DOCUMENT, valid(table))


def is_imported(at: Commit = AT) -> ColumnElement[bool]:
    """Return the condition for completely imported documents, including deleted ones."""
    return and_(document.c.state == "ready", document.c.created_commit <= at)


def there(at: Commit = AT) -> ColumnElement[bool]:
    """Documents that could be seen."""
    return and_(is_imported(at), document.c.deleted_commit > at)
