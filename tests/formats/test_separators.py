"""Tables between commas or semicolons are read as tables between tabs, with every byte at its place."""

from __future__ import annotations

import io

import pytest

from mcml.formats.text.separators import tabbed


@pytest.mark.parametrize(
    ("text", "read"),
    [
        (b"a,b\n1.5,2\n", b"a\tb\n1.5\t2\n"),
        (b"a;b\n1,5;2\n", b"a\tb\n1.5\t2\n"),
        (b"\n  a,b\r1;2,3", b"\n  a\tb\r1;2\t3"),
    ],
)
def test_the_first_line_decides_what_separates(text: bytes, read: bytes) -> None:
    stream = tabbed(io.BytesIO(text))
    assert stream.tell() == 0
    assert stream.read() == read
    assert stream.tell() == len(text)


@pytest.mark.parametrize("text", [b"a\tb,c;d\n1,2;3\n", b"a b\n1,2;3\n", b"a b\r1,2;3\r", b""])
def test_a_table_between_tabs_or_spaces_is_the_same_stream(text: bytes) -> None:
    given = io.BytesIO(text)
    assert tabbed(given) is given
    assert given.tell() == 0


def test_a_stream_that_was_read_from_is_read_from_its_beginning() -> None:
    given = io.BytesIO(b"a,b\n1,2\n")
    given.seek(2)
    stream = tabbed(given)
    assert stream.read(2) == b"a\t"
    assert stream.read(2) == b"b\n"
    given = io.BytesIO(b",\n")
    given.seek(1)
    assert tabbed(given).read() == b"\t\n"
    assert stream.seek(5) == 5
    assert stream.read() == b"\t2\n"
