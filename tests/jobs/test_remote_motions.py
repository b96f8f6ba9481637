"""One analysis on two workers, of this host and of Dask: the result is what one alone makes, whichever of them dies."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Executor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import dask
import numpy as np
import pytest
from distributed import Client, LocalCluster
from sqlalchemy import select

from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.jobs.dask_workers import DaskCrew, DaskExecutor
from mcml_service.jobs.host_workers import HostWorkers
from mcml_service.jobs.worker import Refused, Task, perform, work_on
from mcml_service.jobs.workers import Crew
from mcml_service.settings import Settings
from mcml_service.storage.core.tables import document
from mcml_service.storage.database import Database
from tests.builders import one_kind
from tests.jobs import works

Inputs = list[dict[str, Any]]


HOST_AND_DASK = [
    "host",
    # How a piece and a worker die there is tested with a team's workers (test_team).
    pytest.param("dask", marks=pytest.mark.fuzz),
]


@pytest.fixture(params=HOST_AND_DASK)
def two(request: pytest.FixtureRequest) -> Iterator[tuple[Executor, Crew]]:
    """Two workers, who help each other from the first piece on."""
    if request.param == "host":
        with HostWorkers(2, 2 << 30) as workers:
            yield workers, replace(workers.crew, alone_seconds=0.0)
        return
    failures = {"distributed.scheduler.allowed-failures": 0}
    with (
        dask.config.set(failures),
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield DaskExecutor(client), DaskCrew()


def danced(database: Database, *bars: int, fps: float = 30.0) -> Inputs:
    """All clips of the store, after some of so many bars were added."""
    clips = [dance_clip("step", name=f"{fps:g}-{n}", bars=many, seed=n, fps=fps).clip for n, many in enumerate(bars)]
    add_clips(database, Settings(), "dance", clips, (), "")
    with database.read() as tx:
        return [{"document": uuid, "revision": 1} for uuid in tx.connection.scalars(select(document.c.uuid))]


def queued(database: Database, inputs: Inputs, parameters: dict[str, Any]) -> Task:
    with database.write() as tx:
        key = tx.projects.get_or_add("dance")
        job = tx.jobs.add(key, "motion-graph", "graph", "kim", inputs, parameters, runner="me")
    return Task((database.url, None), job, "me", "motion-graph", inputs, parameters)


@pytest.mark.slow
@one_kind
def test_two_make_what_one_makes(database: Database, two: tuple[Executor, Crew]) -> None:
    executor, crew = two
    task = queued(database, danced(database, 20, 18, 16), {"shared_music": True})
    apart = executor.submit(work_on, task, crew).result()
    alone = perform(database, "motion-graph", task.inputs, task.parameters, lambda stage, share: None)
    assert not isinstance(alone, Refused)
    assert set(apart) == set(alone)
    for name, part in alone.items():
        assert apart[name].data == part.data
        assert all(np.array_equal(apart[name].arrays[one], part.arrays[one]) for one in part.arrays)
    assert len(alone["graph"].data["nodes"]) > 50, "too few for more than one piece"
    # What a piece finds wrong is the job's problem, in the same words.
    task = queued(database, danced(database, 8, fps=8.0), {})
    wrong = executor.submit(work_on, task, crew).result()
    assert isinstance(wrong, Refused)
    assert wrong.problem["code"] == "frame-rate-too-low"
    assert wrong == perform(database, "motion-graph", task.inputs, {}, lambda stage, share: None)


@pytest.mark.slow
@one_kind
@pytest.mark.parametrize(
    ("function", "expected"),
    [
        pytest.param(works.with_another, [True] * 12, marks=pytest.mark.fuzz),
        (works.dying_piece, list(range(0, 120, 10))),
    ],
)
def test_pieces_are_done_by_several_and_again_when_one_dies(
    database: Database, two: tuple[Executor, Crew], tmp_path: Path, function: Any, expected: list[Any]
) -> None:
    executor, crew = two
    task, work = queued(database, [], {}), partial(works.spread, function, str(tmp_path))
    try:
        found = executor.submit(work, task, crew).result()
    except BrokenExecutor:
        # A worker of Dask may have a piece of the job that it waits for, and die of it. Runners try the job once more.
        assert isinstance(executor, DaskExecutor)
        found = executor.submit(work, task, crew).result()
    assert found == expected


@pytest.mark.slow
@one_kind
def test_a_piece_that_kills_two_workers_is_given_up(
    database: Database, two: tuple[Executor, Crew], tmp_path: Path
) -> None:
    executor, crew = two
    work = partial(works.spread, works.deadly_piece, str(tmp_path))
    with pytest.raises(BrokenExecutor):
        executor.submit(work, queued(database, [], {}), crew).result()


@pytest.mark.slow
def test_a_short_job_needs_no_help(tmp_path: Path) -> None:
    with HostWorkers(2, 2 << 30) as workers:
        task = Task(("sqlite://", None), "", "me", "motion-graph", [], {})
        (process,) = set(workers.submit(partial(works.spread, works.process, ""), task, workers.crew).result())
        assert process


@pytest.mark.slow
def test_jobs_share_the_places(tmp_path: Path) -> None:
    """One alone has all of them, two have half each."""
    with HostWorkers(4, 2 << 30) as workers:
        task = Task(("sqlite://", None), "", "me", "motion-graph", [], {})
        assert workers.submit(works.places, task, workers.crew).result() == 4
        both = [
            workers.submit(partial(works.places_of_two, str(tmp_path)), task, workers.crew),
            workers.submit(partial(works.places_of_two, str(tmp_path)), task, workers.crew),
        ]
        assert [one.result() for one in both] == [2, 2]
