"""Long answers as streams: the first block is made before the status is sent, so an error is still a problem."""

from __future__ import annotations

import asyncio
import re
import sys
from collections.abc import AsyncIterator, Callable, Generator, Iterator
from contextlib import ExitStack
from typing import TypeAlias
from urllib.parse import quote

from fastapi import Request, Response
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from mcml.answers import Content
from mcml.errors import LimitError, ReplicaError
from mcml_service.api.problems import plain

PIECE = 1 << 18
"""Bytes that are sent together: each piece is handed from a thread to the event loop, which takes longer than to make
a small one. A shorter answer is sent whole."""


Bytes: TypeAlias = bytes | memoryview
Again: TypeAlias = Callable[[], Iterator[Bytes]]

_RANGE = re.compile(r"bytes=(\d{0,18})-(\d{0,18})")
_UTF_8 = {"application/xml": "application/xml; charset=utf-8"}
"""All XML that the service writes is UTF-8; for text the framework adds it."""
_HEADERS = {"total-count": "x-total-count"}
"""Names of facts that are not the repository's own."""


def make_response(
    content: Content, headers: dict[str, str], held: ExitStack, http: Request, again: Again | None = None
) -> Response:
    """Return content as a response.

    Its beginning is produced here: short content completely, long content far enough to detect errors. held: resources
    that the content reads from; released when the answer is sent. again: gives the same bytes from the beginning, if
    the replica that they are read from becomes unreachable.
    """
    headers |= {_HEADERS.get(name, f"x-mcml-{name}"): _latin(text) for name, text in content.facts.items()}
    if content.name is not None:
        headers["content-disposition"] = attachment(content.name, "inline" if content.shown else "attachment")
    media_type = _UTF_8.get(content.media_type, content.media_type)
    wanted = _range(content, headers, http)
    if content.size is not None and "etag" in headers:
        headers["accept-ranges"] = "bytes"
    with held as stack:
        if wanted is not None:
            return _part(content, headers, stack, wanted, again)
        if content.live:
            kept = stack.pop_all()
            return StreamingResponse(_holding(kept, content.blocks), media_type=media_type, headers=headers)
        joined = pieces(content.blocks)
        first = next(joined, b"")
        if content.notices:
            text = " | ".join(notice.what for notice in content.notices)
            headers["x-mcml-notices"] = text.encode("ascii", "replace").decode()[:4000]
        if len(first) < PIECE:
            return Response(first, media_type=media_type, headers=headers)
        if content.size is not None:
            headers["content-length"] = str(content.size)
        kept = stack.pop_all()
    others = _resume(_holding(kept, joined), len(first), again)
    return StreamingResponse(ahead(others, first), media_type=media_type, headers=headers)


def _range(content: Content, headers: dict[str, str], http: Request) -> range | None:
    """Return the requested bytes, None for all (RFC 9110, 14).

    Supports one range; other requests get the whole content.
    """
    match = _RANGE.fullmatch(http.headers.get("range", ""))
    tag = http.headers.get("if-range")
    if match is None or content.size is None or "etag" not in headers or (tag is not None and tag != headers["etag"]):
        return None
    first, last = match[1], match[2]
    if not first:
        return range(max(0, content.size - int(last or 0)), content.size)
    return range(int(first), min(int(last) + 1, content.size) if last else content.size)


def _part(content: Content, headers: dict[str, str], stack: ExitStack, wanted: range, again: Again | None) -> Response:
    if not wanted:
        headers["content-range"] = f"bytes */{content.size}"
        return plain(416, "The file has no such bytes.", "Ask for a range within Content-Range.", headers)
    headers["content-range"] = f"bytes {wanted.start}-{wanted.stop - 1}/{content.size}"
    headers["content-length"] = str(len(wanted))
    kept = stack.pop_all()
    remaining, at = content.blocks, 0
    if content.seek is not None:
        remaining, at = content.seek(wanted.start), wanted.start
    whole = _resume(_holding(kept, remaining), at, again)
    blocks = ahead(pieces(_within(whole, range(wanted.start - at, wanted.stop - at))))
    return StreamingResponse(blocks, 206, headers, media_type=content.media_type)


def _within(blocks: Iterator[Bytes], wanted: range) -> Iterator[Bytes]:
    at = 0
    for block in blocks:
        if at >= wanted.stop:
            return
        part = block[max(0, wanted.start - at) : max(0, wanted.stop - at)]
        at += len(block)
        if len(part):
            yield part


def _holding(kept: ExitStack, blocks: Iterator[Bytes]) -> Generator[Bytes]:
    with kept:
        yield from blocks


def _resume(blocks: Iterator[Bytes], at: int, again: Again | None) -> Generator[Bytes]:
    """Yield blocks, the first of which begins at byte `at`; if their replica becomes unreachable, continue with the
    blocks of `again`.
    """
    try:
        for block in blocks:
            at += len(block)
            yield block
    except ReplicaError:
        if again is None:
            raise
        yield from _within(again(), range(at, sys.maxsize))


def _latin(text: str) -> str:
    """Text of any kind, as a header carries it: its bytes in UTF-8."""
    return text.encode().decode("latin-1")


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
    """Yield `first`, then each non-empty piece of a content; while one is sent, a thread makes the next.

    A reader that stops must close this generator; it closes the content as soon as no thread uses it.
    """

    def end(made: asyncio.Future[Bytes]) -> None:
        # Nobody else reads its error. Cancelled with the loop: a thread may still be in it.
        if not made.cancelled() and made.exception() is None:
            content.close()

    making = asyncio.ensure_future(run_in_threadpool(next, content, b""))
    try:
        if first:
            yield first
        # If the client disconnects, it is cancelled here; the thread runs to its end.
        while piece := await asyncio.shield(making):
            making = asyncio.ensure_future(run_in_threadpool(next, content, b""))
            yield piece
    finally:
        making.add_done_callback(end)


async def read_body(request: Request, most: int) -> bytes:
    """Read the whole body of a small request. Raises LimitError above `most` bytes."""
    content = bytearray()
    async for block in request.stream():
        content += block
        if len(content) > most:
            raise LimitError(f"The request has more than {most >> 20} MiB.", remedy="Send it in parts.")
    return bytes(content)


def attachment(file_name: str, way: str = "attachment") -> str:
    """A Content-Disposition that every client reads (RFC 6266): plain and UTF-8 name."""
    plain = "".join(c if c.isascii() and c.isprintable() and c not in '"\\' else "_" for c in file_name)
    return f"{way}; filename=\"{plain}\"; filename*=UTF-8''{quote(file_name)}"


def match_tag(request: Request, tag: str) -> str | None:
    """How a client names this representation if it has it already, None if it has not."""
    known = request.headers.get("if-none-match", "")
    for item in known.split(","):
        stated = item.strip().removeprefix("W/")
        if stated == "*" or stated.replace('-gzip"', '"') == tag:
            return tag if stated == "*" else stated
    return None
