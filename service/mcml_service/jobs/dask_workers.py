"""Workers of a team's Dask cluster, on one machine or several. They need the extra `cluster`."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from mcml.errors import StoreError
from mcml_service.jobs.workers import InterruptionError, Workers
from mcml_service.settings import Settings
from mcml_service.storage.database import Database

FIRST = 10
"""Priority of pieces: they run before jobs that have not started."""


class DaskExecutor(Executor):
    """An executor over a client of Dask.

    `Client.get_executor` has neither keys nor priorities: without keys work cannot be killed, without priorities pieces
    would wait behind jobs. tasks: Dask's own future for each unfinished one.
    """

    def __init__(self, client: Any, priority: int = 0) -> None:
        self.tasks: dict[Future[Any], Any] = {}
        self._client = client
        self._priority = priority

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_running_or_notify_cancel()
        self.tasks[future] = task = self._client.submit(function, *args, pure=False, priority=self._priority, **kwargs)
        task.add_done_callback(partial(self._settle, future))
        return future

    def _settle(self, future: Future[Any], task: Any) -> None:
        from distributed import KilledWorker
        from distributed.client import FutureCancelledError

        try:
            value = task.result()
        except KilledWorker as error:
            future.set_exception(BrokenExecutor(str(error)))
        except FutureCancelledError:
            future.set_exception(
                InterruptionError("The scheduler of the workers ended.", remedy="Start the job again.")
            )
        except BaseException as error:
            future.set_exception(error)
        else:
            future.set_result(value)
        finally:
            self.tasks.pop(future, None)
            task.release()


class DaskWorkers(Workers):
    """Made cheaply; the scheduler is called when the first job comes."""

    def __init__(self, database: Database, settings: Settings) -> None:
        if find_spec("distributed") is None:
            raise StoreError(
                "MCML_DASK_SCHEDULER is set, but Dask is not installed.",
                remedy="Run pip install 'mcml-repository[cluster]', or unset MCML_DASK_SCHEDULER.",
            )
        if database.name != "postgresql":
            raise StoreError(
                "A team's Dask scheduler needs PostgreSQL: its workers cannot read an SQLite file of this machine.",
                remedy="Unset MCML_DASK_SCHEDULER or set MCML_DATABASE to a PostgreSQL address.",
            )
        files = (settings.dask_tls_ca, settings.dask_tls_cert, settings.dask_tls_key)
        if _speaks_tls(settings) and not all(file and Path(file).is_file() for file in files):
            raise StoreError(
                "A Dask scheduler at tls:// needs certificates, and not all are there.",
                remedy="Set MCML_DASK_TLS_CA, MCML_DASK_TLS_CERT and MCML_DASK_TLS_KEY to files in PEM.",
            )
        self.crew = DaskCrew()
        self._settings = settings
        self._lock = threading.Lock()
        self._client: Any = None
        self._executor: DaskExecutor | None = None

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        with self._lock:
            if self._client is not None and self._client.status not in ("running", "connecting"):
                # Its scheduler ended.
                self._drop()
            if self._executor is None:
                self._client = self._connect()
                self._executor = DaskExecutor(self._client)
            return self._executor.submit(function, *args, **kwargs)

    def kill(self, future: Future[Any]) -> None:
        with self._lock:
            client = self._client
            task = None if self._executor is None else self._executor.tasks.get(future)
        if task is None:
            return
        with suppress(OSError, TimeoutError, ValueError):
            busy = [worker for worker, keys in client.processing().items() if task.key in map(str, keys)]
            # Forgotten first, or it would be given to the worker that takes the place of the killed one.
            task.cancel(force=True)
            if busy:
                client.restart_workers(busy, timeout=30, raise_for_error=False)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Disconnect from the cluster, which continues."""
        with self._lock:
            self._drop()

    def _connect(self) -> Any:
        # Imported late: it takes a second, and many servers never run a job.
        from distributed import Client, Security

        said, security = self._settings, None
        if _speaks_tls(said):
            security = Security(
                tls_ca_file=said.dask_tls_ca,
                tls_client_cert=said.dask_tls_cert,
                tls_client_key=said.dask_tls_key,
                require_encryption=True,
            )
        return Client(said.dask_scheduler, set_as_default=False, security=security)

    def _drop(self) -> None:
        client, self._client, self._executor = self._client, None, None
        if client is not None:
            with suppress(OSError, TimeoutError):
                client.close(timeout=5)


@dataclass(frozen=True)
class DaskCrew:
    """All workers of the cluster. They run already, so a job uses them at once."""

    alone_seconds: float = 0.0

    def places(self) -> int:
        """Return the number of threads of all workers."""
        from distributed import get_client

        return sum(get_client().nthreads().values())

    @contextmanager
    def helpers(self, shared: Sequence[Any]) -> Iterator[tuple[Executor, Sequence[Any]]]:
        from distributed import worker_client

        # While it waits, this worker has room for pieces too.
        with worker_client() as client:
            executor = DaskExecutor(client, FIRST)
            try:
                yield executor, client.scatter(list(shared), hash=False)
            finally:
                client.cancel(list(executor.tasks.values()))


def _speaks_tls(settings: Settings) -> bool:
    return str(settings.dask_scheduler).startswith("tls://")
