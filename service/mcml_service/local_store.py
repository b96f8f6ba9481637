"""Operations on a local store. Anybody who can open the file has all rights."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

from mcml.answers import Content
from mcml.client.client import Client, FileProgress, JobProgress, follow
from mcml_schemas.jobs import Job
from mcml_service.operations import find_operation
from mcml_service.operations.call import Call, Repository
from mcml_service.settings import Settings
from mcml_service.storage.core.identifiers import new_uuid
from mcml_service.storage.database import Database


class Local(Client):
    """database: whose schema is current. owned: it is closed with the client."""

    def __init__(self, database: Database, settings: Settings, *, owned: bool = False) -> None:
        self._owned = owned
        self.repository = Repository(database, settings)
        self.repository.runner = new_uuid()

    def call(self, name: str, /, *, progress: FileProgress | None = None, **given: Any) -> Any:
        operation = find_operation(name)
        checked = operation.check({key: value for key, value in given.items() if value is not None})
        call = Call(self.repository, progress=progress)
        with call.held as held:
            answer = operation.run(call, checked)
            if isinstance(answer, Content):
                answer.blocks = _holding(held.pop_all(), answer.blocks)
        return answer

    def queue(self) -> None:
        self.repository.runner = None

    def finish(self, job: Job, progress: JobProgress) -> Job:
        # Imported late: mathematics takes a second.
        from mcml_service.jobs.runner import run_here

        database, runner = self.repository.database, self.repository.runner
        with database.read() as tx:
            stored = tx.jobs.get(job.id)
        if runner is not None and stored.state == "running":
            run_here(database, self.repository.settings, stored, runner, lambda stage, share: progress(stage, share))
        return follow(self, job, progress)

    def close(self) -> None:
        self.repository.close()
        if self._owned:
            self.repository.database.close()


def _holding(held: ExitStack, blocks: Iterator[bytes | memoryview]) -> Iterator[bytes | memoryview]:
    with held:
        yield from blocks


def open_store(address: str) -> Local:
    """Open a store by its file or SQLAlchemy URL; create a missing file.

    Raises StoreError for an older schema, which `mcml db upgrade` upgrades.
    """
    settings = Settings(database=address if "://" in address else f"sqlite:///{address}")
    database = Database(settings.database_url)
    database.make_or_require()
    return Local(database, settings, owned=True)
