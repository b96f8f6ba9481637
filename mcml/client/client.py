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
    """Access to a repository: every operation by its name."""

    @abstractmethod
    def call(self, name: str, /, *, progress: FileProgress | None = None, **given: Any) -> Any:
        """Call an operation; return a model of `mcml_schemas`, Content (bytes), or None.

        name: as in the API description, such as "list_documents". given: its arguments; None values are left out.
        progress: called while files are read. Raises McmlError, with the problem, the place and the remedy.
        """

    def every(self, name: str, /, *, limit: int | None = None, **given: Any) -> Any:
        """Call a list operation; return all pages as one, or up to `limit` items."""
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
        """Wait for a job and return it. progress: called until then. On a local store the job runs in this process."""

    @abstractmethod
    def close(self) -> None:
        """Release resources. Completed work is kept in any case."""

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def follow(client: Client, job: Job, progress: JobProgress) -> Job:
    """Poll a job until it has ended. An interruption cancels the job."""
    current: Job = client.call("get_job", id=job.id)
    try:
        while current.state in ("waiting", "running"):
            progress(current.stage, current.share)
            time.sleep(POLL_SECONDS)
            current = client.call("get_job", id=job.id)
    except KeyboardInterrupt:
        current = client.call("cancel_job", id=job.id)
    return current
