"""The caches of the queries of a process: parts of the store that never change, not answers."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from itertools import count
from typing import Generic, Protocol, TypeVar

from mcml_service.clips.bodies import Body, read_bodies
from mcml_service.storage.documents.blocks import Block
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.library.cache import OVERHEAD, Cache, ColumnCache
from mcml_service.xpath.library.disk.sidecar import Sidecar
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.library.head_parts import Heads
from mcml_service.xpath.library.likeness import Poses
from mcml_service.xpath.library.listing import LISTING, Listing
from mcml_service.xpath.library.tracks import BlockKey, Tracks
from mcml_service.xpath.library.zones import Zones, read_zones
from mcml_service.xpath.nodes.frame_runs import Ids, Labels, read_ids, read_labels
from mcml_service.xpath.nodes.layouts import Layout, read_layouts


class _Sized(Protocol):
    @property
    def nbytes(self) -> int: ...


Entry = TypeVar("Entry", bound=_Sized)


class DocumentCache(Generic[Entry]):
    """A cache of data of single documents. At one revision a document never changes.

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

    def forget(self, held: Container[tuple[int, int]]) -> None:
        """Let the entries of all other documents go (key, revision)."""
        self._kept.forget(held.__contains__)

    def read(self, tx: Transaction, documents: Sequence[Listed]) -> list[Entry]:
        """Return the entry of each document. tx: read-only, because an uncommitted revision must not be cached."""
        wanted = {(listed.key, listed.revision): listed for listed in documents}

        def missing(keys: list[tuple[int, int]]) -> dict[tuple[int, int], Entry]:
            entries = self._read(tx, [wanted[key] for key in keys])
            return {key: entries[key[0]] for key in keys}

        return self._kept.get([(listed.key, listed.revision) for listed in documents], missing)


COLUMNS = 512 << 20
"""Default limit in bytes."""

SOME_CHANGES = 16
"""Number of changes of the store between clean-ups: searching the cached data of many documents takes some
milliseconds.
"""


class Caches:
    """The caches of a process.

    limit: bytes of columns: half for the structure of documents and their zone maps, half for samples; other caches are
    small. listing: the list of documents. heads, layouts, labels, ids, zones: of documents. columns: of groups of
    documents. samples: of bones of groups. bodies, poses: of documents, in space. tracks: decoded. blocks: all tracks
    over a chunk. sidecar: the columns on disk; None without them.
    """

    def __init__(self, limit: int = COLUMNS, sidecar: Sidecar | None = None) -> None:
        small = min(8 << 20, limit // 16)
        self.sidecar = sidecar
        self._changes = count(1)
        self.listing = Listing(sidecar, self._forget)
        self.heads = Heads(small)
        self.layouts = DocumentCache[Layout](read_layouts, 2 * small)
        self.labels = DocumentCache[Labels](read_labels, small)
        self.ids = DocumentCache[Ids](read_ids, small)
        self.zones = DocumentCache[Zones](read_zones, 3 * small)
        self.columns = ColumnCache(limit // 2)
        self.samples = ColumnCache(limit // 2)
        self.bodies = DocumentCache[Body](read_bodies, 4 * small)
        self.poses = DocumentCache[Poses](self._read_poses, 8 * small)
        self.tracks = Tracks(4 * small, 5 * small)
        self.blocks = Cache[BlockKey, Block](3 * small, lambda block: block.values.nbytes + OVERHEAD)

    def _forget(self, groups: set[Group]) -> None:
        """Data of unused groups is removed at once, data of documents some changes later."""
        for columns in (self.columns, self.samples):
            columns.forget(groups)
        if self.sidecar is not None:
            self.sidecar.forget({LISTING[0], *(group.fingerprint for group in groups if group.lasting)})
        if next(self._changes) % SOME_CHANGES:
            return
        held = frozenset[tuple[int, int]]().union(*(group.versions for group in groups))
        for entries in (self.layouts, self.labels, self.ids, self.zones, self.bodies, self.poses, self.heads):
            entries.forget(held)
        self.blocks.forget(lambda key: key[:2] in held)
        self.tracks.forget({key for key, _ in held})

    def _read_poses(self, tx: Transaction, documents: Sequence[Listed]) -> Mapping[int, Poses]:
        bodies = self.bodies.read(tx, documents)
        return {listed.key: Poses.of(body) for listed, body in zip(documents, bodies, strict=True)}
