"""A server, and a folder to sync with it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from mcml.client.client import Client
from mcml.client.remote import Remote
from mcml.client.sync import looks
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import served
from tests.client.synced_folder import Synced


@pytest.fixture
def library(database: Database) -> Iterator[Client]:
    with served(database, Settings(), base_url="http://127.0.0.1:8000/api/v1/") as client:
        yield Remote("http://127.0.0.1:8000", http=client)  # type: ignore[arg-type]


@pytest.fixture
def synced(library: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Synced:
    """An empty folder. Files that were written just now are not waited for."""
    monkeypatch.setattr(looks, "SETTLE_SECONDS", 0)
    return Synced(library, tmp_path / "takes")
