"""Requests with an Idempotency-Key, each of which is done once, though it is sent again after a broken line."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any, TypeAlias

from fastapi import Header, Response
from pydantic import BaseModel

from mcml.errors import ConflictError, DocumentError
from mcml.formats.format import SourceFile
from mcml_service.operations.call import Call
from mcml_service.operations.operation import Effect, Operation
from mcml_service.storage.team.idempotency import KEY_HOURS, Remembered

Key: TypeAlias = Annotated[
    str | None,
    Header(
        min_length=1,
        max_length=255,
        description=f"A text of the client's own: the same request with it is not done again within {KEY_HOURS} hours, "
        "but answered as it was",
        examples=["3f2b6c1e-upload-walk"],
    ),
]


def creates(operation: Operation) -> bool:
    """Whether an operation makes something, so that to do it twice would make two."""
    return operation.method == "POST" and (operation.status == 201 or operation.effect is Effect.STARTS)


def do_once(operation: Operation, call: Call, key: str, given: dict[str, Any], do: Callable[[], Response]) -> Response:
    """The answer of `do`, or that of the same request when it was done.

    Raises ConflictError where it is being done, or its end is not known; DocumentError for another request.
    """
    database, author = call.database, call.author
    digest = _digest(operation, given)
    with database.write(author) as tx:
        before = tx.requests.begin(author, key, operation.name, digest)
    if before is not None:
        return _again(operation, digest, before)
    try:
        answer = do()
    except BaseException:
        # Nothing was done: an operation is whole or absent.
        with database.write(author) as tx:
            tx.requests.forget(author, key)
        raise
    with database.write(author) as tx:
        tx.requests.end(author, key, answer.status_code, answer.headers.get("location"), bytes(answer.body).decode())
    return answer


def _again(operation: Operation, digest: str, before: Remembered) -> Response:
    if (before.operation, before.digest) != (operation.name, digest):
        raise DocumentError("This Idempotency-Key came with another request.", remedy="Make a key for each request.")
    if before.status is None or before.answer is None:
        raise ConflictError(
            "The request with this Idempotency-Key is being worked on, or the server stopped meanwhile.",
            remedy="Wait, and ask again; if it stays so, look whether it was done before you send it with another key.",
        )
    headers = {"idempotency-replayed": "true"} | ({} if before.location is None else {"location": before.location})
    return Response(before.answer, before.status, headers, media_type="application/json")


def _digest(operation: Operation, given: dict[str, Any]) -> str:
    """Return the digest of a request: its arguments, and the bytes of files."""
    made = hashlib.sha256(operation.name.encode())
    for name, value in sorted(given.items()):
        made.update(name.encode())
        for item in value if isinstance(value, list) else [value]:
            if isinstance(item, SourceFile):
                made.update(item.name.encode())
                for block in iter(partial(item.stream.read, 1 << 20), b""):
                    made.update(block)
                item.stream.seek(0)
            else:
                text = item.model_dump_json() if isinstance(item, BaseModel) else repr(item)
                made.update(text.encode())
    return made.hexdigest()
