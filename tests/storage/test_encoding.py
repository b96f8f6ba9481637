"""Frames to rows and back, without a database."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray

from mcml.motion.clip import FrameBlock, full_shape
from mcml_service.storage.documents.encoding import (
    TRACK_COLUMNS,
    ClipEncoder,
    FrameIdRuns,
    Spans,
    compress,
    decompress,
    encode_chunk,
    pack_shape,
    unpack_shape,
)

FINITE = st.floats(allow_nan=False, allow_infinity=False, width=64)


ON_GRID = st.integers(-(10**9), 10**9).flatmap(lambda number: st.sampled_from([number / 100, number / 10**6, -0.0]))


@given(
    arrays.arrays(
        np.float64,
        st.tuples(st.integers(1, 6), st.integers(1, 40)),
        elements=st.one_of(FINITE, ON_GRID, st.sampled_from([-0.0, np.nan])),
    ),
    st.sampled_from([None, 0, 2, 6, 15]),
)
def test_compression_keeps_every_bit(columns: np.ndarray, decimals: int | None) -> None:
    back = decompress(compress(columns, decimals), len(columns), 1)
    assert back.tobytes() == columns.tobytes()


@given(st.lists(st.tuples(st.integers(0, 65535), st.integers(0, 255)), max_size=50))
def test_shapes_pack(pairs: list[tuple[int, int]]) -> None:
    assert unpack_shape(pack_shape(tuple(pairs))) == tuple(pairs)


def test_zone_map_covers_present_samples_only() -> None:
    (made,) = encode_chunk(3, np.array([[1.0, np.nan, -2.0], [4.0, 4.0, 4.0]]).T, [(7, 5), (7, 3)])
    row = dict(zip(TRACK_COLUMNS, made, strict=True))
    assert (row["min_Rz"], row["max_Rz"], row["min_Rx"], row["max_Rx"]) == (-2.0, 1.0, 4.0, 4.0)
    assert row["channels"] == 0b101000
    assert row["has_missing"] == 0b100000
    assert row["min_Tx"] is None
    assert encode_chunk(0, np.full((4, 1), np.nan), [(0, 0)]) == []


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 7)), min_size=1, max_size=9, unique=True), st.data())
def test_rows_of_a_chunk_are_those_of_its_bones_alone(columns: list[tuple[int, int]], data: st.DataObject) -> None:
    numbers = st.one_of(st.just(math.nan), st.floats(-9, 9))
    values = data.draw(arrays.arrays(np.float64, (5, len(columns)), elements=numbers))
    rows = {row[1]: row for row in encode_chunk(2, values, columns)}
    for bone in {bone for bone, _ in columns}:
        own = [place for place, (other, _) in enumerate(columns) if other == bone]
        alone = encode_chunk(2, values[:, own], [columns[place] for place in own])
        assert alone == ([rows[bone]] if bone in rows else [])
        kept = [place for place in own if not np.isnan(values[:, place]).all()]
        assert (bone in rows) == bool(kept)
        if bone in rows:
            row = dict(zip(TRACK_COLUMNS, rows[bone], strict=True))
            ordered = sorted(kept, key=lambda place: columns[place][1])
            assert row["channels"] == sum(1 << columns[place][1] for place in ordered)
            back = decompress(row["data"], len(ordered), row["codec"])
            assert back.tobytes() == np.ascontiguousarray(values[:, ordered].T).tobytes()


@given(st.lists(st.lists(st.integers(-5, 30), min_size=1, max_size=30), max_size=6))
def test_frame_ids_come_back(parts: list[list[int]]) -> None:
    runs = FrameIdRuns()
    for part in parts:
        runs.add(np.array(part, dtype=np.int64))
    found = [row["first_id"] + row["step"] * i for row in runs.rows for i in range(row["count"])]
    assert found == [item for part in parts for item in part]
    assert [row["first"] for row in runs.rows] == list(np.cumsum([1] + [row["count"] for row in runs.rows])[:-1])


def test_a_regular_clip_has_one_run_of_ids() -> None:
    runs = FrameIdRuns()
    for start in range(0, 5000, 700):
        runs.add(np.arange(start, min(start + 700, 5000)))
    assert [(row["first_id"], row["count"], row["step"]) for row in runs.rows] == [(0, 5000, 1)]


@given(st.lists(st.lists(st.sampled_from("abc"), max_size=3).map(tuple), min_size=1, max_size=25), st.integers(1, 25))
def test_spans_say_what_frames_said(frames: list[tuple[str, ...]], cut: int) -> None:
    spans = Spans()
    for part in (frames[:cut], frames[cut:]):
        if part:
            spans.add(len(part), part if any(part) else None)
    spans.finish()
    for position, names in enumerate(frames, 1):
        covering = sorted((r["rank"], r["name"]) for r in spans.rows if r["first"] <= position <= r["last"])
        assert tuple(name for _, name in covering) == names


@given(st.integers(1, 1200), st.lists(st.integers(1, 400), min_size=1, max_size=8), st.integers(0, 10))
def test_chunks_do_not_depend_on_blocks(frames: int, lengths: list[int], seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=(frames, 5))
    columns = ((0, 0), (0, 5), (2, 3), (2, 4), (1, 6))
    rows = []
    with ThreadPoolExecutor(2) as executor:
        encoder = ClipEncoder(executor)
        start, turn = 0, 0
        while start < frames:
            end = min(start + lengths[turn % len(lengths)], frames)
            block = FrameBlock(values[start:end], columns, (full_shape(columns),), np.arange(start + 1, end + 1))
            for chunk in encoder.add(block):
                rows += chunk
            start, turn = end, turn + 1
        encoder.close()
        for chunk in encoder.rest():
            rows += chunk
    assert encoder.frames == frames
    named = [dict(zip(TRACK_COLUMNS, row, strict=True)) for row in rows]
    assert [row["chunk"] for row in named] == sorted(row["chunk"] for row in named)
    joined: dict[int, list[NDArray[np.float64]]] = {}
    for row in named:
        bits = bin(row["channels"]).count("1")
        joined.setdefault(row["bone"], []).append(decompress(row["data"], bits, 1))
    for bone, wanted in ((0, [0, 1]), (1, [4]), (2, [2, 3])):
        assert np.array_equal(np.concatenate(joined[bone], axis=1), values[:, wanted].T)
    assert encoder.shape_rows == [{"slot": 0, "count": frames, "shape": 0}]
