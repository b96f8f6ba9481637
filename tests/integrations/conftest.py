from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.api.test_authentication import listening
from tests.blender import why_not
from tests.integrations.addon import Blender, Served


@pytest.fixture
def repository(sqlite_template: Path, tmp_path: Path) -> Iterator[Served]:
    """A server with an empty store, which asks everybody for a token."""
    if why_not():
        pytest.skip(why_not())
    shutil.copy(sqlite_template, tmp_path / "store.db")
    settings = Settings(database=f"sqlite:///{tmp_path}/store.db", login="always")
    database = Database(settings.database_url)
    with database.write("test") as tx:
        token = tx.tokens.add("animator")
    with listening(create_app(settings, database)) as port:
        yield Served(f"http://127.0.0.1:{port}", token)
    database.close()


@pytest.fixture(scope="module")
def blender(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Blender]:
    started = Blender(tmp_path_factory.mktemp("blender"))
    yield started
    started.close()
