"""A server that starts on a full disk says what to do; the reserve is made as soon as there is room."""

from __future__ import annotations

import asyncio
import shutil
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import uvicorn
from uvicorn.lifespan.on import LifespanOn

from mcml.errors import SpaceError, StoreError
from mcml_service.jobs.runner import Runner
from mcml_service.settings import Settings
from mcml_service.storage.core import reserve
from mcml_service.storage.database import Database
from tests.builders import one_kind, served


def told_by_a_start(database: Database, caplog: pytest.LogCaptureFixture) -> str:
    """What uvicorn logs of a start that fails."""
    config = uvicorn.Config(served(database).app, log_config=None, lifespan="on")
    config.load()
    lifespan = LifespanOn(config)
    asyncio.run(lifespan.startup())
    assert lifespan.should_exit
    return caplog.text


@one_kind
@pytest.mark.parametrize(
    ("error", "said"),
    [
        (SpaceError(), "There is no room left on the disk. Make room on the disk of the store, then start the server"),
        (StoreError("The store is newer.", remedy="Update the program."), "The store is newer. Update the program."),
    ],
)
def test_a_start_that_fails_is_told_in_words(
    database: Database, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, error: StoreError, said: str
) -> None:
    def refused(*_: Any) -> None:
        raise error

    monkeypatch.setattr(Database, "sweep", refused)
    told = told_by_a_start(database, caplog)
    assert said in told
    assert "Traceback" not in told


class Usage(NamedTuple):
    total: int
    used: int
    free: int


@one_kind
def test_the_reserve_is_made_as_soon_as_there_is_room(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    spare = Path(database.url.removeprefix("sqlite:///") + ".reserve")
    free = [0]
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(1 << 40, 0, free[0]))
    runner = Runner(database, Settings(job_workers=1))
    looks = [0]

    def look(_: float) -> bool:
        """Between two looks for jobs: at first there is no room, then just enough."""
        looks[0] += 1
        if looks[0] == 1:
            assert not spare.exists()
            free[0] = reserve.ENOUGH * reserve.BYTES
        else:
            runner._stopping.set()
        return True

    monkeypatch.setattr(runner._wake, "wait", look)
    runner._look()
    assert spare.stat().st_size == reserve.BYTES
    assert reserve.ENOUGH <= 2
