"""OPERATIONS as Typer commands: one loop. Each is created on use, so that modules of other commands are not loaded.

A word in capitals in `Operation.command` is an argument of that name, a field of the request, or else a file: the body
that is sent, or OUTPUT, which the answer is written to. All other arguments are options of the same names and words.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import orjson
import typer
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from mcml.answers import Content
from mcml.client.choosing import id_of
from mcml.client.client import Client
from mcml.errors import McmlError
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    ForceOption,
    JsonOption,
    ServerOption,
    open_client,
    write_blocks,
    write_to_the_end,
)
from mcml_service.cli.terminal.present import present
from mcml_service.operations import OPERATIONS
from mcml_service.operations.arguments import DocumentId, Documents
from mcml_service.operations.operation import Argument, Effect, Operation

_METAVARS = {"q": "TEXT"}
"""Words of commands for arguments that the API calls otherwise."""

MOST = 1000
"""Default number of items in a list."""


@dataclass(frozen=True)
class _Slot:
    """One parameter of a command. argument: that it fills; field: or the field of the body."""

    name: str
    argument: Argument | None
    field: str | None
    annotation: Any
    default: Any


def add_group(group: typer.Typer, name: str) -> None:
    """Add the commands of OPERATIONS that belong to a group."""
    for operation in OPERATIONS.values():
        words = (operation.command or "").split()
        if words[:1] == [name]:
            group.command(words[1], help=operation.description)(_command(operation))


def command_of(operation: Operation) -> Callable[[], tuple[Callable[..., None], str]]:
    """Return the factory of an operation's command: its function and its help."""
    return lambda: (_command(operation), operation.description)


def _command(operation: Operation) -> Callable[..., None]:
    slots = _slots(operation)

    def command(**values: Any) -> None:
        if operation.effect not in (Effect.READS, Effect.STREAMS):
            write_to_the_end()
        as_json = values.pop("as_json", False)
        client = open_client(values.pop("database"), values.pop("server"))
        output, force = values.pop("output", None), values.pop("force", False)
        arguments = _read_arguments(client, operation, slots, values)
        try:
            answer = _ask(client, operation, arguments)
        except McmlError as error:
            file = next((value for value in values.values() if isinstance(value, Path)), None)
            raise error if file is None else error.in_file(file.name) from error
        if isinstance(answer, Content):
            write_blocks(answer.blocks if output else _end_lines(answer), output, force=force)
        else:
            present(operation, answer, as_json)

    parameters = [
        inspect.Parameter(slot.name, inspect.Parameter.KEYWORD_ONLY, default=slot.default, annotation=slot.annotation)
        for slot in slots
    ]
    shared: dict[str, tuple[Any, Any]] = {"database": (DatabaseOption, None), "server": (ServerOption, None)}
    if operation.model is not None:
        shared["as_json"] = (JsonOption, False)
    parameters += [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
        for name, (kind, default) in shared.items()
    ]
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]  # what Typer reads
    command.__annotations__ = {item.name: item.annotation for item in parameters}
    return command


def _slots(operation: Operation) -> list[_Slot]:
    words = {word.strip("[]").lower(): word for word in (operation.command or "").split() if word != word.lower()}
    arguments = [argument for argument in operation.arguments if argument.name != "cursor"]
    fields = {argument.name: _plain_fields(argument) for argument in arguments if argument.place == "body"}
    named = {_METAVARS.get(argument.name, argument.name).lower() for argument in arguments}.union(*fields.values())
    # An argument that names no parameter is a file with the body.
    sent = {argument.name for argument in arguments if argument.place == "content"}
    file = next((word for word in words if (word not in named or word in sent) and word != "output"), None)
    slots: list[_Slot] = []
    for argument in arguments:
        if argument.place in ("body", "content") and file is not None:
            help_ = f"{argument.field.description or 'File of JSON'}; - reads standard input"
            default: Any = Path("-") if words[file].startswith("[") else inspect.Parameter.empty
            slots.append(_Slot(file, argument, None, Annotated[Path, typer.Argument(help=help_)], default))
        elif argument.place == "body":
            for name, field in fields[argument.name].items():
                slots.append(_slot(name, argument, name, field.annotation, field, None, words))
        else:
            default = None if argument.required else argument.default
            slots.append(_slot(argument.name, argument, None, argument.plain, argument.field, default, words))
    if "output" in words:
        place = Annotated[Path, typer.Argument(help="File to write")]
        slots.append(_Slot("output", None, None, place, inspect.Parameter.empty))
        slots.append(_Slot("force", None, None, ForceOption, False))
    # Arguments have the order of the words, options follow.
    order = list(words)
    return sorted(slots, key=lambda slot: order.index(slot.name) if slot.name in order else len(order))


