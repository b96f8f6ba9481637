"""The one place that chooses what runs jobs: processes of this host, or a Dask cluster."""

from __future__ import annotations

from mcml_service.jobs.dask_workers import DaskWorkers
from mcml_service.jobs.host_workers import HostWorkers
from mcml_service.jobs.workers import Workers
from mcml_service.settings import Settings
from mcml_service.storage.database import Database


def make_workers(database: Database, settings: Settings) -> Workers:
    """Return the workers that the settings name. No process starts before the first job.

    Raises StoreError if the settings or the installed packages do not fit.
    """
    if settings.dask_scheduler:
        return DaskWorkers(database, settings)
    return HostWorkers(settings.jobs_at_a_time, settings.job_memory_mib << 20)
