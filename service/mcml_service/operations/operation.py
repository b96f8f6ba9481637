"""Operations: the functions of the repository for users, each declared once.

Its row in OPERATIONS has its name, address, command, effect, right and description; the function of that name has its
arguments and its answer, as types. The HTTP route, its entry in OpenAPI, the command, the Python call and the tables of
the documentation are generated from these.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping, Set
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from enum import StrEnum
from functools import cached_property
from importlib import import_module
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel, Field, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from mcml.answers import Content
from mcml.errors import AccessError, NotFoundError, RequestError
from mcml_service.operations.call import Call
from mcml_service.storage.team.shares import Share

Function = TypeVar("Function", bound=Callable[..., Any])
Mark = TypeVar("Mark")
Place = Literal["path", "query", "header", "body", "form", "file", "content"]
"""Where a request carries an argument. body: as JSON; content: as the bytes that the body is."""


class Effect(StrEnum):
    """The effect of an operation on the store."""

    READS = "reads"
    STREAMS = "streams"
    WRITES = "writes"
    STARTS = "starts a job"


class Right(StrEnum):
    """The rights of users: to see, to change, to manage a project, to maintain the repository."""

    READ = "read"
    EDIT = "edit"
    OWN = "own"
    OPERATE = "operate"


RIGHTS: Mapping[str, frozenset[Right]] = {
    "read": frozenset({Right.READ}),
    "edit": frozenset({Right.READ, Right.EDIT}),
    "own": frozenset({Right.READ, Right.EDIT, Right.OWN}),
    "operate": frozenset(Right),
}
"""The rights of each scope.

