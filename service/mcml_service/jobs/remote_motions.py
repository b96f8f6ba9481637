"""A job on several processes: one has it and gives pieces to the others, which read clips from the store themselves."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from functools import cached_property, lru_cache
from typing import Any, overload

from mcml_service.actions.composing.load_motions import Input, load_motions
from mcml_service.analysis.interface import Motion
from mcml_service.analysis.pieces import ApartMotions, each, spread_here
from mcml_service.jobs.workers import Crew
from mcml_service.storage.core.views import WHOLE
from mcml_service.storage.database import Database

Urls = tuple[str, str | None]
"""Of the store, and of its replica."""

PIECES = 4
"""Average number of pieces for each worker: workers with fast pieces get more of them."""


@lru_cache(maxsize=4)
def database_of(url: str, read_url: str | None) -> Database:
    """Of this worker."""
    return Database(url, read_url)


class StoredMotions(ApartMotions):
    """See `ApartMotions`. inputs, skeleton: as `load_motions` takes them."""

    def __init__(self, urls: Urls, crew: Crew, inputs: Sequence[Input], skeleton: Input | None) -> None:
        self._urls, self._crew, self._skeleton = urls, crew, skeleton
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
        return _load(self._inputs, self._urls, self._skeleton)

    def each(self, function: Callable[..., Any], shared: Sequence[Any], told: Callable[[float], None]) -> list[Any]:
        places = self._crew.places()
        if places < 2:
            return each(self._all, function, shared, told)
        step = -(-len(self) // (PIECES * places))
        groups = [self._inputs[at : at + step] for at in range(0, len(self), step)]
        groups_of_values = self.spread(_of_each, groups, (self._urls, self._skeleton, function, tuple(shared)), told)
        return [value for values in groups_of_values for value in values]

    def spread(
        self,
        function: Callable[..., Any],
        pieces: Sequence[Any],
        shared: Sequence[Any] = (),
        told: Callable[[float], None] = lambda share: None,
    ) -> list[Any]:
        if len(pieces) < 2 or self._crew.places() < 2:
            return spread_here(function, pieces, shared, told)
        results: list[Any] = []
        end = time.monotonic() + self._crew.alone_seconds
        while len(results) < len(pieces) and time.monotonic() < end:
            results.append(function(pieces[len(results)], *shared))
            told(len(results) / len(pieces))
        if len(results) < len(pieces):
            results += self._spread(function, pieces, shared, told, len(results))
        return results

    def _spread(
        self,
        function: Callable[..., Any],
        pieces: Sequence[Any],
        shared: Sequence[Any],
        told: Callable[[float], None],
        first: int,
    ) -> list[Any]:
        """Do the pieces from the first one on. One whose process dies is done once more."""
        results: dict[int, Any] = {}
        rest, again = deque(range(first, len(pieces))), set[int]()
        waiting: dict[Future[Any], int] = {}
        with self._crew.helpers(shared) as (executor, given):
            while rest or waiting:
                while rest and len(waiting) < self._crew.places():
                    place = rest.popleft()
                    waiting[executor.submit(function, pieces[place], *given)] = place
                for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                    place = waiting.pop(future)
                    try:
                        results[place] = future.result()
                    except BrokenExecutor:
                        if place in again:
                            raise
                        again.add(place)
                        rest.appendleft(place)
                    else:
                        told((first + len(results)) / len(pieces))
        return [results[place] for place in range(first, len(pieces))]


def _load(inputs: Sequence[Input], urls: Urls, skeleton: Input | None) -> list[Motion]:
    database = database_of(*urls).for_call(WHOLE, from_replica=True)
    return database.ask(lambda tx: load_motions(tx, inputs, skeleton=skeleton))


def _of_each(
    inputs: Sequence[Input], urls: Urls, skeleton: Input | None, function: Callable[..., Any], shared: tuple[Any, ...]
) -> list[Any]:
    return each(_load(inputs, urls, skeleton), function, shared)
