"""Operations on finished results: a motion from a fitted model, a path through a space."""

from __future__ import annotations

import threading
from collections import OrderedDict
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

from mcml.errors import NotFoundError
from mcml_service.actions.analysing.save_results import add_parts, list_versions, load_parts
from mcml_service.actions.analysing.start_analysis import check_parameters
from mcml_service.actions.importing.store_clip import store_clip
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.analysis.interface import Answer, Parts, ResultUse
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.work.results import OPERATION, StoredResult

KEPT = 8
"""Results whose models are kept ready. A result never changes, so what is kept is never stale."""


@dataclass(frozen=True)
class Done:
    """The output of an operation. document, result: uuids of stored output."""

    answer: Answer
    document: str | None = None
    result: str | None = None


class Results:
    """Runs operations; thread-safe."""

    def __init__(self, database: Database, settings: Settings) -> None:
        self._database = database
        self._settings = settings
        self._lock = threading.Lock()
        self._ready: OrderedDict[str, tuple[StoredResult, Any]] = OrderedDict()

    def on(self, database: Database) -> Results:
        """Return the same for a store with a limited view."""
        if database is self._database:
            return self
        other = copy(self)
        other._database = database
        return other

    def use(
        self,
        uuid: str,
        operation: str,
        parameters: dict[str, Any],
        *,
        author: str,
        save: bool = False,
        name: str | None = None,
        project: str | None = None,
    ) -> Done:
        """Run an operation on a result. save: store the clip it makes as a document.

        Raises NotFoundError for a result or operation that does not exist, AnalysisError for unfit parameters.
        """
        stored, ready = self._prepare(uuid)
        chosen = self._operation(stored, operation)
        checked = chosen.parameters.model_validate(check_parameters(chosen.parameters, parameters))
        answer = chosen.run(ready, checked)
        if name and answer.clip is not None:
            answer = replace(answer, clip=replace(answer.clip, name=name))
        document = None
        if save and answer.clip is not None:
            provenance = {
                "analysis": stored.analysis,
                "result": stored.uuid,
                "operation": operation,
                "parameters": checked.model_dump(mode="json"),
                "sources": stored.inputs,
            }
            document = store_clip(
                self._database,
                answer.clip,
                self._settings,
                project=project or stored.project,
                author=author,
                provenance=provenance,
            )
        kept = None
        if answer.keep is not None:
            with self._database.write(author) as tx:
                key, kept = tx.results.add(
                    tx.projects.get_or_add(stored.project),
                    stored.analysis,
                    name or f"{operation} of {stored.name}",
                    author,
                    stored.inputs,
                    {OPERATION: operation, **checked.model_dump(mode="json")},
                    list_versions(stored.analysis),
                    parent=uuid,
                )
                add_parts(tx, key, answer.keep, {})
        return Done(answer, document, kept)

    def forget(self, uuid: str) -> None:
        with self._lock:
            self._ready.pop(uuid, None)

    def _prepare(self, uuid: str) -> tuple[StoredResult, Any]:
        with self._database.read() as tx:
            try:
                tx.results.get(uuid)
            except NotFoundError:
                # Another process may have deleted it, or purged what it was made of.
                self.forget(uuid)
                raise
        with self._lock:
            prepared = self._ready.get(uuid)
            if prepared is not None:
                self._ready.move_to_end(uuid)
                return prepared
        # Stored output of operations has only new data, so that all paths of a space share one copy of it.
        chain: list[tuple[StoredResult, Parts]] = []
        above = uuid
        while prepared is None:
            with self._database.read() as tx:
                stored = tx.results.get(above)
                chain.append((stored, load_parts(tx, stored.key)))
            if not stored.continues or stored.parent is None:
                break
            above = stored.parent
            with self._lock:
                prepared = self._ready.get(above)
        ready = None if prepared is None else prepared[1]
        for stored, parts in reversed(chain):
            analysis = ANALYSES.get(stored.analysis)
            if analysis is None:
                raise NotFoundError(f"There is no analysis {stored.analysis!r} any more.")
            ready = analysis.proceed(ready, parts) if stored.continues else analysis.prepare(parts)
            with self._lock:
                self._ready[stored.uuid] = (stored, ready)
                while len(self._ready) > KEPT:
                    self._ready.popitem(last=False)
        return stored, ready

    def _operation(self, stored: StoredResult, name: str) -> ResultUse:
        operations = ANALYSES[stored.analysis].operations
        if name not in operations:
            raise NotFoundError(
                f"A result of {stored.analysis} has no operation {name!r}.",
                remedy=f"It has: {', '.join(operations) or 'none'}.",
            )
        return operations[name]
