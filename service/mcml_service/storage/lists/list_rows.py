"""Facts by which lists are filtered and sorted, for many documents at once: one statement for each kind of fact."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

from sqlalchemy import and_, case, func, null, or_, select

from mcml_service.storage.core.sql_expressions import OneOf
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import content, document, header, project, property_, revision, span
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import AT, is_imported, valid
from mcml_service.storage.lists.filtering import IS_SAID, SAID, SHORT, seconds

Row: TypeAlias = tuple[Any, ...]

KEYS_AT_A_TIME = 10_000


@dataclass(frozen=True)
class ListRows:
    """The rows for lists.

    documents: (key, uuid, name, project, format, commit of creation, whether it exists, skeleton, frames, seconds a
    frame or None, revision, commit of the revision). said: (key, text). named: (key, motion name), each once. having:
    (key, name, number or None, text, None for a long text), of properties.
    """

    documents: list[Row]
    said: Iterable[Row]
    named: Iterable[Row]
    having: Iterable[Row]


@cache
def _statements() -> dict[str, tuple[Prepared, Prepared]]:
    """Of each kind of fact the statement for all documents, and that for some `keys`."""
    joined = document.join(project).join(content, and_(content.c.document == document.c.id, valid(content)))
    about = (document.c.id, document.c.uuid, document.c.name, project.c.name, document.c.format)
    since = (document.c.created_commit, document.c.deleted_commit > AT, content.c.skeleton, content.c.frames)
    short = case((func.length(property_.c.text) <= SHORT, property_.c.text), else_=null())
    facts = (property_.c.document, property_.c.name, property_.c.number, short)
    newest = select(revision.c.document, func.max(revision.c.number), func.max(revision.c.commit))
    said = select(header.c.document, SAID).where(IS_SAID, valid(header))
    short_or_number = or_(func.length(property_.c.text) <= SHORT, property_.c.number.is_not(None))
    wanted = {
        "documents": (select(*about, *since, seconds()).select_from(joined).where(is_imported()), document.c.id),
        "newest": (newest.where(revision.c.commit <= AT).group_by(revision.c.document), revision.c.document),
        "said": (said, header.c.document),
        "named": (select(span.c.document, span.c.name).where(valid(span)).distinct(), span.c.document),
        "having": (select(*facts).where(short_or_number), property_.c.document),
    }
    return {name: (Prepared(query), Prepared(query.where(OneOf(key, "keys")))) for name, (query, key) in wanted.items()}


_KEYS = Prepared(select(document.c.id).where(is_imported()))


def read_list_rows(tx: BaseTransaction, keys: Sequence[int] | None = None) -> ListRows:
    """Of documents, of all if no keys are given, whose import was complete; deleted ones too."""
    newest = {row[0]: row[1:] for row in _rows(tx, "newest", keys)}
    return ListRows(
        [(*row, *newest[row[0]]) for row in _rows(tx, "documents", keys)],
        _rows(tx, "said", keys),
        _rows(tx, "named", keys),
        _rows(tx, "having", keys),
    )


def _rows(tx: BaseTransaction, kind: str, keys: Sequence[int] | None) -> Iterable[Row]:
    whole, some = _statements()[kind]
    if keys is None:
        yield from tx.fetch_all(whole, {"at": tx.at})
        return
    for start in range(0, len(keys), KEYS_AT_A_TIME):
        yield from tx.fetch_all(some, {"at": tx.at, "keys": list(keys[start : start + KEYS_AT_A_TIME])})


def find_keys(tx: BaseTransaction) -> list[int]:
    """The documents of `read_list_rows`, all of them."""
    return tx.fetch_column(_KEYS, {"at": tx.at})
