"""What the queries of a process keep between them: parts of the store that never change, not answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeAlias, TypeVar

from service.storage.blocks import Block
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.batches import Batch, batch_of
from service.xpath.cache import Cache
from service.xpath.frame_runs import Ids, Labels, read_ids, read_labels
from service.xpath.heads import Heads
from service.xpath.layouts import Layout, read_layouts
from service.xpath.listing import Listing
from service.xpath.tracks import OVERHEAD, BlockKey, Tracks
from service.xpath.zones import Zones, read_zones


class _Sized(Protocol):
    @property
    def nbytes(self) -> int: ...


Entry = TypeVar("Entry", bound=_Sized)


class DocumentCache(Generic[Entry]):
    """A cache of what belongs to one document. At one revision a document never changes.

    read: the entry of each document by its key. limit: bytes kept.
    """

    def __init__(
        self, read: Callable[[Transaction, Sequence[Listed]], Mapping[int, Entry]], limit: int = 8 << 20
    ) -> None:
        self._read = read
        self._kept = Cache[tuple[int, int], Entry](limit, lambda entry: entry.nbytes)

    def holds(self, documents: Sequence[Listed]) -> bool:
        """Whether the entries of all of them are kept now."""
        return self._kept.holds([(listed.key, listed.revision) for listed in documents])

    def read(self, tx: Transaction, documents: Sequence[Listed]) -> list[Entry]:
        """The entry of each document. tx: one that only reads, for a revision that may yet be taken back is none."""
        wanted = {(listed.key, listed.revision): listed for listed in documents}

        def missing(keys: list[tuple[int, int]]) -> dict[tuple[int, int], Entry]:
            entries = self._read(tx, [wanted[key] for key in keys])
            return {key: entries[key[0]] for key in keys}

        return self._kept.get([(listed.key, listed.revision) for listed in documents], missing)


MANY_DOCUMENTS = 256
"""Of more documents, columns are made anew for each query."""

BatchKey: TypeAlias = tuple[bool, tuple[tuple[int, int], ...]]


@dataclass(frozen=True)
class Caches:
    """listing: which documents there are. heads, layouts, labels, ids, zones: of documents. tracks: decoded. blocks:
    all tracks over a chunk."""

    listing: Listing = field(default_factory=Listing)
    heads: Heads = field(default_factory=Heads)
    layouts: DocumentCache[Layout] = field(default_factory=lambda: DocumentCache(read_layouts))
    labels: DocumentCache[Labels] = field(default_factory=lambda: DocumentCache(read_labels))
    ids: DocumentCache[Ids] = field(default_factory=lambda: DocumentCache(read_ids))
    zones: DocumentCache[Zones] = field(default_factory=lambda: DocumentCache(read_zones, 24 << 20))
    _batches: Cache[BatchKey, Batch] = field(default_factory=lambda: Cache(24 << 20, lambda batch: batch.nbytes))
    tracks: Tracks = field(default_factory=Tracks)
    blocks: Cache[BlockKey, Block] = field(
        default_factory=lambda: Cache(24 << 20, lambda block: block.values.nbytes + OVERHEAD)
    )

    def batch(self, documents: Sequence[Listed], *, whole_heads: bool) -> Batch:
        """What was made so far of the columns of some documents, by all queries that asked these."""
        if len(documents) > MANY_DOCUMENTS:
            return batch_of(documents)
        key = (whole_heads, tuple([(listed.key, listed.revision) for listed in documents]))
        return self._batches.get([key], lambda _: {key: batch_of(documents)})[0]