def _slot(
    name: str,
    argument: Argument,
    field: str | None,
    kind: Any,
    about: FieldInfo,
    default: Any,
    words: dict[str, str],
) -> _Slot:
    kind, help_ = _simple(kind), about.description
    if name == "if_match":
        option = typer.Option("--revision", min=1, help="Only if it is still at this revision")
        return _Slot(name, argument, None, Annotated[int | None, option], None)
    if name == "limit":
        option = typer.Option(min=1, help=f"Most items; default {MOST}")
        return _Slot(name, argument, None, Annotated[int | None, option], None)
    bounds = {
        ours: getattr(mark, theirs)
        for mark in about.metadata
        for theirs, ours in (("ge", "min"), ("le", "max"))
        if hasattr(mark, theirs) and _bare(kind) in (int, float)
    }
    word = words.get(_METAVARS.get(name, name).lower())
    if word is not None:
        place = Annotated[kind, typer.Argument(metavar=word.strip("[]"), help=help_, **bounds)]
        return _Slot(name, argument, field, place, default if word.startswith("[") else inspect.Parameter.empty)
    flags = [f"--{name.rstrip('_').replace('_', '-')}", *(["-m"] if name == "message" else [])]
    if kind is bool and default:
        flags[0] += f"/--no-{flags[0].removeprefix('--')}"
    elif kind is bool:
        default = False
    elif field is not None and _bare(kind) is kind and get_origin(kind) is not list:
        kind = kind | None
    return _Slot(name, argument, field, Annotated[kind, typer.Option(*flags, help=help_, **bounds)], default)


def _plain_fields(argument: Argument) -> dict[str, FieldInfo]:
    """Return the fields of a body whose values can be given on a command line."""
    model: type[BaseModel] = argument.plain
    if get_origin(model) is list:
        return {}
    return {name: field for name, field in model.model_fields.items() if _is_plain(_simple(field.annotation))}


def _simple(kind: Any) -> Any:
    """A type without what is annotated anywhere in it."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return _simple(inner[0])
    if origin is list:
        return list[_simple(inner[0])]  # type: ignore[misc]  # made from values
    if origin in (Union, UnionType):
        return Union[tuple(_simple(item) for item in inner)]  # noqa: UP007  # made from values
    return kind


def _bare(kind: Any) -> Any:
    others = [item for item in get_args(kind) if item is not type(None)]
    return others[0] if get_origin(kind) in (Union, UnionType) and len(others) == 1 else kind


def _is_plain(kind: Any) -> bool:
    kind = _bare(kind)
    kind = get_args(kind)[0] if get_origin(kind) is list else kind
    return kind in (str, int, float, bool) or get_origin(kind) is Literal


def _read_arguments(client: Client, operation: Operation, slots: list[_Slot], values: dict[str, Any]) -> dict[str, Any]:
    """Values as the operation takes them."""
    given: dict[str, Any] = {}
    bodies: dict[str, dict[str, Any]] = {}
    for slot in slots:
        value = values.get(slot.name)
        argument = slot.argument
        if argument is None:
            continue
        if slot.field is not None:
            body = bodies.setdefault(argument.name, {})
            if value is not None and value != []:
                body[slot.field] = value
        elif isinstance(value, Path):
            content = sys.stdin.buffer.read() if str(value) == "-" else value.read_bytes()
            sent = argument.place == "content"
            given[argument.name] = content if sent else orjson.loads(content)
        elif argument.name == "if_match":
            given["if_match"] = "*" if value is None else f'"{value}"'
        elif argument.kind == Documents and value:
            given[argument.name] = [id_of(client, text) for text in value]
        elif argument.kind == DocumentId:
            given[argument.name] = id_of(client, str(value), deleted=operation.name == "restore_document")
        elif value is not None and value != []:
            given[argument.name] = value
    for argument in operation.arguments:
        if argument.name in bodies:
            body = bodies[argument.name]
            if not {key for key, value in body.items() if value is not False} - {"message"}:
                fields = [slot.name for slot in slots if slot.field not in (None, "message")]
                raise typer.BadParameter(f"say what: {', '.join('--' + name.replace('_', '-') for name in fields)}")
            given[argument.name] = body
    return given


def _end_lines(answer: Content) -> Iterator[bytes | memoryview]:
    """Text for a terminal ends its last line."""
    last: bytes | memoryview = b""
    for last in answer.blocks:
        yield last
    if bytes(last[-1:]) != b"\n" and not answer.media_type.startswith("application/octet-stream"):
        yield b"\n"


def _ask(client: Client, operation: Operation, given: dict[str, Any]) -> Any:
    if any(argument.name == "cursor" for argument in operation.arguments):
        return client.every(operation.name, **{"limit": MOST, **given})
    return client.call(operation.name, **given)
