"""A library on a server, asked through its REST API."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from mcml.client.client import Client
from mcml.client.remote import Remote
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import bvh, served, store


@pytest.fixture
def library(database: Database) -> Iterator[Client]:
    """Five documents, the last one deleted, on a server whose pages hold two."""
    uuids = [store(database, {f"{name}.bvh": bvh(2 + number)})[0] for number, name in enumerate("abcde")]
    with served(database, Settings(page_limit=2), base_url="http://127.0.0.1:8000/api/v1/") as client:
        client.delete(f"documents/{uuids[-1]}", headers={"if-match": "*"}).raise_for_status()
        yield Remote("http://127.0.0.1:8000", http=client)  # type: ignore[arg-type]


@pytest.mark.parametrize("limit", [1, 2, 3, 4, 5000])
def test_a_list_goes_on_behind_the_first_page(library: Client, limit: int) -> None:
    page = library.every("list_documents", limit=limit)
    assert [item.name for item in page.items] == list("abcd")[:limit]
    assert page.total == 4


def test_deleted_documents_are_listed_from_a_server(library: Client) -> None:
    assert [item.name for item in library.every("list_documents", deleted=True, limit=10).items] == ["e"]
