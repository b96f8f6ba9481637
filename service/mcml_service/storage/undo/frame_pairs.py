"""Frames that a document has before and after edits: by identity, or in the place of as many others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from mcml_service.storage.documents.timelines import Run, common_frames
from mcml_service.storage.documents.tracks import Piece


def pair_frames(before: list[Piece], after: list[Piece]) -> list[Run]:
    """Return the frames that one edit keeps, in the order of the later state.

    before, after: the timelines. Frames with the same slots are the same; between such frames, as many new frames as
    old ones replace them one by one, as edits of samples do.
    """
    same = common_frames(before, after)
    if any(a.before > b.before for a, b in pairwise(same)):
        # Frames were moved: there is no "between".
        return join_runs(same)
    ends = Run(_length(before) + 1, _length(after) + 1, 0)
    return join_runs([run for pair in pairwise([Run(1, 1, 0), *same, ends]) for run in _with_replaced(*pair)])


def _with_replaced(run: Run, following: Run) -> Iterator[Run]:
    """Frames that replace as many others between two runs, and the second run."""
    before, after = run.before + run.count, run.after + run.count
    if following.before - before == following.after - after > 0:
        yield Run(before, after, following.before - before)
    if following.count:
        yield following


def _length(pieces: Sequence[Piece]) -> int:
    return max((piece.first + piece.count - 1 for piece in pieces), default=0)


def compose_pairs(first: Sequence[Run], second: Sequence[Run]) -> list[Run]:
    """Return the frames that two edits keep, one after the other; each run: from before to after its edit."""
    one = sorted(first, key=lambda run: run.after)
    other = sorted(second, key=lambda run: run.before)
    runs: list[Run] = []
    a = b = 0
    while a < len(one) and b < len(other):
        start = max(one[a].after, other[b].before)
        end = min(one[a].after + one[a].count, other[b].before + other[b].count)
        if start < end:
            runs.append(
                Run(one[a].before + start - one[a].after, other[b].after + start - other[b].before, end - start)
            )
        if one[a].after + one[a].count < other[b].before + other[b].count:
            a += 1
        else:
            b += 1
    return join_runs(sorted(runs, key=lambda run: run.after))


def join_runs(runs: Sequence[Run]) -> list[Run]:
    """Runs with those joined that follow each other in both states."""
    runs_joined: list[Run] = []
    for run in runs:
        last = runs_joined[-1] if runs_joined else None
        if last and (last.before + last.count, last.after + last.count) == (run.before, run.after):
            runs_joined[-1] = Run(last.before, last.after, last.count + run.count)
        else:
            runs_joined.append(run)
    return runs_joined
