"""Contents that are sent in pieces, made while others are sent."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Generator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml_service.api.streaming import PIECE, ahead, pieces

SIZES = st.sampled_from([0, 1, 1000, PIECE - 1, PIECE, PIECE + 1])


@given(st.lists(SIZES, max_size=8), st.integers(1, 255))
def test_pieces_hold_the_same_bytes_and_none_is_small_but_the_last(sizes: list[int], letter: int) -> None:
    blocks = [bytes([(letter + place) % 256]) * size for place, size in enumerate(sizes)]
    made = [bytes(piece) for piece in pieces(iter(blocks))]
    assert b"".join(made) == b"".join(blocks)
    assert all(len(piece) >= PIECE for piece in made[:-1])
    assert all(made)


def test_all_pieces_come_in_order() -> None:
    async def read() -> list[bytes]:
        return [bytes(piece) async for piece in ahead((b"%d" % number for number in range(50)), b"first")]

    assert asyncio.run(read()) == [b"first", *(b"%d" % number for number in range(50))]


def test_an_error_comes_behind_the_pieces_before_it() -> None:
    def content() -> Generator[bytes]:
        yield b"a"
        yield b"b"
        raise ValueError("no more")

    read: list[bytes] = []

    async def reading() -> None:
        async for piece in ahead(content()):
            read.append(bytes(piece))

    with pytest.raises(ValueError, match="no more"):
        asyncio.run(reading())
    assert read == [b"a", b"b"]


@pytest.mark.parametrize("fails", [False, True])
def test_a_content_is_closed_when_its_reader_leaves(fails: bool) -> None:
    asked, go_on, closed = threading.Event(), threading.Event(), threading.Event()

    def content() -> Generator[bytes]:
        try:
            yield b"a"
            asked.set()
            # The reader leaves while a thread is in here.
            assert go_on.wait(30)
            if fails:
                raise ValueError("nobody hears this")
            yield b"b"
        finally:
            closed.set()

    async def leave() -> None:
        stream = ahead(content())
        assert await anext(stream) == b"a"
        assert await asyncio.to_thread(asked.wait, 30)
        await stream.aclose()  # type: ignore[attr-defined]
        assert not closed.is_set()
        go_on.set()
        assert await asyncio.to_thread(closed.wait, 30)

    asyncio.run(leave())


def test_a_reader_who_leaves_while_it_waits_lets_the_thread_end() -> None:
    asked, go_on, closed = threading.Event(), threading.Event(), threading.Event()
    said: list[object] = []

    def content() -> Generator[bytes]:
        try:
            yield b"a"
            asked.set()
            assert go_on.wait(30)
            yield b"b"
        finally:
            closed.set()

    async def leave() -> None:
        asyncio.get_running_loop().set_exception_handler(lambda _, told: said.append(told))
        stream = ahead(content())
        assert await anext(stream) == b"a"
        waiting = asyncio.ensure_future(anext(stream))
        assert await asyncio.to_thread(asked.wait, 30)
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
        assert not closed.is_set()
        go_on.set()
        assert await asyncio.to_thread(closed.wait, 30)

    asyncio.run(leave())
    assert said == []
