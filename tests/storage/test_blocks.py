"""Tracks side by side, against the same one number at a time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import StoreError
from mcml.motion.skeleton import Array
from mcml.numerics.runs import evenly
from mcml_service.storage.documents.blocks import Stretch, gathered, side_by_side
from mcml_service.storage.documents.encoding import PCODEC, channels_of, compress

Sample = tuple[int, int, int]
"""Bone, channel, frame of the chunk."""


@st.composite
def chunks(draw: st.DrawFn) -> list[tuple[int, int, Array]]:
    """(bone, channels as bits, samples) of the tracks over one chunk, some of them shorter than others."""
    bones = draw(st.lists(st.integers(0, 6), unique=True, max_size=5).map(sorted))
    rng = np.random.default_rng(draw(st.integers(0, 1000)))
    tracks = []
    for bone in bones:
        bits = draw(st.integers(1, 255))
        tracks.append((bone, bits, rng.normal(size=(bits.bit_count(), draw(st.sampled_from([3, 8, 8, 8]))))))
    return tracks


def samples(tracks: list[tuple[int, int, Array]]) -> dict[Sample, float]:
    return {
        (bone, channel, frame): float(row[frame])
        for bone, bits, values in tracks
        for channel, row in zip(channels_of(bits), values, strict=True)
        for frame in range(len(row))
    }


@given(st.lists(st.tuples(chunks(), st.lists(st.integers(0, 7), min_size=1, max_size=8)), min_size=1, max_size=3))
def test_frames_are_gathered_from_chunks_of_any_layout(
    parts: list[tuple[list[tuple[int, int, Array]], list[int]]],
) -> None:
    frames = sum(len(offsets) for _, offsets in parts)
    shuffled = np.random.default_rng(frames).permutation(frames)
    stretches, wanted, start = [], {}, 0
    for tracks, offsets in parts:
        places = np.sort(shuffled[start : start + len(offsets)])
        packed = [(bone, bits, values.shape[1], PCODEC, compress(values)) for bone, bits, values in tracks]
        stretches.append(Stretch(side_by_side(packed), evenly(np.array(offsets)), evenly(places)))
        held = samples(tracks)
        for place, offset in zip(places.tolist(), offsets, strict=True):
            wanted |= {(place, b, c): value for (b, c, frame), value in held.items() if frame == offset}
        start += len(offsets)
    values, columns = gathered(stretches, frames)
    found = {
        (place, *column): float(value)
        for place, row in enumerate(values)
        for column, value in zip(columns, row, strict=True)
        if value == value
    }
    assert found == wanted


def test_a_damaged_track_is_told() -> None:
    packed = compress(np.arange(16.0).reshape(2, 8))
    with pytest.raises(StoreError, match="damaged"):
        side_by_side([(0, 3, 8, PCODEC, packed[:-9])])
    with pytest.raises(StoreError, match="damaged"):
        side_by_side([(0, 3, 7, PCODEC, packed)])
    with pytest.raises(StoreError, match="codec 77"):
        side_by_side([(0, 3, 8, 77, packed)])
