"""OPERATIONS as routes of FastAPI: one loop, which gives each function the signature that FastAPI reads."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from copy import copy
from functools import partial
from typing import Annotated, Any

from anyio import to_thread
from fastapi import APIRouter, Depends, Form, Header, Path, Query, Request, Response, UploadFile
from fastapi import File as FilePart
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import UploadFile as FormFile

from mcml.answers import Content
from mcml.errors import ClashError, LimitError, ReplicaError
from mcml.formats.format import SourceFile
from mcml_service.actions.analysing.start_analysis import find_analysis
from mcml_service.api.admission import while_connected
from mcml_service.api.idempotency import Key, creates, do_once
from mcml_service.api.streaming import Bytes, make_response, match_tag, read_body
from mcml_service.operations.call import Call, SameError
from mcml_service.operations.operation import Argument, Body, Effect, Operation
from mcml_service.storage.team.entries import Entry

PREFIX = "/api/v1"

TRIES = 4
"""How often a request is tried that the database gives up for another's sake."""

BYTES = "application/octet-stream"

LOCAL = Entry("local")
"""The identity of anonymous requests on a store with anonymous access."""

LASTING = {"cache-control": "private, max-age=31536000, immutable"}
"""Headers of answers about a revision named in the request: clients can cache them permanently."""

_MARKS: dict[str, Callable[..., Any]] = {"path": Path, "query": Query, "header": Header, "form": Form, "file": FilePart}


def add_routes(router: APIRouter, operations: list[Operation]) -> None:
    """A route for each operation that has an address."""
    for operation in operations:
        if operation.address is not None:
            _add_route(router, operation)
    # Behind all analyses, so that it is reached by no other.
    router.add_api_route("/analyses/{name}", _unknown_analysis, methods=["POST"], include_in_schema=False)


def _unknown_analysis(name: str) -> None:
    """Return the error for an unknown analysis, with the list of analyses."""
    find_analysis(name)


def _add_route(router: APIRouter, operation: Operation) -> None:
    endpoint = _make_queued_endpoint(operation) if operation.queued else _plain(operation)
    endpoint.__signature__ = _signature(operation)  # type: ignore[attr-defined]  # what inspect, and so FastAPI, reads
    endpoint.__name__ = operation.name
    plain: dict[str, Any] = {"response_class": Response} if operation.media and operation.model is None else {}
    router.add_api_route(
        operation.path,
        endpoint,
        methods=[operation.method],
        operation_id=operation.name,
        summary=operation.summary or None,
        description=operation.description,
        tags=[operation.module],
        status_code=operation.status,
        response_model=operation.model,
        response_model_exclude_none=operation.omit_null,
        responses=_responses(operation),
        openapi_extra=_content(operation),
        **plain,
    )


def _plain(operation: Operation) -> Callable[..., Any]:
    def endpoint(http: Request, call: Call, **given: Any) -> Response:
        return respond(operation, call, http, given)

    return endpoint


def _make_queued_endpoint(operation: Operation) -> Callable[..., Any]:
    """An endpoint that is worked on when it is its turn."""

    async def endpoint(http: Request, call: Call, **given: Any) -> Response:
        def ask() -> Response:
            return respond(operation, call, http, given)

        if not operation.is_queued(given):
            return await run_in_threadpool(ask)
        queue = http.app.state.admission.of(operation)
        if not queue.has_place(call.client) and operation.is_quick(given):
            answer = await _ask_quickly(http, call, ask)
            if answer is not None:
                return answer
        async with queue.place(http, call.client) as threads:
            if operation.cancel_on_disconnect:
                # Only now, for the time of a query begins with its limits.
                return await while_connected(http, call.limits.cancel, ask, threads)
            return await to_thread.run_sync(ask, limiter=threads)

    return endpoint


async def _ask_quickly(http: Request, call: Call, ask: Callable[[], Response]) -> Response | None:
    """Ask in the place that only quick requests have. None if the request took too long there."""
    async with http.app.state.admission.quick.place(http, call.client) as threads:
        call.limits.hurry()
        try:
            return await while_connected(http, call.limits.cancel, ask, threads)
        except LimitError as error:
            if error.details.get("code") != "query-timeout":
                raise
    call.renew_limits()
    return None


def respond(operation: Operation, call: Call, http: Request, given: dict[str, Any]) -> Response:
    """Run an operation; return its answer as an HTTP response."""
    key = given.pop("idempotency_key", None)
    values = {name: _value(value) for name, value in given.items()}
    if key is not None:
        return do_once(operation, call, key, values, lambda: _try(operation, call, http, values))
    return _try(operation, call, http, values)


def _try(operation: Operation, call: Call, http: Request, values: dict[str, Any]) -> Response:
    """Run an operation, again if the replica became unreachable, or if the database aborted a transaction because of
    another one and nothing was written.
    """
    for _ in range(TRIES - 1):
        written = call.database.writes
        try:
            return _answer(operation, call, http, values)
        except ReplicaError:
            pass
        except ClashError:
            if call.database.writes != written:
                raise
        call.begin_again()
        for value in values.values():
            for item in value if isinstance(value, list) else [value]:
                if isinstance(item, SourceFile):
                    item.stream.seek(0)
    return _answer(operation, call, http, values)


