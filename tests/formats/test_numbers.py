"""Text to doubles and back: the fast way against the obvious one."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import FormatError
from mcml.formats.text.number_text import detect_style, number_tokens, rows_of_text
from mcml.formats.text.numbers import (
    PARSER,
    NumberStream,
    Orjson,
    Parser,
    bad_token,
    is_number,
    parse_numbers,
    token_bounds,
    what_is_wrong,
)

doubles = st.floats(allow_nan=False, allow_infinity=False)
spellings = st.sampled_from(["{!r}", "{:.6f}", "{:g}", "{:.17g}", "{:.25e}", "{:+}", "{:E}"])
separators = st.sampled_from([" ", "  ", "\t", "\n", " \r\n", "\n\n \t", "\v", "\f"])
STYLES = st.sampled_from(["shortest", "fixed:0", "fixed:6", "fixed:80", "fixed:99", "general:6", "general:99"])
odd = st.sampled_from(["-0", "0", "-0.0", "+0", ".5", "-.5", "5.", "007", "1e-0", "-0e0", "1e-011", str(10**30), "1E5"])
tokens = st.one_of(odd, st.builds(lambda value, form: form.format(value), doubles, spellings))


each_parser = pytest.mark.parametrize("parser", [PARSER, Orjson()], ids=["fastest", "orjson"])


def bits(values: object) -> list[int]:
    return np.asarray(values, dtype=np.float64).view(np.int64).tolist()  # type: ignore[no-any-return]


@each_parser
@given(pairs=st.lists(st.tuples(tokens, separators)))
def test_parses_as_float_does(parser: Parser, pairs: list[tuple[str, str]]) -> None:
    text = "".join(token + separator for token, separator in pairs).encode()
    found = parse_numbers(text, parser)
    assert found is not None
    assert bits(found) == bits([float(token) for token, _ in pairs])


@given(st.text("0-.e,\1 \t\n\r\v\f", max_size=20))
def test_bounds_are_those_of_the_words(text: str) -> None:
    data = text.encode()
    assert [data[start:end] for start, end in token_bounds(data).tolist()] == data.split()


@each_parser
@given(
    text=st.lists(st.sampled_from([*'0123456789+-.eE,_ infaxy[]"{}:\n\t\0', "true", "null"]), max_size=20).map("".join)
)
def test_accepts_numbers_and_nothing_else(parser: Parser, text: str) -> None:
    found = parse_numbers(text.encode(), parser)
    words = [word for word in text.replace("\n", " ").replace("\t", " ").split(" ") if word]
    if all(is_number(word) for word in words):
        assert found is not None
        assert bits(found) == bits([float(word) for word in words])
    else:
        assert found is None
        bad = bad_token(text.encode())
        assert bad is not None
        assert bad[2] == next(word for word in words if not is_number(word))
        assert text.encode()[bad[1] :].startswith(bad[2].encode())


@given(st.lists(doubles, min_size=1, max_size=30), STYLES)
def test_every_style_reads_back_as_the_same_double(values: list[float], style: str) -> None:
    array = np.array(values)
    assert bits(parse_numbers(b" ".join(number_tokens(array, style)))) == bits(array)
    rows = rows_of_text(array.reshape(1, -1), style, "\t")
    assert rows[0].count(b"\t") == len(values) - 1


@each_parser
@pytest.mark.parametrize("word", ["true", "false", "null", '"1"', "[1]", "{}", '{"a":1}', "NaN", "Infinity", "1e999"])
def test_other_words_of_json_are_no_numbers(parser: Parser, word: str) -> None:
    for text in (word, f"{word} 2", f"1 {word}", f"1 {word} 2"):
        assert parse_numbers(text.encode(), parser) is None


@each_parser
@given(patterns=st.lists(st.integers(0, 2**64 - 1), min_size=1, max_size=20))
def test_any_finite_bit_pattern_survives(parser: Parser, patterns: list[int]) -> None:
    values = np.array([struct.unpack("<d", struct.pack("<Q", pattern))[0] for pattern in patterns])
    values = values[np.isfinite(values)]
    assert bits(parse_numbers(b" ".join(number_tokens(values)), parser)) == bits(values)


@pytest.mark.parametrize(
    ("text", "style"),
    [
        ("0.100000 -1.250000 3.000000 -0.000000", "fixed:6"),
        ("0.10 1.25 3.00 10.50", "fixed:2"),
        ("12.3902 0.0490239 -2.65014 3.97569e-05 7", "general:6"),
        ("0.1 1.0 1e-5 123.456789", "shortest"),
        (" ".join(f"{number:.80f}" for number in (0.5, 1.25)), "fixed:80"),
        (" ".join(f"{number:.100f}" for number in (0.5, 1.25)), "shortest"),
        (f"0.5 1.{'3' * 150} 2.{'7' * 380}", "shortest"),
        ("", "shortest"),
        ("no numbers", "shortest"),
    ],
)
def test_the_style_of_a_file_is_recognised(text: str, style: str) -> None:
    assert detect_style(text.encode()) == style


@pytest.mark.parametrize(
    ("token", "fault"),
    [
        ("1,5", "uses a decimal comma"),
        ("-1,5e3", "uses a decimal comma"),
        ("0.0-7.5094748", "two numbers without a space"),
        ("1e5-2", "two numbers without a space"),
        ("abc", "is not a finite number"),
        ("nan", "is not a finite number"),
        ("1e999", "is not a finite number"),
        ("1-", "is not a finite number"),
        ("x" * 500, "…' is not a finite number"),
    ],
)
def test_says_what_is_wrong_with_a_word(token: str, fault: str) -> None:
    assert fault in what_is_wrong(token)


@given(
    tokens=st.lists(st.floats(-1e6, 1e6).map(repr), min_size=1, max_size=60),
    separators=st.lists(st.sampled_from([" ", "\n", "\r\n", "\r", "\t", "\v", "\f", "  "]), min_size=1, max_size=9),
    block=st.integers(30, 90),
    start=st.integers(0, 5),
)
def test_a_stream_of_numbers_gives_out_every_token_whole(
    tokens: list[str], separators: list[str], block: int, start: int
) -> None:
    body = "".join(token + separators[place % len(separators)] for place, token in enumerate(tokens)).encode()
    stream = NumberStream(io.BytesIO(b"#" * start + body), start, block)
    pieces = []
    while (piece := stream.next()) is not None:
        text, offset = piece
        assert (b"#" * start + body)[offset : offset + len(text)] == text
        assert len(text) <= 3 * block
        pieces.append(text)
    assert b"".join(pieces) == body
    assert [word for text in pieces for word in text.decode().split()] == tokens
    assert stream.offset == start + len(body)


def test_a_word_without_end_is_refused_with_its_place() -> None:
    stream = NumberStream(io.BytesIO(b"1 2\n3 4\n" + b"9" * 1000), 0, 100)
    assert stream.next() == (b"1 2\n3 4\n", 0)
    with pytest.raises(FormatError, match="a single word is longer than 100 bytes") as error:
        stream.next()
    assert error.value.at is not None
    assert error.value.at.line == 3