A scope holds for a project or for all (`storage.views`); the transaction checks the data that an operation touches.
"""


@dataclass(frozen=True)
class Body:
    """Marks an argument of type bytes that is the body of the request.

    types: media types with an example of each. most: bytes. model: of the body where it is JSON.
    """

    types: Mapping[str, Any]
    most: int
    model: type[BaseModel] | None = None


class Upload:
    """Marks an argument that is a file or a list of files: parts of a form, whose fields all other arguments are."""


@dataclass(frozen=True)
class Media:
    """Answers other than JSON: their description, and their media types with an example of each or None."""

    words: str
    types: Mapping[str, Any]


@dataclass(frozen=True)
class Argument:
    """One argument of an operation.

    name: in Python and on the command line. wire: its name in requests. kind: its type with constraints, for pydantic.
    group: the parameter of the function of which it is a field, None if it is a parameter itself.
    """

    name: str
    wire: str
    place: Place
    kind: Any
    field: FieldInfo
    default: Any
    group: str | None

    @property
    def required(self) -> bool:
        return self.default is inspect.Parameter.empty

    def check(self, value: Any) -> Any:
        """The value as the type has it. RequestError where it does not fit."""
        if self.place == "file":
            return value
        try:
            return self.adapter.validate_python(value)
        except ValidationError as error:
            fault = error.errors()[0]
            place = ".".join(str(part) for part in (self.name, *fault["loc"]))
            raise RequestError(f"{place}: {fault['msg'].removeprefix('Value error, ')}") from None

    @cached_property
    def adapter(self) -> TypeAdapter[Any]:
        # Without what a request calls it, which is no matter of the value.
        kind: Any = Annotated[self.plain, Field(description=self.field.description), *self.field.metadata]
        return TypeAdapter(kind)

    @property
    def plain(self) -> Any:
        """The type without what is annotated."""
        return get_args(self.kind)[0] if get_origin(self.kind) is Annotated else self.kind

    @property
    def bare(self) -> Any:
        """The type without what is annotated, and without None."""
        kind = self.plain
        others = [item for item in get_args(kind) if item is not type(None)]
        return others[0] if get_origin(kind) in (Union, UnionType) and len(others) == 1 else kind

    @property
    def body(self) -> Body | None:
        """The form of the body, if the argument is a body, else None."""
        return self.mark(Body)

    def mark(self, kind: type[Mark]) -> Mark | None:
        """The marker of this class among what annotates the type, or None."""
        return next((item for item in get_args(self.kind)[1:] if isinstance(item, kind)), None)


@dataclass(frozen=True)
class Operation:
    """A row of OPERATIONS.

    name: of the function in `mcml_service.operations`, the operationId, the Python call.
    address: method and path below /api/v1; None for operations on the machine of the store only. command: its command,
    with positional arguments in capitals; None if no command is generated from this row.
    status: of a success. ok_description: of an answer 200, for operations that answer 200 if they created nothing.
    omit_null: answers leave out values that are null. cancel_on_disconnect: the operation ends when its client leaves.
    queued: it takes long, so a server runs few at a time; or the name of the argument that makes it long.
    open_to_links: visitors with a share link may use it, for the documents of the link. summary: a title, if the
    description is too long for one. implementation: the function, if no module has it.
    """

    name: str
    address: str | None
    effect: Effect
    right: Right
    words: str
    module: str = ""
    command: str | None = None
    status: int = 200
    omit_null: bool = False
    ok_description: str = ""
    cancel_on_disconnect: bool = False
    queued: bool | str = False
    open_to_links: bool = False
    summary: str = ""
    implementation: Callable[..., Any] | None = None

    @property
    def method(self) -> str:
        return (self.address or "").partition(" ")[0]

    @property
    def path(self) -> str:
        return (self.address or "").partition(" ")[2]

    @cached_property
    def function(self) -> Callable[..., Any]:
        """The implementation, from (call, arguments) to an answer. Imported on first use."""
        if self.implementation is not None:
            return self.implementation
        function: Callable[..., Any] = getattr(import_module(f"mcml_service.operations.{self.module}"), self.name)
        return function

    @cached_property
    def description(self) -> str:
        """The description of the row, and of the function's docstring."""
        more = inspect.getdoc(self.function)
        return f"{self.words}\n\n{more}" if more else self.words

    @property
    def media(self) -> Media | None:
        """The answers other than JSON, None if there are none."""
        return getattr(self.function, "media", None)

    @cached_property
    def model(self) -> type[BaseModel] | None:
        """The model of the JSON answer, None if there is none."""
        returned = get_type_hints(self.function, include_extras=True)["return"]
        kinds = get_args(returned) if get_origin(returned) in (Union, UnionType) else (returned,)
        return next((kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)), None)

    @cached_property
    def groups(self) -> dict[str, type]:
        """Parameters of the function that are dataclasses of arguments."""
        hints = get_type_hints(self.function, include_extras=True)
        return {
            name: kind
            for name, kind in hints.items()
            if isinstance(kind, type) and is_dataclass(kind) and kind not in (Call, Content)
        }

    @cached_property
    def arguments(self) -> tuple[Argument, ...]:
        hints = get_type_hints(self.function, include_extras=True)
        parameters = list(inspect.signature(self.function).parameters.values())[1:]
        arguments = [
            each for item in parameters for each in _arguments(self, hints[item.name], item.name, item.default)
        ]
        if any(argument.place == "file" for argument in arguments):
            arguments = [_in_form(argument) for argument in arguments]
        return tuple(arguments)

    def is_queued(self, given: Mapping[str, Any]) -> bool:
        """Whether it takes long with these arguments."""
        return given.get(self.queued) is not None if isinstance(self.queued, str) else self.queued

    def is_quick(self, given: Mapping[str, Any]) -> bool:
        """Whether it is expected to take milliseconds with these arguments, although others take long."""
        test = getattr(self.function, "is_quick", None)
        return test is not None and test(given)

    def allow(self, call: Call) -> None:
        """Check the right of the user. Raises AccessError without it. Every call is checked here."""
        if call.share is not None and not self.open_to_links:
            raise AccessError(
                f"A link to some documents does not open {self.name}.",
                remedy="Ask the sender of the link for an account.",
            )
        if self.right not in RIGHTS[call.scope]:
            raise AccessError(
                f"{self.name} needs the right to {self.right}, and {call.author} has only that to {call.scope}.",
                remedy="Ask an owner of the repository for another role, or a token of another scope.",
            )

    def run(self, call: Call, given: Mapping[str, Any]) -> Any:
        """Run the operation and return its answer.

        given: validated values by the names of the arguments. Raises AccessError without the right.
        """
        self.allow(call)
        if call.share is not None:
            given = _as_shared(call.share, given, {argument.name for argument in self.arguments})
        values: dict[str, Any] = {}
        parts: dict[str, dict[str, Any]] = {name: {} for name in self.groups}
        for argument in self.arguments:
            if argument.name in given:
                place = values if argument.group is None else parts[argument.group]
                place[argument.name] = given[argument.name]
        grouped = {name: self.groups[name](**stated) for name, stated in parts.items()}
        return self.function(call, **values, **grouped)

    def check(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Values as the arguments' types have them. RequestError for an unknown name, or a value that does not fit."""
        known = {argument.name: argument for argument in self.arguments}
        for name in given:
            if name not in known:
                raise RequestError(f"{self.name} has no argument {name!r}.", remedy=f"It takes {', '.join(known)}.")
        for name, argument in known.items():
            if argument.required and name not in given:
                raise RequestError(f"{name} is missing.", remedy=f"{self.name} needs it.")
        return {name: known[name].check(value) for name, value in given.items()}


def _as_shared(share: Share, given: Mapping[str, Any], known: Set[str]) -> Mapping[str, Any]:
    """Return the arguments of a call by a visitor with a share link, with the revision of the link.

    known: names of all arguments of the operation, also of those that are not given.
    Raises NotFoundError for another document or revision, AccessError for a format that the link does not allow.
    """
    document = share.documents.get(given["id"])
    if document is None:
        raise NotFoundError("This link shows no such document.", remedy="Take one that it shows.")
    if {"format", "original"} <= known:
        # A preset alone would choose any format.
        format = given.get("format")
        if format not in share.formats:
            raise AccessError(
                f"This link does not give {format or 'formats of presets'} away.",
                remedy=f"It gives {', '.join(sorted(share.formats)) or 'none'}.",
            )
        given = {**given, "original": False}
    return {**given, "revision": document.choose_revision(given.get("revision"))}


def gives(words: str, types: Mapping[str, Any]) -> Callable[[Function], Function]:
    """Declare that a function may return content of these media types, each with an example (None: the description
    is enough).
    """

    def attach(function: Function) -> Function:
        function.media = Media(words, types)  # type: ignore[attr-defined]  # functions take any attribute
        return function

    return attach


def quick_if(test: Callable[[Mapping[str, Any]], bool]) -> Callable[[Function], Function]:
    """Declare with which arguments a queued function takes milliseconds, so that it need not wait behind others."""

    def attach(function: Function) -> Function:
        function.is_quick = test  # type: ignore[attr-defined]  # functions take any attribute
        return function

    return attach


def _arguments(
    operation: Operation, kind: Any, name: str, default: Any, group: str | None = None
) -> Iterator[Argument]:
    """An argument, or those in a dataclass of arguments."""
    if is_dataclass(kind):
        hints = get_type_hints(kind, include_extras=True)
        for field in fields(kind):
            value = inspect.Parameter.empty if field.default is MISSING else field.default
            yield from _arguments(operation, hints[field.name], field.name, value, name)
        return
    marks = get_args(kind)[1:] if get_origin(kind) is Annotated else ()
    field_info = next((mark for mark in marks if isinstance(mark, FieldInfo)), FieldInfo())
    wire = field_info.alias or name
    bare = get_args(kind)[0] if marks else kind
    place: Place = "query"
    if name == "if_match":
        wire, place = "if-match", "header"
    elif f"{{{wire}}}" in operation.path or f"{{{wire}:path}}" in operation.path:
        place = "path"
    elif any(isinstance(mark, Body) for mark in marks):
        place = "content"
    elif any(mark is Upload or isinstance(mark, Upload) for mark in marks):
        place = "file"
    elif _is_model(bare):
        place = "body"
    yield Argument(name, wire, place, kind, field_info, default, group)


def _is_model(kind: Any) -> bool:
    kind = get_args(kind)[0] if get_origin(kind) is list else kind
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _in_form(argument: Argument) -> Argument:
    if argument.place != "query":
        return argument
    return replace(argument, place="form")
