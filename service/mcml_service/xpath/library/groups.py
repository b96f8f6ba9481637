"""Documents in groups: data computed from the columns of a group is kept as long as queries may use that group."""

from __future__ import annotations

import threading
from collections.abc import Hashable, Iterable, Iterator
from functools import cache, cached_property
from operator import eq

import numpy as np
import xxhash

from mcml.errors import StoreError
from mcml.motion.skeleton import CHANNELS
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.documents.columns import Listed
from mcml_service.xpath.library.cache import Cache
from mcml_service.xpath.nodes.numbering import MAX_DOCUMENTS, MAX_FRAMES, Ints, code_names

DOCUMENTS = 512
"""Of a group, on average."""
FEW_DOCUMENTS = 256
"""Size of groups of documents selected by a query."""
MOST_DOCUMENTS = 4 * DOCUMENTS
MOST_FRAMES = 1 << 19

LASTING = 32
"""Reading a group of fewer documents takes less time than looking it up in the cache."""

CHOSEN_DOCUMENTS = 1 << 17
"""Of all groups of chosen documents that are held; those of a small group count as more."""

VIEWS = 64
"""Choices of projects of which the groups are kept."""

_SPREAD = 2654435761
_WORD = (1 << 32) - 1


class Group(list[Listed]):
    """Documents in order of the answer. Two groups are equal only if they are the same object."""

    __hash__ = object.__hash__  # type: ignore[assignment]  # lists have none

    def __init__(self, documents: Iterable[Listed]) -> None:
        super().__init__(documents)
        self.lasting = False
        """Whether it is of a whole library, whose columns are worth being kept on disk."""

    def __eq__(self, other: object) -> bool:
        return self is other

    @cached_property
    def keys(self) -> list[int]:
        return [listed.key for listed in self]

    @cached_property
    def versions(self) -> frozenset[tuple[int, int]]:
        """Keys and revisions."""
        return frozenset((listed.key, listed.revision) for listed in self)

    @cached_property
    def fingerprint(self) -> bytes:
        """The identity of the group: equal in every process with these documents, at these revisions, in this order."""
        return xxhash.xxh3_128(salt() + "".join([one.uuid for one in self]).encode() + _numbers_of(self)).digest()

    @cached_property
    def frames(self) -> Ints:
        """How many each document has. StoreError where nodes cannot be numbered."""
        frames = np.array([listed.frames for listed in self], np.int64)
        if len(self) > MAX_DOCUMENTS or (frames > MAX_FRAMES).any():
            raise StoreError("More documents or frames than nodes can be numbered for.")
        return frames


class Groups:
    """The groups that are in use, so that equal documents are the same group at any state of the store. Threads may
    share it."""

    def __init__(self) -> None:
        self._known: dict[bytes, Group] = {}
        self._lock = threading.Lock()
        self._views = Cache[Hashable, list[Group]](VIEWS, lambda _: 1)
        self._chosen = Cache[bytes, Group](CHOSEN_DOCUMENTS, lambda group: len(group) + 32)

    def hold_view(self, view: Hashable, groups: list[Group]) -> None:
        """Hold these until others take their place."""
        self._views.put(view, groups)

    def hold_chosen(self, group: Group) -> Group:
        """Keep a group of selected documents until the same are queried at another revision, or many others."""
        self._chosen.put(np.array(group.keys, np.int64).tobytes(), group)
        return group

    def forget(self, others: Iterable[Group]) -> set[Group]:
        """Forget all groups that are not held here and not one of the others. The ones that are left."""
        held = set(others).union(*self._views.values(), self._chosen.values())
        with self._lock:
            self._known = {key: group for key, group in self._known.items() if group in held}
        return held

    def cut(self, documents: Iterable[Listed]) -> list[Group]:
        """Documents in groups, in their order.

        Where a group ends depends on its last document alone, unless it would be too large: one document more or less
        changes one group, not all behind it (content-defined chunking).
        """
        groups = [self.group(part) for part in _parts(documents)]
        for group in groups:
            group.lasting = len(group) >= LASTING
        return groups

    def group(self, documents: list[Listed]) -> Group:
        """The group of these documents."""
        key = _numbers_of(documents)
        with self._lock:
            known = self._known.get(key)
            # Restored at the same revision, they may have other names.
            if known is None or not all(map(eq, known, documents)):
                known = self._known[key] = Group(documents)
            return known


def _numbers_of(documents: list[Listed]) -> bytes:
    """Keys and revisions. Thousands of pairs would trigger a full garbage collection."""
    keys, revisions = ([getattr(one, name) for one in documents] for name in ("key", "revision"))
    return np.array([keys, revisions], np.int64).tobytes()


def _parts(documents: Iterable[Listed]) -> Iterator[list[Listed]]:
    part: list[Listed] = []
    frames = 0
    for one in documents:
        if part and frames + one.frames > MOST_FRAMES:
            yield part
            part, frames = [], 0
        part.append(one)
        frames += one.frames
        if _ends_here(one.key) or len(part) == MOST_DOCUMENTS:
            yield part
            part, frames = [], 0
    if part:
        yield part


def _ends_here(key: int) -> bool:
    return ((key * _SPREAD) & _WORD) < _WORD // DOCUMENTS


@cache
def salt() -> bytes:
    """Return the versions on which the meaning of the numbers in columns depends."""
    return f"{CHUNK} {' '.join(CHANNELS)} {' '.join(code_names())} ".encode()
