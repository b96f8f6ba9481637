"""Report the progress of a job and detect its cancellation, through its row, from any process."""

from __future__ import annotations

import threading
import time
from types import TracebackType

from mcml.errors import ConflictError, McmlError
from mcml_service.storage.database import Database
from mcml_service.storage.work.jobs import LEASE_SECONDS

TELL_SECONDS = 0.3
"""Time between two looks at the row."""

BEGUN = "starting"
"""The first stage that a job itself reports."""


class CancelledError(Exception):
    """The user no longer wants the job, or another runner has it."""


class Teller(threading.Thread):
    """Reports progress inside a `with` block.

    A call with a stage and a share raises CancelledError if the job is cancelled. A thread writes the row, so the work
    never waits for a busy or unreachable store. runner: owner of the job. renews: whether to renew the lease; false if
    another process does that.
    """

    def __init__(self, database: Database, uuid: str, runner: str, *, renews: bool = False) -> None:
        super().__init__(name="mcml-teller", daemon=True)
        self._database = database
        self._uuid = uuid
        self._runner = runner
        self._renew_seconds = LEASE_SECONDS / 8 if renews else float("inf")
        self._renewed = time.monotonic()
        self._news: tuple[str, float] | None = (BEGUN, 0.0)
        self._is_unwanted = threading.Event()
        self._is_over = threading.Event()

    def __call__(self, stage: str, share: float) -> None:
        self._news = stage, share
        if self._is_unwanted.is_set():
            raise CancelledError

    def __enter__(self) -> Teller:
        # At once: a process that dies now dies of the job.
        self._look()
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._is_over.set()
        self.join()

    def run(self) -> None:
        while not self._is_over.wait(TELL_SECONDS):
            self._look()

    def _look(self) -> None:
        news, self._news = self._news, None
        try:
            if not self._tell(news):
                self._is_unwanted.set()
        except ConflictError:
            self._is_unwanted.set()
        except McmlError:
            # The store is away for a while.
            self._news = self._news or news

    def _tell(self, news: tuple[str, float] | None) -> bool:
        """Return whether the job is still wanted."""
        is_due = time.monotonic() - self._renewed > self._renew_seconds
        if news is None and not is_due:
            with self._database.read() as tx:
                return tx.jobs.is_wanted(self._uuid, self._runner)
        with self._database.write("jobs") as tx:
            if is_due:
                tx.jobs.renew(self._uuid, self._runner)
                self._renewed = time.monotonic()
            if news is not None:
                tx.jobs.tell(self._uuid, self._runner, *news)
            return tx.jobs.is_wanted(self._uuid, self._runner)
