"""Aliases of joints in a project: one table for each project."""

from __future__ import annotations

import json
from dataclasses import dataclass

from sqlalchemy import delete, select

from mcml_service.storage.core.identifiers import now
from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.projects.projects import Projects
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.work.tables import joint_alias

_HELD = select(joint_alias.c.version, joint_alias.c.author, joint_alias.c.changed, joint_alias.c.pairs)

Pairs = tuple[tuple[str, str], ...]
"""(name in files, MCML's name)."""


@dataclass(frozen=True)
class StoredAliases:
    """version: counts changes from 1; 0 where the project has none."""

    project: str
    version: int = 0
    author: str = ""
    changed: str = ""
    pairs: Pairs = ()


class Aliases:
    def __init__(self, tx: BaseTransaction, projects: Projects, quotas: Quotas) -> None:
        self._tx = tx
        self._projects = projects
        self._quotas = quotas

    def of(self, project_name: str) -> StoredAliases:
        """Return the aliases of a project, empty for a project that does not exist yet."""
        key = self._projects.find(project_name)
        rows = [] if key is None else self._tx.fetch_all(verify(_HELD.where(joint_alias.c.project == key), joint_alias))
        if not rows:
            return StoredAliases(project_name)
        ((version, author, changed, packed),) = rows
        pairs = tuple((source, name) for source, name in json.loads(packed))
        return StoredAliases(project_name, version, author, changed, pairs)

    def put(self, project_name: str, pairs: Pairs, author: str) -> StoredAliases:
        """Store a table, replacing an existing one."""
        values = {"pairs": json.dumps(pairs, ensure_ascii=False), "author": author, "changed": now()}
        key = self._projects.get_or_add(project_name)
        before = self.of(project_name)
        self._tx.run(delete(joint_alias).where(joint_alias.c.project == key))
        self._tx.insert_rows(joint_alias, [{"project": key, "version": before.version + 1, **values}])
        return self.of(project_name)

    def remove(self, project_name: str) -> None:
        """AccessError."""
        key = self._projects.get(project_name)
        self._quotas.require(key)
        self._tx.run(delete(joint_alias).where(joint_alias.c.project == key))
