"""The operations of a server: operations.json, which `make docs` generates from the declarations of the service."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path

import orjson
from pydantic import BaseModel

from mcml.errors import NotFoundError, RequestError

PATH = Path(__file__).with_name("operations.json")


@dataclass(frozen=True)
class Argument:
    """wire: its name in requests.

    place: "path", "query", "header", "body" (JSON), "form", "file" or "content" (bytes that are the body, of one of the
    media types).
    """

    wire: str
    place: str
    types: tuple[str, ...] = ()
    required: bool = False


@dataclass(frozen=True)
class Operation:
    """method, path: of its address below /api/v1. answer: the model of an answer in JSON, as module:name; empty: none.
    is_content: whether answers may be bytes that are no JSON."""

    name: str
    method: str
    path: str
    arguments: dict[str, Argument]
    answer: str
    is_content: bool

    @property
    def model(self) -> type[BaseModel] | None:
        module, _, name = self.answer.partition(":")
        if not name:
            return None
        kind: type[BaseModel] = getattr(import_module(module), name)
        return kind

    def check_names(self, given: dict[str, object]) -> None:
        """RequestError for an argument that it does not have, or one that is missing."""
        for name in given:
            if name not in self.arguments:
                known = ", ".join(self.arguments)
                raise RequestError(f"{self.name} has no argument {name!r}.", remedy=f"It takes {known}.")
        for name, argument in self.arguments.items():
            if argument.required and name not in given:
                raise RequestError(f"{name} is missing.", remedy=f"{self.name} needs it.")


@cache
def _operations() -> dict[str, Operation]:
    operations = {}
    for name, row in orjson.loads(PATH.read_bytes()).items():
        arguments = {
            key: Argument(argument["wire"], argument["place"], tuple(argument["types"]), argument["required"])
            for key, argument in row["arguments"].items()
        }
        operations[name] = Operation(name, row["method"], row["path"], arguments, row["answer"], row["is_content"])
    return operations


def find_operation(name: str) -> Operation:
    """The operation of this name. NotFoundError."""
    try:
        return _operations()[name]
    except KeyError:
        raise NotFoundError(
            f"There is no operation {name!r}.", remedy="docs/api/index.md lists them; dir(repo.operations) too."
        ) from None


def operation_names() -> list[str]:
    """Names of all operations of a server."""
    return list(_operations())
