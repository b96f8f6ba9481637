"""Documents in groups: what is made of the columns of a group is kept as long as none of its documents changes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache, cached_property
from itertools import count
from operator import eq

import numpy as np
import xxhash

from service.errors import StoreError
from service.motion.skeleton import CHANNELS
from service.storage.columns import Listed
from service.storage.schema import CHUNK
from service.xpath.library.cache import Cache
from service.xpath.nodes.numbering import MAX_DOCUMENTS, MAX_FRAMES, Ints, code_names

DOCUMENTS = 512
"""Of a group, on average."""
FEW_DOCUMENTS = 256
"""Of those that a question chose, as many are a group."""
MOST_DOCUMENTS = 4 * DOCUMENTS
MOST_FRAMES = 1 << 19

LASTING = 32
"""A group of fewer documents is read anew in less time than it takes to look for what is kept of it."""

KNOWN_DOCUMENTS = 200_000
"""Of all groups that are kept."""

_SPREAD = 2654435761
_WORD = (1 << 32) - 1


_numbers = count()


class Group(list[Listed]):
    """Documents in order of the answer. Two groups are equal only if they are the same object."""

    __hash__ = object.__hash__  # type: ignore[assignment]  # lists have none

    def __init__(self, documents: Iterable[Listed]) -> None:
        super().__init__(documents)
        self.number = next(_numbers)
        """What is kept of the group is kept under it; no other group of this process has it."""

        self.lasting = False
        """Whether it is of a whole library, whose columns are worth being kept on disk."""

    def __eq__(self, other: object) -> bool:
        return self is other

    @cached_property
    def keys(self) -> list[int]:
        return [listed.key for listed in self]

    @cached_property
    def fingerprint(self) -> bytes:
        """What it is made of: equal in every process that has these documents, at these revisions, in this order."""
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
        self._known = Cache[bytes, Group](KNOWN_DOCUMENTS, len)

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
        (known,) = self._known.get([key], lambda keys: {keys[0]: Group(documents)})
        # Restored at the same revision, they may have other names.
        return known if all(map(eq, known, documents)) else Group(documents)


def _numbers_of(documents: list[Listed]) -> bytes:
    """Keys and revisions. Thousands of pairs would have the collector of garbage look through all that there is."""
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
    """What the meaning of the numbers in columns depends on."""
    return f"{CHUNK} {' '.join(CHANNELS)} {' '.join(code_names())} ".encode()
