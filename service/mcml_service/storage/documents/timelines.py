"""Timelines of a document at two commits: which frames are the same ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mcml_service.storage.documents.tracks import Piece


@dataclass(frozen=True)
class Run:
    """`count` frames that both states have: at positions from `before` in the one, from `after` in the other."""

    before: int
    after: int
    count: int


def common_frames(before: Sequence[Piece], after: Sequence[Piece]) -> list[Run]:
    """Return the frames with the same slots in two timelines, in the order of the later one."""
    runs: list[Run] = []
    old = sorted(before, key=lambda piece: piece.slot)
    for piece in after:
        for other in old:
            start = max(piece.slot, other.slot)
            end = min(piece.slot + piece.count, other.slot + other.count)
            if start < end:
                runs.append(Run(other.first + start - other.slot, piece.first + start - piece.slot, end - start))
    return sorted(runs, key=lambda run: run.after)
