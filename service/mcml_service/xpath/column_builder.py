"""The process of a server that builds columns in advance, while the server is idle."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress

from mcml.errors import McmlError
from mcml.processes.bounds import bound_growth, end_with_starter
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.clips.deriver import Stage
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.library.disk.part_file import path_of
from mcml_service.xpath.library.preparing import Progress, prepare_bodies, prepare_columns
from mcml_service.xpath.queries import Queries
from mcml_service.xpath.query_pool import fork_context

NICE = 19
LOOK_SECONDS = 0.25
"""Interval of checks whether to continue."""


SKELETON_QUERIES = ("count(//bone)", "count(distinct-values(//bone/name))")
"""Queries that read one document of each skeleton: these are a group of their own, which they build."""


def build_columns(database: Database, settings: Settings, stage: Stage, go_on: Callable[[], bool]) -> None:
    """Build the missing columns of a store on disk in a separate process, and wait for its end.

    stage: columns of documents, or those of their bodies. go_on: False ends the process; finished columns stay.
    """
    if path_of(database, settings.cache_dir) is None:
        return
    process = fork_context().Process(
        target=run, args=(database.url, database.read_url, settings, stage), name=f"build-{stage}", daemon=True
    )
    process.start()
    while process.is_alive():
        process.join(LOOK_SECONDS)
        if not go_on():
            process.kill()
            process.join()
    process.close()


def run(url: str, read_url: str | None, settings: Settings, stage: Stage) -> None:
    """Do the work of the process."""
    end_with_starter()
    os.nice(NICE)
    bound_growth(settings.query_memory_mib << 20)
    database = Database(url, read_url)
    queries = Queries(database, settings)
    # Memory may not do for a large group, whose first query then builds its columns.
    with suppress(MemoryError):
        build_stage(queries, stage)
    queries.close()
    database.close()


def build_stage(queries: Queries, stage: Stage, progress: Progress = lambda done, of: None) -> None:
    """Build the missing columns of one stage. queries: an engine for this work alone."""
    if stage == "bodies":
        prepare_bodies(queries.database, queries.caches, progress)
        return
    prepare_columns(queries.database, queries.caches, progress)
    for text in SKELETON_QUERIES:
        with suppress(McmlError):
            queries.answer(QueryRequest(q=text))
