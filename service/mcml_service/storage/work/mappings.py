"""Mappings of joints that a project keeps under names."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Row, Select, delete, select, tuple_, update

from mcml.errors import NotFoundError
from mcml_service.storage.core.identifiers import normalise_name, now
from mcml_service.storage.core.seals import SEALS
from mcml_service.storage.core.tables import project
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import is_seen
from mcml_service.storage.projects.projects import Projects
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.work.tables import joint_mapping

_LISTED = select(joint_mapping, project.c.name.label("project_name")).join(
    project, project.c.id == joint_mapping.c.project
)


@dataclass(frozen=True)
class StoredMapping:
    """pairs: names of joints of the source and the target. version: counts changes from 1."""

    key: int
    project: str
    name: str
    version: int
    author: str
    changed: str
    pairs: tuple[tuple[str, str], ...]


class Mappings:
    def __init__(self, tx: BaseTransaction, projects: Projects, quotas: Quotas) -> None:
        self._tx = tx
        self._projects = projects
        self._quotas = quotas

    def page(self, project_name: str | None, after: tuple[str, str] | None, limit: int) -> list[StoredMapping]:
        """Mappings by project and name, those behind (project, name) `after`."""
        query = self._select_seen().order_by(project.c.name, joint_mapping.c.name).limit(limit)
        if project_name is not None:
            query = query.where(joint_mapping.c.project == self._projects.get(project_name))
        if after is not None:
            query = query.where(tuple_(project.c.name, joint_mapping.c.name) > after)
        return [_to_mapping(row) for row in self._tx.fetch_all(query)]

    def find(self, project_name: str, name: str) -> StoredMapping | None:
        query = self._select_seen().where(
            project.c.name == normalise_name(project_name), joint_mapping.c.name == normalise_name(name)
        )
        row = self._tx.fetch_one(query)
        return None if row is None else _to_mapping(row)

    def get(self, project_name: str, name: str) -> StoredMapping:
        """NotFoundError."""
        mapping = self.find(project_name, name)
        if mapping is None:
            raise NotFoundError(
                f"The project {project_name!r} has no mapping {name!r}.", remedy="List them, or save one."
            )
        return mapping

    def put(self, project_name: str, name: str, pairs: tuple[tuple[str, str], ...], author: str) -> StoredMapping:
        """Store a mapping under a name, replacing an existing one."""
        values = {"pairs": json.dumps(pairs, ensure_ascii=False), "author": author, "changed": now()}
        before = self.find(project_name, name)
        if before is None:
            key = self._projects.get_or_add(project_name)
            self._tx.insert_row(joint_mapping, project=key, name=normalise_name(name), version=1, **values)
        else:
            key = self._projects.get_or_add(project_name)
            row = {"project": key, "name": before.name, "version": before.version + 1, **values}
            checksum = SEALS[joint_mapping].of(tuple(row[name] for name in SEALS[joint_mapping].columns))
            chosen = update(joint_mapping).where(joint_mapping.c.id == before.key)
            self._tx.run(chosen.values(**row, checksum=checksum))
        return self.get(project_name, name)

    def _select_seen(self) -> Select[Any]:
        return _LISTED.where(is_seen(self._tx.view, joint_mapping.c.project))

    def remove(self, stored: StoredMapping) -> None:
        """AccessError."""
        self._quotas.require(self._projects.get(stored.project))
        self._tx.run(delete(joint_mapping).where(joint_mapping.c.id == stored.key))


def _to_mapping(row: Row[tuple[object, ...]]) -> StoredMapping:
    pairs = tuple((source, target) for source, target in json.loads(row.pairs))
    return StoredMapping(row.id, row.project_name, row.name, row.version, row.author, row.changed, pairs)
