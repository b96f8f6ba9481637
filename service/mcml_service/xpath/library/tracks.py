"""Tracks as arrays, the ones read last kept in memory."""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import TYPE_CHECKING, TypeAlias

from mcml.motion.skeleton import Array
from mcml_service.storage.documents.blocks import Block, side_by_side
from mcml_service.storage.documents.encoding import channels_of, decompress
from mcml_service.xpath.library.cache import OVERHEAD, Cache

if TYPE_CHECKING:
    from mcml_service.storage.transaction import Transaction

Key: TypeAlias = tuple[int, int, int, int]
"""(document, chunk, bone, from_commit): under a key a track never changes."""
Row: TypeAlias = tuple[int, int, int, int, int]
"""A key, and the channels that the track has."""
BlockKey: TypeAlias = tuple[int, int, int]
"""(document, revision, chunk)."""
Packed: TypeAlias = tuple[int, bytes]
"""Codec and bytes, as the store has them."""


class Tracks:
    """Tracks as the store has them and decoded, each up to a number of bytes.

    What is kept are the store's own numbers, as a database keeps pages: no answer is kept. Compressed they take a fifth
    of the memory; to fetch a track takes twice as long as to decode it.
    """

    def __init__(self, packed: int = 32 << 20, decoded: int = 40 << 20) -> None:
        self._packed = Cache[Key, Packed](packed, lambda track: len(track[1]) + OVERHEAD)
        self._decoded = Cache[Key, Array](decoded, lambda values: values.nbytes + OVERHEAD)

    def forget(self, documents: Container[int]) -> None:
        """Let the tracks of all other documents go, and those in whose place newer ones were read."""
        newest: dict[tuple[int, int, int], int] = {}
        for document, chunk, bone, commit in (*self._packed, *self._decoded):
            newest[document, chunk, bone] = max(commit, newest.get((document, chunk, bone), commit))

        def is_held(key: Key) -> bool:
            return key[0] in documents and newest.get(key[:3], key[3]) == key[3]

        self._packed.forget(is_held)
        self._decoded.forget(is_held)

    def read(self, tx: Transaction, rows: Sequence[Row]) -> list[Array]:
        """The (channels, frames) array of each track."""
        channels = {row[:4]: len(channels_of(row[4])) for row in rows}

        def decoded(keys: list[Key]) -> dict[Key, Array]:
            packed = self._packed.get(keys, lambda missing: _fetch(tx, missing))
            return {
                key: decompress(data, channels[key], codec) for key, (codec, data) in zip(keys, packed, strict=True)
            }

        return self._decoded.get([row[:4] for row in rows], decoded)


def read_blocks(tx: Transaction, chunks: Sequence[tuple[int, int]]) -> dict[tuple[int, int], Block]:
    """The block of each chunk (document, chunk)."""
    tracks: dict[tuple[int, int], list[tuple[int, int, int, int, bytes]]] = {chunk: [] for chunk in chunks}
    for row in tx.columns.tracks_over(list(tracks)):
        tracks[row[:2]].append(row[2:7])
    return {chunk: side_by_side(rows) for chunk, rows in tracks.items()}


def _fetch(tx: Transaction, keys: Sequence[Key]) -> dict[Key, Packed]:
    found = tx.columns.track_data(keys)
    return {row[:4]: row[4:6] for row in found}
