"""All operations of a repository, as methods; operations.pyi has their types."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from mcml.client.catalogue import operation_names
from mcml.client.client import Client


class Operations:
    """A method for each operation: `repo.operations.list_documents(q="walk")`."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name not in operation_names():
            raise AttributeError(f"There is no operation {name!r}; dir() lists them.")
        return partial(self._client.call, name)

    def __dir__(self) -> list[str]:
        return operation_names()
