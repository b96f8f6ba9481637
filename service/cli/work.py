"""Analyses, jobs and results as commands see them: on a store of this machine, or through a server's REST API."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote

from schemas.jobs import Job, Result, Selection
from service.actions.analysing.describe_job import job_answer, result_answer
from service.actions.analysing.start_analysis import find_analysis, start_analysis
from service.actions.analysing.use_result import Results
from service.actions.importing.store_clip import clip_file
from service.analysis.interface import Progress
from service.cli.access import LocalLibrary, RemoteLibrary
from service.cli.shared import open_library
from service.errors import NotFoundError
from service.jobs.runner import run_here
from service.storage.identifiers import new_uuid
from service.storage.jobs import ENDED
from service.xpath.run import Queries

POLL_SECONDS = 0.4


@dataclass(frozen=True)
class Order:
    """An analysis that shall run. queue: a server shall do it; the command does not wait."""

    analysis: str
    selection: Selection
    parameters: dict[str, Any]
    name: str | None = None
    project: str | None = None
    queue: bool = False
    extends: str | None = None
    skeleton: str | None = None


class Work(ABC):
    """What commands do with analyses, in the words of the REST API."""

    @abstractmethod
    def start(self, order: Order, progress: Progress) -> Job:
        """Run an analysis to its end, or queue it."""

    @abstractmethod
    def job(self, uuid: str) -> Job: ...

    @abstractmethod
    def jobs(self, project: str | None, state: str | None, limit: int) -> list[Job]: ...

    @abstractmethod
    def cancel(self, uuid: str) -> Job: ...

    @abstractmethod
    def result(self, uuid: str) -> Result: ...

    @abstractmethod
    def results(self, project: str | None, analysis: str | None, limit: int) -> list[Result]: ...

    @abstractmethod
    def delete_result(self, uuid: str) -> None: ...

    @abstractmethod
    def use(self, uuid: str, operation: str, parameters: dict[str, Any], saving: dict[str, Any]) -> dict[str, Any]:
        """What an operation gives, as JSON."""

    @abstractmethod
    def use_for_file(
        self, uuid: str, operation: str, parameters: dict[str, Any], saving: dict[str, Any], format: str
    ) -> tuple[str, bytes]:
        """(file name, bytes) of the clip that an operation makes."""

    def wait(self, job: Job, progress: Progress) -> Job:
        """Follow a job until it has ended."""
        while job.state not in ENDED:
            progress(job.stage, job.share)
            time.sleep(POLL_SECONDS)
            job = self.job(job.id)
        return job


class LocalWork(Work):
    def __init__(self, library: LocalLibrary) -> None:
        self._database, self._settings = library.database, library.settings
        self._results = Results(self._database, self._settings)

    def start(self, order: Order, progress: Progress) -> Job:
        runner = None if order.queue else new_uuid()
        queries = Queries(self._database, self._settings)
        try:
            uuid = start_analysis(
                self._database,
                queries,
                self._settings,
                find_analysis(order.analysis),
                order.selection,
                order.parameters,
                author="local",
                name=order.name,
                project=order.project,
                runner=runner,
                extends=order.extends,
                skeleton=order.skeleton,
            )
        finally:
            queries.close()
        if runner is not None:
            with self._database.read() as tx:
                stored = tx.jobs.get(uuid)
            run_here(self._database, self._settings, stored, runner, progress)
        return self.job(uuid)

    def job(self, uuid: str) -> Job:
        with self._database.read() as tx:
            return job_answer(tx.jobs.get(uuid))

    def jobs(self, project: str | None, state: str | None, limit: int) -> list[Job]:
        with self._database.read() as tx:
            found = tx.jobs.page(project_name=project, state=state, before=None, limit=limit)
        return [job_answer(job) for job in found]

    def cancel(self, uuid: str) -> Job:
        with self._database.write() as tx:
            return job_answer(tx.jobs.cancel(uuid))

    def result(self, uuid: str) -> Result:
        with self._database.read() as tx:
            stored = tx.results.get(uuid)
            return result_answer(stored, tx.results.parts(stored.key))

    def results(self, project: str | None, analysis: str | None, limit: int) -> list[Result]:
        with self._database.read() as tx:
            found = tx.results.page(project_name=project, analysis=analysis, parent=None, before=None, limit=limit)
        return [result_answer(result) for result in found]

    def delete_result(self, uuid: str) -> None:
        with self._database.write() as tx:
            tx.results.remove(tx.results.get(uuid).key)

    def use(self, uuid: str, operation: str, parameters: dict[str, Any], saving: dict[str, Any]) -> dict[str, Any]:
        done = self._results.use(uuid, operation, parameters, author="local", **saving)
        answer: dict[str, Any] = {"value": done.answer.value.model_dump(mode="json", exclude_none=True)}
        stored = {"document": done.document, "result": done.result}
        return answer | {key: value for key, value in stored.items() if value is not None}

    def use_for_file(
        self, uuid: str, operation: str, parameters: dict[str, Any], saving: dict[str, Any], format: str
    ) -> tuple[str, bytes]:
        done = self._results.use(uuid, operation, parameters, author="local", **saving)
        if done.answer.clip is None:
            raise NotFoundError("The operation makes no clip.", remedy="Leave --output away.")
        name, _, content = clip_file(done.answer.clip, format)
        return name, content


class RemoteWork(Work):
    def __init__(self, library: RemoteLibrary) -> None:
        self._send = library.api.send

    def start(self, order: Order, progress: Progress) -> Job:
        body: dict[str, Any] = {
            "inputs": order.selection.model_dump(exclude_defaults=True),
            "parameters": order.parameters,
        }
        body |= {
            key: value
            for key in ("name", "project", "extends", "skeleton")
            if (value := getattr(order, key)) is not None
        }
        job = Job(**self._send("POST", f"/analyses/{order.analysis}", json=body).json())
        if order.queue:
            return job
        try:
            return self.wait(job, progress)
        except KeyboardInterrupt:
            return self.cancel(job.id)

    def job(self, uuid: str) -> Job:
        return Job(**self._send("GET", f"/jobs/{uuid}").json())

    def jobs(self, project: str | None, state: str | None, limit: int) -> list[Job]:
        return [Job(**item) for item in self._list("/jobs", {"project": project, "state": state}, limit)]

    def cancel(self, uuid: str) -> Job:
        return Job(**self._send("DELETE", f"/jobs/{uuid}").json())

    def result(self, uuid: str) -> Result:
        return Result(**self._send("GET", f"/results/{uuid}").json())

    def results(self, project: str | None, analysis: str | None, limit: int) -> list[Result]:
        wanted = {"project": project, "analysis": analysis}
        return [Result(**item) for item in self._list("/results", wanted, limit)]

    def delete_result(self, uuid: str) -> None:
        self._send("DELETE", f"/results/{uuid}")

    def use(self, uuid: str, operation: str, parameters: dict[str, Any], saving: dict[str, Any]) -> dict[str, Any]:
        body = {"parameters": parameters} | saving
        answer: dict[str, Any] = self._send("POST", f"/results/{uuid}/{operation}", json=body).json()
        answer.pop("clip", None)
        return answer

    def use_for_file(
        self, uuid: str, operation: str, parameters: dict[str, Any], saving: dict[str, Any], format: str
    ) -> tuple[str, bytes]:
        body = {"parameters": parameters} | saving
        answer = self._send("POST", f"/results/{uuid}/{operation}", json=body, params={"format": format})
        disposition = answer.headers.get("content-disposition", "")
        return unquote(disposition.rpartition("UTF-8''")[2]) or f"{operation}.{format}", answer.content

    def _list(self, path: str, wanted: dict[str, Any], limit: int) -> list[dict[str, Any]]:
        parameters = {key: value for key, value in wanted.items() if value is not None}
        items: list[dict[str, Any]] = []
        while True:
            page = self._send("GET", path, params=parameters | {"limit": limit - len(items)}).json()
            items += page["items"]
            if page.get("next_cursor") is None or len(items) >= limit:
                return items
            parameters["cursor"] = page["next_cursor"]


def open_work(database: str | None, server: str | None) -> Work:
    """Where a command runs analyses."""
    library = open_library(database, server)
    if isinstance(library, RemoteLibrary):
        return RemoteWork(library)
    assert isinstance(library, LocalLibrary)
    return LocalWork(library)
