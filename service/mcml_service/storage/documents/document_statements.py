"""Prepared statements for the documents `at` a commit and their facts."""

from __future__ import annotations

from functools import cache
from typing import Any

from sqlalchemy import Select, and_, bindparam, func, select

from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import commit, content, document, header, project, revision
from mcml_service.storage.core.validity import AT, is_imported, there, valid

CONTENT = tuple(
    column.name for column in content.c if not column.primary_key and column.name not in ("to_commit", "checksum")
)
"""Values with one entry for each revision of a document."""

_NEWEST = (
    select(func.max(revision.c.number))
    .where(revision.c.document == document.c.id, revision.c.commit <= AT)
    .scalar_subquery()
)


@cache
def one_document(*, past: bool, deleted: bool) -> Prepared:
    """The document of a `uuid`. deleted: a deleted one too."""
    query = all_documents(past=past).where(document.c.uuid == bindparam("uuid"))
    return Prepared(query if deleted else query.where(document.c.deleted_commit > AT), document, content)


@cache
def all_documents(*, past: bool) -> Select[Any]:
    """All documents whose import was complete, deleted ones too, in the columns of `StoredDocument`.

    past: the commit may not be the newest.
    """
    rate = (
        select(header.c.text)
        .where(header.c.document == document.c.id, header.c.tag == "dataframe_rate", valid(header))
        .scalar_subquery()
    )
    made = select(commit.c.time).where(commit.c.number == document.c.created_commit).scalar_subquery()
    changed = (
        select(func.max(commit.c.time))
        .join(revision, revision.c.commit == commit.c.number)
        .where(revision.c.document == document.c.id, revision.c.commit <= AT)
        .scalar_subquery()
    )
    source, held = _select_names(past=past)
    return (
        select(
            document.c.id.label("key"),
            document.c.uuid,
            project.c.name.label("project"),
            project.c.id.label("project_key"),
            held.c.name.label("name"),
            document.c.format,
            *(content.c[name] for name in CONTENT),
            rate.label("data_rate"),
            _NEWEST.label("revision"),
            made.label("created"),
            changed.label("modified"),
            document.c.next_slot,
        )
        .select_from(source)
        .join(project, project.c.id == held.c.project)
        .join(content, and_(content.c.document == document.c.id, valid(content)))
        .where(is_imported())
    )


def select_listed(*, past: bool) -> Select[Any]:
    """Select all existing documents, in the columns of `Listed`. past: as above."""
    source, held = _select_names(past=past)
    about = (document.c.id, document.c.uuid, held.c.name, content.c.version, content.c.skeleton)
    return (
        select(*about, content.c.frames, content.c.frame_time, _NEWEST, held.c.project)
        .select_from(source)
        .join(content, and_(content.c.document == document.c.id, valid(content)))
        .where(there())
    )


def _select_names(*, past: bool) -> tuple[Any, Any]:
    """Documents, and the table that has their names and projects: of the past only the revision of that time knows."""
    if not past:
        return document, document
    then = revision.alias()
    return document.join(then, and_(then.c.document == document.c.id, then.c.number == _NEWEST)), then
