"""What the Python package knows of operations, made from their declarations: what a client sends, and types of calls.

`python -m tests.docs.signatures` writes the files; a test compares.
"""

from __future__ import annotations

import types
from pathlib import Path
from textwrap import fill
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import orjson
from pydantic import BaseModel

import mcml
from mcml.answers import Content
from mcml.formats.format import SourceFile
from mcml_schemas.jobs import ResultUsed
from mcml_service.operations import all_operations
from mcml_service.operations.operation import Argument, Operation

FOLDER = Path(mcml.__file__).parent / "client"
HEAD = '''"""Types of `repo.operations`, made by `make docs` from the declarations of operations."""

from typing import Any, Literal

'''


def made() -> dict[Path, str]:
    """The files, with what is to stand in them."""
    operations = [operation for operation in all_operations() if operation.address is not None]
    rows = [f'"{operation.name}": {orjson.dumps(_row(operation)).decode()}' for operation in operations]
    text = "{\n" + ",\n".join(rows) + "\n}\n"
    return {FOLDER / "operations.json": text, FOLDER / "operations.pyi": _stub(operations)}


def _row(operation: Operation) -> dict[str, Any]:
    answer = _answer(operation)
    return {
        "method": operation.method,
        "path": operation.path.replace(":path}", "}"),
        "arguments": {
            one.name: {
                "wire": one.wire,
                "place": one.place,
                "types": list(one.body.types) if one.body else [],
                "required": one.required,
            }
            for one in operation.arguments
        },
        "answer": "" if answer is None else f"{answer.__module__}:{answer.__name__}",
        "is_content": operation.media is not None,
    }


def _answer(operation: Operation) -> type[BaseModel] | None:
    """The model of an answer that others can import."""
    model = operation.model
    return ResultUsed if model is not None and issubclass(model, ResultUsed) else model


def _stub(operations: list[Operation]) -> str:
    named: dict[str, set[str]] = {"mcml.client.client": {"Client", "FileProgress"}}
    methods = "".join(_method(operation, named) for operation in operations)
    imports = "".join(
        f"from {module} import {', '.join(sorted(names, key=str.casefold))}\n"
        for module, names in sorted(named.items())
    )
    return f"{HEAD}{imports}\nclass Operations:\n    def __init__(self, client: Client) -> None: ...\n{methods}"


def _method(operation: Operation, named: dict[str, set[str]]) -> str:
    arguments = [f"        {one.name}: {_argument(one, named)}," for one in operation.arguments]
    arguments.append("        progress: FileProgress | None = None,")
    said = get_type_hints(operation.function, include_extras=True)["return"]
    kinds = [] if _answer(operation) is None else [_shown(_answer(operation), named)]
    if operation.media is not None or said is Content:
        kinds.append(_shown(Content, named))
    words = fill(operation.words, 110, subsequent_indent=" " * 8)
    return (
        f"    def {operation.name}(\n        self,\n        *,\n"
        + "\n".join(arguments)
        + f'\n    ) -> {" | ".join(kinds) or "None"}:\n        """{words}"""\n'
    )


def _argument(argument: Argument, named: dict[str, set[str]]) -> str:
    shown = _shown(argument.plain, named)
    if argument.place == "body":
        shown += " | list[dict[str, Any]]" if shown.startswith("list[") else " | dict[str, Any]"
        shown = "dict[str, Any]" if shown.startswith("Any") else shown
    if argument.required:
        return shown
    return f"{shown} = ..." if "None" in shown else f"{shown} | None = ..."


def _shown(kind: Any, named: dict[str, set[str]]) -> str:
    """A type as source, its classes added to those that are imported; Any for one that nobody can import."""
    origin = get_origin(kind)
    if origin is Annotated:
        return _shown(get_args(kind)[0], named)
    if origin in (Union, types.UnionType):
        return " | ".join(dict.fromkeys(_shown(item, named) for item in get_args(kind)))
    if origin is Literal:
        return f"Literal[{', '.join(map(_quoted, get_args(kind)))}]"
    if origin in (list, dict, tuple):
        return f"{origin.__name__}[{', '.join(_shown(item, named) for item in get_args(kind))}]"
    if kind is type(None):
        return "None"
    if isinstance(kind, type) and kind.__module__ == "builtins":
        return kind.__name__
    if kind in (Content, SourceFile) or getattr(kind, "__module__", "").startswith("mcml_schemas."):
        named.setdefault(kind.__module__, set()).add(kind.__name__)
        return str(kind.__name__)
    return "Any"


def _quoted(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else repr(value)


if __name__ == "__main__":
    for path, text in made().items():
        path.write_text(text, encoding="utf-8")
