"""Operations on a store of this machine. Whoever may open the file may do everything."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from mcml.client import Client, follow
from service.operations.call import Call, Content, Repository
from service.operations.operation import Operation
from service.settings import Settings
from service.storage.database import Database
from service.storage.identifiers import new_uuid

if TYPE_CHECKING:
    from schemas.jobs import Job
    from service.actions.importing.encode_clip import Progress
    from service.analysis.interface import Progress as JobProgress


class Local(Client):
    """database: whose schema is current. owned: it is closed with the client."""

    def __init__(self, database: Database, settings: Settings, *, owned: bool = False) -> None:
        self._owned = owned
        self.repository = Repository(database, settings)
        self.repository.runner = new_uuid()

    def run(self, operation: Operation, given: dict[str, Any], progress: Progress | None) -> Any:
        call = Call(self.repository, progress=progress)
        with call.held as held:
            answer = operation.run(call, given)
            if isinstance(answer, Content):
                answer.blocks = _holding(held.pop_all(), answer.blocks)
        return answer

    def queue(self) -> None:
        self.repository.runner = None

    def finish(self, job: Job, progress: JobProgress) -> Job:
        # Imported late: mathematics takes a second.
        from service.jobs.runner import run_here

        database, runner = self.repository.database, self.repository.runner
        with database.read() as tx:
            stored = tx.jobs.get(job.id)
        if runner is not None and stored.state == "running":
            run_here(database, self.repository.settings, stored, runner, progress)
        return follow(self, job, progress)

    def close(self) -> None:
        self.repository.close()
        if self._owned:
            self.repository.database.close()


def _holding(held: ExitStack, blocks: Iterator[bytes | memoryview]) -> Iterator[bytes | memoryview]:
    with held:
        yield from blocks


def open_store(address: str) -> Local:
    """A store by its file or SQLAlchemy URL; a file that is not there is made. StoreError for an older schema, which
    `mcml db upgrade` upgrades."""
    settings = Settings(database=address if "://" in address else f"sqlite:///{address}")
    database = Database(settings.database_url)
    database.make_or_require()
    return Local(database, settings, owned=True)
