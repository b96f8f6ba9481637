"""Which documents there are `at` a commit, and all that is told of one: statements that are made once."""

from __future__ import annotations

from functools import cache
from typing import Any

from sqlalchemy import BigInteger, ColumnElement, Select, Table, and_, bindparam, func, select

from service.storage.tables import commit, content, document, header, project, revision

_AT = bindparam("at", type_=BigInteger)


@cache
def one_document(*, past: bool, deleted: bool) -> Select[Any]:
    """The document of a `uuid`. deleted: a deleted one too."""
    query = all_documents(past=past).where(document.c.uuid == bindparam("uuid"))
    return query if deleted else query.where(document.c.deleted_commit > _AT)


@cache
def all_documents(*, past: bool) -> Select[Any]:
    """All documents whose import was complete, deleted ones too, in the columns of `StoredDocument`.

    past: the commit may not be the newest. Then only the revision of that time knows name and project.
    """
    newest = (
        select(func.max(revision.c.number))
        .where(revision.c.document == document.c.id, revision.c.commit <= _AT)
        .scalar_subquery()
    )
    rate = (
        select(header.c.text)
        .where(header.c.document == document.c.id, header.c.tag == "dataframe_rate", *_valid(header))
        .scalar_subquery()
    )
    made = select(commit.c.time).where(commit.c.number == document.c.created_commit).scalar_subquery()
    changed = (
        select(func.max(commit.c.time))
        .join(revision, revision.c.commit == commit.c.number)
        .where(revision.c.document == document.c.id, revision.c.commit <= _AT)
        .scalar_subquery()
    )
    about: tuple[Any, Any, Any] = (document, document.c.name, document.c.project)
    if past:
        then = revision.alias()
        known = and_(then.c.document == document.c.id, then.c.number == newest)
        about = (document.join(then, known), then.c.name, then.c.project)
    source, name, project_key = about
    return (
        select(
            document.c.id.label("key"),
            document.c.uuid,
            project.c.name.label("project"),
            project.c.id.label("project_key"),
            name.label("name"),
            document.c.format,
            content.c.version,
            content.c.skeleton,
            content.c.frames,
            content.c.frame_time,
            rate.label("data_rate"),
            content.c.intact,
            newest.label("revision"),
            made.label("created"),
            changed.label("modified"),
            document.c.next_slot,
        )
        .select_from(source)
        .join(project, project.c.id == project_key)
        .join(content, and_(content.c.document == document.c.id, *_valid(content)))
        .where(document.c.state == "ready", document.c.created_commit <= _AT)
    )


def _valid(table: Table) -> tuple[ColumnElement[bool], ColumnElement[bool]]:
    return table.c.from_commit <= _AT, table.c.to_commit > _AT
