"""Readers do no work for a message before there is one: twice the input is twice the work.

Work is what can be counted: bytes that are read from the file, calls, and characters that are looked at.
"""

from __future__ import annotations

import io
import sys
from typing import Any

import pytest

from benchmarks.reader_inputs import INPUTS, bvh_of_one_line, mcml_of_one_name, read_through, trc
from mcml.formats.text import lines
from mcml.language import frames, reader
from mcml.language.element import Element

FRAMES = 600
MOST = 2.2


class Counted(io.BytesIO):
    """A file that counts the bytes that are read from it."""

    total = 0

    def read(self, size: int | None = -1, /) -> bytes:
        found = super().read(size)
        Counted.total += len(found)
        return found


def work(name: str, count: int) -> int:
    """Bytes read and calls made for an input."""
    calls = 0

    def count_call(frame: Any, event: str, argument: object) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    made = INPUTS[name](count)
    Counted.total = 0
    sys.setprofile(count_call)
    try:
        read_through(made, Counted)
    finally:
        sys.setprofile(None)
    return Counted.total + 50 * calls


@pytest.mark.parametrize("name", INPUTS)
def test_twice_the_input_is_twice_the_work(name: str) -> None:
    # The first reading fills what is kept for files to come.
    work(name, 10)
    once, twice = work(name, FRAMES), work(name, 2 * FRAMES)
    assert twice < MOST * once


def test_no_line_is_counted_where_nothing_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    counted: list[int] = []
    monkeypatch.setattr("mcml.formats.trc.rows.line_and_column", lambda *given: counted.append(1))
    assert read_through(trc(200)) == 200
    assert counted == []


def test_a_line_is_not_looked_at_again_for_each_joint(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hierarchy may be one long line."""
    seen = 0
    whole = lines.Tokens.rest_words

    def rest_words(self: lines.Tokens, most: int) -> list[str]:
        nonlocal seen
        found = whole(self, most)
        seen += len(found)
        return found

    monkeypatch.setattr(lines.Tokens, "rest_words", rest_words)
    joints = 300
    assert read_through(bvh_of_one_line(joints)) == 1
    assert seen < 30 * joints


def test_pieces_of_a_text_are_counted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Comments cut a text into pieces; each was added to, or counted with, all before it."""
    seen = 0

    class Pieces(list[str]):
        def __iter__(self) -> Any:
            nonlocal seen
            seen += len(self)
            return super().__iter__()

    start = frames.FrameReader.start

    def begin(self: frames.FrameReader, tag: str, attributes: list[str]) -> None:
        start(self, tag, attributes)
        self._text = Pieces(self._text)

    monkeypatch.setattr(frames.FrameReader, "start", begin)
    assert read_through(mcml_of_one_name(500)) == 1
    assert seen <= 1000


def test_a_text_is_put_together_once(monkeypatch: pytest.MonkeyPatch) -> None:
    written = 0

    class Watched(Element):
        def __setattr__(self, name: str, value: object) -> None:
            nonlocal written
            written += len(str(value)) if name == "text" else 0
            super().__setattr__(name, value)

    monkeypatch.setattr(reader, "Element", Watched)
    read_through(INPUTS["mcml"](500))
    assert written < 5_000
