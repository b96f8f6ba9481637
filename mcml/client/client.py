"""Operations called from Python: on a store of this machine, or of a server. `mcml.open` chooses."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, TypeAlias

from mcml_schemas.jobs import Job

FileProgress: TypeAlias = Callable[[str, int, int | None], None]
"""Called with a file name, frames done, and frames in all if known."""
JobProgress: TypeAlias = Callable[[str, float], None]
"""Called with a word for the stage of a job, and the share of it that is done."""

POLL_SECONDS = 0.4
"""Between two looks at a job."""


class Client(ABC):
    """Whoever has one can do all that the repository offers: every operation by its name."""

    @abstractmethod
    def call(self, name: str, /, *, progress: FileProgress | None = None, **given: Any) -> Any:
        """The answer of an operation: a model of `mcml_schemas`, Content (bytes as they come), or None.

        name: as the API's description calls it, such as "list_documents". given: its arguments; what is None is left
        out. progress: told while files are read.
        Raises McmlError: what is wrong, where, and how to mend it.
        """

    def every(self, name: str, /, *, limit: int | None = None, **given: Any) -> Any:
        """The same for a list, all of its pages as one, or so many items."""
        first: Any = None
        items: list[Any] = []
        cursor: str | None = None
        while first is None or cursor is not None:
            # The server decides how many one page holds.
            wanted = 1000 if limit is None else limit - len(items)
            page = self.call(name, limit=wanted, cursor=cursor, **given)
            first = first or page
            items += page.items
            cursor = page.next_cursor if limit is None or len(items) < limit else None
        return first.model_copy(update={"items": items, "next_cursor": None})

    def queue(self) -> None:  # noqa: B027  # a server queues them anyway
        """Leave the jobs that are started to a server of the store."""

    @abstractmethod
    def finish(self, job: Job, progress: JobProgress) -> Job:
        """A job as it ended. progress: told until then. On a store of this machine the job is done in this process."""

    @abstractmethod
    def close(self) -> None:
        """Let go of what is held; nothing that was done is lost without."""

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def follow(client: Client, job: Job, progress: JobProgress) -> Job:
    """Look at a job now and then, until it has ended. Who interrupts this ends the job."""
    current: Job = client.call("get_job", id=job.id)
    try:
        while current.state in ("waiting", "running"):
            progress(current.stage, current.share)
            time.sleep(POLL_SECONDS)
            current = client.call("get_job", id=job.id)
    except KeyboardInterrupt:
        current = client.call("cancel_job", id=job.id)
    return current
