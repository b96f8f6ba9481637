"""Long answers as streams: the first block is made before the status is sent, so an error is still a problem."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Generator, Iterator
from contextlib import ExitStack
from itertools import chain
from typing import TypeAlias
from urllib.parse import quote

from fastapi import Request, Response
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from service.errors import LimitError
from service.storage.database import Database, Transaction

PIECE = 1 << 18
"""Bytes that are sent together: each piece is handed from a thread to the event loop, which takes longer than to make
a small one. A shorter answer is sent whole."""


Bytes: TypeAlias = bytes | memoryview


def streamed(
    database: Database, make: Callable[[Transaction], tuple[Iterator[Bytes], str, dict[str, str]] | Response]
) -> Response:
    """Stream what `make` returns: (content, media type, headers); or a response that says all.

    The read transaction lives as long as the stream.
    """
    with ExitStack() as stack:
        tx = stack.enter_context(database.read())
        made = make(tx)
        if isinstance(made, Response):
            return made
        content, media_type, headers = made
        first = next(content, b"")
        held = stack.pop_all()

    def blocks() -> Generator[Bytes]:
        with held:
            yield from pieces(chain((first,), content))

    return StreamingResponse(ahead(blocks()), media_type=media_type, headers=headers)


def begun(content: Iterator[bytes], media_type: str, headers: dict[str, str]) -> Response:
    """A response whose beginning is made here: a short answer whole, and of a long one enough for an error to show."""
    joined = pieces(content)
    first = next(joined, b"")
    if len(first) < PIECE:
        return Response(first, media_type=media_type, headers=headers)
    return StreamingResponse(ahead(joined, first), media_type=media_type, headers=headers)


def pieces(content: Iterator[Bytes]) -> Generator[Bytes]:
    """The same bytes in pieces that are worth being sent."""
    waiting: list[Bytes] = []
    size = 0
    for block in content:
        waiting.append(block)
        size += len(block)
        if size >= PIECE:
            yield waiting[0] if len(waiting) == 1 else b"".join(waiting)
            waiting, size = [], 0
    if size:
        yield b"".join(waiting)


async def ahead(content: Generator[Bytes], first: Bytes = b"") -> AsyncIterator[Bytes]:
    """`first`, then each piece of a content, of which none is empty; while one is sent, a thread makes the next.

    Whoever reads no more closes this, and so the content, as soon as no thread is in it.
    """

    def end(made: asyncio.Future[Bytes]) -> None:
        # Nobody else asks for its error any more.
        if made.cancelled() or made.exception() is None:
            content.close()

    making = asyncio.ensure_future(run_in_threadpool(next, content, b""))
    try:
        if first:
            yield first
        while piece := await making:
            making = asyncio.ensure_future(run_in_threadpool(next, content, b""))
            yield piece
    finally:
        making.add_done_callback(end)


async def read_body(request: Request, most: int) -> bytes:
    """The whole body of a request that is small by nature. LimitError above so many bytes."""
    content = bytearray()
    async for block in request.stream():
        content += block
        if len(content) > most:
            raise LimitError(f"The request has more than {most >> 20} MiB.", remedy="Send it in parts.")
    return bytes(content)


def attachment(file_name: str) -> str:
    """A Content-Disposition that every client reads (RFC 6266): plain and UTF-8 name."""
    plain = "".join(c if c.isascii() and c.isprintable() and c not in '"\\' else "_" for c in file_name)
    return f"attachment; filename=\"{plain}\"; filename*=UTF-8''{quote(file_name)}"


def unchanged(request: Request, tag: str) -> Response | None:
    """304 where the client has this representation already."""
    known = request.headers.get("if-none-match", "")
    for item in known.split(","):
        said = item.strip().removeprefix("W/")
        if said == "*" or said.replace('-gzip"', '"') == tag:
            return Response(status_code=304, headers={"etag": tag if said == "*" else said})
    return None
