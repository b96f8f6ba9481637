"""Saved items of projects: queries, collections of documents, colours of motion names, and the vocabulary of a
project.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import Select, delete, select, tuple_

from mcml.errors import NotFoundError
from mcml_service.storage.core.identifiers import normalise_name, now
from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.tables import project
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import is_seen
from mcml_service.storage.documents.documents import Documents
from mcml_service.storage.lists.filtering import DocumentFilter, parse_condition, parse_range
from mcml_service.storage.projects.projects import Projects
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.work.tables import saved

Kind = Literal["query", "collection", "colours", "vocabulary"]

PREFIX = "collection:"
"""How a collection is named where ids of documents are taken: `collection:NAME`, or `collection:PROJECT/NAME`."""

_HELD = select(
    project.c.name.label("project_name"),
    *(saved.c[name] for name in ("name", "version", "author", "changed", "content")),
).join(project, project.c.id == saved.c.project)


@dataclass(frozen=True)
class StoredThing:
    """version: number of changes from 1; 0 for an item that does not exist. content: plain JSON values."""

    project: str
    name: str
    version: int
    author: str
    changed: str
    content: dict[str, Any]


class Saved:
    def __init__(self, tx: BaseTransaction, documents: Documents, projects: Projects, quotas: Quotas) -> None:
        self._tx = tx
        self._documents = documents
        self._projects = projects
        self._quotas = quotas

    def page(
        self, kind: Kind, project_name: str | None, after: tuple[str, str] | None, limit: int
    ) -> list[StoredThing]:
        """By project and name, those behind (project, name) `after`."""
        query = self._select_seen().where(saved.c.kind == kind).order_by(project.c.name, saved.c.name).limit(limit)
        if project_name is not None:
            query = query.where(project.c.name == normalise_name(project_name))
        if after is not None:
            query = query.where(tuple_(project.c.name, saved.c.name) > after)
        return [_to_thing(row) for row in self._tx.fetch_all(verify(query, saved))]

    def find(self, kind: Kind, project_name: str, name: str) -> StoredThing | None:
        query = self._select_seen().where(
            saved.c.kind == kind, project.c.name == normalise_name(project_name), saved.c.name == normalise_name(name)
        )
        rows = self._tx.fetch_all(verify(query, saved))
        return _to_thing(rows[0]) if rows else None

    def get(self, kind: Kind, project_name: str, name: str) -> StoredThing:
        """NotFoundError."""
        thing = self.find(kind, project_name, name)
        if thing is None:
            raise NotFoundError(
                f"The project {project_name!r} has no {kind} {name!r}.", remedy="List them, or save one."
            )
        return thing

    def put(self, kind: Kind, project_name: str, name: str, content: dict[str, Any], author: str) -> StoredThing:
        """Store an item under a name, replacing an existing one."""
        before = self.find(kind, project_name, name)
        if before is not None:
            self.remove(kind, before)
        row = {
            "project": self._projects.get_or_add(project_name),
            "kind": kind,
            "name": normalise_name(name),
            "version": 1 if before is None else before.version + 1,
            "author": author,
            "changed": now(),
            "content": json.dumps(content, ensure_ascii=False),
        }
        self._tx.insert_rows(saved, [row])
        return self.get(kind, project_name, name)

    def _select_seen(self) -> Select[Any]:
        return _HELD.where(is_seen(self._tx.view, saved.c.project))

    def remove(self, kind: Kind, thing: StoredThing) -> None:
        """AccessError."""
        key = self._projects.get(thing.project)
        self._quotas.require(key)
        chosen = (saved.c.project == key, saved.c.kind == kind)
        self._tx.run(delete(saved).where(*chosen, saved.c.name == thing.name))

    def expand(self, documents: Sequence[str]) -> list[str]:
        """Replace collections by the ids of their documents. Raises NotFoundError."""
        uuids: list[str] = []
        for text in documents:
            if text.startswith(PREFIX):
                uuids += self.members(self.collection(text.removeprefix(PREFIX)))
            else:
                uuids.append(text)
        return uuids

    def collection(self, text: str) -> StoredThing:
        """The collection of that name in the project `default`, or, where it is PROJECT/NAME, in that one."""
        project_name, slash, name = text.rpartition("/")
        return self.get("collection", project_name if slash else "default", name)

    def members(self, thing: StoredThing) -> list[str]:
        """Ids of the documents that are in a collection and still there."""
        wanted = thing.content.get("where")
        if wanted is None:
            return [uuid for uuid in thing.content["documents"] if self._documents.find(uuid) is not None]
        return self._documents.uuids(filter_of(wanted))


def filter_of(wanted: dict[str, Any]) -> DocumentFilter:
    """Return the conditions of a list from JSON. Raises QueryError for an invalid one."""
    return DocumentFilter(
        project=wanted.get("project"),
        motion_name=wanted.get("motion_name"),
        format=wanted.get("format"),
        skeleton=wanted.get("skeleton"),
        text=wanted.get("q"),
        properties=tuple(parse_condition(text) for text in wanted.get("property") or ()),
        length=parse_range(wanted["length"]) if wanted.get("length") else (None, None),
        rate=parse_range(wanted["rate"]) if wanted.get("rate") else (None, None),
    )


def _to_thing(row: Sequence[Any]) -> StoredThing:
    project_name, name, version, author, changed, content = row
    return StoredThing(project_name, name, version, author, changed, json.loads(content))
