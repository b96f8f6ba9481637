"""The Dask cluster that runs jobs: a small one of this host, started with the first job, or a team's."""

from __future__ import annotations

import threading
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from mcml.errors import StoreError
from mcml_service.settings import Settings
from mcml_service.storage.database import Database

REPLACE_SECONDS = 5.0
"""How often workers that are gone are replaced."""


class Cluster:
    """Made cheaply; the processes start when `client` is asked for."""

    def __init__(self, database: Database, settings: Settings) -> None:
        if settings.dask_scheduler and database.name != "postgresql":
            raise StoreError(
                "A team's Dask scheduler needs PostgreSQL: its workers cannot read an SQLite file of this machine.",
                remedy="Unset MCML_DASK_SCHEDULER or set MCML_DATABASE to a PostgreSQL address.",
            )
        files = (settings.dask_tls_ca, settings.dask_tls_cert, settings.dask_tls_key)
        if (settings.dask_scheduler or "").startswith("tls://") and not all(
            file and Path(file).is_file() for file in files
        ):
            raise StoreError(
                "A Dask scheduler at tls:// needs certificates, and not all are there.",
                remedy="Set MCML_DASK_TLS_CA, MCML_DASK_TLS_CERT and MCML_DASK_TLS_KEY to files in PEM.",
            )
        self._settings = settings
        self._lock = threading.Lock()
        self._client: Any = None

    def client(self) -> Any:
        """A `distributed.Client`."""
        with self._lock:
            if self._client is not None and self._client.status not in ("running", "connecting"):
                # Its scheduler ended.
                self._drop()
            if self._client is None:
                self._client = self._connected()
            return self._client

    def _connected(self) -> Any:
        # Imported late: it takes a second, and most commands and many servers never run a job.
        import dask
        from distributed import Client, LocalCluster, Security
        from tornado.ioloop import PeriodicCallback

        # A worker that dies takes its job to another one once; the second death is the job's own fault.
        dask.config.set(
            {"distributed.scheduler.allowed-failures": 1, "distributed.admin.large-graph-warning-threshold": "1GB"}
        )
        if self._settings.dask_scheduler:
            return Client(self._settings.dask_scheduler, set_as_default=False, security=self._security())
        # Whoever can speak to a scheduler can run code: only holders of keys that never leave this process may.
        security = Security.temporary()
        cluster = LocalCluster(
            n_workers=self._settings.jobs_at_a_time,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            protocol="tls",
            security=security,
            memory_limit=f"{self._settings.job_memory_mib}MiB",
            dashboard_address="127.0.0.1:0",
            worker_dashboard_address="127.0.0.1:0",
            silence_logs=50,
        )
        # A process that is killed while it starts is not started again by whoever watches over it.
        again = PeriodicCallback(partial(cluster.scale, self._settings.jobs_at_a_time), REPLACE_SECONDS * 1000)
        client: Any = Client(cluster, set_as_default=False, security=security)
        client.loop.add_callback(again.start)
        return client

    def _security(self) -> Any:
        """The certificates of a team's cluster, None for a scheduler without."""
        from distributed import Security

        said = self._settings
        if not str(said.dask_scheduler).startswith("tls://"):
            return None
        return Security(
            tls_ca_file=said.dask_tls_ca,
            tls_client_cert=said.dask_tls_cert,
            tls_client_key=said.dask_tls_key,
            require_encryption=True,
        )

    def kill(self, future: Any) -> None:
        """End the process of the worker that has a task, whatever it is doing."""
        client = self.client()
        with suppress(OSError, TimeoutError, ValueError):
            busy = [worker for worker, keys in client.processing().items() if future.key in map(str, keys)]
            # Forgotten first, or it would be given to the worker that takes the place of the killed one.
            future.cancel(force=True)
            if busy:
                client.restart_workers(busy, timeout=30, raise_for_error=False)

    def close(self) -> None:
        with self._lock:
            self._drop()

    def _drop(self) -> None:
        client, self._client = self._client, None
        if client is None:
            return
        with suppress(OSError, TimeoutError):
            cluster = client.cluster
            client.close(timeout=5)
            if cluster is not None:
                cluster.close(timeout=10)
