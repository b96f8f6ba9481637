"""One analysis on two workers: what comes of it is what one alone makes, whoever of them dies."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cloudpickle
import numpy as np
import pytest
from sqlalchemy import select

from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.jobs.apart import StoredMotions
from mcml_service.jobs.cluster import Cluster
from mcml_service.jobs.worker import Refused, on_dask, perform
from mcml_service.settings import Settings
from mcml_service.storage.core.tables import document
from mcml_service.storage.database import Database
from tests.builders import one_kind

Inputs = list[dict[str, Any]]


@pytest.fixture
def two(database: Database) -> Iterator[Any]:
    cluster = Cluster(database, Settings(job_workers=2))
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    yield cluster.client()
    cluster.close()


def danced(database: Database, *bars: int, fps: float = 30.0) -> Inputs:
    """All clips of the store, after some of so many bars were added."""
    clips = [dance_clip("step", name=f"{fps:g}-{n}", bars=many, seed=n, fps=fps).clip for n, many in enumerate(bars)]
    add_clips(database, Settings(), "dance", clips, (), "")
    with database.read() as tx:
        return [{"document": uuid, "revision": 1} for uuid in tx.connection.scalars(select(document.c.uuid))]


def queued(database: Database, inputs: Inputs) -> str:
    with database.write() as tx:
        return tx.jobs.add(tx.projects.get_or_add("dance"), "motion-graph", "graph", "kim", inputs, {})


def with_another(piece: int, place: str) -> bool:
    """Waits until another process has a piece too; False where none comes."""
    Path(place, str(os.getpid())).touch()
    end = time.monotonic() + 20
    while len(os.listdir(place)) < 2 and time.monotonic() < end:
        time.sleep(0.01)
    return len(os.listdir(place)) > 1


def dying(piece: int, place: str) -> int:
    if piece == 3 and not os.path.exists(f"{place}/killed"):
        Path(place, "killed").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return 10 * piece


def spread(url: str, function: Any, place: str) -> list[Any]:
    return StoredMotions((url, None), [], None).spread(function, range(12), (place,))


@one_kind
def test_two_make_what_one_makes(database: Database, two: Any, tmp_path: Path) -> None:
    inputs = danced(database, 24, 22, 20)
    job, parameters = queued(database, inputs), {"shared_music": True}
    urls = database.url, None
    apart = two.submit(on_dask, urls, job, "motion-graph", inputs, parameters, pure=False).result()
    alone = perform(database, "motion-graph", inputs, parameters, lambda stage, share: None)
    assert set(apart) == set(alone)
    for name, part in alone.items():
        assert apart[name].data == part.data
        assert all(np.array_equal(apart[name].arrays[one], part.arrays[one]) for one in part.arrays)
    assert len(alone["graph"].data["nodes"]) > 50, "too few for more than one piece"
    # What a piece finds wrong is the job's problem, in the same words.
    inputs = danced(database, 8, fps=8.0)
    wrong = two.submit(on_dask, urls, job, "motion-graph", inputs, {}, pure=False).result()
    assert isinstance(wrong, Refused)
    assert wrong.problem["code"] == "frame-rate-too-low"
    assert wrong == perform(database, "motion-graph", inputs, {}, lambda stage, share: None)
    for function, expected in ((with_another, [True] * 12), (dying, list(range(0, 120, 10)))):
        place = tmp_path / function.__name__
        place.mkdir()
        assert two.submit(spread, database.url, function, str(place), pure=False).result() == expected
    assert (tmp_path / "dying" / "killed").exists()