def _answer(operation: Operation, call: Call, http: Request, values: dict[str, Any]) -> Response:
    with call.held as held:
        try:
            answer = operation.run(call, values)
        except SameError as same:
            return Response(status_code=304, headers={"etag": same.tag} | (LASTING if call.lasting else {}))
        headers = dict(LASTING) if call.lasting else {}
        if call.tag is not None:
            headers["etag"] = f'"{call.tag}"'
        if call.created is not None:
            headers["location"] = f"{PREFIX}/{call.created}"
        if isinstance(answer, Content):
            again = partial(_make_again, operation, call, values) if call.from_replica and call.tag else None
            return make_response(answer, headers, held.pop_all(), http, again)
    if answer is None:
        return Response(status_code=operation.status, headers=headers)
    following = getattr(answer, "next_cursor", None)
    if following is not None and operation.method == "GET":
        headers["link"] = f'<{http.url.include_query_params(cursor=following)}>; rel="next"'
    # Here, in a thread: FastAPI would make the text of a model on the event loop, where all others wait for it.
    text = answer.model_dump_json(exclude_none=operation.omit_null, by_alias=True)
    return Response(text, operation.status if call.made else 200, headers, media_type="application/json")


def _make_again(operation: Operation, call: Call, values: dict[str, Any]) -> Iterator[Bytes]:
    """The bytes of content whose replica went away while it was sent. ReplicaError where they are others by now."""
    other = copy(call)
    other.begin_again()
    with other.held:
        content = operation.run(other, values)
        if other.tag != call.tag:
            raise ReplicaError
        yield from content.blocks


def _value(value: Any) -> Any:
    """An argument as operations take it."""
    if isinstance(value, FormFile):
        return SourceFile(value.filename or "unnamed", value.file)
    return [_value(item) for item in value] if isinstance(value, list) else value


def _signature(operation: Operation) -> inspect.Signature:
    keyword = inspect.Parameter.KEYWORD_ONLY
    own: dict[str, Any] = {"call": Annotated[Call, Depends(_calling(operation))], "http": Request}
    parameters = [inspect.Parameter(name, keyword, annotation=kind) for name, kind in own.items()]
    for argument in operation.arguments:
        default = argument.default
        parameters.append(inspect.Parameter(argument.name, keyword, annotation=_annotation(argument), default=default))
    if creates(operation):
        parameters.append(inspect.Parameter("idempotency_key", keyword, annotation=Key, default=None))
    return inspect.Signature(parameters)


def _annotation(argument: Argument) -> Any:
    """Return the type with FastAPI's marker for the source of the value."""
    if argument.place == "body":
        return argument.kind
    if argument.body is not None:
        return Annotated[bytes, Depends(_reading(argument.body.most))]
    field = argument.field
    extra: dict[str, Any] = {"description": field.description, "examples": field.examples}
    if argument.wire != argument.name and argument.place != "header":
        extra["alias"] = argument.wire
    kind = argument.bare
    if argument.place == "file":
        many = kind is not SourceFile
        return Annotated[list[UploadFile] if many else UploadFile, FilePart(**extra)]
    return Annotated[argument.plain, *field.metadata, _MARKS[argument.place](**extra)]


def _reading(most: int) -> Callable[[Request], Any]:
    async def content(request: Request) -> bytes:
        return await read_body(request, most)

    return content


def _calling(operation: Operation) -> Callable[[Request], Any]:
    async def call(request: Request) -> Call:
        """Async endpoints need no thread. Users without the right are refused before their data is read."""
        made = call_of(request)
        made.from_replica = operation.effect in (Effect.READS, Effect.STREAMS)
        operation.allow(made)
        return made

    return call


def call_of(request: Request) -> Call:
    """Return the call of a request: authentication has stored the user."""
    entry = request.scope.get("mcml.entry", LOCAL)
    host = request.client.host if request.client else ""
    call = Call(
        request.app.state.repository,
        entry.author,
        entry.view,
        entry.account,
        entry.share,
        client=f"{entry.author}@{host}",
        origin=host,
        media_type=request.headers.get("content-type", "").partition(";")[0].strip(),
    )
    call.known = lambda tag: match_tag(request, f'"{tag}"')
    return call


def _responses(operation: Operation) -> dict[int | str, dict[str, Any]]:
    responses: dict[int | str, dict[str, Any]] = {}
    if operation.media is not None:
        types = {name: {} if shown is None else {"example": shown} for name, shown in operation.media.types.items()}
        if BYTES in types:
            types[BYTES]["schema"] = {"type": "string", "format": "binary"}
        responses[operation.status] = {"description": operation.media.words, "content": types}
    if operation.ok_description:
        responses[200] = {"model": operation.model, "description": operation.ok_description}
    return responses


def _content(operation: Operation) -> dict[str, Any] | None:
    """Describe the body of a request that is read as raw bytes."""
    for argument in operation.arguments:
        body = argument.body
        if body is not None:
            # Generators of clients know few types of text; this one is read just the same.
            types = {BYTES: "the same, as bytes", **body.types}
            content = {name: {"schema": _schema(name, body), "example": shown} for name, shown in types.items()}
            return {"requestBody": {"required": argument.required, "content": content}}
    return None


def _schema(media_type: str, body: Body) -> dict[str, Any]:
    if media_type == "application/json" and body.model is not None:
        return body.model.model_json_schema()
    return {"type": "string"} | ({"format": "binary"} if media_type == BYTES else {})
