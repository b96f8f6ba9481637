"""Independent pieces of an analysis, which other processors may do."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from mcml_service.analysis.interface import Motion


class Spread(Protocol):
    """Runs pieces of work, and yields their results in order.

    function: of a module, (piece, *shared) -> value; pure. shared: data for all pieces, such as large arrays. told:
    called with the share of finished pieces. Raises the errors of pieces.
    """

    def __call__(
        self,
        function: Callable[..., Any],
        pieces: Sequence[Any],
        shared: Sequence[Any] = (),
        told: Callable[[float], None] = ...,
    ) -> list[Any]: ...


def spread_here(
    function: Callable[..., Any],
    pieces: Sequence[Any],
    shared: Sequence[Any] = (),
    told: Callable[[float], None] = lambda share: None,
) -> list[Any]:
    """One after the other."""
    results = []
    for number, piece in enumerate(pieces, 1):
        results.append(function(piece, *shared))
        told(number / len(pieces))
    return results


class ApartMotions(Sequence[Motion]):
    """Clips of a job that several processes share: each process reads the clips of its pieces, and all are read here
    only if one is needed.
    """

    @abstractmethod
    def each(self, function: Callable[..., Any], shared: Sequence[Any], told: Callable[[float], None]) -> list[Any]:
        """See the function `each`."""

    @abstractmethod
    def spread(
        self,
        function: Callable[..., Any],
        pieces: Sequence[Any],
        shared: Sequence[Any] = (),
        told: Callable[[float], None] = lambda share: None,
    ) -> list[Any]:
        """See `Spread`."""


def each(
    motions: Sequence[Motion],
    function: Callable[..., Any],
    shared: Sequence[Any] = (),
    told: Callable[[float], None] = lambda share: None,
) -> list[Any]:
    """Return the values of a module's function, (motion, *shared) -> value, for each clip, in the order of document
    ids.
    """
    if isinstance(motions, ApartMotions):
        return motions.each(function, shared, told)
    return spread_here(function, sorted(motions, key=lambda motion: motion.document), shared, told)


def spread_of(motions: Sequence[Motion]) -> Spread | None:
    """Return the runner of pieces for these clips; None if there are no other processes."""
    return motions.spread if isinstance(motions, ApartMotions) else None
