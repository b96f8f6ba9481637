"""A job on several workers of Dask: one has it and gives pieces to the others, and they read clips from the store."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache
from typing import Any, overload

from mcml_service.actions.composing.load_motions import Input, load_motions
from mcml_service.analysis.interface import Motion
from mcml_service.analysis.pieces import ApartMotions, each, spread_here
from mcml_service.storage.core.views import WHOLE
from mcml_service.storage.database import Database

Urls = tuple[str, str | None]
"""Of the store, and of its replica."""

PIECES = 4
"""Of each worker, in the mean: who has fast ones gets more of them."""

FIRST = 10
"""Priority of pieces: they go before jobs that nobody has begun."""


@lru_cache(maxsize=4)
def database_of(url: str, read_url: str | None) -> Database:
    """Of this worker."""
    return Database(url, read_url)


class StoredMotions(ApartMotions):
    """See `ApartMotions`. inputs, skeleton: as `load_motions` takes them."""

    def __init__(self, urls: Urls, inputs: Sequence[Input], skeleton: Input | None) -> None:
        self._urls, self._skeleton = urls, skeleton
        self._inputs = sorted(inputs, key=lambda item: str(item["document"]))

    def __len__(self) -> int:
        return len(self._inputs)

    @overload
    def __getitem__(self, index: int) -> Motion: ...
    @overload
    def __getitem__(self, index: slice) -> list[Motion]: ...
    def __getitem__(self, index: int | slice) -> Motion | list[Motion]:
        return self._all[index]

    @cached_property
    def _all(self) -> list[Motion]:
        return _loaded(self._inputs, self._urls, self._skeleton)

    def each(self, function: Callable[..., Any], shared: Sequence[Any], told: Callable[[float], None]) -> list[Any]:
        if _workers() < 2:
            return each(self._all, function, shared, told)
        step = -(-len(self) // (PIECES * _workers()))
        groups = [self._inputs[at : at + step] for at in range(0, len(self), step)]
        found = self.spread(_of_each, groups, (self._urls, self._skeleton, function, tuple(shared)), told)
        return [value for values in found for value in values]

    def spread(
        self,
        function: Callable[..., Any],
        pieces: Sequence[Any],
        shared: Sequence[Any] = (),
        told: Callable[[float], None] = lambda share: None,
    ) -> list[Any]:
        from distributed import as_completed, worker_client

        if len(pieces) < 2 or _workers() < 2:
            return spread_here(function, pieces, shared, told)
        # While it waits, this worker has room for pieces too.
        with worker_client() as client:
            given = client.scatter(list(shared), hash=False)
            futures = [client.submit(function, piece, *given, pure=False, priority=FIRST) for piece in pieces]
            places = {future.key: place for place, future in enumerate(futures)}
            found: list[Any] = [None] * len(pieces)
            try:
                for number, (future, value) in enumerate(as_completed(futures, with_results=True), 1):
                    found[places[future.key]] = value
                    told(number / len(pieces))
            finally:
                client.cancel(futures)
        return found


def _workers() -> int:
    from distributed import get_client

    return sum(get_client().nthreads().values())


def _loaded(inputs: Sequence[Input], urls: Urls, skeleton: Input | None) -> list[Motion]:
    database = database_of(*urls).for_call(WHOLE, from_replica=True)
    return database.ask(lambda tx: load_motions(tx, inputs, skeleton=skeleton))


def _of_each(
    inputs: Sequence[Input], urls: Urls, skeleton: Input | None, function: Callable[..., Any], shared: tuple[Any, ...]
) -> list[Any]:
    return each(_loaded(inputs, urls, skeleton), function, shared)
